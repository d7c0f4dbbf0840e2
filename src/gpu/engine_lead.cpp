// Steps that the device makes by itself (comm/lead_rule.hpp): dt by a kernel, launches by a graph, and a host that
// hears of each step later. Scenes in which a step needs its host are stepped as ever: can_lead() says which.

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstring>
#include <utility>

#include "gpu/engine.hpp"
#include "gpu/kernels/lead/dt_places.hpp"

namespace moraine::gpu {

namespace {

/// Launches for outgoing particles and lists.
constexpr int binning_launches = 4;
/// With a stress kernel each, and a gather; a graph has space for that.
constexpr std::size_t most_materials = 16;

}  // namespace

/// One rank, one round whose dt is known before the nodes, and nothing that the host does within a step: structures to
/// place, sleepers to look for, means or pressures that go by the number of the step.
template <class Real, int Dim>
bool DeviceEngine<Real, Dim>::can_lead() const {
    return !exchange_ && !sleepers_ && !takes_means() && !pending_ && scene_.structures.empty() &&
           method_.rounds.size() == 1 && method_.rounds.front().nodes == NodeTask::solve && census_.particles > 0 &&
           census_.particles <= most_led_particles && !epoch_.own.empty() && stress_.size() <= most_materials &&
           LeadGraph::is_possible();
}

/// Behind the decision, in the order of capture_lead().
template <class Real, int Dim>
std::vector<LeadLaunch> DeviceEngine<Real, Dim>::lead_launches() const {
    using Args = GatherArgs<Real, Dim>;
    using Stress = StressArgs<Real, Dim>;
    const DtPlace of_nodes = dt_of_nodes<Real, Dim>();
    const LeadLaunch other{}, sums{true}, nodes{false, 0, of_nodes.offset, 0, of_nodes.size};
    const LeadLaunch gather{false, 2, offsetof(Args, dt), offsetof(Args, gravity_impulse), sizeof(Args)};
    const LeadLaunch stress{false, 2, offsetof(Stress, dt), 0, sizeof(Stress)};
    const bool limiting = limits(method_.rounds.front());
    std::vector<LeadLaunch> launches{sums, nodes};
    if (materials_) launches.push_back(other);
    if (limiting) launches.insert(launches.end(), {other, gather});
    if (materials_) launches.insert(launches.end(), stress_.size(), gather);
    if (materials_ && limiting) launches.push_back(other);
    launches.insert(launches.end(), limiting ? 2 : 1, gather);
    launches.insert(launches.end(), stress_.size(), stress);
    launches.insert(launches.end(), binning_launches, other);
    return launches;
}

/// What a captured step depends on, dt and what comes of it apart.
template <class Real, int Dim>
std::vector<std::uint64_t> DeviceEngine<Real, Dim>::lead_key(const Columns<Real, Dim>& columns,
                                                             const StepScales<Dim>& step) const {
    constexpr std::size_t words = sizeof(Columns<Real, Dim>) / sizeof(std::uint64_t);
    static_assert(sizeof(Columns<Real, Dim>) % sizeof(std::uint64_t) == 0);
    std::vector<std::uint64_t> key(words);
    std::memcpy(key.data(), &columns, sizeof(columns));
    const ListView<Dim> list = lists_.view();
    for (const void* p : {static_cast<const void*>(list.first), static_cast<const void*>(list.slot)})
        key.push_back(reinterpret_cast<std::uintptr_t>(p));
    for (double x : {step.mass_cutoff, step.quantum.scale}) key.push_back(std::bit_cast<std::uint64_t>(x));
    key.insert(key.end(), {layout_, tile_capacity_});
    return key;
}

/// columns: where they will be when the graph runs. Grids are for as many blocks as there is space for: more of them
/// end the lead, and an idle thread block costs half a nanosecond.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::capture_lead(LeadGraph& graph, const StepScales<Dim>& step,
                                           const Columns<Real, Dim>& columns) {
    const Round& round = method_.rounds.front();
    const cudaStream_t stream = lead_->capturing();
    const std::int64_t occupied = std::exchange(census_.blocks, static_cast<std::int64_t>(tile_capacity_));
    columns_of_lead_ = &columns;
    graph.capture(lead_launches(), stream, [&](const LeadNodes& behind) {
        lead_->decide_beside(report_work(&lead_->state()->report), behind, static_cast<int>(sizeof(Real)),
                             [&] { sum_part(1, stream); });
        nodes_kernel_.solve(view(), method_.stencil, node_round(round.nodes, 0, step), step.quantum,
                            light_marks_of(round), stream);
        gather_part(1, round, gather_args(round, step), {interior_blocks(), stream});
        lists_.collect(tables_.view(), Part::all, interior_blocks(), stream);
        lists_.make(tables_.view(), stream);
    });
    columns_of_lead_ = nullptr;
    census_.blocks = occupied;
    graph.set_key(lead_key(columns, step));
}

/// In an epoch whose guard layer nobody is in, a lead goes on to the next refresh; else the host must come by, to make
/// the next one.
template <class Real, int Dim>
bool DeviceEngine<Real, Dim>::take_lead(const LeadRule<Dim>& rule, const LeadClock<Dim>& clock,
                                        const StepScales<Dim>& step) {
    if (!can_lead() || (!moving_ && !unreported_)) return false;
    if (clock.steps < LeadGraph::steps) return false;
    if (!lead_) {
        lead_ = std::make_unique<Lead<Dim>>();
        watch_.time_all();  // of the steps that are left to the host
    }
    if (moving_) {
        lists_.make(tables_.view(), stream_);
        moving_ = false;
        unreported_ = true;
        lead_->forget_clock();
    }
    if (refresh_clock_.left() <= 1) refresh();
    if (materials_ && materials_->choose_grids()) ++layout_;
    const Columns<Real, Dim> columns = particles_.view();
    if (lead_->next_graph().holds(lead_key(columns, step))) lead_->take_next_graph();
    if (!lead_->graph().holds(lead_key(columns, step))) capture_lead(lead_->graph(), step, columns);

    LeadClock<Dim> begins = clock;
    const int most = clock.in_guard_layer > 0 ? steps_ahead : std::max(refresh_clock_.left(), steps_ahead);
    begins.steps = std::min<std::int64_t>(clock.steps, most);
    lead_->begin(rule, begins, static_cast<std::uint32_t>(tile_capacity_), stream_);
    lead_scales_ = step;
    share_is_of_now_ = false;
    queue_lead();
    return true;
}

/// A graph for after the next refresh is made while the device is busy with the last steps before it.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::queue_lead() {
    if (!lead_->queue(stream_) || refresh_clock_.left() > lead_->to_come() + 1) return;
    const Columns<Real, Dim> next = particles_.view_after_refresh();
    if (!lead_->next_graph().holds(lead_key(next, lead_scales_))) capture_lead(lead_->next_graph(), lead_scales_, next);
}

template <class Real, int Dim>
bool DeviceEngine<Real, Dim>::leads() {
    if (!lead_ || !lead_->is_under_way()) return false;
    if (lead_->is_used_up()) {  // the last of its steps is under way
        lead_->end();
        return false;
    }
    queue_lead();
    const LeadEntry<Dim>& entry = lead_->next(stream_);
    told_ = &entry.report;
    report_is_of_epoch_ = true;
    if (entry.goes_on) return true;
    stream_.wait();  // until what was queued behind has passed by
    if (lead_->taken() % 2 != 0) lists_.turn();
    unreported_ = false;
    lead_->end();
    return false;
}

/// A report that came with a decision.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::take_entry(StepReport<Dim>& report) {
    const LeadEntry<Dim>& entry = lead_->next(stream_);
    report.next_dt = entry.dt;
    if (report.seconds[0] == 0) report.seconds = lead_->seconds_until(entry);
    lead_->take(entry);
    if (entry.report.in_guard_layer) lead_->queue_no_more();
}

/// Where the device has gone on to the end of its lead, nobody has asked for the last report yet.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::report_lead() {
    if (!unreported_) return;
    unreported_ = false;
    report(nullptr);
    report_is_of_epoch_ = true;
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
