#pragma once
// What the kernels of the grid's pressure are told (gpu/kernels/pressure/pressure.hpp). Plain data, for kernels and
// their launches alike.

#include "core/fluid/find_pressures.hpp"
#include "core/fluid/grid_pressure.hpp"
#include "gpu/kernels/nodes/node_work.hpp"

namespace moraine::gpu {

/// Pointers to it.
template <class Real, int Dim>
struct PressureView {
    CellPressure<Real>* cell;         ///< [tile][cell]
    CellMoments<Real, Dim>* moments;  ///< [tile][cell]; of cells that are not whole
    HeldNode<Real, Dim>* held;        ///< [node block][node]
    const Real* bulk;                 ///< by body: K [Pa]
};

/// Of the cells and nodes of a block [bytes].
template <class Real, int Dim>
constexpr double pressure_bytes() {
    return Block<Dim>::cells *
           double(sizeof(CellPressure<Real>) + sizeof(CellMoments<Real, Dim>) + 1.3 * sizeof(HeldNode<Real, Dim>));
}

/// Nodes from the sums of particles: velocities, masses, what is held, e_i of the shifts in the last lane, light marks.
template <class Real, int Dim>
struct HoldWork {
    View<Real, Dim> view;
    PressureView<Real, Dim> pressure;
    int origin;           ///< of the stencil
    Real mass_cutoff;     ///< [kg]
    Real inverse_volume;  ///< 1 / h^d [1/m3]
    bool shifts;          ///< in this step
    NodeCapacity<Real, Dim> capacity;
    LightMarks<Real> marks;
    NodeContact<Dim> contact;  ///< near.mark null: there is no structure
};

/// What a launch over cells does.
template <class Real>
struct PressureTask {
    bool updates;  ///< takes the velocities of the substep before
    Real dt;       ///< of it [s]
    Real time;     ///< half of the time from the start of the step to its middle [s]
    bool sums;     ///< writes the tiles of this substep
    Real damping;  ///< d [-]
};

template <class Real, int Dim>
struct SubstepWork : NodeWork<Real, Dim> {
    PressureView<Real, Dim> pressure;
};

/// Of the kernel that finds cells.
template <class Real, int Dim>
struct FindWork {
    View<Real, Dim> view;
    PressureFinder<Real, Dim> finder;
    CellMoments<Real, Dim>* moments;  ///< [tile][cell]; of cells that are not whole
    const Real* bulk;                 ///< by body [Pa]
};

}  // namespace moraine::gpu
