#pragma once
// The volumetric part of rate and stress from a cell instead of each particle's own: a cure for volumetric locking.
//
//   dL_p <- dL_p + (mean of tr dL - tr dL_p) / Dim I,    sigma_p <- sigma_p + (mean of tr sigma - tr sigma_p) / 3 I
//
// before the stress update, with means sum m_p x / sum m_p over the particles of a binning cell whose materials want
// it. A nearly incompressible material then constrains the nodes once per cell and not once per particle.
//
// Both are needed. With the rates alone, pressures that differ within a cell are seen by no rate: nothing takes them
// back, and they push for ever (a slurry gained more energy than it had in one second). With one pressure p for the
// particles of a cell the force sum V_p p grad w_p is the derivative of the cell's energy, whose rate is the mean one.
// Cells of binning are local to a block: no exchange.
//
// F-bar: de Souza Neto et al. 1996; over the points of a cell in MPM: Coombs et al. 2018.

#include "core/data/vec.hpp"

namespace moraine {

template <class Real, int Dim>
MORAINE_HD Real trace(const Mat<Real, Dim>& dL) {
    Real sum = Real(0);
    for (int a = 0; a < Dim; ++a) sum += dL(a, a);
    return sum;
}

/// What each of N normal components takes where their sum is `sum` and `wanted` is wanted.
template <int N, class Real>
MORAINE_HD Real trace_step(Real wanted, Real sum) {
    return (wanted - sum) * Real(1.0 / N);
}

/// Gives dL another trace and leaves its deviator (in plane strain: in the plane).
template <class Real, int Dim>
MORAINE_HD void set_trace(Mat<Real, Dim>& dL, Real wanted) {
    const Real step = trace_step<Dim>(wanted, trace(dL));
    for (int a = 0; a < Dim; ++a) dL(a, a) += step;
}

/// Gives a stress another trace and leaves its deviator.
template <class Real, int Dim>
MORAINE_HD void set_trace(Sym<Real, Dim>& stress, Real wanted) {
    const Real step = trace_step<3>(wanted, stress.trace());
    for (int a = 0; a < 3; ++a) stress[a] += step;
}

/// The means of a cell, particle by particle.
template <class Real>
struct VolumetricMean {
    Real rate = Real(0);    ///< sum m tr dL; after finish() the mean
    Real stress = Real(0);  ///< sum m tr sigma; likewise
    Real mass = Real(0);    ///< [kg]

    MORAINE_HD void add(Real m, Real of_rate, Real of_stress) {
        rate += m * of_rate;
        stress += m * of_stress;
        mass += m;
    }
    MORAINE_HD void finish() {
        const Real share = mass > Real(0) ? Real(1) / mass : Real(0);
        rate *= share;
        stress *= share;
    }
};

}  // namespace moraine
