// The engine's parts of a step, in the order in which the simulation calls them.

#include <bit>
#include <utility>

#include "gpu/engine.hpp"

namespace moraine::gpu {

namespace {

template <int Dim>
Budget<Dim> budget_of(const Account<Dim>& a) {
    Budget<Dim> l;
    l.work = a.work;
    l.lost_mass = a.lost_mass;
    for (std::size_t i = 0; i < Dim; ++i) {
        l.impulse[i] = a.impulse[i];
        l.lost_momentum[i] = a.lost_momentum[i];
        l.lost_gravity_impulse[i] = a.lost_gravity_impulse[i];
    }
    l.lost_count = static_cast<std::int64_t>(a.lost_count);
    return l;
}

}  // namespace

/// Incoming particles, then the next lists; the report of the step before goes to the host.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::bin() {
    report_lead();
    if (!moving_) return;
    if (exchange_) {
        exchange_->migration.post();
        exchange_->migration.finish(exchange_->routes.receive(), lists_.binning(tables_.view()), records(),
                                    counters_.data(), exchange_->stream);
        exchange_->arrived.record(exchange_->stream);
        stream_.wait_for(exchange_->arrived);
    }
    watch_.begin_step(stream_);
    timed_ = true;
    lists_.make(tables_.view(), stream_);
    const std::uint32_t* former_first = pending_ ? nullptr : lists_.former_first();
    if (pending_) {
        if (sleepers_) sleepers_->wake_entered(view(), particles_.rest(), lists_.former_first(), stream_);
        change_tables();
        lead_ ? watch_.begin_again(stream_) : watch_.skip();
    }
    count_migration_bound();
    report(former_first);
    report_is_of_epoch_ = true;
    moving_ = false;
}

/// former_first: the lists' bounds before, for sleepers.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::report(const std::uint32_t* former_first) {
    const ReportWork<Dim> work = report_work(report_.device());
    if (sleepers_) {
        sleepers_->find(view(), particles_.rest(), former_first, stream_);
        sleepers_->report(work, stream_);
    } else {
        fold_report(work, stream_);
    }
    reported_.record(stream_);
    told_ = nullptr;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::find_gaps(const StructureSet<Dim>& structures) {
    contact_ = structures_.place(structures, stream_);
    gaps_.make(epoch_, structures.field(), structures.any_moves(), method_.stencil.width, stream_);
    contact_.ground = gaps_.ground(tables_.view(), contact_, method_.stencil.origin, stream_);
    finding_ = limiting_ = true;
}

/// Boundary and interior at once: the device has its queues.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::sum_boundary() {
    if (!timed_) watch_.begin(0, stream_);
    sum();
}

/// The boundary goes first, on the halo's stream, and the interior fills what it leaves free.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::sum() {
    const bool limiting = std::exchange(limiting_, false);
    if (exchange_) {
        exchange_->binned.record(stream_);
        exchange_->stream.wait_for(exchange_->binned);
        if (limiting) limit_depths(view(), method_.ends, contact_, gaps_, gaps_.boundary(), exchange_->stream);
        sum_part(0, exchange_->stream);
        if (finding_) gpu::find_gaps(view(), scene_.shape, contact_, gaps_, gaps_.boundary(), exchange_->stream);
        exchange_->boundary_summed.record(exchange_->stream);
    }
    if (limiting) limit_depths(view(), method_.ends, contact_, gaps_, gaps_.interior(), stream_);
    sum_part(1, stream_);
    if (finding_) gpu::find_gaps(view(), scene_.shape, contact_, gaps_, gaps_.interior(), stream_);
    if (exchange_) stream_.wait_for(exchange_->boundary_summed);  // of the watch alone; the nodes wait for more
    if (sleepers_) sleepers_->summed(view(), particles_.rest(), stream_);
    watch_.end(0, stream_);
    share_is_of_now_ = false;
    summed_ = true;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::send_halo() {
    if (!exchange_) return;
    Exchange<Real, Dim>& e = *exchange_;
    e.halo.start(e.routes.send(), view().grid, finding_ ? &gaps_ : nullptr, halo_sleepers(),
                 tile_side(method_.stencil.width), counters_.data(), e.stream);
}

/// The interior's sums are queued already: what is left is the host's part of the halo.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::sum_interior() {
    if (exchange_) exchange_->halo.post();
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::receive_halo() {
    const bool finding = std::exchange(finding_, false);
    if (!exchange_) return;
    Exchange<Real, Dim>& e = *exchange_;
    e.halo.finish(e.routes.receive(), view().grid, finding ? &gaps_ : nullptr, halo_sleepers(), lists_.tile_of(),
                  static_cast<int>(epoch_.own.size()), tile_side(method_.stencil.width), e.stream);
    e.halo_here.record(e.stream);
    stream_.wait_for(e.halo_here);
}

/// Capacity for the messages, and in memory for all that may arrive in this step.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::expect_outgoing(const MigrationBound& bound) {
    if (!exchange_) return;
    exchange_->migration.expect(bound, records().bytes());
    const std::size_t incoming = exchange_->migration.most_incoming();
    const std::size_t most = static_cast<std::size_t>(census_.particles) + incoming;
    if (most > particles_.capacity())
        refresh_and_grow(most);
    else if (stored_ + incoming > particles_.capacity())
        refresh();
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::send_outgoing(const StepScales<Dim>&) {
    if (exchange_) {
        lists_.collect(tables_.view(), Part::boundary, boundary_blocks_, exchange_->stream);
        exchange_->migration.start(exchange_->routes.send(), lists_.binning(tables_.view()), records(),
                                   counters_.data(), exchange_->stream);
    }
    lists_.collect(tables_.view(), exchange_ ? Part::interior : Part::all, interior_blocks(), stream_);
    moving_ = true;
}

template <class Real, int Dim>
Traffic DeviceEngine<Real, Dim>::traffic() const {
    if (!exchange_) return {};
    exchange_->stream.wait();
    stream_.wait();
    const Counters counted = counters_.host().front();
    return {static_cast<std::int64_t>(counted.halo_bytes), static_cast<std::int64_t>(counted.crossed)};
}

template <class Real, int Dim>
NodeRound<Real, Dim> DeviceEngine<Real, Dim>::node_round(NodeTask task, double dt, const StepScales<Dim>& step) const {
    return {task, static_cast<Real>(dt), method_.gravity, method_.damping, static_cast<Real>(step.mass_cutoff)};
}

template <class Real, int Dim>
LightMarks<Real> DeviceEngine<Real, Dim>::light_marks_of(const Round& round) const {
    if (!limits(round)) return {};
    return {light_marks_.data(), Real(0.5) * full_mass_, limited_count_.data()};
}

/// The structures as nodes see them, with the ground of this epoch.
template <class Real, int Dim>
NodeContact<Dim> DeviceEngine<Real, Dim>::node_contact(const StructureSet<Dim>& structures) {
    ContactField<Dim> field = structures_.place(structures, stream_);
    field.ground = contact_.ground;
    node_contact_ = {field, gaps_.view(),
                     near_blocks_.find(tables_.view(), field, method_.stencil.origin, structures.any_moves(), stream_)};
    return node_contact_;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::solve_nodes(const Round& round, const StepScales<Dim>& step) {
    watch_.begin(1, stream_);
    if (round.nodes == NodeTask::hold) return hold(round, step);
    const NodeRound<Real, Dim> args = node_round(round.nodes, step.dt, step);
    const LightMarks<Real> marks = light_marks_of(round);
    if (step.structures) {
        const NodeContact<Dim> contact = node_contact(*step.structures);
        run_nodes(args, step.quantum, marks, &contact);
        structures_.fetch(stream_);
    } else {
        run_nodes(args, step.quantum, marks, nullptr);
    }
    watch_.end(1, stream_);
    summed_ = false;
}

template <class Real, int Dim>
std::vector<FaultRecord<Dim>> DeviceEngine<Real, Dim>::fault_records() {
    if (!faults_) return {};
    std::vector<FaultRecord<Dim>> found;
    each_piece(
        [&](const SharePiece<Real, Dim>& piece) {
            for (int b = piece.begin; b < piece.end && found.empty(); ++b)
                for (std::uint32_t s : piece.slots(b)) {
                    if (piece.p.id[s] != faulty_id_) continue;
                    const auto& block = piece.tables.position[static_cast<std::size_t>(b)];
                    found = {{faulty_id_, faults_,
                              place_in<Real, Dim>(scene_, method_.stencil, block, piece.p.position[s])}};
                }
        },
        {"id", "position"});
    if (!found.empty()) return found;
    return {{faulty_id_, faults_, {}}};
}

/// Of the last step that is binned; waits for it.
template <class Real, int Dim>
const Report<Dim>& DeviceEngine<Real, Dim>::last_report() const {
    if (told_) return *told_;
    reported_.wait();
    return *report_;
}

/// What the last binning counted, unless an epoch has begun since and knows better.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::take_census() {
    const Report<Dim>& last = last_report();
    if (sleepers_) census_.asleep = sleepers_->particles();
    if (!report_is_of_epoch_) return;
    census_ = {last.particles, last.occupied(), {last.migration_bound[0], last.migration_bound[1]}, census_.asleep};
    boundary_blocks_ = static_cast<int>(last.boundary);
    stored_ = last.stored;
}

template <class Real, int Dim>
StepReport<Dim> DeviceEngine<Real, Dim>::take_report() {
    const Report<Dim>& last = last_report();
    const Account<Dim>& account = last.account;
    take_census();
    faults_ = account.faults;
    faulty_id_ = account.faulty_id;
    StepReport<Dim> report;
    report.signal = std::bit_cast<double>(account.signal);
    report.moved = std::bit_cast<double>(account.moved);
    report.square_speed = std::bit_cast<double>(account.square_speed);
    report.faults = account.faults;
    report.in_guard_layer = last.in_guard_layer != 0;
    report.clamped = account.clamped;
    report.budget = budget_of(account);
    if (sleepers_) sleepers_->add_taken(report.budget);
    report.felt = structures_.take();
    report.seconds = watch_.take();
    refresh_clock_.step();
    if (lead_) lead_->note_timed(report.seconds);
    if (lead_ && lead_->is_under_way()) {
        take_entry(report);
        return report;
    }
    if (static_cast<std::size_t>(census_.blocks) > tile_capacity_) grow_tiles();
    if (refresh_clock_.left() <= 0) refresh();
    return report;
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
