#pragma once
// Static slabs of equal width over the domain, along balance.axis: the scheme of the method paper, kept
// for comparison.
//
// A slab is a number of whole block layers, equal to one layer; layer i of L belongs to rank floor(i P / L).
// With more ranks than layers some ranks stay idle, and the imbalance says so.

#include <algorithm>

#include "balance/partitioner.hpp"

namespace moraine {

class Slabs final : public Partitioner {
  public:
    Slabs(const Layout& layout, int axis, int ranks) : layout_(layout), axis_(axis), ranks_(ranks) {}

    const char* name() const override { return "slabs"; }
    bool is_static() const override { return true; }

    std::vector<std::int32_t> owners(std::span<const BlockLoad> blocks, std::int64_t) const override {
        std::vector<std::int32_t> owner;
        owner.reserve(blocks.size());
        for (const BlockLoad& block : blocks) owner.push_back(owner_at(block_position(layout_, block.key)));
        return owner;
    }

    std::int32_t owner_at(const Position& position) const override {
        const std::int64_t layers = layout_.blocks[axis_];
        const std::int64_t layer = std::clamp<std::int64_t>(position[axis_], 0, layers - 1);
        return static_cast<std::int32_t>(layer * ranks_ / layers);
    }

  private:
    Layout layout_;
    int axis_;
    int ranks_;
};

}  // namespace moraine
