#pragma once
// Who is near to each element, and how much of it soil lies on (core/surfaces/element_rule.hpp: tell_ring): a thread
// block per pair of a block and a structure, whole numbers in shared memory, as gpu/kernels/gaps/gaps.cu has it for
// nodes. The tiles are those of gaps, by the node in the middle of an element's cell.

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

    __device__ __forceinline__ void add(std::uint32_t s, const Structure<Dim>& structure,
                                        const GroundBound<Dim>* bound) const {
        using Core = CoreRows<Real, Dim>;
        Core core;
        core.row[Core::place] = w.view.p.core[Core::place][s];
        Vec<Coordinate<Real>, Dim> u;
        Vec<double, Dim> x;
        int c = 0;
        for (int a = 0; a < Dim; ++a) {
            u[a] = core.coordinate(a);
            c |= cell_of<Real>(u[a]) << (2 * a);
            x[a] = cell_of<Real>(u[a]) + double(fraction_of<Real>(u[a])) - 0.5;
        }
        const std::uint16_t* around = bed.first_around + c;
        if (around[0] == around[1]) return;
        const Vec<double, Dim> place = contact_place<Real>(w.field, structure, w.view.table.position[pair.block], u);
        if (bound && bound->is_clear(place)) return;
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

template <class Real, int Dim>
__global__ void __launch_bounds__(surface_threads, 1)
    surface_gaps_kernel(const __grid_constant__ SurfaceGapWork<Real, Dim> w) {
    constexpr int nodes = surface_tile<Dim>;
    __shared__ std::int32_t gap[nodes];
    __shared__ std::uint32_t area[nodes];
    const ContactPair pair = w.pairs[blockIdx.x];
    const ListView<Dim>& list = w.view.list;
    const std::int32_t bed = w.tables.bed_of[pair.block];
    if (list.count(pair.block) == 0) return;
    for (int n = static_cast<int>(threadIdx.x); n < nodes; n += surface_threads) gap[n] = NodeGap::none, area[n] = 0;
    __syncthreads();
    const Structure<Dim>& structure = w.field.structure[pair.structure];
    const bool ground = w.bounds && structure.shape == StructureShape::ground;
    const SurfaceGaps<Real, Dim> gaps{w, pair, w.tables.bed[bed < 0 ? 0 : bed], gap, area};
    const std::uint32_t end = bed < 0 ? 0 : list.first[pair.block + 1];
    for (std::uint32_t k = list.first[pair.block] + threadIdx.x; k < end; k += surface_threads)
        gaps.add(list.slot[k], structure, ground ? w.bounds + pair.block : nullptr);
    __syncthreads();
    NodeGap* to = w.tiles + std::size_t(pair.tile) * nodes;
    for (int n = static_cast<int>(threadIdx.x); n < nodes; n += surface_threads) to[n] = NodeGap{gap[n], area[n]};
}

}  // namespace moraine::gpu
