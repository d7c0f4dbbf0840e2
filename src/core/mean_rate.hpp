#pragma once
// The volumetric rate of a cell instead of each particle's own: a cure for volumetric locking.
//
//   dL_p <- dL_p + (mean - tr dL_p) / Dim I,    mean = sum_p m_p tr dL_p / sum_p m_p
//
// over the particles of a filing cell whose materials want it. A nearly incompressible material then constrains the
// nodes once per cell and not once per particle; particles that have the same history of rates have the same pressure.
// The rate is averaged, not F or the pressure: hypoelastic laws have only rates, and a gradient of pressure that is
// there (geostatic) stays. Cells of filing are local to a block: no exchange.
//
// F-bar: de Souza Neto et al. 1996; over the points of a cell in MPM: Coombs et al. 2018.

#include "core/vec.hpp"

namespace moraine {

template <class Real, int Dim>
MORAINE_HD Real trace(const Mat<Real, Dim>& dL) {
    Real sum = Real(0);
    for (int a = 0; a < Dim; ++a) sum += dL(a, a);
    return sum;
}

/// Gives dL another trace and leaves its deviator (in plane strain: in the plane).
template <class Real, int Dim>
MORAINE_HD void set_trace(Mat<Real, Dim>& dL, Real wanted) {
    const Real step = (wanted - trace(dL)) * Real(1.0 / Dim);
    for (int a = 0; a < Dim; ++a) dL(a, a) += step;
}

/// The mean of a cell, particle by particle.
template <class Real>
struct MeanRate {
    Real moment = Real(0);  ///< sum m tr dL [kg]
    Real mass = Real(0);    ///< [kg]

    MORAINE_HD void add(Real m, Real rate) {
        moment += m * rate;
        mass += m;
    }
    MORAINE_HD Real value() const { return mass > Real(0) ? moment / mass : Real(0); }
};

}  // namespace moraine
