#pragma once
// What tractions give particles, and the sums of that at the nodes of tiles (loads.hpp).

#include "gpu/kernels/g2p/box.cuh"
#include "gpu/kernels/loads/load_rows.cuh"
#include "gpu/kernels/loads/load_work.hpp"

namespace moraine::gpu {

inline constexpr int load_threads = 128;

/// What the particle in slot s is given.
template <class Real, int Dim>
__device__ ParticleLoad<Real, Dim> load_of(const LoadWork<Real, Dim>& w, const View<Real, Dim>& v, std::uint32_t s) {
    ParticleLoad<Real, Dim> load{zero_vec<Real, Dim>(), zero_mat<Real, Dim>()};
    const Mat<Real, Dim> F = DeformationRows<Real, Dim>(v.p, s).get();
    for (int k = 0; k < w.count; ++k) {
        const Real place = load_place(v.p, s, k);
        if (!(place > Real(0))) continue;
        constexpr int mass_row = moraine::place_of<Dim>("mass").row, mass_lane = moraine::place_of<Dim>("mass").lane;
        constexpr int scalar_row = moraine::place_of<Dim>("history_0").row,
                      scalar_lane = moraine::place_of<Dim>("history_0").lane;
        const int scalar = w.traction[k].density_scalar;
        Real inverse_density = w.traction[k].inverse_density;
        if (scalar >= 0)
            inverse_density = Real(1) / (scalar == 0 ? v.p.core[scalar_row][s].e[scalar_lane] : v.p.history(scalar)[s]);
        add_load(w.traction[k], w.factor[k], place, F, v.p.core[mass_row][s].e[mass_lane], inverse_density, load);
    }
    return load;
}

/// Finds what the particles of a block are given; whether any is under a traction. Whole thread blocks call it.
template <class Real, int Dim>
__device__ bool set_loads(const LoadWork<Real, Dim>& w, const View<Real, Dim>& v, int block) {
    const std::uint32_t begin = v.list.first[block] + threadIdx.x, end = v.list.first[block + 1];
    bool under = false;
    for (std::uint32_t k = begin; k < end; k += load_threads)
        for (int t = 0; t < w.count; ++t) under = under || load_place(v.p, v.list.slot[k], t) > Real(0);
    const bool any = __syncthreads_or(under) != 0;
    if (threadIdx.x == 0) w.loaded[block] = any ? 1 : 0;
    for (std::uint32_t k = begin; any && k < end; k += load_threads) w.of[k] = load_of(w, v, v.list.slot[k]);
    __syncthreads();
    return any;
}

/// Weight and slope [1/cell] of the particle in slot s at a node; o: its place in the stencil of the particle's cell c.
template <class Shape, class Real, int Dim>
__device__ void weigh(const View<Real, Dim>& v, int block, int c, const int (&o)[Dim], std::uint32_t s,
                      Real (&weight)[Dim], Real (&slope)[Dim]) {
    constexpr int width = Shape::width;
    CoreRows<Real, Dim> core;
    core.row[core.place] = v.p.core[core.place][s];
    Row<Real> stretch;
    if constexpr (Shape::sized)
        if (v.p.log_stretch) stretch = load_row(v.p.log_stretch + s);
#pragma unroll
    for (int a = 0; a < Dim; ++a) {
        Real n[width], dn[width];
        const Real half = Shape::sized ? half_size(v, v.p.body[s], stretch, a) : Real(0);
        Shape::weights(fraction_of<Real>(core.coordinate(a)), half, n, dn);
        if constexpr (width > 2)
            if (v.table.border[block] != 0) {
                const int base = first_node<Shape>(v.table.position[block][a]) + cell_coordinate<Dim>(c, a);
                fold_weights<width>(v.context.walls.ghosts(a, base, width), n, dn);
            }
        weight[a] = n[0], slope[a] = dn[0];
#pragma unroll
        for (int i = 1; i < width; ++i)
            if (o[a] == i) weight[a] = n[i], slope[a] = dn[i];
    }
}

/// Adds what the particles of cell c give to a node.
template <class Shape, class Real, int Dim>
__device__ void add_cell(const LoadWork<Real, Dim>& w, const View<Real, Dim>& v, int block, int c, const int (&o)[Dim],
                         Vec<Real, Dim>& sum) {
    const std::uint32_t* bounds = v.list.cell_first + std::size_t(block) * (Block<Dim>::cells + 1) + c;
    const std::uint32_t first = v.list.first[block];
    for (std::uint32_t k = first + bounds[0]; k < first + bounds[1]; ++k) {
        const ParticleLoad<Real, Dim> load = w.of[k];
        if (!acts(load)) continue;
        Real weight[Dim], slope[Dim];
        weigh<Shape>(v, block, c, o, v.list.slot[k], weight, slope);
        Real all = Real(1);
#pragma unroll
        for (int a = 0; a < Dim; ++a) all *= weight[a];
#pragma unroll
        for (int a = 0; a < Dim; ++a) sum[a] += all * load.force[a];
#pragma unroll
        for (int b = 0; b < Dim; ++b) {
            Real along = slope[b] * v.context.inverse_cell;
#pragma unroll
            for (int a = 0; a < Dim; ++a) along *= a == b ? Real(1) : weight[a];
#pragma unroll
            for (int a = 0; a < Dim; ++a) sum[a] += along * load.couple(a, b);
        }
    }
}

/// What the particles of a block give to node n of its tile [N].
template <class Shape, class Real, int Dim>
__device__ Vec<Real, Dim> force_at(const LoadWork<Real, Dim>& w, const View<Real, Dim>& v, int block, int n) {
    constexpr int width = Shape::width, side = tile_side(width);
    Vec<Real, Dim> sum = zero_vec<Real, Dim>();
#pragma unroll 1
    for (int q = 0; q < power<Dim>(width); ++q) {
        int o[Dim], c = 0;
        bool inside = true;
#pragma unroll
        for (int a = 0, of_node = n, of_stencil = q; a < Dim; ++a, of_node /= side, of_stencil /= width) {
            o[a] = of_stencil % width;
            const int at = of_node % side - o[a];
            inside = inside && at >= 0 && at < Block<Dim>::side;
            c |= at << (2 * a);
        }
        if (inside) add_cell<Shape>(w, v, block, c, o, sum);
    }
    return sum;
}

/// A thread block takes blocks in turn.
template <class Real, int Dim, class Shape>
__global__ void __launch_bounds__(load_threads, 1)
    loads_kernel(const __grid_constant__ LoadWork<Real, Dim> w, const __grid_constant__ View<Real, Dim> v,
                 const Chosen chosen) {
    constexpr int nodes = power<Dim>(tile_side(Shape::width));
    const std::uint32_t count = *chosen.count;
    for (std::uint32_t item = blockIdx.x; item < count; item += gridDim.x) {
        const int block = chosen.block[item];
        if (!(w.sets ? set_loads(w, v, block) : w.loaded[block] != 0)) continue;
        Real* tile = v.grid.tiles + std::size_t(v.grid.tile_of[block]) * nodes * node_reals;
        for (int n = static_cast<int>(threadIdx.x); n < nodes; n += load_threads) {
            const Vec<Real, Dim> sum = force_at<Shape>(w, v, block, n);
            for (int a = 0; a < Dim; ++a) tile[n * node_reals + quad + a] += sum[a];
        }
    }
}

}  // namespace moraine::gpu
