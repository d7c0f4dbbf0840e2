#pragma once
// The kernels over nodes of gpu/kernels/pressure/pressure.hpp: a thread per node, as in gpu/kernels/nodes/nodes.cuh.

#include "gpu/kernels/nodes/nodes.cuh"
#include "gpu/kernels/pressure/cells_around.cuh"

namespace moraine::gpu {

/// What substeps want of a node (core/nodes/nodes.hpp: SolveNodes::hold).
template <bool Contact, class Real, int Dim>
__device__ __forceinline__ void hold_node(const HoldWork<Real, Dim>& w, int c, int n, const Quad<Real>& sums,
                                          const Quad<Real>& force, bool full) {
    const std::size_t at = std::size_t(c) * Block<Dim>::cells + std::size_t(n);
    const Real inverse = sums[0] > w.mass_cutoff ? Real(1) / sums[0] : Real(0);
    Quad<Real> first = Quad<Real>::zero(), second = Quad<Real>::zero();
    HeldNode<Real, Dim> held;
    int lowest[Dim], node[Dim];
#pragma unroll
    for (int a = 0; a < Dim; ++a) {
        first[a] = sums[1 + a] * inverse;
        held.acceleration[a] = force[a] * inverse;
        lowest[a] = 4 * w.view.table.node_position[c][a] - w.origin;
        node[a] = lowest[a] + ((n >> (2 * a)) & 3);
    }
    first[quad - 1] = sums[0];
    held.filling = force[quad - 1] * w.inverse_volume;
    if constexpr (Contact)
        second[quad - 1] = excess_of_node<3>(w.contact, w.capacity, c, n, lowest, node, held.filling, full);
    else
        second[quad - 1] = node_excess(held.filling, w.capacity.of(node), full);
    Quad<Real>* out = values_of_node(w.view, c, n);
    store_row(out, first);
    store_row(out + 1, second);
    if (w.pressure.velocity) store_row(w.pressure.velocity + at, first);
    w.pressure.held[at] = held;
}

template <class Real, int Dim, bool Contact>
__global__ void __launch_bounds__(node_threads, 1) hold_nodes_kernel(const __grid_constant__ HoldWork<Real, Dim> w) {
    each_node_block<Contact>(w.view.table, w.contact.near, [&](int c) {
        const int n = static_cast<int>(threadIdx.x) % Block<Dim>::cells;
        const TilesAround<Dim> around(w.view.table, w.view.grid.tile_of, c);
        if (w.marks.of && c == 0 && n < light_counts) w.marks.count[n] = 0;
        if (__all_sync(all_lanes, !around.wanted(w.view.table, c))) return;
        Quad<Real> sums, force;
        sum_tiles<Dim, 3>(w.view.grid.tiles, around, n, sums, force);
        if (w.marks.of) mark_light<Real, Dim>(w.marks, c, w.view.table.node_blocks, n, sums[0]);
        const bool full = w.shifts && is_full_above<3>(w.view, w.capacity, w.origin, w.inverse_volume, around, c, n);
        if (around.wanted(w.view.table, c)) hold_node<Contact>(w, c, n, sums, force, full);
    });
}

/// The sums of a substep as those of a step, (m, q) and f (core/nodes/nodes.hpp: SolveNodes::take_held), and what
/// follows.
template <bool Contact, class Real, int Dim>
__device__ __forceinline__ void solve_substep_node(const SubstepWork<Real, Dim>& w, int c, int n, Quad<Real> first,
                                                   const HeldNode<Real, Dim>& held, const Real (&pushed)[Dim],
                                                   bool counted, ExactSum (&impulse)[Dim]) {
    const std::size_t at = std::size_t(c) * Block<Dim>::cells + std::size_t(n);
    Quad<Real>* out = values_of_node(w.view, c, n);
    Quad<Real>* velocity = velocity_of(w.view, w.pressure, at);
    const bool changes = !w.pressure.velocity;  // dv by substeps, or of the step at its end
    const bool ends = !changes && w.is_last;    // read here: behind the sums it took four times as long
    Quad<Real> second = changes || ends ? load_row(out + 1) : Quad<Real>::zero();
    const Quad<Real> start = ends ? load_row(out) : Quad<Real>::zero();
    const Real m = first[quad - 1];
    Quad<Real> sums = Quad<Real>::of(m, Real(0), Real(0), Real(0)), force = Quad<Real>::zero();
    NodeValues<Real, Dim> former;
#pragma unroll
    for (int a = 0; a < Dim; ++a) {
        former.first[a] = first[a], former.second[a] = second[a];
        sums[1 + a] = m * first[a];
        force[a] = pushed[a] + m * held.acceleration[a];
    }
    int node[Dim];
    const NodeValues<Real, Dim> now =
        advance_node<3, Contact, Real, Dim>(w, c, n, sums, force, former, counted, node, impulse);
#pragma unroll
    for (int a = 0; a < Dim; ++a) first[a] = now.first[a], second[a] = now.second[a];
    store_row(velocity, first);
    if (changes) return store_row(out + 1, second);
    if (!ends) return;
#pragma unroll
    for (int a = 0; a < Dim; ++a) second[a] = first[a] - start[a];
    store_row(out, first);
    store_row(out + 1, second);
}

template <class Real, int Dim, bool Contact>
__global__ void __launch_bounds__(node_threads, 1) substep_kernel(const __grid_constant__ SubstepWork<Real, Dim> w) {
    using Cells = CellsAround<Real, Dim>;
    __shared__ Cells of_warps[node_threads / Cells::lanes];
    Cells& cells = of_warps[threadIdx.x / Cells::lanes];
    each_node_block<Contact>(w.view.table, w.contact.near, [&](int c) {
        const int n = static_cast<int>(threadIdx.x) % Block<Dim>::cells;
        const std::size_t at = std::size_t(c < w.view.table.node_blocks ? c : 0) * Block<Dim>::cells + std::size_t(n);
        const Quad<Real> former = load_row(velocity_of(w.view, w.pressure, at));  // under way with the tiles
        const HeldNode<Real, Dim> held = w.pressure.held[at];
        const TilesAround<Dim> around(w.view.table, w.view.grid.tile_of, c);
        if (__all_sync(all_lanes, !around.wanted(w.view.table, c))) return;
        cells.load(w.view, w.pressure, around, n);
        Real pushed[Dim];
        cells.sum(n, pushed);
#pragma unroll
        for (int a = 0; a < Dim; ++a) pushed[a] *= -w.area;
        take_cut_cells(w.view, w.pressure, around, n, pushed);
        const bool counted = around.first_is_own(n, 3);
        ExactSum impulse[Dim];
        if (around.wanted(w.view.table, c))
            solve_substep_node<Contact>(w, c, n, former, held, pushed, counted, impulse);
        fold_sums(impulse, w.view.accounts[blockIdx.x % account_parts].impulse);
    });
}

}  // namespace moraine::gpu
