#pragma once
// What limits accelerations at light nodes on the device (core/grid/light_nodes.hpp): which node blocks have some, and
// which blocks of particles are limited by them. Empty where the method limits nothing.

#include <algorithm>

#include "core/transfer/method.hpp"
#include "gpu/kernels/g2p/g2p.hpp"
#include "gpu/kernels/nodes/nodes.hpp"
#include "gpu/memory/array.hpp"
#include "gpu/memory/pool_array.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
struct LightState {
    Array<Stiffness<Real>> stiffness;        ///< by body; empty: nothing is limited
    Real full_mass = 0;                      ///< the largest of the bodies' [kg]
    PoolArray<std::uint8_t> marks;           ///< of node blocks
    PoolArray<std::uint8_t> limited;         ///< of own blocks
    PoolArray<std::int32_t> limited_blocks;  ///< LimitedBlocks of the boundary, then of the interior
    Array<std::uint32_t> limited_count;      ///< of both

    void start(const Method<Host, Real, Dim>& method, std::size_t bodies) {
        if (!method.stiffness()) return;
        stiffness.assign(method.stiffness(), bodies);
        for (std::size_t b = 0; b < bodies; ++b) full_mass = std::max(full_mass, method.stiffness()[b].full_mass);
        limited_count.resize(2 * LimitedBlocks::lists);
    }
    /// For an epoch. Asynchronous.
    void open(std::size_t node_blocks, std::size_t own, cudaStream_t stream) {
        if (stiffness.size() == 0) return;
        marks.resize(node_blocks * light_marks<Dim>, stream);
        limited.resize(own, stream);
        limited_blocks.resize(2 * LimitedBlocks::lists * own, stream);
    }
    LightArgs<Real> args(const ReactionLimits<Real>& limits) const {
        return {stiffness.data(), limits, full_mass, marks.data(), limited.data()};
    }
    LightMarks<Real> marks_of_nodes() const { return {marks.data(), Real(0.5) * full_mass, limited_count.data()}; }
    /// Where those of a part are listed: 0 is the boundary, 1 the interior.
    LimitedBlocks found(int part, std::size_t own) const {
        std::int32_t* blocks = limited_blocks.data() + static_cast<std::size_t>(LimitedBlocks::lists * part) * own;
        return {blocks, blocks + own, limited_count.data() + part};
    }
};

}  // namespace moraine::gpu
