#pragma once
// Gather and stress update in one kernel: hats or quadratic splines, with splines also an affine field; one material.
//
// One thread per particle; its gradient never leaves the registers, and its rows are read and written once. Kernels
// that take means over cells (volumetric.cuh) are instances of their own: a branch cost the others a register too
// many. So are those of blocks with light nodes (light.cuh), which ask at run time whether means are wanted.

#include "gpu/kernels/g2p/fluid.cuh"
#include "gpu/kernels/g2p/g2p_particle.cuh"
#include "gpu/kernels/g2p/gather_affine.cuh"
#include "gpu/kernels/g2p/light.cuh"
#include "gpu/kernels/g2p/stress_particle.cuh"
#include "gpu/kernels/g2p/volumetric.cuh"

namespace moraine::gpu {

template <class Real, int Dim, class Shape, class Law, bool Affine, bool Averages, bool Light, FluidGrid Fluid>
struct FusedGather {
    static_assert(!Affine || Shape::width == 3);
    using T = Team<Dim>;
    static constexpr int side = tile_side(Shape::width);
    using Tile = GatherTile<Real, Dim, Shape::width, !Affine>;
    using Rows = RowsAhead<Real, law_rows<Law, Dim>, 0, T::threads>;
    struct PlainShared {
        Rows rows;
        Tile tile;
        std::conditional_t<Light, LightShared<Real, Dim, Shape::width>, char> light;
        double sums[T::warps];
        std::conditional_t<Averages, CellMeans<Real, Dim>, char> means;
    };
    struct SharedWithFluid : PlainShared {
        FluidSharedOf<Real, Dim, Shape::width, Fluid> fluid;
    };
    static constexpr bool fluid = Fluid != FluidGrid::none, of_grid = Fluid == FluidGrid::pressure;
    using Shared = std::conditional_t<fluid, SharedWithFluid, PlainShared>;
    using V = View<Real, Dim>;
    using Args = GatherArgsOf<Real, Dim, Fluid>;
    using U = Vec<Coordinate<Real>, Dim>;

    static __device__ __forceinline__ Gathered<Real, Dim, Affine> sums_of(const V& v, const Args& g, int block,
                                                                          const U& u, const Tile& tile) {
        const int at = number_of<side, Real, Dim>(u);
        if constexpr (Affine) {
            SplineAxis<Real> n[Dim];
#pragma unroll
            for (int a = 0; a < Dim; ++a)
                n[a] = spline_axis(fraction_of<Real>(u[a]), takes_gradient<Shape>(v, g, block, u, a));
            return gather_affine<Real, Dim>(tile, at, n);
        } else {
            AxisWeights<Real, Shape, false> n[Dim];
#pragma unroll
            for (int a = 0; a < Dim; ++a) n[a] = axis_weights<Shape, false>(fraction_of<Real>(u[a]), Real(0), false);
            return gather<Shape, false, Real, Dim>(tile, at, n);
        }
    }

    static __device__ __forceinline__ bool averages(const Args& g) {
        return Averages && (!Light || g.averages);
    }

    /// The nodes of the block, and where they are wanted the means of its cells.
    static __device__ __forceinline__ void prepare(const V& v, const Args& g, const Work& work, Shared& shared) {
        if constexpr (Light) {
            load_light_tile<Shape>(v, work.block, shared.light.tile);
            weigh_cells<Shape>(v, work.block, shared.light.tile, shared.light.masses);
        }
        if constexpr (fluid) load_fluid<Shape>(v, g, work.block, shared.fluid);
        load_tile<Shape>(v, work.block, shared.tile);
        if constexpr (Averages)
            if (averages(g))
                average_cells(v, g, work, shared.means, [&](std::uint32_t s, const U& u) {
                    return gather_limited<Shape, Light, Affine>(
                        v, g, work.block, shared.light, s, [&] { return sums_of(v, g, work.block, u, shared.tile); });
                });
    }

    static __device__ __forceinline__ PlaceStep<Real> move(const V& v, const Args& g, const Work& work, std::uint32_t k,
                                                           const Gathered<Real, Dim, Affine>& sums, U& u,
                                                           const Shared& shared) {
        if constexpr (fluid) {
            Real velocity[Dim];
#pragma unroll
            for (int a = 0; a < Dim; ++a) velocity[a] = sums.velocity[a];
            if (of_grid || g.fluid.shifts) add_shift(v, g, work.block, g.fluid.all, shared.fluid, u, velocity);
            return move_particle<Light>(v, g, work, k, velocity, u);
        } else {
            return move_particle<Light>(v, g, work, k, sums.velocity, u);
        }
    }

    /// What a fluid's particle takes of the grid before its stress; p has the new velocity.
    static __device__ __forceinline__ void take_fluid(const V& v, const Args& g, int half, const Shared& shared,
                                                      CoreRows<Real, Dim>& p, Mat<Real, Dim>& dL,
                                                      SeenOf<Real, of_grid>& tally, double& power) {
        if constexpr (of_grid) {
            const Real square = square_speed(p);
            if (square > tally.square_speed) tally.square_speed = square;
            CoreRows<Real, Dim> before;  // where it was
            before.row[p.place] = shared.rows.take(half, T::rank(), p.place);
            const U at = place_of<Real, Dim>(before);
            const int cell = number_of<4, Real, Dim>(at);
            const Real borne = borne_share(shared.fluid.loose[cell], g.bulk[0]);
            smooth(g.fluid.all, g.dt, pressure_of_cell(v, shared.fluid, cell, at), p);
            power += take_cell(
                g.bulk[0], taken_increment(shared.fluid.increment[cell], shared.fluid.in_tension[cell], borne), p, dL);
        } else if constexpr (fluid) {
            if (!g.fluid.shifts) smooth(g.fluid.all, g.dt, shared.fluid.own[0][T::rank()], p);
        }
    }

    static __device__ __forceinline__ std::uint32_t update(const V& v, const Args& g, const Law& law,
                                                           Real inverse_density, const Work& work, std::uint32_t k,
                                                           std::uint32_t s, int half, Shared& shared,
                                                           SeenOf<Real, of_grid>& tally, double& power) {
        const auto row = [&](int r) { return shared.rows.take(half, T::rank(), r); };
        CoreRows<Real, Dim> p;
        if constexpr (fluid) {
            p.row[p.place] = row(p.place);
            find_fluid<Shape, Light>(v, g, g.fluid.all, place_of<Real, Dim>(p), zero_vec<Real, Dim>(), shared.fluid);
        }
        p.row[p.place] = row(p.place);
        U u = place_of<Real, Dim>(p);
        auto sums = gather_limited<Shape, Light, Affine>(v, g, work.block, shared.light, s,
                                                         [&] { return sums_of(v, g, work.block, u, shared.tile); });
        if constexpr (Affine) store_affine(v, sums.affine, s);
        if constexpr (Averages)
            if (averages(g)) shared.means.put_rate(number_of<4, Real, Dim>(u), sums);

        const PlaceStep<Real> step = move(v, g, work, k, sums, u, shared);
        if (step.moved > tally.moved) tally.moved = step.moved;
#pragma unroll
        for (int a = 0; a < Dim; ++a) p.set_coordinate(a, u[a]);
        if constexpr (Dim == 3) store_row(v.p.core[p.place] + s, p.row[p.place]);

        p.row[p.motion] = row(p.motion);
        if constexpr (Affine)
            for (int a = 0; a < Dim; ++a) p.velocity(a) = sums.velocity[a];
        else
            take_velocity(g.flip, sums, p);
        p.row[p.normal] = row(p.normal);
        p.row[p.shear] = row(p.shear);
        if (averages(g)) {
            CoreRows<Real, Dim> before;  // the cell is not kept in a register; in 2-D the shear row is the normal one
            before.row[p.place] = row(p.place);
            if constexpr (Averages) shared.means.put_stress(number_of<4, Real, Dim>(place_of<Real, Dim>(before)), p);
        }
        Row<Real> b[stretch_rows<Dim>];
        if constexpr (Law::uses_left_stretch)
            for (int r = 0; r < stretch_rows<Dim>; ++r) b[r] = row(core_rows<Dim> + r);
        Mat<Real, Dim> dL = tensor_of<Dim>(g.dt * v.context.inverse_cell, sums.gradient);
        take_fluid(v, g, half, shared, p, dL, tally, power);
        const std::uint32_t faults =
            step.faults | update_stress(law, inverse_density, dL, g.dt, v.p, s, p, b, tally, power);
#pragma unroll
        for (int r = Dim == 3 ? 1 : 0; r < core_rows<Dim>; ++r) store_row(v.p.core[r] + s, p.row[r]);
        report(v, g, s, faults, step.move);
        return faults;
    }
};

template <class Real, int Dim, class Shape, class Law, bool Affine, bool Averages, bool Light, FluidGrid Fluid,
          int MinBlocks>
__global__ void __launch_bounds__(Team<Dim>::block_threads, MinBlocks)
    g2p_fused(const __grid_constant__ View<Real, Dim> v, const Chosen chosen,
              const __grid_constant__ GatherArgsOf<Real, Dim, Fluid> g, const __grid_constant__ Law law,
              const Real inverse_density) {
    using T = Team<Dim>;
    using F = FusedGather<Real, Dim, Shape, Law, Affine, Averages, Light, Fluid>;
    extern __shared__ __align__(32) unsigned char memory[];
    auto& shared = reinterpret_cast<typename F::Shared*>(memory)[T::index()];
    SeenOf<Real, Fluid == FluidGrid::pressure> tally;
    const std::uint32_t count = *chosen.count;
#pragma unroll 1
    for (std::uint32_t item = T::first(); item < count; item += T::stride()) {
        const Work work = work_on(v.list, chosen, item);
        if (!Light && is_limited(g, work.block)) continue;
        double power = 0;
        each_entry<Dim>(
            v.list.slot, work,
            [&](int half, std::uint32_t, std::uint32_t s) {
#pragma unroll
                for (int r = 0; r < law_rows<Law, Dim>; ++r)
                    shared.rows.start(half, T::rank(), r, law_row<Law>(v.p, r, s));
                return 0u;
            },
            [&] { F::prepare(v, g, work, shared); },
            [&](std::uint32_t k, std::uint32_t s, int half, std::uint32_t) {
                F::update(v, g, law, inverse_density, work, k, s, half, shared, tally, power);
            });
        power = T::sum(power, shared.sums);
        if (T::rank() == 0) add_exact(&account_of(v).work, g.quantum.of(power));
    }
    tally.fold_into(account_of(v));
}

/// Thread blocks of a multiprocessor: as many as leave a thread the registers it needs.
template <class Real, class Law, bool Affine, bool Averages, bool Light, FluidGrid Fluid>
constexpr int fused_blocks() {
    if (Light) return light_blocks;
    if (Fluid == FluidGrid::pressure) return pressure_blocks<Real>;
    constexpr DeviceBlocks blocks = device_blocks_of<Law>();
    if (sizeof(Real) == 8) return blocks.double_fused;
    if (Affine) return Averages ? blocks.affine_averaged : blocks.affine;
    return Averages ? blocks.averaged : blocks.plain;
}

}  // namespace moraine::gpu
