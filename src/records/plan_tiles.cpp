#include "records/plan_tiles.hpp"

#include <algorithm>

namespace moraine {

int owner_of_tile(std::int64_t tile, int ranks) {
    const std::uint64_t mixed = static_cast<std::uint64_t>(tile) * 0x9E3779B97F4A7C15ULL >> 32;
    return static_cast<int>(mixed % static_cast<std::uint64_t>(ranks));
}

PlanTiles::PlanTiles(const Comm& comm, std::vector<std::int64_t> mine) : comm_(comm), mine_(std::move(mine)) {
    const auto owner = [&](std::int64_t tile) { return owner_of_tile(tile, comm.size()); };
    std::sort(mine_.begin(), mine_.end(),
              [&](std::int64_t a, std::int64_t b) { return std::pair(owner(a), a) < std::pair(owner(b), b); });
    sent_.assign(static_cast<std::size_t>(comm.size()), 0);
    for (std::int64_t tile : mine_) ++sent_[static_cast<std::size_t>(owner(tile))];
    received_ = sent_;
    const std::vector<std::int64_t> came = comm.exchange(mine_, received_);
    owned_ = came;
    std::sort(owned_.begin(), owned_.end());
    owned_.erase(std::unique(owned_.begin(), owned_.end()), owned_.end());
    for (std::int64_t tile : came)
        slot_.push_back(
            static_cast<std::size_t>(std::lower_bound(owned_.begin(), owned_.end(), tile) - owned_.begin()));
}

}  // namespace moraine
