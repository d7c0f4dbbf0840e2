#pragma once
// The kernels over cells of a substep (gpu/kernels/pressure/pressure.hpp): one for blocks whose cells are whole, with a
// thread per cell, and one for those with others, with a team per block. What a block is was found once in the step
// (CellBlock), so that all that a substep reads of it is under way at once.

#include "gpu/kernels/copy_async.cuh"
#include "gpu/kernels/pressure/layer_factors.cuh"
#include "gpu/kernels/pressure/pressure_work.hpp"
#include "gpu/kernels/pressure/whole_cells.cuh"
#include "gpu/kernels/team.cuh"

namespace moraine::gpu {

/// By axis.
template <class Real, int Dim>
using TileVelocities = Real[Dim][pressure_tile<Dim>];

/// The nodes of a block, by `threads` threads.
template <class Real, int Dim>
__device__ __forceinline__ void load_velocities(const AdvanceWork<Real, Dim>& w, const CellBlock<Dim>& of, int rank,
                                                int threads, TileVelocities<Real, Dim>& to) {
    for (int n = rank; n < pressure_tile<Dim>; n += threads) {
        int corner = 0, at = 0, rest = n;
#pragma unroll
        for (int a = 0; a < Dim; ++a) {
            const int x = rest % nodes_along;
            rest /= nodes_along;
            corner |= (x >> 2) << a;
            at |= (x & 3) << (2 * a);
        }
        const std::size_t stored = std::size_t(of.node_block[corner]) * Block<Dim>::cells + std::size_t(at);
        const Quad<Real> row = load_row(velocity_of(w.view, w.pressure, stored));
#pragma unroll
        for (int a = 0; a < Dim; ++a) to[a][n] = row[a];
    }
}

/// A cell between substeps, in the registers of its thread.
template <class Real, int Dim>
struct AdvancingCell {
    CellPressure<Real>* from;
    Quad<Real> state;  ///< V_c, P_c, dP_c, dl_c
    Real bulk, source;
    CellKind kind;

    __device__ __forceinline__ AdvancingCell(const AdvanceWork<Real, Dim>& w, std::int32_t tile, int c)
        : from(w.pressure.cell + std::size_t(tile) * Block<Dim>::cells + std::size_t(c)),
          state(load_row(reinterpret_cast<const Quad<Real>*>(from))),
          bulk(from->bulk),
          source(from->source),
          kind(!(state[0] > Real(0)) ? no_part
               : from->whole         ? whole_kind
                                     : by_moments) {}

    __device__ __forceinline__ void update(const PressureTask<Real>& task, Real rate) {
        const Real step = task.dt * (rate - task.time * source);
        state[2] = bulk * step;
        state[1] += state[2];
        state[3] += step;
        store_row(reinterpret_cast<Quad<Real>*>(from), state);
    }
    __device__ __forceinline__ Real divergence(const TileVelocities<Real, Dim>& velocity, int c) const {
        const Real* v[Dim];
#pragma unroll
        for (int a = 0; a < Dim; ++a) v[a] = velocity[a] + tile_offset<Dim, 3>(c);
        return divergence_of_whole<Real, Dim>(v);
    }
    /// P_c + d dP_c
    __device__ __forceinline__ Real force(const PressureTask<Real>& task) const {
        return kind == no_part ? Real(0) : state[1] + task.damping * state[2];
    }
};

/// What cells push other ranks' nodes with, into the halo's tiles: in the momentum's first lane that of whole cells, at
/// the nodes by which others know them (CellsAround), and in the second quad what the others push with. cut(axis,
/// node).
template <class Real, int Dim, class Cut>
__device__ __forceinline__ void tell_forces(const AdvanceWork<Real, Dim>& w, std::int32_t tile, int rank, int threads,
                                            const Real* whole, const Cut& cut) {
    constexpr int tile_nodes = pressure_tile<Dim>;
    Quad<Real>* out =
        reinterpret_cast<Quad<Real>*>(w.view.grid.tiles) + std::size_t(tile) * std::size_t(2 * tile_nodes);
    for (int n = rank; n < tile_nodes; n += threads) {
        int cell = 0, rest = n;
#pragma unroll
        for (int a = 0; a < Dim; ++a, rest /= nodes_along) {
            const int x = rest % nodes_along;
            cell |= (x < cells_along ? x : x - 2) << (2 * a);
        }
        Quad<Real> second = Quad<Real>::zero();
#pragma unroll
        for (int a = 0; a < Dim; ++a) second[a] = cut(a, n);
        reinterpret_cast<Real*>(out + 2 * n)[1] = whole[cell];
        store_row(out + 2 * n + 1, second);
    }
}

/// Threads of a block whose cells are whole, one per cell.
template <int Dim>
struct WholeTeam {
    static constexpr int threads = Block<Dim>::cells;
    static constexpr int per_block = Dim == 3 ? 1 : 8;  ///< teams of a thread block
    static constexpr int block_threads = threads * per_block;

    static __device__ __forceinline__ int rank() { return int(threadIdx.x) % threads; }
    static __device__ __forceinline__ int index() { return int(threadIdx.x) / threads; }
    static __device__ __forceinline__ void sync() {
        if constexpr (threads < 32)
            __syncwarp();
        else
            __syncthreads();
    }
};

template <class Real, int Dim>
struct WholeShared {
    TileVelocities<Real, Dim> velocity;
    Real force[Block<Dim>::cells];
};

template <class Real, int Dim>
__global__ void __launch_bounds__(WholeTeam<Dim>::block_threads, sizeof(Real) == 8 ? 12 : (Dim == 3 ? 20 : 10))
    advance_whole_kernel(const __grid_constant__ AdvanceWork<Real, Dim> w) {
    using T = WholeTeam<Dim>;
    __shared__ WholeShared<Real, Dim> all[T::per_block];
    WholeShared<Real, Dim>& shared = all[T::index()];
    const CellBlocks<Dim> blocks = w.blocks[0];
    const std::uint32_t count = *blocks.count;
    const int c = T::rank();
#pragma unroll 1
    for (std::uint32_t first = blockIdx.x * T::per_block; first < count; first += gridDim.x * T::per_block) {
        const std::uint32_t item = first + unsigned(T::index());
        const bool there = item < count;
        const CellBlock<Dim>& of = blocks.list[there ? item : first];
        AdvancingCell<Real, Dim> mine(w, of.tile, c);
        if (w.task.updates) load_velocities(w, of, c, T::threads, shared.velocity);
        T::sync();
        if (there && w.task.updates && mine.kind == whole_kind)
            mine.update(w.task, w.view.context.inverse_cell * mine.divergence(shared.velocity, c));
        const Real force = mine.force(w.task);
        if (w.task.sums && there) w.pressure.whole[std::size_t(of.tile) * Block<Dim>::cells + std::size_t(c)] = force;
        if (w.task.sums && w.task.tells) {
            shared.force[c] = force;
            T::sync();
            if (there) tell_forces(w, of.tile, c, T::threads, shared.force, [](int, int) { return Real(0); });
        }
        T::sync();
    }
}

template <class Real, int Dim>
struct CutShared {
    static constexpr int cells = Block<Dim>::cells;
    CutFactors<Real, Dim> factors;
    TileVelocities<Real, Dim> velocity;
    Real part[parts<Dim>][cells];
    Real cut[cells];          ///< P_c + d dP_c; 0 of whole cells
    Real whole[cells];        ///< the same; 0 of cells that are not whole
    std::int8_t cell[cells];  ///< those that are not whole, in their order
};

/// A block with cells that are not whole.
template <class Real, int Dim>
struct AdvanceCut {
    using T = Team<Dim>;
    using Shared = CutShared<Real, Dim>;
    using Factors = CutFactors<Real, Dim>;
    static constexpr int cells = Block<Dim>::cells, tile_nodes = pressure_tile<Dim>;

    const AdvanceWork<Real, Dim>& w;
    const CellBlock<Dim>& of;
    Shared& shared;

    /// Each cell's to its place.
    __device__ __forceinline__ void load_factors() const {
        constexpr int units = Factors::each / Factors::unit;  // of 16 bytes
        const auto* from = reinterpret_cast<const uint4*>(w.pressure.factors + of.tile);
        auto* to = reinterpret_cast<uint4*>(&shared.factors);
        for (int k = T::rank(); k < cells * units; k += T::threads) {
            const int c = k / units, u = k % units;
            if (of.cut.has(c))
                copy_async<16>(to + k, from + of.cut.before(c) * units + u);
            else
                to[k] = uint4{0, 0, 0, 0};
        }
        commit_async();
    }

    __device__ __forceinline__ void number_cells() const {
        const int c = T::rank();
        if (c < cells && of.cut.has(c)) shared.cell[of.cut.before(c)] = static_cast<std::int8_t>(c);
    }

    /// This thread's part of the fluxes of cells that are not whole.
    __device__ __forceinline__ void find_parts() const {
        const int p = T::rank() / layer_cells, count = of.cut.count();
#pragma unroll 1
        for (int k = T::rank() % layer_cells; k < count; k += layer_cells) {
            const int c = shared.cell[k], corner = tile_offset<Dim, 3>(c);
            const Real* factor = shared.factors.of + c * Factors::each;
            Real flux = Real(0);
#pragma unroll
            for (int n = p; n < Factors::nodes; n += parts<Dim>) {
                const int at = corner + n % 3 + nodes_along * (n / 3 % 3 + nodes_along * (n / 9));
#pragma unroll
                for (int a = 0; a < Dim; ++a) flux += factor[a * Factors::nodes + n] * shared.velocity[a][at];
            }
            shared.part[p][c] = flux;
        }
    }

    __device__ __forceinline__ Real flux_of(int c) const {
        Real flux = Real(0);
#pragma unroll
        for (int p = 0; p < parts<Dim>; ++p) flux += shared.part[p][c];
        return flux;
    }

    /// What cells that are not whole push node n of the tile with, in the order of offsets.
    __device__ __forceinline__ void sum_at(int n, Real (&sum)[Dim]) const {
        constexpr int layers_of_node = Dim == 3 ? 3 : 1;
        const int X = n % nodes_along, Y = n / nodes_along % nodes_along, Z = n / (nodes_along * nodes_along);
#pragma unroll
        for (int a = 0; a < Dim; ++a) sum[a] = Real(0);
#pragma unroll
        for (int k = layers_of_node - 1; k >= 0; --k)
#pragma unroll
            for (int j = 2; j >= 0; --j)
#pragma unroll
                for (int i = 2; i >= 0; --i) {
                    const int x = X - i, y = Y - j, z = Z - k;
                    if (unsigned(x) > 3 || unsigned(y) > 3 || unsigned(z) > 3) continue;
                    const int c = x + cells_along * (y + cells_along * z);
                    const Real* factor = shared.factors.of + c * Factors::each + (i + 3 * (j + 3 * k));
#pragma unroll
                    for (int a = 0; a < Dim; ++a) sum[a] += factor[a * Factors::nodes] * shared.cut[c];
                }
    }

    __device__ __forceinline__ void push() const {
        Real* cut = w.pressure.cut + std::size_t(of.tile) * std::size_t(Dim * tile_nodes);
        for (int n = T::rank(); n < tile_nodes; n += T::threads) {
            Real sum[Dim];
            sum_at(n, sum);
#pragma unroll
            for (int a = 0; a < Dim; ++a) cut[a * tile_nodes + n] = sum[a];
        }
        const int c = T::rank();
        if (c < cells) w.pressure.whole[std::size_t(of.tile) * cells + std::size_t(c)] = shared.whole[c];
        if (!w.task.tells) return;
        T::sync();
        tell_forces(w, of.tile, c, T::threads, shared.whole, [&](int a, int n) { return cut[a * tile_nodes + n]; });
    }

    __device__ __forceinline__ void run() const {
        load_factors();
        const int c = T::rank();
        AdvancingCell<Real, Dim> mine(w, of.tile, c % cells);
        if (w.task.updates) load_velocities(w, of, c, T::threads, shared.velocity);
        number_cells();
        wait_async<0>();
        T::sync();
        if (w.task.updates) {
            find_parts();
            T::sync();
        }
        if (c < cells) {
            if (w.task.updates && mine.kind == whole_kind)
                mine.update(w.task, w.view.context.inverse_cell * mine.divergence(shared.velocity, c));
            else if (w.task.updates && mine.kind == by_moments)
                mine.update(w.task, flux_of(c) / mine.state[0]);
            const Real force = mine.force(w.task);
            shared.cut[c] = mine.kind == by_moments ? force : Real(0);
            shared.whole[c] = mine.kind == whole_kind ? force : Real(0);
        }
        T::sync();
        if (w.task.sums) push();
        T::sync();
    }
};

/// Thread blocks of a multiprocessor that are wanted.
template <class Real>
inline constexpr int cut_blocks = sizeof(Real) == 8 ? 4 : 8;

template <class Real, int Dim>
__global__ void __launch_bounds__(Team<Dim>::block_threads, cut_blocks<Real>)
    advance_cut_kernel(const __grid_constant__ AdvanceWork<Real, Dim> w) {
    using T = Team<Dim>;
    extern __shared__ __align__(32) unsigned char memory[];
    auto& shared = reinterpret_cast<CutShared<Real, Dim>*>(memory)[T::index()];
    const CellBlocks<Dim> blocks = w.blocks[1];
    const std::uint32_t count = *blocks.count;
#pragma unroll 1
    for (std::uint32_t item = T::first(); item < count; item += T::stride())
        AdvanceCut<Real, Dim>{w, blocks.list[item], shared}.run();
}

}  // namespace moraine::gpu
