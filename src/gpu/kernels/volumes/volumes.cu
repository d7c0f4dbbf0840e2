#include "gpu/kernels/nodes/nodes.cuh"
#include "gpu/kernels/volumes/volumes.hpp"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

namespace {

constexpr int volume_threads = 128;

/// Weight of node `index` of a particle's stencil along an axis, with what folded ghosts give it.
template <class Shape, class Real>
__device__ __forceinline__ Real weight_of(Real f, Real half, unsigned ghosts, int index) {
    Real w[Shape::width], dw[Shape::width];
    Shape::weights(f, half, w, dw);
    if constexpr (Shape::width > 2) fold_weights<Shape::width>(ghosts, w, dw);
    Real found = w[0];
#pragma unroll
    for (int i = 1; i < Shape::width; ++i) found = index == i ? w[i] : found;
    return found;
}

/// w_ip V_p of the node that is at `index` in the stencil of the particle in slot s.
template <class Shape, class Real, int Dim>
__device__ __forceinline__ Real volume_at(const View<Real, Dim>& v, std::uint32_t s, const int (&index)[Dim],
                                          const unsigned (&ghosts)[Dim]) {
    using Core = CoreRows<Real, Dim>;
    Core p;
    p.row[Core::place] = load_row(v.p.core[Core::place] + s);
    if constexpr (Core::volume_row != Core::place) p.row[Core::volume_row] = load_row(v.p.core[Core::volume_row] + s);
    Real share = p.volume();
#pragma unroll
    for (int a = 0; a < Dim; ++a) {
        Real half = Real(0);
        if constexpr (Shape::sized) {
            half = v.context.half_size[v.p.body[s]][a];
            half = held_half(v.p.log_stretch ? stretched_half(half, v.p.log_stretch[s].e[a]) : half);
        }
        share *= weight_of<Shape>(fraction_of<Real>(p.coordinate(a)), half, ghosts[a], index[a]);
    }
    return share;
}

/// A thread per node: the cells that reach it, in order, and their lists.
template <class Real, int Dim, class Shape>
__global__ void __launch_bounds__(volume_threads, 1)  // without a number the compiler spilled a register or two
    volumes_kernel(const __grid_constant__ View<Real, Dim> v, const Chosen chosen) {
    constexpr int side = tile_side(Shape::width), nodes = power<Dim>(side), cells = Block<Dim>::cells;
    const std::uint32_t count = *chosen.count;
    for (std::uint32_t item = blockIdx.x; item < count; item += gridDim.x) {
        const int block = chosen.block[item];
        const bool border = v.table.border[block] != 0;
        const std::uint32_t* bounds = v.list.cell_first + std::size_t(block) * (cells + 1);
        const std::uint32_t begin = v.list.first[block];
        auto* tile = reinterpret_cast<Row<Real>*>(v.grid.tiles) + std::size_t(v.grid.tile_of[block]) * nodes * 2;
        for (int n = static_cast<int>(threadIdx.x); n < nodes; n += volume_threads) {
            Real sum = Real(0);
            for (int c = 0; c < cells; ++c) {
                int index[Dim], rest = n;
                unsigned ghosts[Dim];
                bool reached = true;
                for (int a = 0; a < Dim; ++a, rest /= side) {
                    const int cell = cell_coordinate<Dim>(c, a);
                    index[a] = rest % side - cell;
                    reached = reached && index[a] >= 0 && index[a] < Shape::width;
                    const int base = first_node<Shape>(v.table.position[block][a]) + cell;
                    ghosts[a] = border ? v.context.walls.ghosts(a, base, Shape::width) : 0u;
                }
                if (!reached) continue;
                for (std::uint32_t k = begin + bounds[c]; k < begin + bounds[c + 1]; ++k)
                    sum += volume_at<Shape>(v, v.list.slot[k], index, ghosts);
            }
            store_row(tile + 2 * n, Row<Real>{{sum, Real(0), Real(0), Real(0)}});
            store_row(tile + 2 * n + 1, Row<Real>{});
        }
    }
}

template <class Real, int Dim>
struct CountWork {
    View<Real, Dim> view;
    NodeCapacity<Real, Dim> capacity;
    int origin;
    double inverse_volume;
    Quantum quantum;
    ExactSum* sums;
};

template <class Real, int Dim, int Width>
__global__ void __launch_bounds__(node_threads) count_kernel(const __grid_constant__ CountWork<Real, Dim> w) {
    constexpr int cells = Block<Dim>::cells;
    const int c = static_cast<int>(blockIdx.x) * (node_threads / cells) + static_cast<int>(threadIdx.x) / cells;
    const int n = static_cast<int>(threadIdx.x) % cells;
    const TilesAround<Dim> around(w.view.table, w.view.grid.tile_of, c);
    if (__all_sync(all_lanes, around.own == 0)) return;
    Quad<Real> sums, others;
    const bool counted = sum_tiles<Dim, Width>(w.view.grid.tiles, around, n, sums, others);
    ExactSum mine[2];
    if (counted) {
        int node[Dim];
        for (int a = 0; a < Dim; ++a) node[a] = 4 * w.view.table.node_position[c][a] - w.origin + ((n >> (2 * a)) & 3);
        const double full = double(sums[0]) * w.inverse_volume, above = full - double(w.capacity.of(node));
        if (above > 0) mine[0] = w.quantum.of(above);
        mine[1] = w.quantum.of(full);
    }
    fold_sums(mine, w.sums);
}

template <class Real, int Dim, int Width>
void run_count(const CountWork<Real, Dim>& work, cudaStream_t stream) {
    constexpr int blocks = node_threads / Block<Dim>::cells;
    const auto grid = static_cast<unsigned>((work.view.table.node_blocks + blocks - 1) / blocks);
    if (grid == 0) return;
    count_kernel<Real, Dim, Width><<<grid, node_threads, 0, stream>>>(work);
    check(cudaGetLastError(), "Counting volumes");
}

}  // namespace

template <class Real, int Dim>
void sum_volumes(const View<Real, Dim>& view, Shape shape, const Chosen& chosen, int blocks, cudaStream_t stream) {
    const auto grid = static_cast<unsigned>(blocks < 1 ? 1 : blocks);
    switch (shape) {
        case Shape::linear:
            volumes_kernel<Real, Dim, Linear><<<grid, volume_threads, 0, stream>>>(view, chosen);
            break;
        case Shape::quadratic:
            volumes_kernel<Real, Dim, Quadratic><<<grid, volume_threads, 0, stream>>>(view, chosen);
            break;
        case Shape::cubic:
            volumes_kernel<Real, Dim, Cubic><<<grid, volume_threads, 0, stream>>>(view, chosen);
            break;
        default:
            volumes_kernel<Real, Dim, Gimp><<<grid, volume_threads, 0, stream>>>(view, chosen);
    }
    check(cudaGetLastError(), "Summing volumes");
}

template <class Real, int Dim>
void count_volumes(const View<Real, Dim>& view, const Stencil& stencil, const NodeCapacity<Real, Dim>& capacity,
                   double inverse_volume, ExactSum* sums, cudaStream_t stream) {
    const CountWork<Real, Dim> work{view, capacity, stencil.origin, inverse_volume, NodeVolumes::quantum(), sums};
    if (stencil.width == 2)
        run_count<Real, Dim, 2>(work, stream);
    else if (stencil.width == 3)
        run_count<Real, Dim, 3>(work, stream);
    else
        run_count<Real, Dim, 4>(work, stream);
}

/// Of one precision and dimension.
#define MORAINE_VOLUMES(Real, Dim)                                                                              \
    template void sum_volumes(const View<Real, Dim>&, Shape, const Chosen&, int, cudaStream_t);                 \
    template void count_volumes(const View<Real, Dim>&, const Stencil&, const NodeCapacity<Real, Dim>&, double, \
                                ExactSum*, cudaStream_t);
MORAINE_VOLUMES(float, 2)
MORAINE_VOLUMES(float, 3)
MORAINE_VOLUMES(double, 2)
MORAINE_VOLUMES(double, 3)

}  // namespace moraine::gpu
