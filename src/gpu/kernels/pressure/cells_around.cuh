#pragma once
// What the cells around a node push it with (gpu/kernels/pressure/pressure.hpp), by warps: of whole cells, 3^d numbers
// in the order of offsets, w = (1/6, 2/3, 1/6) and g = (-1/2, 0, 1/2) axis by axis; of others the sums of their blocks,
// by offset. What is another rank's comes in the halo's tiles (AdvancePressures::tell_forces).

#include "gpu/kernels/nodes/tiles_around.cuh"
#include "gpu/kernels/pressure/pressure_work.hpp"
#include "gpu/kernels/pressure/whole_cells.cuh"

namespace moraine::gpu {

/// P_c + d dP_c of the cells that the nodes of a warp, or in 2-D of half a warp, are in reach of: two before the node
/// block and four of its own along an axis; in 3-D a warp has two layers of nodes, and four of cells.
template <class Real, int Dim>
struct CellsAround {
    static constexpr int along = 6, layers = Dim == 3 ? 4 : 1, lanes = TilesAround<Dim>::lanes;
    static constexpr int count = along * along * layers;

    Real of[count];

    /// Whole warps call it. n: this thread's node.
    __device__ __forceinline__ void load(const View<Real, Dim>& v, const PressureView<Real, Dim>& pressure,
                                         const TilesAround<Dim>& around, int n) {
        const int lane = n % lanes, lowest[3] = {0, 0, Dim == 3 ? 2 * (n / lanes) : 0};
#pragma unroll
        for (int k = lane; k < (count + lanes - 1) / lanes * lanes; k += lanes) {
            const int place[3] = {k % along, k / along % along, k / (along * along)};
            int delta = 0, cell = 0, told = 0;
#pragma unroll
            for (int a = Dim - 1; a >= 0; --a) {
                const int x = place[a] + lowest[a] - 2;  // along the node block
                const bool before = x < 0;
                delta |= int(before) << a;
                cell |= (x & 3) << (2 * a);
                told = told * along + (before ? x + along : x);
            }
            const std::int32_t tile = around.tile(delta);
            if (k >= count) continue;
            const bool own = ((around.own >> delta) & 1) != 0, there = ((around.there >> delta) & 1) != 0;
            of[k] = own ? pressure.whole[std::size_t(tile) * Block<Dim>::cells + std::size_t(cell)]
                    : there
                        ? v.grid.tiles[(std::size_t(tile) * pressure_tile<Dim> + std::size_t(told)) * node_reals + 1]
                        : Real(0);
        }
        __syncwarp();
    }

    /// sum_c of g along a and w along the others, for each axis a.
    __device__ __forceinline__ void sum(int n, Real (&sums)[Dim]) const {
        const Real* first = of + (n & 3) + along * ((n >> 2) & 3) + (Dim == 3 ? along * along * ((n >> 4) & 1) : 0);
        Real w[layers_of_node], gx[layers_of_node], gy[layers_of_node];
#pragma unroll
        for (int k = 0; k < layers_of_node; ++k) {
            Real line[3], slope[3];
#pragma unroll
            for (int j = 0; j < 3; ++j) {
                const Real* p = first + along * (j + along * k);
                line[j] = weighted(p[0], p[1], p[2]), slope[j] = Real(0.5) * (p[0] - p[2]);
            }
            w[k] = weighted(line[0], line[1], line[2]);
            gx[k] = weighted(slope[0], slope[1], slope[2]);
            gy[k] = Real(0.5) * (line[0] - line[2]);
        }
        if constexpr (Dim == 2) {
            sums[0] = gx[0], sums[1] = gy[0];
        } else {
            sums[0] = weighted(gx[0], gx[1], gx[2]);
            sums[1] = weighted(gy[0], gy[1], gy[2]);
            sums[Dim - 1] = Real(0.5) * (w[0] - w[2]);
        }
    }

  private:
    static constexpr int layers_of_node = Dim == 3 ? 3 : 1;
};

/// Takes from a node's force what cells that are not whole push it with. Whole warps call it.
template <class Real, int Dim>
__device__ __forceinline__ void take_cut_cells(const View<Real, Dim>& v, const PressureView<Real, Dim>& pressure,
                                               const TilesAround<Dim>& around, int n, Real (&force)[Dim]) {
    constexpr int tile_nodes = pressure_tile<Dim>;
    constexpr unsigned corners = (1u << Block<Dim>::corners) - 1;
    const int delta_of_lane = lane_id() % TilesAround<Dim>::lanes;
    const bool of_own = delta_of_lane < Block<Dim>::corners && ((around.own >> delta_of_lane) & 1);
    const bool cut = of_own && pressure.has_cut[around.mine];
    const unsigned own = __ballot_sync(all_lanes, cut) >> (lane_id() - delta_of_lane) & corners;
    const unsigned told = around.there & ~around.own, wanted = own | told;
#pragma unroll 1
    for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
        if (__all_sync(all_lanes, !((wanted >> delta) & 1))) continue;
        const std::int32_t tile = around.tile(delta);
        const int at = tile_node<Dim>(n, delta, 3);
        if (!((wanted >> delta) & 1) || at < 0) continue;
        if ((own >> delta) & 1) {
            const Real* from = pressure.cut + std::size_t(tile) * std::size_t(Dim * tile_nodes) + at;
#pragma unroll
            for (int a = 0; a < Dim; ++a) force[a] -= from[a * tile_nodes];
        } else {
            const Quad<Real> from = load_row(reinterpret_cast<const Quad<Real>*>(v.grid.tiles) +
                                             (std::size_t(tile) * tile_nodes + std::size_t(at)) * 2 + 1);
#pragma unroll
            for (int a = 0; a < Dim; ++a) force[a] -= from[a];
        }
    }
}

}  // namespace moraine::gpu
