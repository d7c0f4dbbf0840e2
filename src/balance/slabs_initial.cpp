#include "balance/slabs_initial.hpp"

#include <algorithm>

#include "balance/cut.hpp"

namespace moraine {

void SlabsInitial::start(std::span<const BlockLoad> initial) {
    profile_.assign(static_cast<std::size_t>(layout_.blocks[axis_]), 0);
    for (const BlockLoad& block : initial) profile_[layer_of(block_position(layout_, block.key))] += block.particles;
    cut_layers();
}

std::vector<std::int32_t> SlabsInitial::owners(std::span<const BlockLoad> blocks, std::int64_t) const {
    std::vector<std::int32_t> owner;
    owner.reserve(blocks.size());
    for (const BlockLoad& block : blocks) owner.push_back(owner_at(block_position(layout_, block.key)));
    return owner;
}

std::int32_t SlabsInitial::owner_at(const Position& position) const {
    return owner_of_layer_[layer_of(position)];
}

std::vector<std::int64_t> SlabsInitial::state() const {
    std::vector<std::int64_t> state{axis_};
    state.insert(state.end(), profile_.begin(), profile_.end());
    return state;
}

bool SlabsInitial::restore(std::span<const std::int64_t> state) {
    if (state.size() != static_cast<std::size_t>(layout_.blocks[axis_]) + 1 || state[0] != axis_) return false;
    profile_.assign(state.begin() + 1, state.end());
    cut_layers();
    return true;
}

std::int32_t SlabsInitial::layer_of(const Position& position) const {
    return std::clamp(position[axis_], 0, layout_.blocks[axis_] - 1);
}

void SlabsInitial::cut_layers() {
    const std::vector<std::int64_t> cuts = exact_cut(profile_, ranks_);
    owner_of_layer_.resize(profile_.size());
    for (std::int32_t p = 0; p < ranks_; ++p)
        std::fill(owner_of_layer_.begin() + cuts[p], owner_of_layer_.begin() + cuts[p + 1], p);
}

}  // namespace moraine
