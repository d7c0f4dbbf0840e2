// The host's engine: what acts on surfaces where they are (Bed::surface), in a step.

#include "comm/host_engine.hpp"
#include "comm/host_surfaces.hpp"

namespace moraine {

/// What nodes see of structures: what acts along them does so on their surfaces.
template <class Real, int Dim>
const Structure<Dim>* HostEngine<Real, Dim>::smooth_structures(const ContactField<Dim>& field) {
    smooth_.assign(field.structure, field.structure + field.count);
    for (Structure<Dim>& s : smooth_) s.law = InterfaceLaw::smooth;
    return smooth_.data();
}

/// Structures as they move in this step; the gaps of its nodes are found.
template <class Real, int Dim>
void HostEngine<Real, Dim>::begin_surfaces(const StepScales<Dim>& step) {
    report_.felt.resize(step.structures->size());
    surfaces_->begin_step({step.structures->field(), step.quantum, static_cast<Real>(step.mass_cutoff), pressed_.data(),
                           held_.data(), nullptr, gaps_.data(), report_.felt.data(), impulse_.data()},
                          *halo_, pairs_);
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::act_on_surfaces(const StepScales<Dim>& step) {
    begin_surfaces(step);
    surfaces_->slow(step.dt, 0);
}

template class HostEngine<float, 2>;
template class HostEngine<float, 3>;
template class HostEngine<double, 2>;
template class HostEngine<double, 3>;

}  // namespace moraine
