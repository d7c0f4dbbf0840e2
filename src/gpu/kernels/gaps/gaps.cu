#include "core/structures/particle_depth.hpp"
#include "gpu/kernels/gaps/gaps.hpp"
#include "gpu/kernels/nodes/node_work.hpp"
#include "gpu/kernels/seen.cuh"

namespace moraine::gpu {

namespace {

constexpr int gap_threads = 128;

template <class Real, int Dim>
struct GapWork {
    View<Real, Dim> view;
    ContactField<Dim> contact;
    const ContactPair* pairs;
    NodeGap* tiles;
    const GroundBound<Dim>* bounds;  ///< by own block; null: there is no ground

    /// What bounds a structure over a block; null: nothing.
    __device__ const GroundBound<Dim>* bound(int structure, std::int32_t block) const {
        return bounds && contact.structure[structure].shape == StructureShape::ground ? bounds + block : nullptr;
    }
};

/// Half of a particle's box per axis, where the shape has one [cells].
template <class Shape, class Real, int Dim>
__device__ __forceinline__ Vec<Real, Dim> half_box(const View<Real, Dim>& v, std::uint32_t s) {
    Vec<Real, Dim> half = zero_vec<Real, Dim>();
    if constexpr (Shape::sized) {
        const Vec<Real, Dim>& size = v.context.half_size[v.p.body[s]];
        for (int a = 0; a < Dim; ++a)
            half[a] = held_half(v.p.log_stretch ? stretched_half(size[a], v.p.log_stretch[s].e[a]) : size[a]);
    }
    return half;
}

template <class Real, int Dim, class Shape, bool Turns>
__global__ void __launch_bounds__(gap_threads, 1) gaps_kernel(const __grid_constant__ GapWork<Real, Dim> w) {
    constexpr int nodes = power<Dim>(tile_side(Shape::width));
    __shared__ std::int32_t gap[nodes];
    __shared__ std::uint32_t area[nodes];
    const ContactPair pair = w.pairs[blockIdx.x];
    const ListView<Dim>& list = w.view.list;
    if (list.count(pair.block) == 0) return;
    for (int n = static_cast<int>(threadIdx.x); n < nodes; n += gap_threads) gap[n] = NodeGap::none, area[n] = 0;
    __syncthreads();
    const Structure<Dim>& structure = w.contact.structure[pair.structure];
    const Vec<std::int32_t, Dim> block = w.view.table.position[pair.block];
    const bool border = w.view.table.border[pair.block] != 0;
    const GroundBound<Dim>* bound = w.bound(pair.structure, pair.block);
    for (std::uint32_t k = list.first[pair.block] + threadIdx.x; k < list.first[pair.block + 1]; k += gap_threads) {
        const std::uint32_t s = list.slot[k];
        CoreRows<Real, Dim> core;
        core.row[CoreRows<Real, Dim>::place] = w.view.p.core[CoreRows<Real, Dim>::place][s];
        Vec<Coordinate<Real>, Dim> u;
        for (int a = 0; a < Dim; ++a) u[a] = core.coordinate(a);
        const Vec<double, Dim> x = contact_place<Real>(w.contact, structure, block, u);
        if (bound && bound->is_clear(x)) continue;
        core.row[CoreRows<Real, Dim>::volume_row] = w.view.p.core[CoreRows<Real, Dim>::volume_row][s];
        core.row[CoreRows<Real, Dim>::ln_J_row] = w.view.p.core[CoreRows<Real, Dim>::ln_J_row][s];
        const double distance = surface<Turns>(structure, w.contact.corners, x).distance / w.contact.cell;
        ParticleGap own = gap_at<Real, Dim>(w.contact, lying_at_nodes(), distance, core.volume(), core.ln_J());
        if (own.gap == NodeGap::none) continue;
        own.area = bearing_area(w.contact, structure, own.area, w.view.p.body[s],
                                [&](int n) { return w.view.p.history(n)[s]; });
        each_gap_node<Shape>(w.view.context.walls, border, block, u, half_box<Shape>(w.view, s), own,
                             [&](int n, const NodeGap& told) {
                                 atomicMin(gap + n, told.gap);
                                 atomicAdd(area + n, told.area);
                             });
    }
    __syncthreads();
    NodeGap* to = w.tiles + std::size_t(pair.tile) * nodes;
    for (int n = static_cast<int>(threadIdx.x); n < nodes; n += gap_threads) to[n] = NodeGap{gap[n], area[n]};
}

/// A thread block per block: it takes all structures in turn.
template <class Real, int Dim, bool Turns>
__global__ void __launch_bounds__(gap_threads, 1)
    depths_kernel(const __grid_constant__ GapWork<Real, Dim> w, const __grid_constant__ DomainEnds<Real, Dim> ends,
                  const int count) {
    constexpr int row = CoreRows<Real, Dim>::place;
    const std::int32_t block = w.pairs[blockIdx.x].block;
    const ListView<Dim>& list = w.view.list;
    each_of_block(w.pairs, count, static_cast<int>(blockIdx.x), [&](int k) {
        const GroundBound<Dim>* bound = w.bound(k, block);
        for (std::uint32_t i = list.first[block] + threadIdx.x; i < list.first[block + 1]; i += gap_threads) {
            const std::uint32_t s = list.slot[i];
            CoreRows<Real, Dim> core;
            core.row[row] = w.view.p.core[row][s];
            Vec<Coordinate<Real>, Dim> u;
            for (int a = 0; a < Dim; ++a) u[a] = core.coordinate(a);
            bool buried = false;
            const bool moved = limit_depth<Real, Dim, Turns>(w.contact, w.contact.structure[k], ends,
                                                             w.view.table.position[block], u, &buried, bound);
            if (buried) note_fault(account_of(w.view), fault_buried, w.view.p.id[s]);
            if (!moved) continue;
            for (int a = 0; a < Dim; ++a) core.set_coordinate(a, u[a]);
            w.view.p.core[row][s] = core.row[row];
        }
    });
}

/// A thread per node.
template <int Dim>
__global__ void __launch_bounds__(gap_threads, 1)
    ground_kernel(const BlockTable<Dim> table, const __grid_constant__ ContactField<Dim> contact, const int origin,
                  GroundNode<Dim>* nodes) {
    constexpr int cells = Block<Dim>::cells;
    const int c = static_cast<int>(blockIdx.x) * (gap_threads / cells) + static_cast<int>(threadIdx.x) / cells;
    const int n = static_cast<int>(threadIdx.x) % cells;
    if (c >= table.node_blocks) return;
    const Structure<Dim>& ground = contact.structure[0];
    int lowest[Dim], node[Dim];
    for (int a = 0; a < Dim; ++a) {
        lowest[a] = 4 * table.node_position[c][a] - origin;
        node[a] = lowest[a] + ((n >> (2 * a)) & 3);
    }
    GroundNode<Dim> found{{far_from_ground, zero_vec<double, Dim>()}, 0, 0};
    if (is_near(contact, ground, lowest))
        found = ground_node(ground, contact.corners, node_place(contact, ground, node, 0.0));
    nodes[std::size_t(c) * cells + std::size_t(n)] = found;
}

template <class Shape, class Real, int Dim>
void launch_gaps(const GapWork<Real, Dim>& work, unsigned grid, cudaStream_t stream) {
    const auto kernel =
        work.contact.turning ? gaps_kernel<Real, Dim, Shape, true> : gaps_kernel<Real, Dim, Shape, false>;
    kernel<<<grid, gap_threads, 0, stream>>>(work);
}

template <class Real, int Dim>
GapWork<Real, Dim> work_of(const View<Real, Dim>& view, const ContactField<Dim>& contact, const DeviceGaps<Dim>& gaps,
                           const Array<ContactPair>& pairs) {
    return {view, contact, pairs.data(), gaps.tiles(), gaps.bounds()};
}

}  // namespace

template <int Dim>
GroundNode<Dim>* DeviceGaps<Dim>::ground(const BlockTable<Dim>& table, const ContactField<Dim>& contact, int origin,
                                         cudaStream_t stream) {
    if (!pairs_.bounds() || table.node_blocks == 0) return nullptr;
    if (knows_ground_) return ground_.data();
    constexpr int blocks = gap_threads / Block<Dim>::cells;
    const auto count = static_cast<std::size_t>(table.node_blocks);
    if (count * Block<Dim>::cells > ground_.capacity()) ground_.reserve((count + count / 8) * Block<Dim>::cells);
    ground_.resize(count * Block<Dim>::cells);
    const auto grid = static_cast<unsigned>((table.node_blocks + blocks - 1) / blocks);
    ground_kernel<Dim><<<grid, gap_threads, 0, stream>>>(table, contact, origin, ground_.data());
    check(cudaGetLastError(), "Finding the ground");
    knows_ground_ = true;
    return ground_.data();
}

template <class Real, int Dim>
void limit_depths(const View<Real, Dim>& view, const DomainEnds<Real, Dim>& ends, const ContactField<Dim>& contact,
                  const DeviceGaps<Dim>& gaps, const Array<ContactPair>& pairs, cudaStream_t stream) {
    if (pairs.size() == 0) return;
    const auto kernel = contact.turning ? depths_kernel<Real, Dim, true> : depths_kernel<Real, Dim, false>;
    kernel<<<static_cast<unsigned>(pairs.size()), gap_threads, 0, stream>>>(work_of(view, contact, gaps, pairs), ends,
                                                                            static_cast<int>(pairs.size()));
    check(cudaGetLastError(), "Limiting depths");
}

template <class Real, int Dim>
void find_gaps(const View<Real, Dim>& view, Shape shape, const ContactField<Dim>& contact, const DeviceGaps<Dim>& gaps,
               const Array<ContactPair>& pairs, cudaStream_t stream) {
    if (pairs.size() == 0) return;
    const auto grid = static_cast<unsigned>(pairs.size());
    const GapWork<Real, Dim> work = work_of(view, contact, gaps, pairs);
    switch (shape) {
        case Shape::linear:
            launch_gaps<Linear>(work, grid, stream);
            break;
        case Shape::quadratic:
            launch_gaps<Quadratic>(work, grid, stream);
            break;
        case Shape::cubic:
            launch_gaps<Cubic>(work, grid, stream);
            break;
        default:
            launch_gaps<Gimp>(work, grid, stream);
    }
    check(cudaGetLastError(), "Finding gaps");
}

template class DeviceGaps<2>;
template class DeviceGaps<3>;
template void limit_depths(const View<float, 2>&, const DomainEnds<float, 2>&, const ContactField<2>&,
                           const DeviceGaps<2>&, const Array<ContactPair>&, cudaStream_t);
template void find_gaps(const View<float, 2>&, Shape, const ContactField<2>&, const DeviceGaps<2>&,
                        const Array<ContactPair>&, cudaStream_t);
template void limit_depths(const View<float, 3>&, const DomainEnds<float, 3>&, const ContactField<3>&,
                           const DeviceGaps<3>&, const Array<ContactPair>&, cudaStream_t);
template void find_gaps(const View<float, 3>&, Shape, const ContactField<3>&, const DeviceGaps<3>&,
                        const Array<ContactPair>&, cudaStream_t);
template void limit_depths(const View<double, 2>&, const DomainEnds<double, 2>&, const ContactField<2>&,
                           const DeviceGaps<2>&, const Array<ContactPair>&, cudaStream_t);
template void find_gaps(const View<double, 2>&, Shape, const ContactField<2>&, const DeviceGaps<2>&,
                        const Array<ContactPair>&, cudaStream_t);
template void limit_depths(const View<double, 3>&, const DomainEnds<double, 3>&, const ContactField<3>&,
                           const DeviceGaps<3>&, const Array<ContactPair>&, cudaStream_t);
template void find_gaps(const View<double, 3>&, Shape, const ContactField<3>&, const DeviceGaps<3>&,
                        const Array<ContactPair>&, cudaStream_t);

}  // namespace moraine::gpu
