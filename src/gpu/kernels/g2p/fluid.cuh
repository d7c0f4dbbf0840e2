#pragma once
// What fluids take from the grid besides their motion (core/fluid/pressure_smoothing.hpp,
// core/fluid/particle_shifting.hpp): one number per node of a block in shared memory, P_i or in steps that shift e_i,
// and each particle's sums over it.
//
// The kernel of nodes has left that number in the last lane of a node's values. Only instances for scenes with such
// fluids look at it; weights are made anew for it, because registers for them would be held through the gather.

#include "core/fluid/particle_shifting.hpp"
#include "gpu/kernels/g2p/gather_case.cuh"

namespace moraine::gpu {

/// Ghosts behind walls follow as velocities do.
template <class Real, int Dim, int Width>
struct FluidTile {
    struct Value {
        Real mean;

        template <class F>
        __device__ __forceinline__ void combine(const Value& other, const F& f) {
            mean = f(mean, other.mean);
        }
    };
    static constexpr int size = power<Dim>(tile_side(Width));
    Real mean[size];

    __device__ __forceinline__ Value get(int n) const { return {mean[n]}; }
    __device__ __forceinline__ void set(int n, const Value& x) { mean[n] = x.mean; }
};

/// From the nodes' values; all threads of the team, which see it afterwards.
template <class Shape, class Real, int Dim>
__device__ __forceinline__ void load_fluid_tile(const View<Real, Dim>& v, int block,
                                                FluidTile<Real, Dim, Shape::width>& tile) {
    for (int n = Team<Dim>::rank(); n < tile.size; n += Team<Dim>::threads)
        tile.mean[n] = node_in_tile<tile_side(Shape::width)>(v, block, n)[1].e[quad - 1];
    Team<Dim>::sync();
    if (Shape::width > 2 && v.table.border[block]) set_ghosts<Shape::width>(v, block, Shape::origin, tile);
}

/// How far nodes of a block's tile are from surfaces [cells], where one is near.
template <class Real, int Dim, int Width>
struct DistanceTile {
    FluidTile<Real, Dim, Width> of;
    bool near;
};

/// By all threads of the team, which see it afterwards.
template <class Shape, class Real, int Dim>
__device__ __forceinline__ void load_distance_tile(const View<Real, Dim>& v, const SurfaceSpace& surfaces, int block,
                                                   DistanceTile<Real, Dim, Shape::width>& tile) {
    constexpr int side = tile_side(Shape::width);
    if (Team<Dim>::rank() == 0) tile.near = false;
    Team<Dim>::sync();
    for (int n = Team<Dim>::rank(); n < tile.of.size; n += Team<Dim>::threads) {
        int corner = 0, at = 0;
        for (int a = 0, rest = n; a < Dim; ++a, rest /= side) {
            const int x = rest % side;
            corner |= (x >> 2) << a, at |= (x & 3) << (2 * a);
        }
        const SpaceNode* node = surfaces.of(v.table.node_block[block * Block<Dim>::corners + corner], at);
        const Real distance = node ? Real(node->distance) : Real(100);
        tile.of.mean[n] = distance;
        if (distance < Real(1.5)) tile.near = true;
    }
    Team<Dim>::sync();
    if (Shape::width > 2 && v.table.border[block]) set_ghosts<Shape::width>(v, block, Shape::origin, tile.of);
}

/// A particle's weights and slopes [1/cell].
template <class Shape, class Real, int Dim>
struct FluidStencil {
    Real w[Dim][Shape::width], dw[Dim][Shape::width];

    /// half: of its box, where the shape is sized [cells].
    __device__ __forceinline__ FluidStencil(const Vec<Coordinate<Real>, Dim>& u, const Vec<Real, Dim>& half) {
#pragma unroll
        for (int a = 0; a < Dim; ++a) Shape::weights(fraction_of<Real>(u[a]), half[a], w[a], dw[a]);
    }
};

/// sum_i w_ip P_i. at: tile offset of the particle's cell. Rolled: plane by plane in a loop, with fewer registers.
template <class Shape, bool Rolled, class Real, int Dim>
__device__ __forceinline__ Real gathered_mean(const FluidTile<Real, Dim, Shape::width>& tile, int at,
                                              const FluidStencil<Shape, Real, Dim>& n) {
    constexpr int side = tile_side(Shape::width);
    Real sum = Real(0);
#pragma unroll(Rolled ? 1 : Shape::width)
    for (int k = 0; k < (Dim == 3 ? Shape::width : 1); ++k) {
        Real plane = Real(0);
#pragma unroll
        for (int j = 0; j < Shape::width; ++j) {
            Real line = Real(0);
#pragma unroll
            for (int i = 0; i < Shape::width; ++i)
                line = std::fma(n.w[0][i], tile.mean[at + i + side * (j + side * k)], line);
            plane = std::fma(n.w[1][j], line, plane);
        }
        sum = Dim == 3 ? std::fma(n.w[Dim - 1][k], plane, sum) : plane;
    }
    return sum;
}

/// sum_i e_i grad w_ip [1/cell], or zero where a node of the stencil reaches a structure.
template <class Shape, bool Rolled, class Real, int Dim>
__device__ __forceinline__ Vec<Real, Dim> excess_gradient(const FluidTile<Real, Dim, Shape::width>& tile, int at,
                                                          const FluidStencil<Shape, Real, Dim>& n) {
    constexpr int side = tile_side(Shape::width);
    Vec<Real, Dim> gradient = zero_vec<Real, Dim>();
    Real least = Real(0);
#pragma unroll(Rolled ? 1 : Shape::width)
    for (int k = 0; k < (Dim == 3 ? Shape::width : 1); ++k) {
        Real plane[3] = {};  // the value, and its slopes along x and y
#pragma unroll
        for (int j = 0; j < Shape::width; ++j) {
            Real value = Real(0), slope = Real(0);
#pragma unroll
            for (int i = 0; i < Shape::width; ++i) {
                const Real e = tile.mean[at + i + side * (j + side * k)];
                least = e < least ? e : least;
                value = std::fma(n.w[0][i], e, value);
                slope = std::fma(n.dw[0][i], e, slope);
            }
            plane[0] = std::fma(n.w[1][j], value, plane[0]);
            plane[1] = std::fma(n.w[1][j], slope, plane[1]);
            plane[2] = std::fma(n.dw[1][j], value, plane[2]);
        }
        const Real w = Dim == 3 ? n.w[Dim - 1][k] : Real(1);
        gradient[0] = std::fma(w, plane[1], gradient[0]);
        gradient[1] = std::fma(w, plane[2], gradient[1]);
        if constexpr (Dim == 3) gradient[Dim - 1] = std::fma(n.dw[Dim - 1][k], plane[0], gradient[Dim - 1]);
    }
    return least > at_structure<Real> ? gradient : zero_vec<Real, Dim>();
}

/// The shift of a particle at u in a step [m].
template <class Shape, bool Rolled, class Real, int Dim>
__device__ __forceinline__ Vec<Real, Dim> found_shift(const View<Real, Dim>& v, const FluidTerms<Real>& of, Real dt,
                                                      const FluidTile<Real, Dim, Shape::width>& tile, int at,
                                                      const FluidStencil<Shape, Real, Dim>& n) {
    Vec<Real, Dim> gradient = excess_gradient<Shape, Rolled, Real, Dim>(tile, at, n);
#pragma unroll
    for (int a = 0; a < Dim; ++a) gradient[a] *= v.context.inverse_cell;
    return shift_by(of.shifting, dt, Real(1) / v.context.inverse_cell, gradient);
}

/// rho g.x of particles of a block.
template <class Real>
struct RestingPressure {
    Real first;  ///< at its first node [Pa]

    /// By one thread.
    template <class Shape, int Dim>
    __device__ __forceinline__ void load(const View<Real, Dim>& v, int block) {
        first = Real(0);
        for (int a = 0; a < Dim; ++a)
            first += v.context.gravity_slope[a] * Real(first_node<Shape>(v.table.position[block][a]));
    }
    template <int Dim>
    __device__ __forceinline__ Real at(const View<Real, Dim>& v, const Vec<Coordinate<Real>, Dim>& u) const {
        Real pressure = first;
#pragma unroll
        for (int a = 0; a < Dim; ++a)
            pressure += v.context.gravity_slope[a] * (Real(cell_of<Real>(u[a])) + fraction_of<Real>(u[a]));
        return pressure;
    }
};

struct NoDistances {};

/// The tile, and what each thread's particle takes of it: the shift [m], or the pressure first.
template <class Real, int Dim, int Width, bool Surfaces>
struct FluidShared {
    FluidTile<Real, Dim, Width> tile;
    std::conditional_t<Surfaces, DistanceTile<Real, Dim, Width>, NoDistances> distance;
    RestingPressure<Real> resting;
    Real own[Dim][Team<Dim>::threads];
};

/// Smoothing and shifting. Where the pressure is the grid's, the shift alone: cell_step.cuh smooths.
template <class Case>
struct FluidTerm {
    using Real = typename Case::Real;
    using Shape = typename Case::Shape;
    using U = typename Case::U;
    static constexpr int dim = Case::dim;
    static constexpr bool rolled = Case::light || Shape::width > 3;
    static constexpr unsigned hooks =
        Case::fluid ? hook_block | hook_gather | hook_velocity | (Case::pressure ? 0u : unsigned(hook_stress)) : 0u;
    struct Shared : SharedIf<FluidTerm, Case::fluid, FluidShared<Real, dim, Shape::width, Case::surfaces>> {};

    MORAINE_TEAM bool shifts(const auto& in) { return Case::pressure || in.g.fluid.shifts; }

    MORAINE_TEAM void at_block(const auto& in, Shared& own) {
        if (!Case::pressure && Case::T::rank() == 0) own.resting.template load<Shape>(in.v, in.work.block);
        load_fluid_tile<Shape>(in.v, in.work.block, own.tile);
        if constexpr (Case::surfaces)
            if (shifts(in)) load_distance_tile<Shape>(in.v, in.g.fluid.surfaces, in.work.block, own.distance);
    }

    /// What the particle's rows say is read anew afterwards: registers that held weights until then spilled.
    MORAINE_TEAM void before_gather(const auto& in, const auto& point, Shared& own) {
        const FluidTerms<Real> of = point.fluid();
        if (Case::pressure && !(of.shifting > Real(0))) return;
        const U u = point.place();
        const int at = number_of<Case::side, Real, dim>(u), rank = Case::T::rank();
        const FluidStencil<Shape, Real, dim> n(u, point.half_sizes());
        if (shifts(in)) {
            Vec<Real, dim> shift = found_shift<Shape, rolled>(in.v, of, shifting_dt(in, of), own.tile, at, n);
            if constexpr (Case::surfaces) keep_out(own.distance, at, n, shift);
#pragma unroll
            for (int a = 0; a < dim; ++a) own.own[a][rank] = shift[a];
        } else {
            own.own[0][rank] = gathered_mean<Shape, rolled, Real, dim>(own.tile, at, n) - own.resting.at(in.v, u);
        }
        asm volatile("" ::: "memory");
    }

    MORAINE_TEAM void keep_out(const auto& distance, int at, const auto& n, Vec<Real, dim>& shift) {
        if (!distance.near) return;
        keep_from_surface(gathered_mean<Shape, rolled, Real, dim>(distance.of, at, n),
                          excess_gradient<Shape, rolled, Real, dim>(distance.of, at, n), shift);
    }

    /// No further than it is stable.
    MORAINE_TEAM Real shifting_dt(const auto& in, const FluidTerms<Real>& of) {
        if (!Case::pressure) return in.g.dt;
        const Real h = Real(1) / in.v.context.inverse_cell, most = Real(0.5) * h * h / of.shifting;
        return most < in.g.dt ? most : in.g.dt;
    }

    MORAINE_TEAM void before_stress(const auto& in, auto& point, auto&, const Shared& own, auto&, double&) {
        const FluidTerms<Real> of = point.fluid();
        if (in.g.fluid.shifts || !(of.smoothing > Real(0))) return;
        point.load_pressure();
        smooth_pressure(of, in.g.dt, own.own[0][Case::T::rank()], point.p);
        point.store_pressure();
    }

    /// u: where it is.
    MORAINE_TEAM void on_velocity(const auto& in, const auto& point, const U& u, auto& velocity, const Shared& own) {
        if (!shifts(in) || !(point.fluid().shifting > Real(0))) return;
        Vec<Real, dim> shift;
#pragma unroll
        for (int a = 0; a < dim; ++a) shift[a] = own.own[a][Case::T::rank()];
        if (in.v.table.border[in.work.block]) {
            Vec<Real, dim> move;
#pragma unroll
            for (int a = 0; a < dim; ++a) move[a] = in.g.dt * velocity[a] * in.v.context.inverse_cell;
            keep_from_ends(in.g.ends, in.v.table.position[in.work.block], u, move, shift);
        }
#pragma unroll
        for (int a = 0; a < dim; ++a) velocity[a] += Real(1) / in.g.dt * shift[a];
    }
};

}  // namespace moraine::gpu
