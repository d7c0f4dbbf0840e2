#pragma once
// What tractions give a particle in a step (core/particles/traction.hpp).

#include "core/data/vec.hpp"

namespace moraine {

template <class Real, int Dim>
struct ParticleLoad {
    Vec<Real, Dim> force;   ///< [N]
    Mat<Real, Dim> couple;  ///< by axes of the force and the lever [N m]
};

template <class Real, int Dim>
MORAINE_HD bool acts(const ParticleLoad<Real, Dim>& load) {
    bool any = false;
    for (int a = 0; a < Dim; ++a) {
        any = any || load.force[a] != Real(0);
        for (int b = 0; b < Dim; ++b) any = any || load.couple(a, b) != Real(0);
    }
    return any;
}

/// F - I behind a step: F - I + dL + dL (F - I).
template <class Real, int Dim>
MORAINE_HD void deform(const Mat<Real, Dim>& dL, Mat<Real, Dim>& change) {
    const Mat<Real, Dim> more = dL * change;
    for (int a = 0; a < Dim; ++a)
        for (int b = 0; b < Dim; ++b) change(a, b) += dL(a, b) + more(a, b);
}

}  // namespace moraine
