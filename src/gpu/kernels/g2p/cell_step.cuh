#pragma once
// The pressure of the grid (core/fluid/grid_pressure.hpp) on the device: the cells of a block in shared memory.

#include "gpu/kernels/g2p/fluid.cuh"

namespace moraine::gpu {

template <class Real, int Dim>
struct PressureShared {
    static constexpr int cells = Block<Dim>::cells;
    RestingPressure<Real> resting;
    Real head[cells];        ///< of P + rho g.x, which smoothing takes [Pa]
    Real increment[cells];   ///< of ln J
    Real in_tension[cells];  ///< of it (core/fluid/grid_pressure.hpp: increment_in_tension)
    Real loose[cells];       ///< K_c of a loose cell, else 0 [Pa]
    Real stiffest[cells];    ///< the most that particles count of their modulus [Pa]
};

template <class Case>
struct PressureTerm {
    using Real = typename Case::Real;
    static constexpr int dim = Case::dim, cells = Block<dim>::cells;
    static constexpr unsigned hooks = Case::pressure ? hook_block | hook_stress : 0u;
    struct Shared : SharedIf<PressureTerm, Case::pressure, PressureShared<Real, dim>> {};

    MORAINE_TEAM void at_block(const auto& in, Shared& own) {
        const CellPressure<Real>* cell = in.g.cell + std::size_t(in.v.grid.tile_of[in.work.block]) * std::size_t(cells);
        for (int c = Case::T::rank(); c < cells; c += Case::T::threads) {
            const CellStep<Real> step = CellStep<Real>::of(cell[c]);
            own.increment[c] = step.increment;
            own.in_tension[c] = step.in_tension;
            own.loose[c] = step.loose;
            own.stiffest[c] = step.stiffest;
            own.head[c] = cell[c].head;
        }
        if (Case::T::rank() == 0) own.resting.template load<typename Case::Shape>(in.v, in.work.block);
    }

    /// Smoothing stays inside the cell, and comes before its step.
    MORAINE_TEAM void before_stress(const auto& in, auto& point, auto& dL, const Shared& own, auto& tally,
                                    double& power) {
        point.load_all();
        const Real square = square_speed<Real, dim>(point.p);
        if (square > tally.square_speed) tally.square_speed = square;
        const typename Case::U u = point.place();
        const int cell = number_of<4, Real, dim>(u);
        smooth_pressure(point.fluid(), in.g.dt, own.head[cell] - own.resting.at(in.v, u), point.p);
        const CellStep<Real> step{own.increment[cell], own.in_tension[cell], own.loose[cell], own.stiffest[cell]};
        power += take_cell(step, point.bulk(), point.p, dL);
        point.store_pressure();
    }
};

}  // namespace moraine::gpu
