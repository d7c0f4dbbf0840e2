#pragma once
// Contact on surfaces (core/surfaces/element_rule.hpp): a thread block per giver, a warp per element or a thread per
// slave, then a warp per number that elements give, which adds to their nodes in their order, or a thread per node of
// the tile; and a thread per node near a surface, which sums the tiles.

#include "gpu/kernels/nodes/following.cuh"
#include "gpu/kernels/surfaces/surface_nodes.cuh"

namespace moraine::gpu {

/// The gap of an element, from the tiles around the middle of its cell.
template <class Real, int Dim>
__device__ __forceinline__ NodeGap gap_of_element(const SurfaceWork<Real, Dim>& w, int block,
                                                  const SurfaceElement<Dim>& e) {
    int corner = 0, at = 0;
    for (int a = 0; a < Dim; ++a) {
        const int x = ((e.cell >> (2 * a)) & 3) + 1;
        corner |= (x >> 2) << a, at |= (x & 3) << (2 * a);
    }
    const std::int32_t c = w.view.table.node_block[block * Block<Dim>::corners + corner];
    return gap_at_node(w.gaps, w.view.table, w.view.grid.tile_of, 3, c, at, e.structure);
}

/// Which elements the soil touches, and their W_i.
template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1)
    weigh_elements_kernel(const __grid_constant__ SurfaceWork<Real, Dim> w) {
    __shared__ TouchedElements<Dim> touched;
    __shared__ Real sums[node_reals][surface_tile<Dim>];
    const Giver<Real, Dim> giver{w};
    SurfaceElement<Dim>* elements = giver.bed.elements;
    bool touches = false;
    int cell = 0;
    if (static_cast<int>(threadIdx.x) < giver.bed.element_count) {
        SurfaceElement<Dim>& e = elements[threadIdx.x];
        double face = 1;
        for (int a = 1; a < Dim; ++a) face *= w.field.cell;
        take_gap(gap_of_element(w, giver.block, e), face, w.field.structure[e.structure].law, e);
        touches = e.touches, cell = e.cell;
    }
    const bool any = touched.find(touches, cell);
    if (threadIdx.x == 0) giver.gives(any);
    if (!any) return;
    for (int n = static_cast<int>(threadIdx.x); n < surface_tile<Dim> * node_reals; n += surface_threads)
        (&sums[0][0])[n] = Real(0);
    __syncthreads();
    for (int q = static_cast<int>(threadIdx.x) / 32; q <= SurfaceShares<Dim>::count; q += surface_threads / 32)
        touched.add(sums[sum_lane<Dim>(q)],
                    [&](int k, int i) { return static_cast<Real>(share_lane(elements[k], i, q)); });
    __syncthreads();
    for (int n = static_cast<int>(threadIdx.x); n < surface_tile<Dim> * node_reals; n += surface_threads)
        giver.tile()[n] = sums[n % node_reals][n / node_reals];
}

/// W_i of the nodes, and their masses, which not all nodes' kernels leave: 0 where no block has soil.
template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1)
    sum_shares_kernel(const __grid_constant__ SurfaceWork<Real, Dim> w) {
    each_near_node(w, [&](int j, int c, int n) {
        if (j < 0) return;
        Quad<Real> sums[2];
        sum_given(w, c, n, sums);
        const std::size_t at = std::size_t(j) * Block<Dim>::cells + std::size_t(n);
        store_quads(w.shares + at * node_reals, sums[0], sums[1]);
        Real mass = Real(0);
        for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
            const std::int32_t source = w.view.table.source[c * Block<Dim>::corners + delta];
            const std::int32_t tile = source < 0 ? -1 : w.view.grid.tile_of[source];
            const int from = tile < 0 ? -1 : tile_node<Dim>(n, delta, 3);
            if (from < 0) continue;
            mass += w.view.grid.tiles[(std::size_t(tile) * surface_tile<Dim> + std::size_t(from)) * node_reals];
        }
        w.view.grid.nodes[(std::size_t(c) * Block<Dim>::cells + std::size_t(n)) * node_reals + quad - 1] = mass;
    });
}

template <class Real, int Dim>
struct GivenByElements {
    TileNodes<Dim> nodes;
    TouchedElements<Dim> touched;
    ElementImpulse<Dim> impulse[Block<Dim>::cells];
    double heavy[Block<Dim>::cells];  ///< part of an element's weights whose nodes hold soil
    Real sums[Dim][surface_tile<Dim>];
};

/// N_e.
template <class Real, int Dim>
__device__ __forceinline__ double pressure_at(const SurfaceWork<Real, Dim>& w, int g, const SurfaceElement<Dim>& e) {
    return w.cells ? pressure_on_surface(w.cells[g * Block<Dim>::cells + e.cell], w.damping) : 0.0;
}

/// By a warp.
template <class Real, int Dim>
__device__ __forceinline__ void act_with_warp(const Giver<Real, Dim>& giver, int k,
                                              GivenByElements<Real, Dim>& shared) {
    const SurfaceWork<Real, Dim>& w = giver.w;
    SurfaceElement<Dim>& e = giver.bed.elements[k];
    const Structure<Dim>& s = w.field.structure[e.structure];
    const ElementNodes<Real, Dim> nodes{w, shared.nodes, tile_offset<Dim, 3>(e.cell)};
    if constexpr (may_turn)
        if (s.turns) {
            const Vec<double, Dim> place = middle_of(e, giver.centre_of(e.cell, s), w.field.cell, nodes);
            __syncwarp();
            if (lane_id() == 0) e.place = place;
            __syncwarp();
        }
    const ElementImpulse<Dim> impulse = act_on_element(e, s, w.time, pressure_at(w, giver.g, e), w.field.cell, nodes);
    const double heavy = nodes.template sum<1>([&](int i, int at, Vec<double, 1>& sum) {
        if (nodes.values(at)) sum[0] += e.weight[i];
    })[0];
    if (lane_id() == 0) shared.impulse[k] = impulse, shared.heavy[k] = heavy;
}

/// What an element gives to the structure.
template <class Real, int Dim>
__device__ __forceinline__ void tell_structure(const SurfaceWork<Real, Dim>& w, const SurfaceElement<Dim>& e,
                                               const ElementImpulse<Dim>& impulse, double heavy) {
    double all[StructureSums<Dim>::count];
    const Structure<Dim>& s = w.field.structure[e.structure];
    structure_values(w.field, s, heavy * impulse.given, e.place, impulse.follows, all);
    add_together(w.field.sums[e.structure].sum, w.quantum, all);
    if constexpr (may_turn)
        if (s.turns) tell_following(w.field, e.structure, w.quantum, following_of(e, s, impulse));
}

template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1)
    act_on_elements_kernel(const __grid_constant__ SurfaceWork<Real, Dim> w) {
    __shared__ GivenByElements<Real, Dim> shared;
    const Giver<Real, Dim> giver{w};
    if (w.tiles.tile_of[giver.block] < 0) return;
    const int k = static_cast<int>(threadIdx.x);
    for (int n = k; n < Dim * surface_tile<Dim>; n += surface_threads) (&shared.sums[0][0])[n] = Real(0);
    shared.nodes.find(w, giver.block);
    const SurfaceElement<Dim>* elements = giver.bed.elements;
    const bool touches = k < giver.bed.element_count && elements[k].touches;
    shared.touched.find(touches, touches ? elements[k].cell : 0);
    int turn = 0;
    shared.touched.each([&](int of) {
        if (turn++ % (surface_threads / 32) == k / 32) act_with_warp(giver, of, shared);
    });
    __syncthreads();
    if (touches) tell_structure(w, elements[k], shared.impulse[k], shared.heavy[k]);
    __syncwarp();
    for (int a = k / 32; a < Dim; a += surface_threads / 32)
        shared.touched.add(shared.sums[a], [&](int i, int node) {
            return -static_cast<Real>(elements[i].weight[node] * shared.impulse[i].given[a]);
        });
    __syncthreads();
    for (int n = k; n < surface_tile<Dim>; n += surface_threads) {
        Quad<Real> sum = Quad<Real>::zero();
        for (int a = 0; a < Dim && shared.nodes.stored[n] >= 0; ++a) sum[a] = shared.sums[a][n];
        store_row(reinterpret_cast<Quad<Real>*>(giver.tile() + n * node_reals), sum);
    }
}

template <int Dim>
struct GivenBySlaves {
    TileNodes<Dim> nodes;
    Slave slave[surface_threads];
    Vec<double, Dim> given[surface_threads];
    bool acts[surface_threads];
};

template <class Real, int Dim>
__device__ __forceinline__ bool close_slave(const SurfaceWork<Real, Dim>& w, const SlaveNode<Dim>& slave,
                                            const TileNodes<Dim>& tile, Vec<double, Dim>& given) {
    const ElementNodes<Real, Dim> nodes{w, tile, 0};
    const Real *own = nodes.values(slave.nodes.own), *one = nodes.values(slave.nodes.one),
               *two = nodes.values(slave.nodes.two);
    if (!slave_acts(own, one, two, nodes.shares(slave.nodes.own))) return false;
    given = slave_impulse(slave, w.field.structure[slave.surface.structure].law, own, one, two);
    return true;
}

/// What closes slaves.
template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1)
    close_slaves_kernel(const __grid_constant__ SurfaceWork<Real, Dim> w) {
    constexpr int mine = (surface_tile<Dim> + surface_threads - 1) / surface_threads;
    __shared__ GivenBySlaves<Dim> shared;
    const Giver<Real, Dim> giver{w};
    const int count = giver.bed.slave_count, k = static_cast<int>(threadIdx.x);
    const SlaveNode<Dim>* slaves = giver.bed.slaves;
    if (count > 0) shared.nodes.find(w, giver.block);
    Quad<Real> sum[mine];
#pragma unroll
    for (int r = 0; r < mine; ++r) sum[r] = Quad<Real>::zero();
    bool any = false;
    for (int from = 0; from < count; from += surface_threads) {
        const bool is = from + k < count;
        if (is) shared.slave[k] = slaves[from + k].nodes;
        shared.acts[k] = is && close_slave(w, slaves[from + k], shared.nodes, shared.given[k]);
        if (!__syncthreads_or(shared.acts[k])) continue;
        any = true;
        const int last = count - from < surface_threads ? count - from : surface_threads;
        for (int i = 0; i < last; ++i) {
            if (!shared.acts[i]) continue;
#pragma unroll
            for (int r = 0; r < mine; ++r) {
                const int n = k + r * surface_threads;
                const bool once = n == shared.slave[i].own || n == shared.slave[i].two,
                           twice = n == shared.slave[i].one;
#pragma unroll
                for (int a = 0; a < Dim; ++a) {
                    if (once) sum[r][a] += static_cast<Real>(shared.given[i][a]);
                    if (twice) sum[r][a] -= static_cast<Real>(2 * shared.given[i][a]);
                }
            }
        }
        __syncthreads();
    }
    if (k == 0) giver.gives(any);
    if (!any) return;
#pragma unroll
    for (int r = 0; r < mine; ++r) {
        const int n = k + r * surface_threads;
        if (n < surface_tile<Dim>) store_row(reinterpret_cast<Quad<Real>*>(giver.tile() + n * node_reals), sum[r]);
    }
}

/// Whether this rank counts what walls give a node: it owns the first occupied block whose tile covers it.
template <class Real, int Dim>
__device__ __forceinline__ bool is_counted_here(const View<Real, Dim>& v, int c, int n) {
    for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
        const std::int32_t source = v.table.source[c * Block<Dim>::corners + delta];
        if (source < 0 || v.grid.tile_of[source] < 0 || tile_node<Dim>(n, delta, 3) < 0) continue;
        return source < v.table.own;
    }
    return false;
}

/// A node's velocity with the impulse that it got, and walls again.
template <class Real, int Dim>
__device__ __forceinline__ void apply_to_node(const SurfaceWork<Real, Dim>& w, int c, int n, const Quad<Real>& impulse,
                                              ExactSum (&of_walls)[Dim]) {
    auto* values = reinterpret_cast<Quad<Real>*>(w.view.grid.nodes +
                                                 (std::size_t(c) * Block<Dim>::cells + std::size_t(n)) * node_reals);
    Quad<Real> first = load_row(values), second = load_row(values + 1);
    const Real mass = first[quad - 1];
    if (!(mass > w.mass_cutoff)) return;
    Vec<Real, Dim> v;
#pragma unroll
    for (int a = 0; a < Dim; ++a) v[a] = first[a] + impulse[a] / mass;
    Vec<Real, Dim> end = v;
    if (w.view.table.node_border[c] != 0) {
        int at[Dim];
        for (int a = 0; a < Dim; ++a) at[a] = 4 * w.view.table.node_position[c][a] - w.origin + ((n >> (2 * a)) & 3);
        w.view.context.walls.constrain(at, end);
        if (is_counted_here(w.view, c, n))
            for (int a = 0; a < Dim; ++a) of_walls[a] = w.quantum.of(double(mass) * (double(end[a]) - double(v[a])));
    }
#pragma unroll
    for (int a = 0; a < Dim; ++a) {
        second[a] += end[a] - first[a];
        first[a] = end[a];
    }
    store_row(values, first);
    store_row(values + 1, second);
}

/// Impulses to velocities.
template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1)
    apply_impulses_kernel(const __grid_constant__ SurfaceWork<Real, Dim> w) {
    each_near_node(w, [&](int j, int c, int n) {
        Quad<Real> impulse[1];
        ExactSum of_walls[Dim];
        if (j >= 0 && sum_given(w, c, n, impulse)) apply_to_node(w, c, n, impulse[0], of_walls);
        fold_sums(of_walls, w.view.accounts[blockIdx.x % account_parts].impulse);
    });
}

}  // namespace moraine::gpu
