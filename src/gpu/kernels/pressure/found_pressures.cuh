#pragma once
// The kernel that finds the cells of a step (core/fluid/find_pressures.hpp): a team per block of particles. Particles
// are read by all threads, and summed cell by cell in their order.

#include "core/fluid/find_pressures.hpp"
#include "gpu/kernels/pressure/layer_factors.cuh"
#include "gpu/kernels/pressure/pressure_work.hpp"
#include "gpu/kernels/pressure/whole_cells.cuh"
#include "gpu/kernels/team.cuh"

namespace moraine::gpu {

/// Particles of a block, as many as are read at a time: all loads of a thread are under way at once. Numbers stand so
/// that threads of neighbouring cells, eight particles apart, read other banks.
template <class Real, int Dim>
struct StagedParticles {
    static constexpr int each = 4, count = each * Team<Dim>::threads, size = count + count / 32;
    Real volume[size], pressure[size], modulus[size];  ///< the latter two times the volume
    Real fraction[Dim][size];

    static __device__ __forceinline__ int place(int k) { return k + k / 32; }

    __device__ __forceinline__ void load(const Columns<Real, Dim>& p, const Real* of_body, const std::uint32_t* slot,
                                         int number) {
        using Core = CoreRows<Real, Dim>;
        std::uint32_t s[each];
        Core core[each];
        Real bulk[each];
#pragma unroll
        for (int r = 0; r < each; ++r) {
            const int k = Team<Dim>::rank() + r * Team<Dim>::threads;
            s[r] = slot[k < number ? k : number - 1];
        }
#pragma unroll
        for (int r = 0; r < each; ++r) {
            bulk[r] = of_body[p.body[s[r]]];
            core[r].row[Core::place] = load_row(p.core[Core::place] + s[r]);
            if constexpr (Core::volume_row != Core::place)
                core[r].row[Core::volume_row] = load_row(p.core[Core::volume_row] + s[r]);
            if constexpr (Core::normal != Core::volume_row)
                core[r].row[Core::normal] = load_row(p.core[Core::normal] + s[r]);
        }
#pragma unroll
        for (int r = 0; r < each; ++r) {
            const int k = place(Team<Dim>::rank() + r * Team<Dim>::threads);
            const Real V = bulk[r] > Real(0) ? core[r].volume() : Real(0);
            const Real trace = core[r].stress(0) + core[r].stress(1) + core[r].stress(2);
            volume[k] = V, pressure[k] = V * trace * Real(1.0 / 3.0), modulus[k] = V * bulk[r];
#pragma unroll
            for (int a = 0; a < Dim; ++a) fraction[a][k] = fraction_of<Real>(core[r].coordinate(a));
        }
    }
};

template <class Real, int Dim>
struct FindShared {
    static constexpr int sums = Dim * Dim + 1;
    typename PressureFinder<Real, Dim>::Nodes nodes;
    BlockBasis<Real, Dim> basis;
    union {
        StagedParticles<Real, Dim> staged;
        struct {
            CellMoments<Real, Dim> moments[Block<Dim>::cells];  ///< of those that are not whole
            LayerFactors<Real, Dim> factors;
            Real part[sums][parts<Dim>][layer_cells];  ///< L, then sum |G|^2 / m
        };
    };
    std::uint32_t place;  ///< in the list of such blocks
    KindMasks<Dim> kinds;
};

/// A block.
template <class Real, int Dim>
struct FindBlock {
    using T = Team<Dim>;
    using Found = typename PressureFinder<Real, Dim>::Found;
    using Shared = FindShared<Real, Dim>;
    static constexpr int cells = Block<Dim>::cells;

    const FindWork<Real, Dim>& work;
    int block;
    Shared& shared;

    __device__ __forceinline__ std::size_t tile() const { return std::size_t(work.view.grid.tile_of[block]); }
    __device__ __forceinline__ std::size_t first_cell() const { return tile() * cells; }

    __device__ __forceinline__ void sum_particles(Found& found, CellMoments<Real, Dim>& moments) const {
        const ListView<Dim>& list = work.finder.list;
        const std::uint32_t* bounds = list.cell_first + std::size_t(block) * (cells + 1);
        const int c = T::rank(), count = static_cast<int>(bounds[cells]);
        const int from = c < cells ? int(bounds[c]) : 0, to = c < cells ? int(bounds[c + 1]) : 0;
        auto& staged = shared.staged;
#pragma unroll 1
        for (int start = 0; start < count; start += staged.count) {
            const int number = count - start < staged.count ? count - start : staged.count;
            staged.load(work.view.p, work.pressure.bulk, list.slot + list.first[block] + start, number);
            T::sync();
            const int last = to - start < number ? to - start : number;
#pragma unroll 1
            for (int i = from > start ? from - start : 0; i < last; ++i) {
                const int k = staged.place(i);
                Real f[Dim];
#pragma unroll
                for (int a = 0; a < Dim; ++a) f[a] = staged.fraction[a][k];
                work.finder.add(staged.volume[k], staged.pressure[k], staged.modulus[k], f, found);
                if (!found.cell.whole) moments.add(staged.volume[k], f);
            }
            T::sync();
        }
    }

    /// This thread's part of L and of the weight of a cell of the layer.
    __device__ __forceinline__ void find_part(int layer) const {
        const int cell = T::rank() % layer_cells, c = layer * layer_cells + cell;
        if (shared.kinds.kind[c] != by_moments) return;
        const int corner = tile_offset<Dim, 3>(c);
        Mat<Real, Dim> L = zero_mat<Real, Dim>();
        Real weight = Real(0);
        LayerFactors<Real, Dim>::each_of_part([&](int n, int at) {
            Real square = Real(0);
#pragma unroll
            for (int b = 0; b < Dim; ++b) {
                const Real g = shared.factors.of[b][n][cell];
                square += g * g;
#pragma unroll
                for (int a = 0; a < Dim; ++a) L(a, b) += g * shared.nodes.velocity[corner + at][a];
            }
            const Real m = shared.nodes.mass[corner + at];
            if (m > Real(0)) weight += square / m;
        });
        const int p = T::rank() / layer_cells;
#pragma unroll
        for (int e = 0; e < Dim * Dim; ++e) shared.part[e][p][cell] = L(e / Dim, e % Dim);
        shared.part[Dim * Dim][p][cell] = weight;
    }

    __device__ __forceinline__ Real sum_of_parts(int e) const {
        Real sum = Real(0);
#pragma unroll
        for (int p = 0; p < parts<Dim>; ++p) sum += shared.part[e][p][T::rank() % layer_cells];
        return sum;
    }

    __device__ __forceinline__ void keep_factors(int layer) const {
        constexpr int each = CutFactors<Real, Dim>::each;
        Real* to = work.pressure.factors[tile()].of;
        for (int k = T::rank(); k < layer_cells * each; k += T::threads) {
            const int cell = k / each, e = k % each, c = layer * layer_cells + cell;
            if (shared.kinds.kind[c] != by_moments || e >= Dim * CutFactors<Real, Dim>::nodes) continue;
            to[shared.kinds.cut.before(c) * each + e] = (&shared.factors.of[0][0][cell])[e * layer_cells];
        }
    }

    /// The block goes to the substeps' lists.
    __device__ __forceinline__ void list_block() const {
        const bool cut = shared.kinds.cut.count() != 0;
        const CellBlocks<Dim>& blocks = work.blocks[cut];
        if (T::rank() == 0) {
            shared.place = atomicAdd(blocks.count, 1u);
            work.pressure.has_cut[tile()] = cut;
        }
        T::sync();
        CellBlock<Dim>& of = blocks.list[shared.place];
        if (T::rank() == 0) of.tile = static_cast<std::int32_t>(tile()), of.cut = shared.kinds.cut;
        if (T::rank() < Block<Dim>::corners)
            of.node_block[T::rank()] = work.view.table.node_block[block * Block<Dim>::corners + T::rank()];
    }

    __device__ __forceinline__ void close_layers(CellPressure<Real>& cell) const {
        find_basis(work.view, block, shared.basis);
        T::sync();
#pragma unroll 1
        for (int layer = 0; layer < layers<Dim>; ++layer) {
            if (!shared.kinds.any_in(layer)) continue;
            shared.factors.find(shared.moments, shared.kinds, shared.basis, layer, work.view.context.inverse_cell);
            T::sync();
            keep_factors(layer);
            find_part(layer);
            T::sync();
            const int c = T::rank();
            if (c / layer_cells == layer && shared.kinds.kind[c] == by_moments) {
                Mat<Real, Dim> L;
#pragma unroll
                for (int e = 0; e < Dim * Dim; ++e) L(e / Dim, e % Dim) = sum_of_parts(e);
                work.finder.close_cell(L, sum_of_parts(Dim * Dim), cell);
            }
            T::sync();
        }
    }

    __device__ __forceinline__ void close_whole(CellPressure<Real>& cell) const {
        Mat<Real, Dim> L = gradient_of_whole<Real, Dim>(shared.nodes.velocity + tile_offset<Dim, 3>(T::rank()));
        const Real area = cell.volume * work.view.context.inverse_cell;
#pragma unroll
        for (int e = 0; e < Dim * Dim; ++e) L(e / Dim, e % Dim) *= area;
        work.finder.close_cell(L, Real(0), cell);
    }

    /// Sums over the particles of the cell of this thread; its moments go to memory.
    __device__ __forceinline__ CellPressure<Real> open_cell() const {
        const int c = T::rank();
        Found found = {};
        if (c < cells) found = work.finder.begin(block, c, shared.nodes);
        shared.kinds.tell(c >= cells ? no_part : found.cell.whole ? whole_kind : by_moments);
        T::sync();
        CellMoments<Real, Dim> moments;
        moments.clear();
        sum_particles(found, moments);
        CellKind kind = no_part;
        if (c < cells && work.finder.close_sums(found, moments)) {
            kind = found.cell.whole ? whole_kind : by_moments;
            if (kind == by_moments) shared.moments[c] = moments;
        } else {
            found.cell = {};
        }
        shared.kinds.tell(kind);
        T::sync();
        return found.cell;
    }

    __device__ __forceinline__ void run() const {
        for (int n = T::rank(); n < power<Dim>(nodes_along); n += T::threads)
            work.finder.load_node(block, n, shared.nodes);
        T::sync();
        CellPressure<Real> cell = open_cell();
        const int c = T::rank();
        if (c < cells && shared.kinds.kind[c] == whole_kind) close_whole(cell);
        if (shared.kinds.cut.count() != 0) close_layers(cell);
        if (c < cells) work.finder.context.cell[first_cell() + std::size_t(c)] = cell;
        list_block();
        T::sync();
        if (c < cells && cell.volume > Real(0) && !(cell.bulk > Real(0))) work.finder.fill_hole(block, c);
        T::sync();
    }
};

/// Thread blocks of a multiprocessor that are wanted.
template <class Real>
inline constexpr int find_blocks = sizeof(Real) == 8 ? 4 : 6;

template <class Real, int Dim>
__global__ void __launch_bounds__(Team<Dim>::block_threads, find_blocks<Real>)
    find_pressures_kernel(const __grid_constant__ FindWork<Real, Dim> work, const std::uint32_t* number) {
    using T = Team<Dim>;
    extern __shared__ __align__(32) unsigned char memory[];
    auto& shared = reinterpret_cast<FindShared<Real, Dim>*>(memory)[T::index()];
    const std::uint32_t count = *number;
#pragma unroll 1
    for (std::uint32_t item = T::first(); item < count; item += T::stride())
        FindBlock<Real, Dim>{work, work.finder.chosen[item], shared}.run();
}

}  // namespace moraine::gpu
