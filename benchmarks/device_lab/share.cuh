#pragma once
// The lab's device memory, and the step as the program does it.

#include <vector>

#include "device_lab/column.hpp"
#include "device_lab/fused_layout.cuh"
#include "gpu/kernels/cells/binning.hpp"
#include "gpu/kernels/nodes/nodes.cuh"
#include "gpu/kernels/p2g/p2g_launch.cuh"
#include "gpu/memory/refresh.hpp"

namespace moraine::gpu::lab {

using moraine::lab::BoxTables;
using moraine::lab::Column;
using moraine::lab::Motion;

template <class T>
void zero(const Array<T>& a, cudaStream_t stream = nullptr) {
    check(cudaMemsetAsync(a.data(), 0, a.size() * sizeof(T), stream), "Emptying");
}

/// Tables, tiles, nodes, accounts and columns of particles.
template <class Real>
class Memory {
  public:
    Memory(const BoxTables& box, std::size_t slots, std::size_t ids) : own_(box.own), node_blocks_(box.node_blocks) {
        position_.assign(box.position), node_position_.assign(box.node_position);
        neighbour_.assign(box.neighbour), node_block_.assign(box.node_block), source_.assign(box.source);
        border_.resize(box.node_blocks), zero(border_);
        tile_of.assign(std::vector<std::int32_t>(std::size_t(own_), -1));
        std::vector<std::int32_t> self(static_cast<std::size_t>(node_blocks_));
        std::iota(self.begin(), self.end(), 0);
        node_of_.assign(self);
        tiles.resize(std::size_t(own_) * power<3>(tile_side(3)) * node_reals), zero(tiles);
        nodes_.resize(std::size_t(node_blocks_) * Block<3>::cells * node_reals), zero(nodes_);
        accounts_.resize(account_parts), zero(accounts_);
        for (auto& r : row) r.resize(slots), zero(r);
        std::vector<std::uint64_t> counted(ids);
        std::iota(counted.begin(), counted.end(), 0);
        id.assign(counted);
    }

    View<Real, 3> view(const Motion&) const {
        View<Real, 3> v{};
        v.table = {own_,
                   0,
                   position_.data(),
                   neighbour_.data(),
                   node_block_.data(),
                   border_.data(),
                   node_blocks_,
                   node_position_.data(),
                   source_.data(),
                   border_.data()};
        v.grid = {tile_of.data(), tiles.data(), node_of_.data(), nodes_.data()};
        for (int r = 0; r < core_rows<3>; ++r) v.p.core[r] = row[r].data();
        v.p.id = id.data();
        v.context.inverse_cell = Real(1);
        v.accounts = accounts_.data();
        return v;
    }

    Array<Row<Real>> row[core_rows<3>];
    Array<std::uint64_t> id;
    Array<std::int32_t> tile_of;
    Array<Real> tiles;

  private:
    int own_, node_blocks_;
    Array<Vec<std::int32_t, 3>> position_, node_position_;
    Array<std::int32_t> neighbour_, node_block_, source_, node_of_;
    Array<std::uint8_t> border_;
    Array<Real> nodes_;
    Array<Account<3>> accounts_;
};

/// Row r of the particle that begins so.
template <class Real>
Row<Real> first_row(const moraine::lab::Seed<Real>& seed, const Motion& motion, int r) {
    CoreRows<Real, 3> p{};
    for (int a = 0; a < 3; ++a) p.set_coordinate(a, seed.u[a]);
    p.mass() = Real(motion.density / 8), p.volume() = Real(0.125);
    p.velocity(0) = Real(motion.speed), p.velocity(2) = Real(seed.velocity_z);
    return p.row[r];
}

template <class Real>
GatherArgs<Real, 3> gather_args(const Motion& motion) {
    GatherArgs<Real, 3> g{};
    g.flip = Real(1);
    g.dt = Real(motion.dt);
    g.quantum = Quantum::for_largest(1e12);
    return g;
}

/// The stream of a share's steps.
class LabStream {
  public:
    LabStream() { check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "Making a stream"); }
    LabStream(const LabStream&) = delete;
    LabStream& operator=(const LabStream&) = delete;
    ~LabStream() { cudaStreamDestroy(stream_); }
    operator cudaStream_t() const { return stream_; }

  private:
    cudaStream_t stream_ = nullptr;
};

template <class Real>
NodeWork<Real, 3> node_work(const View<Real, 3>& v, const Motion& motion) {
    NodeRound<Real, 3> round{NodeTask::solve, Real(motion.dt), zero_vec<Real, 3>(), Real(0),
                             Real(motion.density / 8 * (sizeof(Real) == 8 ? 1e-18 : 1e-12))};
    return {v, round, Quadratic::origin, Quantum::for_largest(1e12), {}, {}, {}};
}

template <class Real>
using LabCase = P2gCase<Real, 3, Quadratic, false>;

}  // namespace moraine::gpu::lab
