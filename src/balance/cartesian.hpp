#pragma once
// Static boxes over the domain: a grid of P = px py (pz) boxes of whole block layers, as most codes have it.
//
// Of all factorisations the one that leaves the fewest ranks idle, then the one with the smallest largest
// box, then the one whose cuts have the smallest area, then the lowest px, py: near-cubic boxes where P and
// the domain allow. Layer i of L along an axis belongs to box floor(i p / L) there; the first axis counts
// fastest in the rank. Places beyond the domain belong to the outermost boxes.

#include "balance/partitioner.hpp"

namespace moraine {

/// Boxes along each axis; their product is `ranks`. Not collective.
std::array<std::int32_t, 3> boxes_of(const Layout& layout, int ranks);

class Cartesian final : public Partitioner {
  public:
    Cartesian(const Layout& layout, int ranks) : layout_(layout), boxes_(boxes_of(layout, ranks)) {}

    const char* name() const override { return "cartesian"; }
    bool is_static() const override { return true; }
    std::vector<std::int32_t> owners(std::span<const BlockLoad> blocks, std::int64_t round) const override;
    std::int32_t owner_at(const Position& position) const override;

  private:
    Layout layout_;
    std::array<std::int32_t, 3> boxes_;
};

}  // namespace moraine
