#pragma once
// Gather without stress: any shape, with or without an affine field, whatever a round of a scheme takes.
//
// dL goes to a buffer by list entry, component by component: written and read in full lines, and free of the order in
// which particles lie in memory.

#include "gpu/kernels/g2p/fluid.cuh"
#include "gpu/kernels/g2p/light.cuh"
#include "gpu/kernels/g2p/volumetric.cuh"

namespace moraine::gpu {

template <class Real, int Dim, class Shape, bool Affine, bool Averages, bool Light, FluidGrid Fluid>
struct SplitGather {
    using T = Team<Dim>;
    static constexpr int side = tile_side(Shape::width);
    static constexpr int place = 0, motion = 1, box = 2;        ///< rows on their way
    static constexpr bool levers = Affine && Shape::width > 2;  ///< C of hats is the velocity gradient
    static constexpr bool rolled = Light && Shape::width > 3;   ///< or registers spill in double
    static constexpr bool fluid = Fluid != FluidGrid::none, of_grid = Fluid == FluidGrid::pressure;
    using Tile = GatherTile<Real, Dim, Shape::width>;
    using Rows = RowsAhead<Real, Shape::sized ? 3 : 2, 0, T::threads>;
    struct PlainShared {
        Rows rows;
        Tile tile;
        std::conditional_t<Light, LightShared<Real, Dim, Shape::width>, char> light;
        std::conditional_t<Averages, CellMeans<Real, Dim>, char> means;
    };
    struct SharedWithFluid : PlainShared {
        FluidSharedOf<Real, Dim, Shape::width, Fluid> fluid;
        double sums[of_grid ? T::warps : 1];
    };
    using Shared = std::conditional_t<fluid, SharedWithFluid, PlainShared>;
    using V = View<Real, Dim>;
    using Args = GatherArgsOf<Real, Dim, Fluid>;
    using U = Vec<Coordinate<Real>, Dim>;
    using Sums = Gathered<Real, Dim, levers>;

    /// Asks for the particle's rows; returns its body.
    static __device__ __forceinline__ std::uint32_t start(const V& v, const Args& g, int half, std::uint32_t s,
                                                          Shared& shared) {
        shared.rows.start(half, T::rank(), place, v.p.core[0] + s);
        if (g.gather & gather_velocity) shared.rows.start(half, T::rank(), motion, v.p.core[1] + s);
        if constexpr (Shape::sized) {
            if (v.p.log_stretch) shared.rows.start(half, T::rank(), box, v.p.log_stretch + s);
            return v.p.body[s];
        }
        return 0;
    }

    static __device__ __forceinline__ bool averages(const Args& g) {
        return Averages && (!(Light || fluid) || g.averages);
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
            if (averages(g) && (g.gather & gather_gradient))
                average_cells(v, g, work, shared.means, [&](std::uint32_t s, const U& u) {
                    return gather_limited<Shape, Light, false>(v, g, work.block, shared.light, s, [&] {
                        Row<Real> stretch;
                        if constexpr (Shape::sized)
                            if (v.p.log_stretch) stretch = load_row(v.p.log_stretch + s);
                        AxisWeights<Real, Shape, false> n[Dim];
#pragma unroll
                        for (int a = 0; a < Dim; ++a)
                            n[a] = axis_weights<Shape, false>(
                                fraction_of<Real>(u[a]), Shape::sized ? half_size(v, v.p.body[s], stretch, a) : Real(0),
                                false);
                        return gather<Shape, false, Real, Dim>(shared.tile, number_of<side, Real, Dim>(u), n);
                    });
                });
    }

    /// Volumetric rate and pressure of the cell; the stress update follows as a launch of its own.
    static __device__ __forceinline__ void take_means(const V& v, std::uint32_t s, const Row<Real>& at,
                                                      const Shared& shared, Sums& sums) {
        CoreRows<Real, Dim> p;
        p.row[p.place] = at;
        const int cell = number_of<4, Real, Dim>(place_of<Real, Dim>(p));
        shared.means.put_rate(cell, sums);
        p.row[p.normal] = load_row(v.p.core[p.normal] + s);
        shared.means.put_stress(cell, p);
        store_row(v.p.core[p.normal] + s, p.row[p.normal]);
    }

    static __device__ __forceinline__ void store_gradient(const Args& g, const Mat<Real, Dim>& dL, std::uint32_t k) {
#pragma unroll
        for (int i = 0; i < Dim; ++i)
#pragma unroll
            for (int j = 0; j < Dim; ++j) g.gradient[std::uint64_t(Dim * i + j) * g.gradient_stride + k] = dL(i, j);
    }

    /// The box follows the stretch; true when it is held at half a cell.
    static __device__ __forceinline__ bool stretch_box(const V& v, const Args& g, const Sums& sums, std::uint32_t body,
                                                       std::uint32_t s, Row<Real> stretch) {
        bool held = false;
#pragma unroll
        for (int a = 0; a < Dim; ++a) {
            stretch.e[a] = advanced_stretch(stretch.e[a], g.dt * v.context.inverse_cell * sums.gradient[a][a]);
            held = held || stretched_half(v.context.half_size[body][a], stretch.e[a]) > Real(0.5);
        }
        store_row(v.p.log_stretch + s, stretch);
        return held;
    }

    /// What a fluid's particle takes of the mean, before the gather.
    static __device__ __forceinline__ void find_mean(const V& v, const Args& g, std::uint32_t s, int half,
                                                     std::uint32_t body, Shared& shared) {
        CoreRows<Real, Dim> p;
        p.row[p.place] = shared.rows.take(half, T::rank(), place);
        Vec<Real, Dim> size = zero_vec<Real, Dim>();
        if constexpr (Shape::sized) {
            Row<Real> stretch;
            if (v.p.log_stretch) stretch = shared.rows.take(half, T::rank(), box);
            for (int a = 0; a < Dim; ++a) size[a] = half_size(v, body, stretch, a);
        }
        find_fluid<Shape, (Light || Shape::width > 3)>(v, g, terms_of(v, g.fluid, s), place_of<Real, Dim>(p), size,
                                                       shared.fluid);
    }

    /// Before the stress update, which is a launch of its own.
    static __device__ __forceinline__ void take_pressure(const V& v, const Args& g, std::uint32_t s,
                                                         const Shared& shared) {
        const FluidTerms<Real> of = terms_of(v, g.fluid, s);
        if (!(of.smoothing > Real(0))) return;
        CoreRows<Real, Dim> p;
        p.row[p.normal] = load_row(v.p.core[p.normal] + s);
        if (p.ln_J_row != p.normal) p.row[p.ln_J_row] = load_row(v.p.core[p.ln_J_row] + s);
        smooth(of, g.dt, shared.fluid.own[0][T::rank()], p);
        store_row(v.p.core[p.normal] + s, p.row[p.normal]);
        if (p.ln_J_row != p.normal) store_row(v.p.core[p.ln_J_row] + s, p.row[p.ln_J_row]);
    }

    /// The same where the pressure is the grid's: the smoothed one, and what the cell did. p has the new velocity.
    /// Returns the work [J].
    static __device__ __forceinline__ double take_grid(const V& v, const Args& g, std::uint32_t s, const Row<Real>& at,
                                                       const Shared& shared, SeenOf<Real, of_grid>& tally,
                                                       Mat<Real, Dim>& dL) {
        CoreRows<Real, Dim> p;
#pragma unroll
        for (int r = 1; r < core_rows<Dim>; ++r) p.row[r] = load_row(v.p.core[r] + s);
        p.row[p.place] = at;
        const Real square = square_speed(p);
        if (square > tally.square_speed) tally.square_speed = square;
        const U spot = place_of<Real, Dim>(p);
        const int cell = number_of<4, Real, Dim>(spot);
        const Real bulk = g.bulk[v.p.body[s]], borne = borne_share(shared.fluid.loose[cell], bulk);
        smooth(terms_of(v, g.fluid, s), g.dt, pressure_of_cell(v, shared.fluid, cell, spot), p);
        const Real increment = taken_increment(shared.fluid.increment[cell], shared.fluid.in_tension[cell], borne);
        const double work = take_cell(bulk, increment, p, dL);
        store_row(v.p.core[p.normal] + s, p.row[p.normal]);
        if (p.ln_J_row != p.normal) store_row(v.p.core[p.ln_J_row] + s, p.row[p.ln_J_row]);
        return work;
    }

    static __device__ __forceinline__ void move(const V& v, const Args& g, const Work& work, std::uint32_t k,
                                                std::uint32_t s, const Sums& sums, U& u, const Shared& shared,
                                                CoreRows<Real, Dim>& p, SeenOf<Real, of_grid>& tally) {
        Real velocity[Dim];
#pragma unroll
        for (int a = 0; a < Dim; ++a) velocity[a] = moving_velocity(g.gather, sums.velocity[a], sums.change[a]);
        if constexpr (fluid)
            if (of_grid || g.fluid.shifts)
                add_shift(v, g, work.block, terms_of(v, g.fluid, s), shared.fluid, u, velocity);
        const PlaceStep<Real> step = move_particle<Light>(v, g, work, k, velocity, u);
        if (step.moved > tally.moved) tally.moved = step.moved;
#pragma unroll
        for (int a = 0; a < Dim; ++a) p.set_coordinate(a, u[a]);
        store_row(v.p.core[p.place] + s, p.row[p.place]);
        report(v, g, s, step.faults, step.move);
    }

    /// The particle of list entry k in slot s.
    static __device__ __forceinline__ void take(const V& v, const Args& g, const Work& work, std::uint32_t k,
                                                std::uint32_t s, int half, std::uint32_t body, Shared& shared,
                                                SeenOf<Real, of_grid>& tally, double& power) {
        const auto row = [&](int r) { return shared.rows.take(half, T::rank(), r); };
        if constexpr (fluid) find_mean(v, g, s, half, body, shared);
        CoreRows<Real, Dim> p;
        p.row[p.place] = row(place);
        Row<Real> stretch;
        if constexpr (Shape::sized)
            if (v.p.log_stretch) stretch = row(box);
        U u = place_of<Real, Dim>(p);
        Sums sums = gather_limited<Shape, Light, levers>(v, g, work.block, shared.light, s, [&] {
            AxisWeights<Real, Shape, levers> n[Dim];
#pragma unroll
            for (int a = 0; a < Dim; ++a)
                n[a] = axis_weights<Shape, levers>(fraction_of<Real>(u[a]),
                                                   Shape::sized ? half_size(v, body, stretch, a) : Real(0),
                                                   levers && takes_gradient<Shape>(v, g, work.block, u, a));
            return gather<Shape, levers, Real, Dim, rolled>(shared.tile, number_of<side, Real, Dim>(u), n);
        });

        if (g.gather & gather_velocity) {
            p.row[p.motion] = row(motion);
            take_velocity(g.flip, sums, p);
            store_row(v.p.core[p.motion] + s, p.row[p.motion]);
            if constexpr (levers)
                store_affine(v, sums.affine, s);
            else if constexpr (Affine)
                store_affine(v, sums.gradient, s);
        }
        if (g.gather & gather_gradient) {
            Mat<Real, Dim> dL = tensor_of<Dim>(g.dt * v.context.inverse_cell, sums.gradient);
            if constexpr (of_grid)
                power += take_grid(v, g, s, row(place), shared, tally, dL);
            else if constexpr (fluid)
                if (!g.fluid.shifts) take_pressure(v, g, s, shared);
            if constexpr (Shape::sized)
                if (v.p.log_stretch && stretch_box(v, g, sums, body, s, stretch)) ++tally.clamped;
            if constexpr (Averages)
                if (averages(g) && (!g.averaged || g.averaged[v.p.body[s]])) {
                    take_means(v, s, row(place), shared, sums);
                    dL = tensor_of<Dim>(g.dt * v.context.inverse_cell, sums.gradient);
                }
            store_gradient(g, dL, k);
        }
        if (moves_particles(g.gather)) move(v, g, work, k, s, sums, u, shared, p, tally);
    }
};

template <class Real, int Dim, class Shape, bool Affine, bool Averages, bool Light, FluidGrid Fluid, int MinBlocks>
__global__ void __launch_bounds__(Team<Dim>::block_threads, MinBlocks)
    g2p_split(const __grid_constant__ View<Real, Dim> v, const Chosen chosen,
              const __grid_constant__ GatherArgsOf<Real, Dim, Fluid> g) {
    using T = Team<Dim>;
    using S = SplitGather<Real, Dim, Shape, Affine, Averages, Light, Fluid>;
    extern __shared__ __align__(32) unsigned char memory[];
    auto& shared = reinterpret_cast<typename S::Shared*>(memory)[T::index()];
    SeenOf<Real, S::of_grid> tally;
    const std::uint32_t count = *chosen.count;
#pragma unroll 1
    for (std::uint32_t item = T::first(); item < count; item += T::stride()) {
        const Work work = work_on(v.list, chosen, item);
        if (!Light && is_limited(g, work.block)) continue;
        double power = 0;
        each_entry<Dim>(
            v.list.slot, work,
            [&](int half, std::uint32_t, std::uint32_t s) { return S::start(v, g, half, s, shared); },
            [&] { S::prepare(v, g, work, shared); },
            [&](std::uint32_t k, std::uint32_t s, int half, std::uint32_t body) {
                S::take(v, g, work, k, s, half, body, shared, tally, power);
            });
        if constexpr (S::of_grid) {
            power = T::sum(power, shared.sums);
            if (T::rank() == 0) add_exact(&account_of(v).work, g.quantum.of(power));
        }
        T::sync();
    }
    tally.fold_into(account_of(v));
}

/// Thread blocks of a multiprocessor: as many as leave a thread the registers it needs, on sm_80 too.
template <class Real, class Shape, bool Affine, bool Averages, bool Light, FluidGrid Way>
constexpr int split_blocks() {
    if (Light) return light_blocks;
    if (Way == FluidGrid::pressure) return sizeof(Real) == 8 ? 2 : 3;
    constexpr bool Fluid = Way != FluidGrid::none;
    constexpr bool large = Shape::sized || Shape::width > 3;
    if (sizeof(Real) == 8) return Affine || ((Averages || Fluid) && large) ? 2 : 3;
    return 5 - (large || (Fluid && !Affine) ? 1 : 0) - (Affine ? 1 : 0);
}

}  // namespace moraine::gpu
