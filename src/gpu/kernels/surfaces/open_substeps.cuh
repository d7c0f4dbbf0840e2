#pragma once
// Pressures of cells beside surfaces (core/surfaces/open_rule.hpp) in each substep: their forces, and what flows in. By
// givers (open_block.cuh), and by nodes near a surface.

#include "gpu/kernels/surfaces/open_block.cuh"

namespace moraine::gpu {

/// What the structure bears of a cell's pressure.
template <class Real, int Dim>
__device__ __forceinline__ void tell_pressure(const OpenBlock<Real, Dim>& block, int c, double impulse) {
    const OpenWork<Real, Dim>& w = block.all;
    const int structure = block.place(c).structure;
    const Vec<std::int32_t, Dim> node = block.node(c);
    Vec<double, Dim> given, at;
    bool any = false;
    for (int a = 0; a < Dim; ++a) {
        given[a] = impulse * double(block.cell(c).bed[a]);
        any = any || given[a] != 0;
        at[a] = w.field.origin[a] + w.field.cell * node[a];
    }
    double values[StructureSums<Dim>::count];
    const Structure<Dim>& s = w.field.structure[structure];
    structure_values(w.field, s, given, at, zero_vec<double, Dim>(), values);
    if constexpr (may_turn)
        if (s.turns) {
            const Vec<double, Dim> arm = block.centre_of(c, s) - image_near(w.field, s, at);
            add_couple(s, impulse * couple_of(block.cell(c), arm, w.field.cell), values);
        }
    if (any) add_together(w.field.sums[structure].sum, w.quantum, values);
}

/// Children; what a substep's flux makes of the cells (w.updates); and their forces (w.presses).
template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1)
    press_open_cells_kernel(const __grid_constant__ OpenWork<Real, Dim> w) {
    __shared__ TileNodes<Dim> nodes;
    __shared__ Real force[Block<Dim>::cells];
    const OpenBlock<Real, Dim> block(w);
    nodes.find(w, block.block);
    const int c = static_cast<int>(threadIdx.x);
    bool on = false;
    if (c < block.cells) {
        OpenCell<Real, Dim>& cell = block.cell(c);
        if (w.takes_roots && cell.child) take_root(block.sum_at(nodes, block.root_node(c)), cell);
        if (w.updates && cell.on) {
            const Real flux = cell.child || cell.mixed ? block.sum_at(nodes, block.root_node(c))[0] : cell.flux;
            advance_open_cell(flux, static_cast<Real>(w.dt), static_cast<Real>(w.half_time), cell);
        }
        on = cell.on;
        force[c] = on ? cell.state.pressure + static_cast<Real>(w.damping) * cell.state.change : Real(0);
        if (!w.presses && on && block.particles() > 0) {
            CellPressure<Real>& to = block.pressure(c);
            to = finished_cell(cell, to.head);
        }
        if (w.presses && on) tell_pressure(block, c, double(force[c]) * w.dt);
    }
    const bool gives = __syncthreads_or(on);
    if (!w.presses) return;
    if (threadIdx.x == 0) block.gives(gives);
    if (!gives) return;
    block.fill_quads([&](int n, Quad<Real>& sum) {
        block.each_cell(n, [&](int k, int i) {
            const OpenCell<Real, Dim>& cell = block.cell(k);
            if (!cell.on) return;
            for (int a = 0; a < Dim; ++a) sum[a] -= cell.factor[i].gradient[a] * force[k];
        });
    });
}

/// The forces of cells, to what nodes hold.
template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1)
    hold_forces_kernel(const __grid_constant__ OpenWork<Real, Dim> w) {
    each_near_node(w, [&](int j, int c, int n) {
        Quad<Real> sums[1];
        if (j < 0 || !sum_given(w, c, n, sums)) return;
        const std::size_t at = std::size_t(c) * Block<Dim>::cells + std::size_t(n);
        const Real mass = w.view.grid.nodes[at * node_reals + quad - 1];
        Vec<Real, Dim> a = w.open.acceleration[std::size_t(j) * Block<Dim>::cells + std::size_t(n)];
        for (int b = 0; b < Dim && mass > w.mass_cutoff; ++b) a[b] += sums[0][b] / mass;
        w.pressure.held[at].acceleration = a;
    });
}

/// What flows into the cells, and the sums of those that share.
template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1)
    find_fluxes_kernel(const __grid_constant__ OpenWork<Real, Dim> w) {
    __shared__ TileNodes<Dim> nodes;
    __shared__ int root[Block<Dim>::cells];
    const OpenBlock<Real, Dim> block(w);
    nodes.find(w, block.block);
    const int c = static_cast<int>(threadIdx.x);
    if (c < block.cells) {
        OpenCell<Real, Dim>& cell = block.cell(c);
        root[c] = cell.on && (cell.child || cell.mixed) ? block.root_node(c) : -1;
        if (cell.on) {
            const Structure<Dim>& s = w.field.structure[block.place(c).structure];
            cell.flux = flux_into(cell, s, OpenNodes<Real, Dim>{w, nodes, tile_offset<Dim, 3>(c)});
            if constexpr (may_turn)
                if (s.turns)
                    cell.flux -=
                        static_cast<Real>(dot(s.spin, couple_of(cell, block.centre_of(c, s) - s.at, w.field.cell)));
        }
    }
    __syncthreads();
    const bool any = w.open.has_children[block.g] || w.open.has_roots[block.g];
    if (threadIdx.x == 0) block.gives(any);
    if (!any) return;
    block.fill_quads([&](int n, Quad<Real>& sum) {
        for (int k = 0; k < block.cells; ++k)
            if (root[k] == n) sum[0] += block.cell(k).flux;
    });
}

}  // namespace moraine::gpu
