#include "gpu/exchange/block_moves.hpp"

#include <algorithm>
#include <cstring>

#include "comm/point_to_point.hpp"

namespace moraine::gpu {

namespace {

/// Key and number of particles of a block, as hosts tell each other.
struct Notice {
    Key key;
    std::uint64_t count;
};

std::vector<std::byte> notices_of(const std::vector<ListRange>& ranges) {
    std::vector<std::byte> bytes(ranges.size() * sizeof(Notice));
    for (std::size_t i = 0; i < ranges.size(); ++i) {
        const Notice notice{ranges[i].key, ranges[i].count};
        std::memcpy(bytes.data() + i * sizeof(Notice), &notice, sizeof(Notice));
    }
    return bytes;
}

std::vector<ListRange> ranges_of(const std::vector<std::byte>& bytes, std::size_t& particles) {
    std::vector<ListRange> ranges;
    for (std::size_t at = 0; at < bytes.size(); at += sizeof(Notice)) {
        Notice notice{};
        std::memcpy(&notice, bytes.data() + at, sizeof(Notice));
        ranges.push_back({notice.key, static_cast<std::uint32_t>(particles), static_cast<std::uint32_t>(notice.count)});
        particles += notice.count;
    }
    return ranges;
}

}  // namespace

BlockPlan plan_block_moves(const Comm& comm, const std::vector<ListRange>& mine, std::span<const std::int32_t> owner) {
    const auto ranks = static_cast<std::size_t>(comm.size());
    BlockPlan plan;
    std::vector<std::vector<ListRange>> leaving(ranks);
    for (std::size_t b = 0; b < mine.size(); ++b)
        (owner[b] == comm.rank() ? plan.kept : leaving[static_cast<std::size_t>(owner[b])]).push_back(mine[b]);
    std::vector<std::vector<std::byte>> notices(ranks);
    for (std::size_t r = 0; r < ranks; ++r) notices[r] = notices_of(leaving[r]);
    const std::vector<std::vector<std::byte>> come = exchange_all(comm, notices);
    for (std::size_t r = 0; r < ranks; ++r) {
        if (static_cast<int>(r) == comm.rank() || (leaving[r].empty() && come[r].empty())) continue;
        BlockPlan::Partner p{static_cast<int>(r), leaving[r], {}, 0, 0};
        const std::size_t before = plan.incoming;
        p.coming = ranges_of(come[r], plan.incoming);
        p.in = plan.incoming - before;
        for (const ListRange& s : p.leaving) p.out += s.count;
        plan.partners.push_back(std::move(p));
    }
    return plan;
}

}  // namespace moraine::gpu
