#pragma once
// The gap that opens when grains fly apart: volume that is gained past the apex of a cone and bears nothing.
//
//   ln J (whole) = ln J (grains, as PointState keeps it) + gap,   gap >= 0
//   past the apex: gap += (mean - apex) / K;   compressed: the gap closes first, and only then pressure builds up
//
// So mass over volume and the wave speed stay those of the grains, a closed path of strain ends without
// stress, and dt does not fall with a density that means nothing. Source: the volume correction of
// Tampubolon et al. (2017), section 4.3.4, after Klar et al. (2016), in terms of the logarithm of J.
// Where the flow cannot close a gap again (an isolated grain in a stencil of its own), it stays.

#include "core/material/point.hpp"

namespace moraine {

/// Mean stress [Pa] once the gap has given way to compression as far as it goes.
template <class Real>
MORAINE_HD Real close_gap(Real& gap, Real mean, Real bulk) {
    if (!(gap > Real(0) && mean < Real(0))) return mean;
    const Real wanted = -mean / bulk;
    if (wanted < gap) {
        gap -= wanted;
        return Real(0);
    }
    mean += bulk * gap;
    gap = Real(0);
    return mean < Real(0) ? mean : Real(0);
}

/// Puts what the gap has gained or lost since `before` into ln J.
template <class Real, int Dim>
MORAINE_HD void keep_grains(PointState<Real, Dim>& state, Real before, Real gap) {
    state.ln_J += before - gap;
}

}  // namespace moraine
