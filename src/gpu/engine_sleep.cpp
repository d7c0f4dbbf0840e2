// The engine's parts of a step that concern sleeping blocks (core/sleep/sleep.hpp).

#include "comm/activity_exchange.hpp"
#include "gpu/engine.hpp"

namespace moraine::gpu {

/// In the present tables, where no binning follows that would find them.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::find_sleepers() {
    if (!sleepers_) return;
    sleepers_->find(view(), store_.rows.rest(), nullptr, stream_);
    sleepers_->count(stream_);
    stream_.wait();
    census_.asleep = sleepers_->particles();
}

/// With other ranks the host waits and sends the activity of the boundary's blocks; alone it does not wait. Counts come
/// with the report of the last binning, accounts with that of the next.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::check_sleep(bool first, const Quantum& quantum, const StructureSet<Dim>* structures) {
    const RestWords rest = store_.rows.rest();
    if (structures && structures->any_moves())
        sleepers_->keep_awake(view(), contact_.structures.place(*structures, stream_), stream_);
    sleepers_->find_activity(view(), rest, stream_);
    if (exchange_) {
        stream_.wait();
        std::vector<double> activity = sleepers_->activity(reading_);
        exchange_activity(exchange_->activity, epoch_.tables, activity);
        sleepers_->set_activity(activity);
    }
    sleepers_->change(view(), rest, first, quantum, stream_);
    reports_.reported.record(stream_);
    share_is_of_now_ = false;
}

/// Wakes blocks with a fast node or near a moving structure; the gather runs over the lists of awake blocks.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::hold_sleepers(const StepScales<Dim>& step) {
    if (step.structures && step.structures->any_moves())
        sleepers_->keep_awake(view(), contact_.at_nodes.field, stream_);
    const std::uint8_t* near = step.structures ? contact_.at_nodes.near.mark : nullptr;
    if (near && surfaces_) near = surfaces_->near_mark();
    sleepers_->hold(view(), store_.rows.rest(), near, step.quantum, epoch_.lists.is_boundary(), stream_);
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
