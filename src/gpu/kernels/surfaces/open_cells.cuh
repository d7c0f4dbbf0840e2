#pragma once
// Pressures of cells beside surfaces (core/surfaces/open_rule.hpp): a thread block per giver, a thread per cell, then a
// thread per node of the tile, which adds up what the cells around it give; and a thread per node near a surface.

#include "core/surfaces/open_rule.hpp"
#include "gpu/kernels/pressure/pressure_work.hpp"
#include "gpu/kernels/surfaces/surface_nodes.cuh"

namespace moraine::gpu {

/// What the nodes of a cell hold (core/surfaces/open_rule.hpp).
template <class Real, int Dim>
struct OpenNodes {
    const OpenWork<Real, Dim>& w;
    const TileNodes<Dim>& nodes;
    int corner;

    __device__ __forceinline__ const Real* values(int at) const { return nodes.values(w, corner + at); }
    __device__ __forceinline__ const OpenNode& node(int at) const {
        const std::int32_t near = nodes.near[corner + at];
        return w.open.node[near / Block<Dim>::cells][near % Block<Dim>::cells];
    }
    __device__ __forceinline__ double distance(int at) const { return node(at).distance; }
    __device__ __forceinline__ double capacity(int at) const { return node(at).capacity; }
    __device__ __forceinline__ double filling(int at) const {
        return double(w.pressure.held[nodes.place[corner + at]].filling);
    }
};

/// A giver's cells.
template <class Real, int Dim>
struct OpenBlock : Giver<Real, Dim> {
    static constexpr int cells = Block<Dim>::cells;
    using Base = Giver<Real, Dim>;
    const OpenWork<Real, Dim>& all;

    __device__ __forceinline__ explicit OpenBlock(const OpenWork<Real, Dim>& w) : Base{w}, all(w) {}
    __device__ __forceinline__ OpenCell<Real, Dim>& cell(int c) const { return all.open.cell[this->g * cells + c]; }
    __device__ __forceinline__ const SurfaceCell<Dim>& place(int c) const { return this->bed.cells[c]; }
    __device__ __forceinline__ std::uint32_t particles() const { return all.view.list.count(this->block); }
    /// Of the grid's own pressures; the block is occupied.
    __device__ __forceinline__ CellPressure<Real>& pressure(int c) const {
        return all.pressure.cell[std::size_t(all.view.grid.tile_of[this->block]) * cells + std::size_t(c)];
    }
    __device__ __forceinline__ Vec<std::int32_t, Dim> node(int c) const {
        Vec<std::int32_t, Dim> n;
        for (int a = 0; a < Dim; ++a)
            n[a] = first_node<Quadratic>(all.view.table.position[this->block][a]) + 1 + ((c >> (2 * a)) & 3);
        return n;
    }
    /// The tile's node in the middle of the cell with which a cell has its pressure, which may be itself.
    __device__ __forceinline__ int root_node(int c) const {
        int n = tile_offset<Dim, 3>(c) + to_middle<Dim>;
        for (int a = 0, stride = 1; a < Dim && cell(c).child; ++a, stride *= tile_side(3))
            n += stride * place(c).root[a];
        return n;
    }
    __device__ __forceinline__ const Real* sum_at(const TileNodes<Dim>& nodes, int n) const {
        return all.open.sums + std::size_t(nodes.near[n]) * node_reals;
    }
    /// give(n, sum): adds what node n of the tile gets to the lanes of `sum`, zeros. By all threads.
    template <class Give>
    __device__ __forceinline__ void fill_tile(const Give& give) const {
        for (int n = static_cast<int>(threadIdx.x); n < surface_tile<Dim>; n += surface_threads) {
            Real sum[node_reals];
            for (int q = 0; q < node_reals; ++q) sum[q] = Real(0);
            give(n, sum);
            for (int q = 0; q < node_reals; ++q) this->tile()[n * node_reals + q] = sum[q];
        }
    }
    /// The same of the first quad alone.
    template <class Give>
    __device__ __forceinline__ void fill_quads(const Give& give) const {
        for (int n = static_cast<int>(threadIdx.x); n < surface_tile<Dim>; n += surface_threads) {
            Quad<Real> sum = Quad<Real>::zero();
            give(n, sum);
            store_row(reinterpret_cast<Quad<Real>*>(this->tile() + n * node_reals), sum);
        }
    }
    /// f(c, i) of the cells whose stencil has node n of the tile as its node i, ascending.
    template <class F>
    static __device__ __forceinline__ void each_cell(int n, const F& f) {
        constexpr int side = tile_side(3);
        int at[3] = {0, 0, 0};
        for (int a = 0, rest = n; a < Dim; ++a, rest /= side) at[a] = rest % side;
        for (int z = Dim == 3 ? 2 : 0; z >= 0; --z)
            for (int y = 2; y >= 0; --y)
                for (int x = 2; x >= 0; --x) {
                    const int cx = at[0] - x, cy = at[1] - y, cz = at[2] - z;
                    const bool is = cx >= 0 && cx < 4 && cy >= 0 && cy < 4 && cz >= 0 && cz < 4;
                    if (is) f(cx + 4 * (cy + 4 * cz), x + 3 * (y + 3 * z));
                }
    }
};

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

/// Cells by themselves, and what children tell their roots.
template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1)
    find_open_cells_kernel(const __grid_constant__ OpenWork<Real, Dim> w) {
    __shared__ TileNodes<Dim> nodes;
    const OpenBlock<Real, Dim> block(w);
    nodes.find(w, block.block);
    const int c = static_cast<int>(threadIdx.x);
    bool child = false;
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
            for (int q = 0; q < root_lanes; ++q) sum[sum_lane<Dim>(q)] = told_by_root(cell.state, q);
        }
    });
}

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
    structure_values(w.field, w.field.structure[structure], given, at, zero_vec<double, Dim>(), values);
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
            const Real head = to.head;
            to = cell.state;
            to.head = head;
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
        if (cell.on)
            cell.flux = flux_into(cell, w.field.structure[block.place(c).structure],
                                  OpenNodes<Real, Dim>{w, nodes, tile_offset<Dim, 3>(c)});
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
