// The engine's parts of a step that concern sleeping blocks (core/sleep.hpp).

#include "comm/sleepers.hpp"
#include "gpu/engine.hpp"

namespace moraine::gpu {

/// In the tables of now, where no binning follows that would.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::find_sleepers() {
    if (!sleepers_) return;
    sleepers_->find(view(), particles_.rest(), nullptr, stream_);
    sleepers_->count(stream_);
    stream_.wait();
    census_.asleep = sleepers_->particles();
}

/// The host passes on what blocks of the boundary do, where there are others; else it does not wait. Its counts come
/// with the report of the last binning, its accounts with that of the next.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::check_sleep(bool first, const Quantum& quantum, const StructureSet<Dim>* structures) {
    const RestWords rest = particles_.rest();
    if (structures && structures->any_moves())
        sleepers_->keep_awake(view(), structures_.place(*structures, stream_), stream_);
    sleepers_->find_activity(view(), rest, stream_);
    if (exchange_) {
        stream_.wait();
        std::vector<double> activity = sleepers_->activity(reading_);
        exchange_activity(exchange_->activity, epoch_, activity);
        sleepers_->set_activity(activity);
    }
    sleepers_->change(view(), rest, first, quantum, stream_);
    reported_.record(stream_);
    share_is_of_now_ = false;
}

/// Who has a fast node or a structure that moves near wakes; the lists of the gather are of those that are awake.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::hold_sleepers(const StepScales<Dim>& step) {
    if (step.structures && step.structures->any_moves()) sleepers_->keep_awake(view(), node_contact_.field, stream_);
    sleepers_->hold(view(), particles_.rest(), step.structures ? node_contact_.near.mark : nullptr, step.quantum,
                    lists_.is_boundary(), stream_);
}

template <class Real, int Dim>
HaloSleepers DeviceEngine<Real, Dim>::halo_sleepers() const {
    return sleepers_ ? HaloSleepers{sleepers_->asleep(), sleepers_->kept()} : HaloSleepers{};
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
