#include "core/structures/contact.hpp"
#include "gpu/kernels/nodes/near_blocks.hpp"

namespace moraine::gpu {

namespace {

constexpr int near_threads = 128;

/// Whether a structure is near the node block c. Others look at none.
template <bool Turns, int Dim>
__device__ bool structure_near(const BlockTable<Dim>& table, const ContactField<Dim>& field, int origin, int c) {
    if (field.ground && field.ground[std::size_t(c) * Block<Dim>::cells].surface.distance < far_from_ground)
        return true;
    int lowest[Dim];
    for (int a = 0; a < Dim; ++a) lowest[a] = 4 * table.node_position[c][a] - origin;
    for (int k = 0; k < field.count; ++k) {
        const Structure<Dim>& s = field.structure[k];
        if (s.shape != StructureShape::ground && is_near<false, Turns>(field, s, lowest)) return true;
    }
    return false;
}

/// A thread per node block.
template <int Dim, bool Turns>
__global__ void __launch_bounds__(near_threads, 1)
    near_kernel(const BlockTable<Dim> table, const __grid_constant__ ContactField<Dim> field, const int origin,
                std::int32_t* list, std::uint32_t* count, std::uint8_t* mark) {
    const int c = static_cast<int>(blockIdx.x) * near_threads + static_cast<int>(threadIdx.x);
    if (c >= table.node_blocks) return;
    const bool near = structure_near<Turns>(table, field, origin, c);
    mark[c] = near;
    if (near) list[atomicAdd(count, 1u)] = c;
}

}  // namespace

template <int Dim>
NearBlocks DeviceNearBlocks<Dim>::find(const BlockTable<Dim>& table, const ContactField<Dim>& field, int origin,
                                       bool moves, cudaStream_t stream) {
    const auto blocks = static_cast<std::size_t>(table.node_blocks);
    if (!known_ || moves) {
        if (blocks > list_.capacity()) list_.reserve(blocks + blocks / 8), mark_.reserve(blocks + blocks / 8);
        list_.resize(blocks), mark_.resize(blocks), count_.resize(1);
        check(cudaMemsetAsync(count_.data(), 0, sizeof(std::uint32_t), stream), "Emptying the list of near blocks");
        const auto grid = static_cast<unsigned>((blocks + near_threads - 1) / near_threads);
        const auto kernel = field.turning ? near_kernel<Dim, true> : near_kernel<Dim, false>;
        if (grid > 0)
            kernel<<<grid, near_threads, 0, stream>>>(table, field, origin, list_.data(), count_.data(), mark_.data());
        check(cudaGetLastError(), "Finding blocks near structures");
        known_ = true;
    }
    return {list_.data(), count_.data(), mark_.data()};
}

template class DeviceNearBlocks<2>;
template class DeviceNearBlocks<3>;

}  // namespace moraine::gpu
