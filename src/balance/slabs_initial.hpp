#pragma once
// Static slabs along balance.axis that hold equal numbers of particles at t = 0: the best that a static
// slab can do without knowing where the flow will go.
//
// Whole block layers, cut exactly by the particles of each layer. A checkpoint keeps that profile of
// t = 0, not the cut positions: a restart on another number of ranks then gets the slabs that a run begun
// on that number of ranks would have. Layers beyond the domain belong to the outermost slabs.

#include "balance/partitioner.hpp"

namespace moraine {

class SlabsInitial final : public Partitioner {
  public:
    SlabsInitial(const Layout& layout, int axis, int ranks) : layout_(layout), axis_(axis), ranks_(ranks) {}

    const char* name() const override { return "slabs-initial"; }
    bool is_static() const override { return true; }
    void start(std::span<const BlockLoad> initial) override;

    /// start() or restore() must have been called.
    std::vector<std::int32_t> owners(std::span<const BlockLoad> blocks, std::int64_t round) const override;
    std::int32_t owner_at(const Position& position) const override;

    /// The axis, then the particles of each block layer at t = 0.
    std::vector<std::int64_t> state() const override;
    bool restore(std::span<const std::int64_t> state) override;

  private:
    std::int32_t layer_of(const Position& position) const;
    void cut_layers();

    Layout layout_;
    int axis_;
    int ranks_;
    std::vector<std::int64_t> profile_;         // particles of each layer at t = 0
    std::vector<std::int32_t> owner_of_layer_;  // of each layer
};

}  // namespace moraine
