// Steps that the device makes by itself (engine/lead_rule.hpp, gpu/lead.hpp): a kernel sets dt, a graph launches, and
// the host takes the report of each step later. can_lead() says in which scenes; in all others the host launches each
// step.

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

/// What a step of a lead has besides its sums, nodes, gather and lists.
struct LeadParts {
    bool structures;  ///< near some nodes, perhaps
    bool gaps;        ///< some blocks are near one: depths are limited, and gaps are found
    bool limiting;
    bool by_material;      ///< materials have gathers of their own
    std::size_t stresses;  ///< materials with a stress kernel
};

/// The launches of a step behind the decision, in the order of capture_lead().
template <class Real, int Dim>
std::vector<LeadLaunch> lead_launches(const LeadParts& has) {
    using Args = GatherArgs<Real, Dim>;
    using Stress = StressArgs<Real, Dim>;
    const DtPlace of_nodes = dt_of_nodes<Real, Dim>();
    const LeadLaunch other{}, sums{true}, nodes{false, 0, of_nodes.offset, 0, of_nodes.size};
    const LeadLaunch gather{false, 2, offsetof(Args, dt), offsetof(Args, gravity_impulse), sizeof(Args)};
    const LeadLaunch stress{false, 2, offsetof(Stress, dt), 0, sizeof(Stress)};
    std::vector<LeadLaunch> launches{sums};
    if (has.gaps) launches = {other, other, other};
    launches.insert(launches.end(), has.structures ? 2 : 1, nodes);
    if (has.by_material) launches.push_back(other);
    if (has.limiting) launches.insert(launches.end(), {other, gather});
    if (has.by_material) launches.insert(launches.end(), has.stresses, gather);
    if (has.by_material && has.limiting) launches.push_back(other);
    launches.insert(launches.end(), has.limiting ? 2 : 1, gather);
    launches.insert(launches.end(), has.stresses, stress);
    launches.insert(launches.end(), binning_launches, other);
    return launches;
}

/// What a captured step depends on, dt and what comes of it apart.
template <class Real, int Dim>
std::vector<std::uint64_t> lead_key(const Columns<Real, Dim>& columns, const EpochState<Real, Dim>& epoch,
                                    const StepScales<Dim>& step) {
    constexpr std::size_t words = sizeof(Columns<Real, Dim>) / sizeof(std::uint64_t);
    static_assert(sizeof(Columns<Real, Dim>) % sizeof(std::uint64_t) == 0);
    std::vector<std::uint64_t> key(words);
    std::memcpy(key.data(), &columns, sizeof(columns));
    const ListView<Dim> list = epoch.lists.view();
    for (const void* p : {static_cast<const void*>(list.first), static_cast<const void*>(list.slot)})
        key.push_back(reinterpret_cast<std::uintptr_t>(p));
    for (double x : {step.mass_cutoff, step.quantum.scale}) key.push_back(std::bit_cast<std::uint64_t>(x));
    for (double x : step.gravity) key.push_back(std::bit_cast<std::uint64_t>(x));
    key.insert(key.end(), {epoch.layout, epoch.tile_capacity});
    return key;
}

}  // namespace

/// One rank, one round whose dt is known before the nodes, and nothing that the host does within a step: structures
/// that move, sleepers to look for, means or pressures that go by the number of the step, absorbing ends, tractions.
/// Nor over terrain, where flows go through epochs and maps look so often that graphs and ends of leads cost more than
/// they save (docs/adr/0013).
template <class Real, int Dim>
bool DeviceEngine<Real, Dim>::can_lead() const {
    return !exchange_ && !sleepers_ && !added_.ends && !added_.loads && !takes_means(method_) && !epoch_.pending &&
           (scene_.structures.empty() || (contact_.rests && !contact_.field.ground)) && method_.rounds.size() == 1 &&
           method_.rounds.front().nodes == NodeTask::solve && census_.particles > 0 &&
           census_.particles <= most_led_particles && !epoch_.tables.own.empty() &&
           kernels_.stress.size() <= most_materials && LeadGraph::is_possible();
}

/// columns: where they will be when the graph runs. Grids are for as many blocks as there is space for: more of them
/// end the lead, and an idle thread block costs half a nanosecond.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::capture_lead(bool next, const StepScales<Dim>& step, const Columns<Real, Dim>& columns) {
    const Round& round = method_.rounds.front();
    const std::int64_t occupied = std::exchange(census_.blocks, static_cast<std::int64_t>(epoch_.tile_capacity));
    const NodeContact<Dim>* contact = contact_.rests ? &contact_.at_nodes : nullptr;
    const bool gaps = contact && contact_.gaps.interior().size() > 0;
    const auto launch_step = [&](const LeadNodes& behind, cudaStream_t stream) {
        const ReportWork<Dim> report = reports_.work(epoch_.lists, &lead_->state()->report);
        if (gaps) {  // buried particles are noted for the next report: not beside the decision, which reads this one
            lead_->decide_before(report, behind);
            limit_depths(view(), method_.ends, contact_.field, contact_.gaps, contact_.gaps.interior(), stream);
            sum_part(1, stream);
            gpu::find_gaps(view(), scene_.shape, contact_.field, contact_.gaps, contact_.gaps.interior(), stream);
        } else {
            lead_->decide_concurrently(report, behind, [&] { sum_part(1, stream); });
        }
        kernels_.nodes.solve(view(), method_.stencil, node_round(round.nodes, 0, step), step.quantum,
                             light_marks_of(round), stream, contact);
        gather_part(1, round, gather_args(round, step), {interior_blocks(), stream});
        epoch_.lists.collect(epoch_.table.view(), Part::all, interior_blocks(), stream);
        epoch_.lists.make(epoch_.table.view(), stream);
    };
    lead_->capture(next, lead_key(columns, epoch_, step),
                   lead_launches<Real, Dim>(
                       {contact != nullptr, gaps, limits(round), materials_ != nullptr, kernels_.stress.size()}),
                   columns, launch_step);
    census_.blocks = occupied;
}

/// Lasts to the next refresh of memory; shorter where some particle is in the guard layer, so that the host can make
/// the next epoch in time.
template <class Real, int Dim>
bool DeviceEngine<Real, Dim>::begin_lead(const LeadRequest<Dim>& request) {
    if (surfaces_) return false;
    const LeadClock<Dim>& clock = request.clock;
    const StepScales<Dim>& step = request.step;
    if (!can_lead() || (!moving_ && !reports_.is_missing)) return false;
    if (clock.steps < LeadGraph::steps) return false;
    if (!lead_) {
        lead_ = std::make_unique<Lead<Real, Dim>>();
        reports_.watch.time_all();  // of the steps that are left to the host
    }
    if (moving_) {
        epoch_.lists.make(epoch_.table.view(), stream_);
        moving_ = false;
        reports_.is_missing = true;
        lead_->forget_clock();
    }
    if (store_.clock.left() <= 1) refresh();
    if (materials_ && materials_->choose_grids()) ++epoch_.layout;
    const Columns<Real, Dim> columns = store_.rows.view();
    if (!lead_->take_graph(lead_key(columns, epoch_, step))) capture_lead(false, step, columns);

    LeadClock<Dim> begins = clock;
    const int most = clock.in_guard_layer > 0 ? steps_ahead : std::max(store_.clock.left(), steps_ahead);
    begins.steps = std::min<std::int64_t>(clock.steps, most);
    if (contact_.rests) contact_.structures.empty(stream_);  // fetched when the lead ends: sums are exact
    lead_->begin(request.rule, begins, step, static_cast<std::uint32_t>(epoch_.tile_capacity), stream_);
    share_is_of_now_ = false;
    queue_lead();
    return true;
}

/// A graph for after the next refresh is made while the device is busy with the last steps before it.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::queue_lead() {
    if (!lead_->queue(stream_) || store_.clock.left() > lead_->to_come() + 1) return;
    const Columns<Real, Dim> next = store_.rows.view_after_refresh();
    if (!lead_->has_next_graph(lead_key(next, epoch_, lead_->scales()))) capture_lead(true, lead_->scales(), next);
}

template <class Real, int Dim>
bool DeviceEngine<Real, Dim>::leads(const LeadRequest<Dim>* request) {
    if (request && !begin_lead(*request)) return false;
    if (!lead_ || !lead_->is_under_way()) return false;
    const auto end = [&] {  // what structures felt goes with the report of the last step, which was not taken yet
        if (contact_.rests && lead_->taken() > 0) contact_.structures.fetch(stream_);
        lead_->end();
    };
    if (lead_->is_used_up()) {  // the last of its steps is under way
        end();
        return false;
    }
    queue_lead();
    const LeadEntry<Dim>& entry = lead_->next(stream_);
    reports_.of_lead = &entry.report;
    reports_.is_of_epoch = true;
    if (entry.goes_on) return true;
    if (lead_->taken() % 2 != 0) epoch_.lists.turn();
    reports_.is_missing = false;
    end();
    stream_.wait();  // the steps queued behind it run, switched off
    return false;
}

/// Makes the report of a lead's last step, which no kernel has written yet.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::report_lead() {
    if (!reports_.is_missing) return;
    reports_.is_missing = false;
    report(nullptr);
    reports_.is_of_epoch = true;
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
