// The engine's parts of a step, in the order in which the simulation calls them.

#include <utility>

#include "gpu/engine.hpp"

namespace moraine::gpu {

/// Incoming particles, then the next lists; the report of the step before goes to the host.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::bin() {
    report_lead();
    if (!moving_) return;
    if (exchange_) {
        exchange_->migration.post();
        exchange_->migration.finish(exchange_->routes.receive(), epoch_.lists.binning(epoch_.table.view()),
                                    store_.records(), reports_.counters.data(), exchange_->stream);
        exchange_->arrived.record(exchange_->stream);
        stream_.wait_for(exchange_->arrived);
    }
    reports_.watch.begin_step(stream_);
    reports_.timed = true;
    epoch_.lists.make(epoch_.table.view(), stream_);
    const std::uint32_t* former_first = epoch_.pending ? nullptr : epoch_.lists.former_first();
    if (epoch_.pending) {
        if (sleepers_) sleepers_->wake_entered(view(), store_.rows.rest(), epoch_.lists.former_first(), stream_);
        change_tables();
        lead_ ? reports_.watch.begin_again(stream_) : reports_.watch.skip();
    }
    count_migration_bound();
    report(former_first);
    reports_.is_of_epoch = true;
    moving_ = false;
}

/// former_first: the lists' bounds before, for sleepers.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::report(const std::uint32_t* former_first) {
    const ReportWork<Dim> work = reports_.work(epoch_.lists, reports_.report.device());
    if (sleepers_) {
        sleepers_->find(view(), store_.rows.rest(), former_first, stream_);
        sleepers_->report(work, stream_);
    } else {
        fold_report(work, stream_);
    }
    reports_.reported.record(stream_);
    reports_.of_lead = nullptr;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::begin_sums(const SumsOfStep<Dim>& sums, const StructureSet<Dim>* structures) {
    if (structures) contact_.begin(*structures, epoch_.tables, epoch_.table.view(), method_.stencil, stream_);
    if (structures && surfaces_) {
        surfaces_->begin(*structures, epoch_.tables, {exchange_.get(), reports_.counters.data(), &stream_}, stream_);
        contact_.surfaces = surfaces_->space();
    }
    fluid_.mean = sums.mean;
    if (added_.loads) added_.loads->begin_step(sums.load_factors, store_.rows.capacity(), stream_);
}

/// The first call queues boundary and interior; in the second the host has only to send the halo's messages.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::sum(SharePart part) {
    if (part == SharePart::interior) {
        if (exchange_) exchange_->halo.post();
        return;
    }
    if (!reports_.timed) reports_.watch.begin(0, stream_);
    queue_sums();
}

/// The boundary goes first, on the halo's stream, and the interior fills what it leaves free.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::queue_sums() {
    const bool limiting = std::exchange(contact_.limits_depths, false);
    const auto find_gaps = [&](const Array<ContactPair>& pairs, cudaStream_t stream) {  // of nodes, or of elements
        if (surfaces_) return surfaces_->find_gaps(view(), contact_, pairs, stream);
        gpu::find_gaps(view(), scene_.shape, contact_.field, contact_.gaps, pairs, stream);
    };
    if (exchange_) {
        exchange_->binned.record(stream_);
        exchange_->stream.wait_for(exchange_->binned);
        if (limiting)
            limit_depths(view(), method_.ends, contact_.field, contact_.gaps, contact_.gaps.boundary(),
                         exchange_->stream);
        sum_part(0, exchange_->stream);
        if (contact_.finds_gaps) find_gaps(contact_.gaps.boundary(), exchange_->stream);
        exchange_->boundary_summed.record(exchange_->stream);
    }
    if (limiting) limit_depths(view(), method_.ends, contact_.field, contact_.gaps, contact_.gaps.interior(), stream_);
    sum_part(1, stream_);
    if (contact_.finds_gaps) find_gaps(contact_.gaps.interior(), stream_);
    if (exchange_) stream_.wait_for(exchange_->boundary_summed);  // of the watch alone; the nodes wait for more
    if (sleepers_) sleepers_->summed(view(), store_.rows.rest(), stream_);
    reports_.watch.end(0, stream_);
    share_is_of_now_ = false;
    summed_ = true;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::send_halo() {
    if (!exchange_) return;
    Exchange<Real, Dim>& e = *exchange_;
    e.halo.start(e.routes.send(), view().grid, contact_.finds_gaps ? &contact_.gaps : nullptr, halo_sleepers(),
                 tile_side(method_.stencil.width), reports_.counters.data(), e.stream);
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::receive_halo() {
    const bool finding = std::exchange(contact_.finds_gaps, false);
    if (!exchange_) return;
    Exchange<Real, Dim>& e = *exchange_;
    e.halo.finish(e.routes.receive(), view().grid, finding ? &contact_.gaps : nullptr, halo_sleepers(),
                  epoch_.lists.tile_of(), static_cast<int>(epoch_.tables.own.size()), tile_side(method_.stencil.width),
                  e.stream);
    e.halo_here.record(e.stream);
    stream_.wait_for(e.halo_here);
}

/// Capacity for the messages, and in memory for all that may arrive in this step.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::expect_outgoing(const MigrationBound& bound) {
    if (!exchange_) return;
    exchange_->migration.expect(bound, store_.records().bytes());
    const std::size_t incoming = exchange_->migration.most_incoming();
    const std::size_t most = static_cast<std::size_t>(census_.particles) + incoming;
    if (most > store_.rows.capacity())
        refresh_and_grow(most);
    else if (store_.used + incoming > store_.rows.capacity())
        refresh();
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::send_outgoing(const StepScales<Dim>&) {
    if (exchange_) {
        epoch_.lists.collect(epoch_.table.view(), Part::boundary, boundary_blocks_, exchange_->stream);
        exchange_->migration.start(exchange_->routes.send(), epoch_.lists.binning(epoch_.table.view()),
                                   store_.records(), reports_.counters.data(), exchange_->stream);
    }
    epoch_.lists.collect(epoch_.table.view(), exchange_ ? Part::interior : Part::all, interior_blocks(), stream_);
    moving_ = true;
}

template <class Real, int Dim>
Traffic DeviceEngine<Real, Dim>::traffic() const {
    if (!exchange_) return {};
    exchange_->stream.wait();
    stream_.wait();
    const Counters counted = reports_.counters.host().front();
    return {static_cast<std::int64_t>(counted.halo_bytes), static_cast<std::int64_t>(counted.crossed)};
}

template <class Real, int Dim>
NodeRound<Real, Dim> DeviceEngine<Real, Dim>::node_round(NodeTask task, double dt, const StepScales<Dim>& step) const {
    NodeRound<Real, Dim> round{task, static_cast<Real>(dt), {}, method_.damping, static_cast<Real>(step.mass_cutoff)};
    for (int a = 0; a < Dim; ++a) round.gravity[a] = static_cast<Real>(step.gravity[static_cast<std::size_t>(a)]);
    return round;
}

template <class Real, int Dim>
LightMarks<Real> DeviceEngine<Real, Dim>::light_marks_of(const Round& round) const {
    if (!limits(round)) return {};
    return light_.marks_of_nodes();
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::solve_nodes(const Round& round, const StepScales<Dim>& step) {
    reports_.watch.begin(1, stream_);
    if (round.nodes == NodeTask::hold) return hold(round, step);
    const NodeRound<Real, Dim> args = node_round(round.nodes, step.dt, step);
    const LightMarks<Real> marks = light_marks_of(round);
    if (added_.ends && solves(round.nodes)) {
        added_.ends->find(method_.context.walls, method_.absorbs, method_.stencil.origin, epoch_.tables.node_position,
                          stream_);
        added_.ends->act(view(), method_.stencil.width, method_.stencil.origin, args, step.quantum, stream_);
    }
    if (step.structures) {
        const NodeContact<Dim> contact =
            contact_.find_at_nodes(*step.structures, epoch_.table.view(), method_.stencil, stream_);
        run_nodes(args, step.quantum, marks, surfaces_ && !method_.fluid() ? nullptr : &contact);
        if (surfaces_) {
            const SurfaceShare<Real, Dim> share{view(), contact_, step, {}};
            surfaces_->begin_step(share, stream_);
            surfaces_->act(share, {step.dt, step.dt}, 0, stream_);
        }
        contact_.structures.fetch(stream_);
    } else {
        run_nodes(args, step.quantum, marks, nullptr);
    }
    reports_.watch.end(1, stream_);
    summed_ = false;
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::find(FaultQuery<Dim>& query) {
    query.found.clear();
    if (!reports_.faults) return;
    each_piece(
        [&](const SharePiece<Real, Dim>& piece) {
            for (int b = piece.begin; b < piece.end && query.found.empty(); ++b)
                for (std::uint32_t s : piece.slots(b)) {
                    if (piece.p.id[s] != reports_.faulty_id) continue;
                    const auto& block = piece.tables.position[static_cast<std::size_t>(b)];
                    query.found = {{reports_.faulty_id, reports_.faults,
                                    place_in<Real, Dim>(scene_, method_.stencil, block, piece.p.position[s])}};
                }
        },
        {"id", "position"});
    if (query.found.empty()) query.found = {{reports_.faulty_id, reports_.faults, {}}};
}

/// What the last binning counted, unless an epoch has begun since and knows better.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::take_census() {
    const Report<Dim>& last = reports_.last();
    if (sleepers_) census_.asleep = sleepers_->particles();
    if (!reports_.is_of_epoch) return;
    census_ = {last.particles, last.occupied(), {last.migration_bound[0], last.migration_bound[1]}, census_.asleep};
    boundary_blocks_ = static_cast<int>(last.boundary);
    store_.used = last.stored;
}

template <class Real, int Dim>
StepReport<Dim> DeviceEngine<Real, Dim>::take_report() {
    if (surfaces_) surfaces_->prefetch(reports_.reported);
    take_census();
    StepReport<Dim> report = reports_.take();
    if (sleepers_) sleepers_->add_taken(report.budget);
    contact_.structures.take(report.felt, report.turning);
    if (added_.loads) added_.loads->add_to(report.budget);
    report.seconds = reports_.watch.take();
    store_.clock.step();
    if (lead_) lead_->note_timed(report.seconds);
    if (lead_ && lead_->is_under_way()) {
        lead_->take_into(report, stream_);
        return report;
    }
    if (static_cast<std::size_t>(census_.blocks) > epoch_.tile_capacity) grow_tiles();
    if (store_.clock.left() <= 0) refresh();
    return report;
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
