#pragma once
// Who is near to each element, and how much of it soil lies on (core/surfaces/element_rule.hpp: tell_ring): a thread
// block per pair of a block and a structure, whole numbers in shared memory, as gpu/kernels/gaps/gaps.cu has it for
// nodes. The tiles are those of gaps, by the node in the middle of an element's cell. Threads first list the particles
// that are beside elements, which are few of a block and side by side, and then share these.

#include "core/structures/particle_depth.hpp"
#include "gpu/kernels/surfaces/surface_nodes.cuh"

namespace moraine::gpu {

template <class Real, int Dim>
struct SurfaceGaps {
    const SurfaceGapWork<Real, Dim>& w;
    const ContactPair& pair;
    const SurfaceBed<Dim>& bed;
    std::int32_t* gap;
    std::uint32_t* area;

    using Core = CoreRows<Real, Dim>;

    /// Coordinates and cell of a particle whose place is known.
    __device__ __forceinline__ int cell_at(const Core& core, Vec<Coordinate<Real>, Dim>& u) const {
        int c = 0;
        for (int a = 0; a < Dim; ++a) {
            u[a] = core.coordinate(a);
            c |= cell_of<Real>(u[a]) << (2 * a);
        }
        return c;
    }
    /// Whether a particle may be beside an element.
    __device__ __forceinline__ bool is_beside(std::uint32_t s, const Structure<Dim>& structure,
                                              const GroundBound<Dim>* bound) const {
        Core core;
        core.row[Core::place] = w.view.p.core[Core::place][s];
        Vec<Coordinate<Real>, Dim> u;
        const std::uint16_t* around = bed.first_around + cell_at(core, u);
        if (around[0] == around[1]) return false;
        return !bound ||
               !bound->is_clear(contact_place<Real>(w.field, structure, w.view.table.position[pair.block], u));
    }
    __device__ __forceinline__ void add(std::uint32_t s, const Structure<Dim>& structure) const {
        Core core;
        core.row[Core::place] = w.view.p.core[Core::place][s];
        Vec<Coordinate<Real>, Dim> u;
        Vec<double, Dim> x;
        const std::uint16_t* around = bed.first_around + cell_at(core, u);
        for (int a = 0; a < Dim; ++a) x[a] = cell_of<Real>(u[a]) + double(fraction_of<Real>(u[a])) - 0.5;
        const Vec<double, Dim> place = contact_place<Real>(w.field, structure, w.view.table.position[pair.block], u);
        core.row[Core::volume_row] = w.view.p.core[Core::volume_row][s];
        core.row[Core::ln_J_row] = w.view.p.core[Core::ln_J_row][s];
        const double distance = surface(structure, w.field.corners, place).distance / w.field.cell;
        ParticleGap own = gap_at<Real, Dim>(w.field, lying_on_elements(), distance, core.volume(), core.ln_J());
        if (own.gap == NodeGap::none) return;
        own.area =
            bearing_area(w.field, structure, own.area, w.view.p.body[s], [&](int n) { return w.view.p.history(n)[s]; });
        const RingElement<Dim>* ring = bed.ring;
        tell_ring(ring, bed.around + around[0], static_cast<std::uint32_t>(around[1] - around[0]), pair.structure, x,
                  own, [&](int n, const NodeGap& told) {
                      atomicMin(gap + ring[n].node, told.gap);
                      atomicAdd(area + ring[n].node, told.area);
                  });
    }
};

/// Particles that a thread block takes at a time, and those of them that are beside elements.
struct NearParticles {
    static constexpr std::uint32_t most = 512;
    std::uint32_t slot[most];
    int count;

    /// By whole warps.
    __device__ __forceinline__ void list(bool is, std::uint32_t s) {
        const unsigned lanes = __ballot_sync(all_lanes, is);
        int first = 0;
        if (lane_id() == 0 && lanes != 0) first = atomicAdd(&count, __popc(lanes));
        first = __shfl_sync(all_lanes, first, 0);
        if (is) slot[first + __popc(lanes & ((1u << lane_id()) - 1))] = s;
    }
};

template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1)
    surface_gaps_kernel(const __grid_constant__ SurfaceGapWork<Real, Dim> w) {
    constexpr int nodes = surface_tile<Dim>;
    __shared__ std::int32_t gap[nodes];
    __shared__ std::uint32_t area[nodes];
    __shared__ NearParticles beside;
    const ContactPair pair = w.pairs[blockIdx.x];
    const ListView<Dim>& list = w.view.list;
    const std::int32_t bed = w.tables.bed_of[pair.block];
    if (list.count(pair.block) == 0) return;
    for (int n = static_cast<int>(threadIdx.x); n < nodes; n += surface_threads) gap[n] = NodeGap::none, area[n] = 0;
    const Structure<Dim>& structure = w.field.structure[pair.structure];
    const bool ground = w.bounds && structure.shape == StructureShape::ground;
    const SurfaceGaps<Real, Dim> gaps{w, pair, w.tables.bed[bed < 0 ? 0 : bed], gap, area};
    const std::uint32_t end = bed < 0 ? 0 : list.first[pair.block + 1];
    for (std::uint32_t from = list.first[pair.block]; from < end; from += NearParticles::most) {
        if (threadIdx.x == 0) beside.count = 0;
        __syncthreads();
        for (std::uint32_t i = threadIdx.x; i < NearParticles::most; i += surface_threads) {
            const std::uint32_t s = from + i < end ? list.slot[from + i] : 0;
            beside.list(from + i < end && gaps.is_beside(s, structure, ground ? w.bounds + pair.block : nullptr), s);
        }
        __syncthreads();
        for (int i = static_cast<int>(threadIdx.x); i < beside.count; i += surface_threads)
            gaps.add(beside.slot[i], structure);
        __syncthreads();
    }
    if (bed < 0) __syncthreads();
    NodeGap* to = w.tiles + std::size_t(pair.tile) * nodes;
    for (int n = static_cast<int>(threadIdx.x); n < nodes; n += surface_threads) to[n] = NodeGap{gap[n], area[n]};
}

}  // namespace moraine::gpu
