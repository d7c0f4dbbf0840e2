#pragma once
// What the gather of a scene needs besides what both transfers do: for who calls it.

#include "core/transfer/g2p.hpp"
#include "core/transfer/kernel_list.hpp"

namespace moraine {

template <class Real, int Dim>
struct GatherCall {
    HostStress<Real, Dim> stress;
    DomainEnds<Real, Dim> ends;
    GatherRound<Real> round;
    GatherNotes notes;
    HostTerms<Real, Dim> terms = {};
};

}  // namespace moraine
