#include "balance/cartesian.hpp"

#include <algorithm>
#include <tuple>

namespace moraine {
namespace {

/// What makes a grid of boxes worse than another, the most important first.
std::tuple<std::int64_t, std::int64_t, std::int64_t> badness(const Layout& layout,
                                                             const std::array<std::int32_t, 3>& boxes) {
    std::int64_t used = 1;
    std::int64_t largest = 1;
    std::int64_t area = 0;
    for (int a = 0; a < 3; ++a) {
        const std::int64_t layers = layout.blocks[a];
        used *= std::min<std::int64_t>(layers, boxes[a]);
        largest *= (layers + boxes[a] - 1) / boxes[a];
        std::int64_t section = 1;
        for (int b = 0; b < 3; ++b) section *= b == a ? 1 : layout.blocks[b];
        area += (boxes[a] - 1) * section;
    }
    return {-used, largest, area};
}

}  // namespace

std::array<std::int32_t, 3> boxes_of(const Layout& layout, int ranks) {
    std::array<std::int32_t, 3> best{1, 1, ranks};
    bool found = false;
    for (std::int32_t x = 1; x <= ranks; ++x) {
        if (ranks % x != 0) continue;
        for (std::int32_t y = 1; y <= ranks / x; ++y) {
            const std::array<std::int32_t, 3> boxes{x, y, ranks / x / y};
            if (ranks / x % y != 0 || (layout.dimensions == 2 && boxes[2] > 1)) continue;
            if (!found || badness(layout, boxes) < badness(layout, best)) best = boxes;
            found = true;
        }
    }
    return best;
}

std::vector<std::int32_t> Cartesian::owners(std::span<const BlockLoad> blocks, std::int64_t) const {
    std::vector<std::int32_t> owner;
    owner.reserve(blocks.size());
    for (const BlockLoad& block : blocks) owner.push_back(owner_at(block_position(layout_, block.key)));
    return owner;
}

std::int32_t Cartesian::owner_at(const Position& position) const {
    std::int64_t rank = 0;
    for (int a = 2; a >= 0; --a) {
        const std::int64_t layers = layout_.blocks[a];
        rank = rank * boxes_[a] + std::clamp<std::int64_t>(position[a], 0, layers - 1) * boxes_[a] / layers;
    }
    return static_cast<std::int32_t>(rank);
}

}  // namespace moraine
