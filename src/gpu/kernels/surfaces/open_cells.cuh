#pragma once
// Cells beside surfaces (core/surfaces/open_rule.hpp), once in a step: who takes part, who shares with whom, and what
// holes take. By givers (open_block.cuh), and by nodes near a surface.

#include "gpu/kernels/surfaces/open_block.cuh"

namespace moraine::gpu {

/// What nodes have without cells' forces; what holds no soil has nothing.
template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1) keep_held_kernel(const __grid_constant__ OpenWork<Real, Dim> w) {
    each_near_node(w, [&](int j, int c, int n) {
        if (j < 0) return;
        HeldNode<Real, Dim>& held = w.pressure.held[std::size_t(c) * Block<Dim>::cells + std::size_t(n)];
        bool soil = false;
        for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
            const std::int32_t source = w.view.table.source[c * Block<Dim>::corners + delta];
            soil = soil || (source >= 0 && w.view.grid.tile_of[source] >= 0);
        }
        if (!soil) held = HeldNode<Real, Dim>{};
        w.open.acceleration[std::size_t(j) * Block<Dim>::cells + std::size_t(n)] = held.acceleration;
    });
}

template <class Real, int Dim>
__device__ __forceinline__ void sum_cell(const OpenWork<Real, Dim>& w, int block, int c,
                                         CellMoments<Real, Dim>& moments, OpenCell<Real, Dim>& cell) {
    using Core = CoreRows<Real, Dim>;
    moments.clear();
    const ListView<Dim>& list = w.view.list;
    if (list.count(block) == 0) return;
    const std::uint32_t* bounds = list.cell_first + std::size_t(block) * (Block<Dim>::cells + 1) + c;
    for (std::uint32_t k = list.first[block] + bounds[0]; k < list.first[block] + bounds[1]; ++k) {
        const std::uint32_t s = list.slot[k];
        const Real bulk = w.pressure.bulk[w.view.p.body[s]];
        if (!(bulk > Real(0))) continue;
        Core core;
        core.row[Core::place] = w.view.p.core[Core::place][s];
        core.row[Core::volume_row] = w.view.p.core[Core::volume_row][s];
        core.row[Core::normal] = w.view.p.core[Core::normal][s];
        Real fraction[Dim];
        for (int a = 0; a < Dim; ++a) fraction[a] = fraction_of<Real>(core.coordinate(a));
        const Real V = core.volume(), trace = core.stress(0) + core.stress(1) + core.stress(2);
        moments.add(V, fraction);
        cell.particles += V;
        cell.state.pressure += V * trace * Real(1.0 / 3.0);
        cell.state.bulk += V * bulk;
    }
}

/// Cells by themselves, and M_i.
template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1)
    find_open_cells_kernel(const __grid_constant__ OpenWork<Real, Dim> w) {
    __shared__ TileNodes<Dim> nodes;
    const OpenBlock<Real, Dim> block(w);
    nodes.find(w, block.block);
    const int c = static_cast<int>(threadIdx.x);
    bool gives = false;
    if (c < block.cells) {
        OpenCell<Real, Dim>& cell = block.cell(c);
        const SurfaceCell<Dim>& place = block.place(c);
        cell.on = cell.child = false;
        if (place.near) {
            cell = OpenCell<Real, Dim>{};
            if (block.particles() > 0) block.pressure(c).volume = Real(0);
            if (place.part != CellPart::solid) {
                CellMoments<Real, Dim> moments;
                sum_cell(w, block.block, c, moments, cell);
                find_open_cell(w.open.grid, place, block.node(c), moments,
                               OpenNodes<Real, Dim>{w, nodes, tile_offset<Dim, 3>(c)}, cell);
            }
        }
        gives = cell.on;
    }
    const bool any = __syncthreads_or(gives);
    if (threadIdx.x == 0) block.gives(any);
    if (!any) return;
    block.fill_quads([&](int n, Quad<Real>& sum) {
        block.each_cell(n, [&](int k, int i) {
            const OpenCell<Real, Dim>& cell = block.cell(k);
            if (cell.on) sum[0] += size_of(cell.factor[i]);
        });
    });
}

/// R_c, and what children tell their roots.
template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1)
    weigh_open_cells_kernel(const __grid_constant__ OpenWork<Real, Dim> w) {
    __shared__ TileNodes<Dim> nodes;
    const OpenBlock<Real, Dim> block(w);
    nodes.find(w, block.block);
    const int c = static_cast<int>(threadIdx.x);
    bool child = false;
    if (c < block.cells && block.cell(c).on) {
        OpenCell<Real, Dim>& cell = block.cell(c);
        const int corner = tile_offset<Dim, 3>(c);
        weigh_open_cell(
            w.open.grid, OpenNodes<Real, Dim>{w, nodes, corner},
            [&](int at) { return block.sum_at(nodes, corner + at)[0]; }, cell);
        child = cell.child;
    }
    const bool any = __syncthreads_or(child);
    if (threadIdx.x == 0) block.gives(any), w.open.has_children[block.g] = any;
    if (!any) return;
    block.fill_tile([&](int n, Real* sum) {
        for (int k = 0; k < block.cells; ++k) {
            const OpenCell<Real, Dim>& cell = block.cell(k);
            if (!cell.child || block.root_node(k) != n) continue;
            for (int q = 0; q < child_lanes; ++q) sum[sum_lane<Dim>(q)] += told_by_child(cell, q);
        }
    });
}

/// The sums of a pass at nodes near surfaces; zeros where nobody gives.
template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1) sum_pass_kernel(const __grid_constant__ OpenWork<Real, Dim> w) {
    each_near_node(w, [&](int j, int c, int n) {
        if (j < 0) return;
        Quad<Real> sums[2];
        sum_given(w, c, n, sums);
        store_quads(w.open.sums + (std::size_t(j) * Block<Dim>::cells + std::size_t(n)) * node_reals, sums[0], sums[1]);
    });
}

/// Cells with their children, and what they tell holes beside them.
template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1)
    close_open_cells_kernel(const __grid_constant__ OpenWork<Real, Dim> w) {
    __shared__ TileNodes<Dim> nodes;
    const OpenBlock<Real, Dim> block(w);
    nodes.find(w, block.block);
    const int c = static_cast<int>(threadIdx.x);
    if (c < block.cells) {
        OpenCell<Real, Dim>& cell = block.cell(c);
        if (cell.on && !cell.child)
            close_open_cell(block.sum_at(nodes, tile_offset<Dim, 3>(c) + to_middle<Dim>), w.dt, w.damping, cell);
    }
    __syncthreads();
    const bool occupied = block.particles() > 0;
    if (threadIdx.x == 0) block.gives(occupied);
    if (!occupied) return;
    block.fill_tile([&](int n, Real* sum) {
        block.each_cell(n, [&](int k, int) {
            const OpenCell<Real, Dim>& cell = block.cell(k);
            const CellPressure<Real>* from = nullptr;
            if (cell.on && !cell.child && cell.particles > Real(0)) from = &cell.state;
            if (!block.place(k).near) from = &block.pressure(k);
            if (!from || !(from->volume > Real(0)) || !(from->bulk > Real(0))) return;
            sum[sum_lane<Dim>(hole_volume)] += from->volume;
            sum[sum_lane<Dim>(hole_pressure)] += from->volume * from->pressure;
            sum[sum_lane<Dim>(hole_bulk)] += from->volume * from->bulk;
        });
    });
}

/// Holes, and what roots tell their children.
template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1)
    fill_open_holes_kernel(const __grid_constant__ OpenWork<Real, Dim> w) {
    __shared__ TileNodes<Dim> nodes;
    const OpenBlock<Real, Dim> block(w);
    nodes.find(w, block.block);
    const int c = static_cast<int>(threadIdx.x);
    bool root = false;
    if (c < block.cells) {
        OpenCell<Real, Dim>& cell = block.cell(c);
        if (cell.on && !cell.child && !(cell.particles > Real(0)))
            fill_open_hole(block.sum_at(nodes, tile_offset<Dim, 3>(c) + to_middle<Dim>), cell);
        root = cell.on && !cell.child && cell.mixed;
    }
    const bool any = __syncthreads_or(root);
    if (threadIdx.x == 0) {
        block.gives(any);
        w.open.has_roots[block.g] = any;
    }
    if (!any) return;
    block.fill_tile([&](int n, Real* sum) {
        for (int k = 0; k < block.cells; ++k) {
            const OpenCell<Real, Dim>& cell = block.cell(k);
            if (tile_offset<Dim, 3>(k) + to_middle<Dim> != n || !cell.on || cell.child || !cell.mixed) continue;
            for (int q = 0; q < root_lanes; ++q) sum[sum_lane<Dim>(q)] = told_by_root(cell, q);
        }
    });
}

}  // namespace moraine::gpu
