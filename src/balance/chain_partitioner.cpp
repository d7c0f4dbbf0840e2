#include "balance/chain_partitioner.hpp"

#include <algorithm>
#include <numeric>

#include "balance/cut.hpp"
#include "balance/hilbert.hpp"
#include "balance/host_relabel.hpp"
#include "balance/least_migration.hpp"
#include "balance/relabel.hpp"

namespace moraine {
namespace {

Key hilbert_key(const Layout& layout, Key morton) {
    return layout.dimensions == 2 ? Hilbert<2>::encode(Morton<2>::decode(morton))
                                  : Hilbert<3>::encode(Morton<3>::decode(morton));
}

/// Of each link the sum of a column of its blocks.
std::vector<std::int64_t> sums_of(std::span<const BlockLoad> blocks, const Links& links,
                                  std::int64_t BlockLoad::*column) {
    std::int32_t count = 0;
    for (std::int32_t link : links) count = std::max(count, link + 1);
    std::vector<std::int64_t> sums(static_cast<std::size_t>(count), 0);
    for (std::size_t b = 0; b < blocks.size(); ++b) sums[links[b]] += blocks[b].*column;
    return sums;
}

std::vector<std::int64_t> weights_of(std::span<const BlockLoad> blocks, const Links& links) {
    return sums_of(blocks, links, &BlockLoad::weight);
}

std::vector<std::int32_t> parts_of(const Links& links, const std::vector<std::int64_t>& cuts) {
    std::vector<std::int32_t> part_of_link(static_cast<std::size_t>(cuts.back()));
    for (std::size_t p = 0; p + 1 < cuts.size(); ++p)
        std::fill(part_of_link.begin() + cuts[p], part_of_link.begin() + cuts[p + 1], static_cast<std::int32_t>(p));
    std::vector<std::int32_t> part(links.size());
    for (std::size_t b = 0; b < links.size(); ++b) part[b] = part_of_link[links[b]];
    return part;
}

std::vector<std::int32_t> renamed(std::vector<std::int32_t> parts, const std::vector<std::int32_t>& rank_of) {
    for (std::int32_t& part : parts) part = rank_of[part];
    return parts;
}

}  // namespace

Links links_along_morton(std::span<const BlockLoad> blocks) {
    Links links(blocks.size());
    std::iota(links.begin(), links.end(), 0);
    return links;
}

Links links_along_hilbert(const Layout& layout, std::span<const BlockLoad> blocks) {
    std::vector<std::pair<Key, std::int32_t>> order(blocks.size());
    for (std::size_t b = 0; b < blocks.size(); ++b)
        order[b] = {hilbert_key(layout, blocks[b].key), static_cast<std::int32_t>(b)};
    std::sort(order.begin(), order.end());
    Links links(blocks.size());
    for (std::size_t l = 0; l < order.size(); ++l) links[order[l].second] = static_cast<std::int32_t>(l);
    return links;
}

Links links_by_layer(const Layout& layout, int axis, std::span<const BlockLoad> blocks) {
    Links links;
    links.reserve(blocks.size());
    for (const BlockLoad& block : blocks) links.push_back(block_position(layout, block.key)[axis]);
    std::vector<std::int32_t> layers = links;
    std::sort(layers.begin(), layers.end());
    layers.erase(std::unique(layers.begin(), layers.end()), layers.end());
    for (std::int32_t& link : links)
        link = static_cast<std::int32_t>(std::lower_bound(layers.begin(), layers.end(), link) - layers.begin());
    return links;
}

std::vector<std::int32_t> ChainPartitioner::relabelled(std::span<const BlockLoad> blocks,
                                                       std::span<const std::int32_t> parts,
                                                       std::span<const std::int32_t> wanted) const {
    return renamed({parts.begin(), parts.end()}, host_count(hosts_) > 1 ? relabel_on_hosts(blocks, parts, hosts_)
                                                                        : relabel(blocks, parts, ranks_, wanted));
}

std::vector<std::int32_t> ChainPartitioner::owners(std::span<const BlockLoad> blocks, std::int64_t) const {
    const Links links = order_(blocks);
    return relabelled(blocks, parts_of(links, exact_cut(weights_of(blocks, links), ranks_)));
}

std::vector<Option> ChainPartitioner::options_of(std::span<const BlockLoad> blocks, const Links& links,
                                                 std::span<const std::int64_t> weights,
                                                 const std::vector<std::int64_t>& cuts,
                                                 const MemoryLimit& memory) const {
    const std::vector<std::int32_t> parts = parts_of(links, cuts);
    std::vector<Option> options{
        {PlanKind::natural, host_count(hosts_) > 1 ? renamed(parts, ranks_by_host(hosts_)) : parts},
        {PlanKind::relabelled, relabelled(blocks, parts)}};
    const OwnerAffinity homes = affinity_of(blocks, links, static_cast<std::int64_t>(weights.size()), ranks_);
    if (const auto least = least_migration(weights, homes, ranks_, migration_tolerance, memory)) {
        const std::vector<std::int32_t> pieces = parts_of(links, least->cuts);
        options.push_back({PlanKind::least, relabelled(blocks, pieces, least->rank_of)});
    }
    return options;
}

std::vector<Option> ChainPartitioner::options(std::span<const BlockLoad> blocks, std::int64_t) const {
    const Links links = order_(blocks);
    const std::vector<std::int64_t> weights = weights_of(blocks, links);
    return options_of(blocks, links, weights, exact_cut(weights, ranks_), {});
}

std::optional<std::vector<Option>> ChainPartitioner::options_within(std::span<const BlockLoad> blocks,
                                                                    std::int64_t most) const {
    const Links links = order_(blocks);
    const std::vector<std::int64_t> weights = weights_of(blocks, links);
    const std::vector<std::int64_t> held = sums_of(blocks, links, &BlockLoad::particles);
    const MemoryLimit memory{held, most};
    const auto cuts = exact_cut(weights, ranks_, memory);
    return cuts ? options_of(blocks, links, weights, *cuts, memory) : std::vector<Option>{};
}

}  // namespace moraine
