#pragma once
// The kernel over cells of a substep (gpu/kernels/pressure/pressure.hpp): a team per block of particles, and the cell
// of a thread's rank stays in its registers. Whole cells go axis by axis, the others layer by layer.

#include "gpu/kernels/g2p/gather_tile.cuh"
#include "gpu/kernels/pressure/layer_factors.cuh"
#include "gpu/kernels/pressure/pressure_work.hpp"
#include "gpu/kernels/pressure/whole_cells.cuh"
#include "gpu/kernels/team.cuh"

namespace moraine::gpu {

template <class Real, int Dim>
struct PressuresShared {
    static constexpr int cells = Block<Dim>::cells, tile_nodes = power<Dim>(nodes_along);
    using Factors = LayerFactors<Real, Dim>;

    Real velocity[Dim][tile_nodes];
    Real pushed[Dim][tile_nodes];  ///< by cells that are not whole: sum_c G_ic (P_c + d dP_c)
    BlockBasis<Real, Dim> basis;
    union {
        AxisSums<Real, Dim> axes;
        Factors factors;
    };
    Real part[parts<Dim>][layer_cells];
    Real force[cells];        ///< P_c + d dP_c
    Real force_whole[cells];  ///< the same, 0 of cells that are not whole
    KindMasks<Dim> kinds;
};

/// A block.
template <class Real, int Dim>
struct AdvancePressures {
    using T = Team<Dim>;
    using Shared = PressuresShared<Real, Dim>;
    using Factors = typename Shared::Factors;
    static constexpr int cells = Shared::cells, tile_nodes = Shared::tile_nodes;
    static constexpr int layer_nodes = Dim == 3 ? 36 * 3 : 36;

    /// The cell of this thread.
    struct Mine {
        Quad<Real> state;  ///< V_c, P_c, dP_c, dl_c
        Real bulk, source;
        CellKind kind;
    };

    const View<Real, Dim>& v;
    const PressureView<Real, Dim>& pressure;
    const PressureTask<Real>& task;
    int block;
    Shared& shared;

    __device__ __forceinline__ std::size_t first_cell() const {
        return std::size_t(v.grid.tile_of[block]) * std::size_t(cells);
    }

    __device__ __forceinline__ Mine load() const {
        Mine mine{Quad<Real>::zero(), Real(0), Real(0), no_part};
        if (T::rank() < cells) {
            const CellPressure<Real>& cell = pressure.cell[first_cell() + std::size_t(T::rank())];
            mine.state = load_row(reinterpret_cast<const Quad<Real>*>(&cell));
            mine.bulk = cell.bulk, mine.source = cell.source;
            mine.kind = !(mine.state[0] > Real(0)) ? no_part : cell.whole ? whole_kind : by_moments;
        }
        shared.kinds.tell(mine.kind);
        if (task.updates)
            for (int n = T::rank(); n < tile_nodes; n += T::threads) {
                const Row<Real> row = load_row(node_in_tile<nodes_along>(v, block, n));
#pragma unroll
                for (int a = 0; a < Dim; ++a) shared.velocity[a][n] = row.e[a];
            }
        T::sync();
        return mine;
    }

    __device__ __forceinline__ void update(Real rate, Mine& mine) const {
        const Real step = task.dt * (rate - task.time * mine.source);
        mine.state[2] = mine.bulk * step;
        mine.state[1] += mine.state[2];
        mine.state[3] += step;
        store_row(reinterpret_cast<Quad<Real>*>(&pressure.cell[first_cell() + std::size_t(T::rank())]), mine.state);
    }

    __device__ __forceinline__ void tell_force(const Mine& mine) const {
        const int c = T::rank();
        const Real force = mine.kind == no_part ? Real(0) : mine.state[1] + task.damping * mine.state[2];
        shared.force[c] = force;
        shared.force_whole[c] = mine.kind == whole_kind ? force : Real(0);
    }

    /// All cells but those by moments, which follow.
    __device__ __forceinline__ void advance_whole(Mine& mine) const {
        if (task.updates && shared.kinds.any_whole())
            divergence_of_whole<Real, Dim>(shared.velocity, shared.axes, [&](int, Real sum) {
                if (mine.kind == whole_kind) update(v.context.inverse_cell * sum, mine);
            });
        if (T::rank() < cells) tell_force(mine);
        T::sync();
    }

    /// This thread's part of a cell's flux.
    __device__ __forceinline__ void find_part(int layer) const {
        const int cell = T::rank() % layer_cells, c = layer * layer_cells + cell;
        if (shared.kinds.kind[c] != by_moments) return;
        const int corner = tile_offset<Dim, 3>(c);
        Real flux = Real(0);
        Factors::each_of_part([&](int n, int at) {
#pragma unroll
            for (int a = 0; a < Dim; ++a) flux += shared.factors.of[a][n][cell] * shared.velocity[a][corner + at];
        });
        shared.part[T::rank() / layer_cells][cell] = flux;
    }

    __device__ __forceinline__ void advance_mine(int layer, Mine& mine) const {
        const int c = T::rank();
        if (c / layer_cells != layer || mine.kind != by_moments) return;
        Real flux = Real(0);
#pragma unroll
        for (int p = 0; p < parts<Dim>; ++p) flux += shared.part[p][c % layer_cells];
        update(flux / mine.state[0], mine);
        tell_force(mine);
    }

    /// What a layer's cells give their nodes.
    __device__ __forceinline__ void push(int layer) const {
        for (int n = T::rank(); n < layer_nodes; n += T::threads) {
            const int at = n + 36 * layer;
            Vec<Real, Dim> sum;
#pragma unroll
            for (int a = 0; a < Dim; ++a) sum[a] = shared.pushed[a][at];
            Factors::each_cell(n, [&](int cell, int of) {
                const int c = layer * layer_cells + cell;
                if (shared.kinds.kind[c] != by_moments) return;
#pragma unroll
                for (int a = 0; a < Dim; ++a) sum[a] += shared.factors.of[a][of][cell] * shared.force[c];
            });
#pragma unroll
            for (int a = 0; a < Dim; ++a) shared.pushed[a][at] = sum[a];
        }
    }

    /// The cells by moments.
    __device__ __forceinline__ void advance_layers(Mine& mine) const {
        find_basis(v, block, shared.basis);
        if (task.sums)
            for (int n = T::rank(); n < tile_nodes; n += T::threads) {
#pragma unroll
                for (int a = 0; a < Dim; ++a) shared.pushed[a][n] = Real(0);
            }
        T::sync();
#pragma unroll 1
        for (int layer = 0; layer < layers<Dim>; ++layer) {
            if (!shared.kinds.any_in(layer)) continue;
            shared.factors.find(pressure.moments + first_cell(), shared.kinds, shared.basis, layer,
                                v.context.inverse_cell);
            T::sync();
            if (task.updates) {
                find_part(layer);
                T::sync();
                advance_mine(layer, mine);
                T::sync();
            }
            if (task.sums) {
                push(layer);
                T::sync();
            }
        }
    }

    __device__ __forceinline__ Quad<Real>* tile() const {
        return reinterpret_cast<Quad<Real>*>(v.grid.tiles) +
               std::size_t(v.grid.tile_of[block]) * std::size_t(2 * tile_nodes);
    }

    __device__ __forceinline__ void store_forces(bool layered) const {
        Real area = v.context.inverse_cell;
#pragma unroll
        for (int a = 0; a < Dim; ++a) area /= v.context.inverse_cell;
        sum_whole<Real, Dim>(shared.force_whole, shared.axes, [&](int n, const Real(&sums)[Dim]) {
            Quad<Real> force = Quad<Real>::zero();
#pragma unroll
            for (int a = 0; a < Dim; ++a) {
                force[a] = -area * sums[a];
                if (layered) force[a] -= shared.pushed[a][n];
            }
            store_row(tile() + 2 * n + 1, force);
        });
    }

    __device__ __forceinline__ void run() const {
        Mine mine = load();
        const bool layered = shared.kinds.any_by_moments();
        advance_whole(mine);
        if (layered) advance_layers(mine);
        if (task.sums) {
            store_forces(layered);
        }
        T::sync();
    }
};

/// Thread blocks of a multiprocessor that are wanted.
template <class Real>
inline constexpr int advance_blocks = sizeof(Real) == 8 ? 5 : 7;

template <class Real, int Dim>
__global__ void __launch_bounds__(Team<Dim>::block_threads, advance_blocks<Real>)
    advance_pressures_kernel(const __grid_constant__ View<Real, Dim> v, const Chosen chosen,
                             const __grid_constant__ PressureView<Real, Dim> pressure, const PressureTask<Real> task) {
    using T = Team<Dim>;
    extern __shared__ __align__(32) unsigned char memory[];
    auto& shared = reinterpret_cast<PressuresShared<Real, Dim>*>(memory)[T::index()];
    const std::uint32_t count = *chosen.count;
#pragma unroll 1
    for (std::uint32_t item = T::first(); item < count; item += T::stride())
        AdvancePressures<Real, Dim>{v, pressure, task, chosen.block[item], shared}.run();
}

}  // namespace moraine::gpu
