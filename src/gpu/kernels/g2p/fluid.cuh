#pragma once
// What fluids take from the grid besides their motion (core/pressure_smoothing.hpp, core/particle_shifting.hpp): one
// number per node of a block in shared memory, P_i or in steps that shift e_i, and each particle's sums over it.
//
// The kernel of nodes has left that number in the last lane of a node's values. Only instances for scenes with such
// fluids look at it; weights are made anew for it, because registers for them would be held through the gather.

#include "core/particle_shifting.hpp"
#include "gpu/kernels/g2p/g2p_particle.cuh"

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
    Real resting;  ///< rho g.x of its first node [Pa]

    __device__ __forceinline__ Value get(int n) const { return {mean[n]}; }
    __device__ __forceinline__ void set(int n, const Value& x) { mean[n] = x.mean; }
};

/// Fills the tile of a block from a number per node; all threads of the team, which see it afterwards.
template <class Shape, class Real, int Dim, class Number>
__device__ __forceinline__ void fill_fluid_tile(const View<Real, Dim>& v, int block,
                                                FluidTile<Real, Dim, Shape::width>& tile, const Number& number) {
    for (int n = Team<Dim>::rank(); n < tile.size; n += Team<Dim>::threads) tile.mean[n] = number(n);
    if (Team<Dim>::rank() == 0) {
        tile.resting = Real(0);
        for (int a = 0; a < Dim; ++a)
            tile.resting += v.context.gravity_slope[a] * Real(first_node<Shape>(v.table.position[block][a]));
    }
    Team<Dim>::sync();
    if (Shape::width > 2 && v.table.border[block]) set_ghosts<Shape::width>(v, block, Shape::origin, tile);
}

/// From the nodes' values.
template <class Shape, class Real, int Dim>
__device__ __forceinline__ void load_fluid_tile(const View<Real, Dim>& v, int block,
                                                FluidTile<Real, Dim, Shape::width>& tile) {
    fill_fluid_tile<Shape>(v, block, tile,
                           [&](int n) { return node_in_tile<tile_side(Shape::width)>(v, block, n)[1].e[quad - 1]; });
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

/// What the particle of a body takes.
template <class Real, int Dim>
__device__ __forceinline__ FluidTerms<Real> terms_of(const View<Real, Dim>& v, const FluidArgs<Real>& g,
                                                     std::uint32_t s) {
    return g.by_body ? g.by_body[v.p.body[s]] : g.all;
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

/// rho g.x of a particle at u [Pa].
template <class Real, int Dim, int Width>
__device__ __forceinline__ Real resting_pressure(const View<Real, Dim>& v, const FluidTile<Real, Dim, Width>& tile,
                                                 const Vec<Coordinate<Real>, Dim>& u) {
    Real pressure = tile.resting;
#pragma unroll
    for (int a = 0; a < Dim; ++a)
        pressure += v.context.gravity_slope[a] * (Real(cell_of<Real>(u[a])) + fraction_of<Real>(u[a]));
    return pressure;
}

/// The pressure that the nodes around a particle at u have there [Pa].
template <class Shape, bool Rolled, class Real, int Dim>
__device__ __forceinline__ Real found_pressure(const View<Real, Dim>& v, const FluidTile<Real, Dim, Shape::width>& tile,
                                               int at, const Vec<Coordinate<Real>, Dim>& u,
                                               const FluidStencil<Shape, Real, Dim>& n) {
    return gathered_mean<Shape, Rolled, Real, Dim>(tile, at, n) - resting_pressure(v, tile, u);
}

/// The tile, and what each thread's particle takes of it, from before it gathers: in registers it would be too much.
template <class Real, int Dim, int Width>
struct FluidShared {
    FluidTile<Real, Dim, Width> tile;
    Real own[Dim][Team<Dim>::threads];  ///< the shift [m], or the pressure first
};

/// Gathers the shift or the pressure of a particle at u. half: of its box [cells]. What the particle's rows say is read
/// anew afterwards: registers that held weights until then spilled.
template <class Shape, bool Rolled, class Real, int Dim>
__device__ __forceinline__ void find_fluid(const View<Real, Dim>& v, const MeansGatherArgs<Real, Dim>& g,
                                           const FluidTerms<Real>& of, const Vec<Coordinate<Real>, Dim>& u,
                                           const Vec<Real, Dim>& half, FluidShared<Real, Dim, Shape::width>& shared) {
    const int at = number_of<tile_side(Shape::width), Real, Dim>(u), rank = Team<Dim>::rank();
    const FluidStencil<Shape, Real, Dim> n(u, half);
    if (g.fluid.shifts) {
        const Vec<Real, Dim> shift = found_shift<Shape, Rolled>(v, of, g.dt, shared.tile, at, n);
#pragma unroll
        for (int a = 0; a < Dim; ++a) shared.own[a][rank] = shift[a];
    } else {
        shared.own[0][rank] = found_pressure<Shape, Rolled>(v, shared.tile, at, u, n);
    }
    asm volatile("" ::: "memory");
}

/// Adds the shift of this thread's particle to the velocity that moves it from u.
template <class Real, int Dim, int Width>
__device__ __forceinline__ void add_shift(const View<Real, Dim>& v, const MeansGatherArgs<Real, Dim>& g, int block,
                                          const FluidTerms<Real>& of, const FluidShared<Real, Dim, Width>& shared,
                                          const Vec<Coordinate<Real>, Dim>& u, Real (&velocity)[Dim]) {
    if (!(of.shifting > Real(0))) return;
    Vec<Real, Dim> shift;
#pragma unroll
    for (int a = 0; a < Dim; ++a) shift[a] = shared.own[a][Team<Dim>::rank()];
    if (v.table.border[block]) {
        Vec<Real, Dim> move;
#pragma unroll
        for (int a = 0; a < Dim; ++a) move[a] = g.dt * velocity[a] * v.context.inverse_cell;
        keep_from_ends(g.ends, v.table.position[block], u, move, shift);
    }
#pragma unroll
    for (int a = 0; a < Dim; ++a) velocity[a] += Real(1) / g.dt * shift[a];
}

/// Takes this thread's particle's share of the pressure around it into its rows.
template <class Real, int Dim>
__device__ __forceinline__ void smooth(const FluidTerms<Real>& of, Real dt, Real pressure, CoreRows<Real, Dim>& p) {
    if (!(of.smoothing > Real(0))) return;
    Sym<Real, Dim> stress{};
#pragma unroll
    for (int a = 0; a < 3; ++a) stress[a] = p.stress(a);
    smooth_pressure(smoothing_share(of.smoothing, dt), pressure, of.compliance, stress, p.ln_J());
#pragma unroll
    for (int a = 0; a < 3; ++a) p.stress(a) = stress[a];
}

/// Thread blocks of a multiprocessor: as many as leave a thread the registers it needs.
template <class Real>
inline constexpr int pressure_blocks = sizeof(Real) == 8 ? 2 : 4;

/// Where the pressure is the grid's: the block's cells besides.
template <class Real, int Dim, int Width>
struct PressureShared : FluidShared<Real, Dim, Width> {
    Real head[Block<Dim>::cells];        ///< of P + rho g.x, which smoothing takes [Pa]
    Real increment[Block<Dim>::cells];   ///< of ln J
    Real in_tension[Block<Dim>::cells];  ///< of it (core/grid_pressure.hpp: increment_in_tension)
    Real loose[Block<Dim>::cells];       ///< K_c of a loose cell, else 0 [Pa]
};
template <class Real, int Dim, int Width, FluidGrid Fluid>
using FluidSharedOf =
    std::conditional_t<Fluid == FluidGrid::pressure, PressureShared<Real, Dim, Width>, FluidShared<Real, Dim, Width>>;

/// All threads of the team, which see it afterwards.
template <class Shape, class Real, int Dim>
__device__ __forceinline__ void load_fluid(const View<Real, Dim>& v, const MeansGatherArgs<Real, Dim>&, int block,
                                           FluidShared<Real, Dim, Shape::width>& shared) {
    load_fluid_tile<Shape>(v, block, shared.tile);
}
template <class Shape, class Real, int Dim>
__device__ __forceinline__ void load_fluid(const View<Real, Dim>& v, const FluidGatherArgs<Real, Dim>& g, int block,
                                           PressureShared<Real, Dim, Shape::width>& shared) {
    constexpr int cells = Block<Dim>::cells;
    const CellPressure<Real>* cell = g.cell + std::size_t(v.grid.tile_of[block]) * std::size_t(cells);
    for (int c = Team<Dim>::rank(); c < cells; c += Team<Dim>::threads) {
        shared.increment[c] = cell[c].increment;
        shared.in_tension[c] = increment_in_tension(cell[c]);
        shared.loose[c] = cell[c].loose ? cell[c].bulk : Real(0);
        shared.head[c] = cell[c].head;
    }
    load_fluid_tile<Shape>(v, block, shared.tile);
}

/// The shift alone, no further than it is stable.
template <class Shape, bool Rolled, class Real, int Dim>
__device__ __forceinline__ void find_fluid(const View<Real, Dim>& v, const FluidGatherArgs<Real, Dim>& g,
                                           const FluidTerms<Real>& of, const Vec<Coordinate<Real>, Dim>& u,
                                           const Vec<Real, Dim>&, PressureShared<Real, Dim, Shape::width>& shared) {
    if (!(of.shifting > Real(0))) return;
    const int at = number_of<tile_side(Shape::width), Real, Dim>(u), rank = Team<Dim>::rank();
    const FluidStencil<Shape, Real, Dim> n(u, zero_vec<Real, Dim>());
    const Real h = Real(1) / v.context.inverse_cell, most = Real(0.5) * h * h / of.shifting;
    const Vec<Real, Dim> shift = found_shift<Shape, Rolled>(v, of, most < g.dt ? most : g.dt, shared.tile, at, n);
#pragma unroll
    for (int a = 0; a < Dim; ++a) shared.own[a][rank] = shift[a];
    asm volatile("" ::: "memory");
}

/// What the pressure of a particle at u is smoothed towards [Pa]. cell: its own.
template <class Real, int Dim, int Width>
__device__ __forceinline__ Real pressure_of_cell(const View<Real, Dim>& v,
                                                 const PressureShared<Real, Dim, Width>& shared, int cell,
                                                 const Vec<Coordinate<Real>, Dim>& u) {
    return shared.head[cell] - resting_pressure(v, shared.tile, u);
}

/// What a step of the cell does to a particle's rows and its dL (core/g2p.hpp: take_cell). Returns the work [J].
template <class Real, int Dim>
__device__ __forceinline__ double take_cell(Real bulk, Real increment, CoreRows<Real, Dim>& p, Mat<Real, Dim>& dL) {
    const Real step = bulk * increment, before = (p.stress(0) + p.stress(1) + p.stress(2)) * Real(1.0 / 3.0);
    const double work = double(p.volume()) * double(before + Real(0.5) * step) * double(increment);
#pragma unroll
    for (int a = 0; a < 3; ++a) p.stress(a) += step;
    Real cubic;
    dL = isochoric_increment(dL, cubic);
    p.ln_J() += increment - cubic;
    return work;
}

template <class Real, int Dim>
__device__ __forceinline__ Real square_speed(const CoreRows<Real, Dim>& p) {
    Real square = Real(0);
#pragma unroll
    for (int a = 0; a < Dim; ++a) square += p.velocity(a) * p.velocity(a);
    return square;
}

}  // namespace moraine::gpu
