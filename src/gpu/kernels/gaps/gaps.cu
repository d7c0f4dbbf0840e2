#include "core/particle_depth.hpp"
#include "gpu/kernels/gaps/gaps.hpp"

namespace moraine::gpu {

namespace {

constexpr int gap_threads = 128;

template <class Real, int Dim>
struct GapWork {
    View<Real, Dim> view;
    ContactField<Dim> contact;
    const ContactPair* pairs;
    NodeGap* tiles;
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

template <class Real, int Dim, class Shape>
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
    for (std::uint32_t k = list.first[pair.block] + threadIdx.x; k < list.first[pair.block + 1]; k += gap_threads) {
        const std::uint32_t s = list.slot[k];
        CoreRows<Real, Dim> core;
        core.row[CoreRows<Real, Dim>::place] = w.view.p.core[CoreRows<Real, Dim>::place][s];
        core.row[CoreRows<Real, Dim>::volume_row] = w.view.p.core[CoreRows<Real, Dim>::volume_row][s];
        core.row[CoreRows<Real, Dim>::ln_J_row] = w.view.p.core[CoreRows<Real, Dim>::ln_J_row][s];
        Vec<Coordinate<Real>, Dim> u;
        for (int a = 0; a < Dim; ++a) u[a] = core.coordinate(a);
        const ParticleGap<Dim> own = gap_of<Real, Dim>(w.contact, structure, block, u, core.volume(), core.ln_J());
        if (own.gap == NodeGap::none) continue;
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
template <class Real, int Dim>
__global__ void __launch_bounds__(gap_threads, 1)
    depths_kernel(const __grid_constant__ GapWork<Real, Dim> w, const int count) {
    constexpr int row = CoreRows<Real, Dim>::place;
    const std::int32_t block = w.pairs[blockIdx.x].block;
    const ListView<Dim>& list = w.view.list;
    each_of_block(w.pairs, count, static_cast<int>(blockIdx.x), [&](int k) {
        for (std::uint32_t i = list.first[block] + threadIdx.x; i < list.first[block + 1]; i += gap_threads) {
            const std::uint32_t s = list.slot[i];
            CoreRows<Real, Dim> core;
            core.row[row] = w.view.p.core[row][s];
            Vec<Coordinate<Real>, Dim> u;
            for (int a = 0; a < Dim; ++a) u[a] = core.coordinate(a);
            if (!limit_depth<Real, Dim>(w.contact, w.contact.structure[k], w.view.table.position[block], u)) continue;
            for (int a = 0; a < Dim; ++a) core.set_coordinate(a, u[a]);
            w.view.p.core[row][s] = core.row[row];
        }
    });
}

}  // namespace

template <class Real, int Dim>
void limit_depths(const View<Real, Dim>& view, const ContactField<Dim>& contact, const Array<ContactPair>& pairs,
                  cudaStream_t stream) {
    if (pairs.size() == 0) return;
    depths_kernel<Real, Dim><<<static_cast<unsigned>(pairs.size()), gap_threads, 0, stream>>>(
        GapWork<Real, Dim>{view, contact, pairs.data(), nullptr}, static_cast<int>(pairs.size()));
    check(cudaGetLastError(), "Limiting depths");
}

template <class Real, int Dim>
void find_gaps(const View<Real, Dim>& view, Shape shape, const ContactField<Dim>& contact,
               const Array<ContactPair>& pairs, NodeGap* tiles, cudaStream_t stream) {
    if (pairs.size() == 0) return;
    const auto grid = static_cast<unsigned>(pairs.size());
    const GapWork<Real, Dim> work{view, contact, pairs.data(), tiles};
    switch (shape) {
        case Shape::linear:
            gaps_kernel<Real, Dim, Linear><<<grid, gap_threads, 0, stream>>>(work);
            break;
        case Shape::quadratic:
            gaps_kernel<Real, Dim, Quadratic><<<grid, gap_threads, 0, stream>>>(work);
            break;
        case Shape::cubic:
            gaps_kernel<Real, Dim, Cubic><<<grid, gap_threads, 0, stream>>>(work);
            break;
        default:
            gaps_kernel<Real, Dim, Gimp><<<grid, gap_threads, 0, stream>>>(work);
    }
    check(cudaGetLastError(), "Finding gaps");
}

template void find_gaps(const View<float, 2>&, Shape, const ContactField<2>&, const Array<ContactPair>&, NodeGap*,
                        cudaStream_t);
template void find_gaps(const View<float, 3>&, Shape, const ContactField<3>&, const Array<ContactPair>&, NodeGap*,
                        cudaStream_t);
template void find_gaps(const View<double, 2>&, Shape, const ContactField<2>&, const Array<ContactPair>&, NodeGap*,
                        cudaStream_t);
template void find_gaps(const View<double, 3>&, Shape, const ContactField<3>&, const Array<ContactPair>&, NodeGap*,
                        cudaStream_t);

template void limit_depths(const View<float, 2>&, const ContactField<2>&, const Array<ContactPair>&, cudaStream_t);
template void limit_depths(const View<float, 3>&, const ContactField<3>&, const Array<ContactPair>&, cudaStream_t);
template void limit_depths(const View<double, 2>&, const ContactField<2>&, const Array<ContactPair>&, cudaStream_t);
template void limit_depths(const View<double, 3>&, const ContactField<3>&, const Array<ContactPair>&, cudaStream_t);

}  // namespace moraine::gpu
