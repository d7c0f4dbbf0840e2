#include "balance/library_partitioner.hpp"

#include <algorithm>
#include <numeric>

#include "balance/host_relabel.hpp"
#include "balance/relabel.hpp"

namespace moraine {
namespace {

/// Blocks that get a part of their own: as heavy as the mean of what is left, or heavier. In key order.
std::vector<std::int32_t> heavy_blocks(std::span<const BlockLoad> blocks, int parts) {
    std::vector<std::int32_t> order(blocks.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::int32_t x, std::int32_t y) { return blocks[x].weight > blocks[y].weight; });
    std::int64_t left = 0;
    for (const BlockLoad& block : blocks) left += block.weight;
    std::size_t alone = 0;
    for (; parts > 1 && alone < order.size() && blocks[order[alone]].weight > left / parts; ++alone, --parts)
        left -= blocks[order[alone]].weight;
    order.resize(alone);
    std::sort(order.begin(), order.end());
    return order;
}

}  // namespace

std::vector<std::int32_t> LibraryPartitioner::parts(std::span<const BlockLoad> blocks) const {
    std::vector<std::int32_t> part(blocks.size(), 0);
    const std::vector<std::int32_t> heavy = heavy_blocks(blocks, ranks_);
    const int others = ranks_ - static_cast<int>(heavy.size());
    for (std::size_t k = 0; k < heavy.size(); ++k) part[heavy[k]] = others + static_cast<std::int32_t>(k);
    if (others == 1) return part;

    std::vector<BlockLoad> rest;
    std::vector<std::int32_t> number;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
        if (part[b] > 0) continue;
        rest.push_back(blocks[b]);
        number.push_back(static_cast<std::int32_t>(b));
    }
    const auto weighs = [](const BlockLoad& block) { return block.weight > 0; };
    if (std::none_of(rest.begin(), rest.end(), weighs))
        for (BlockLoad& block : rest) block.weight = 1;
    const std::vector<std::int32_t> found =
        rest.size() > static_cast<std::size_t>(others) ? find_(rest, others) : std::vector<std::int32_t>{};
    for (std::size_t k = 0; k < rest.size(); ++k)
        part[number[k]] = found.empty() ? static_cast<std::int32_t>(k) : found[k];
    return part;
}

std::vector<std::int32_t> LibraryPartitioner::owners(std::span<const BlockLoad> blocks, std::int64_t) const {
    if (ranks_ == 1 || blocks.empty()) return std::vector<std::int32_t>(blocks.size(), 0);
    std::vector<std::int32_t> owner = parts(blocks);
    const bool on_hosts = host_count(hosts_) > 1;
    if (on_hosts) owner = numbered_along_curve(std::move(owner), ranks_);
    const std::vector<std::int32_t> rank_of =
        on_hosts ? relabel_on_hosts(blocks, owner, hosts_) : relabel(blocks, owner, ranks_);
    for (std::int32_t& part : owner) part = rank_of[part];
    return owner;
}

}  // namespace moraine
