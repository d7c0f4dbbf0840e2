// The step: Simulation::step() is the first function below, and every message between ranks is visible in it.
//
//   * bin: incoming particles of the last step join; the list of each block is binned by cell
//   * for each round of the scheme (USL has one, USF and MUSL two, FMPM(k) k; core/transfer/method.hpp):
//       - P2G of the blocks that other ranks need; their tiles are sent, unsummed, while P2G of the interior runs
//       - first round: the gaps to structures, with the sums, and in the same message
//       - first round: dt, faults and requests of all ranks in one reduction that overlaps with P2G; it needs no dt
//       - first round: what free structures felt in the last step moves them, by one exact sum
//       - nodes: the tiles in fixed order, gravity, damping, walls, contact
//       - G2P: velocity, position, strain and stress; outgoing particles
//   * outgoing particles are sent; the next step takes them in
//   * time and structures go on by dt
//
// The work is the engine's (engine/engine.hpp); here are the order, dt, and what all must agree on. A device queues the
// work and is waited for once, where the agreement starts; where it makes steps by itself, the host follows them
// (follow(), engine/lead_rule.hpp). Balancing is between steps: simulation_epoch.cpp.

#include "simulation/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/sleep/scene_sleep.hpp"
#include "simulation/diagnostics.hpp"
#include "simulation/gravity_step.hpp"

namespace moraine {

template <class Real, int Dim>
void Simulation<Real, Dim>::step() {
    led_.follows = engine_leads();
    if (led_.follows) return follow();
    bin();  // incoming particles of the last step; each block's list is binned by cell
    check_sleep();
    apply_body_force();
    begin_sums();
    for (const Round& round : method_.rounds) {
        const bool first = &round == &method_.rounds.front();
        phases_.time(Phase::p2g, "P2G boundary", [&] { engine_->sum(SharePart::boundary); });
        if (first) start_agreement(true);  // stable dt, displacement, faults: one reduction, overlapped
        phases_.time(Phase::halo, "send halo", [&] { engine_->send_halo(); });
        phases_.time(Phase::p2g, "P2G interior", [&] { engine_->sum(SharePart::interior); });
        if (first) agree_on_dt();
        if (first) begin_structures();
        phases_.time(Phase::halo, "receive halo", [&] { engine_->receive_halo(); });
        phases_.time(Phase::nodes, "solve nodes", [&] { engine_->solve_nodes(round, scales()); });
        if (round.nodes == NodeTask::hold) make_substeps();
        phases_.time(Phase::g2p, "G2P", [&] { engine_->gather(round, scales()); });
        ++counts_.exchanges;
    }
    phases_.time(Phase::migrate, "send outgoing", [&] { engine_->send_outgoing(scales()); });
    report_pending_ = true;
    clock_.time += clock_.dt;
    structures_.end_step(clock_.time, clock_.dt);
    ++clock_.step;
}

/// Whether a device makes this step by itself; lets it begin to where the particles are not read for some steps.
template <class Real, int Dim>
bool Simulation<Real, Dim>::engine_leads() {
    bool leads = false;
    phases_.time(Phase::agree, "device leads", [&] { leads = engine_->leads(); });
    if (leads || !report_pending_ || agreement_.asks() || body_force_ || scene_.sleep.on || scene_.substeps != 1 ||
        !gravity_stays(scene_, clock_))
        return leads;
    if (clock_.step >= led_.until_step || clock_.time >= led_.until) return false;
    if (epochs_.lifetime().state() == EpochLifetime::State::unbinned || rebalance_.is_under_way() ||
        scene_.balance.trigger == Trigger::every)  // counts steps
        return false;
    LeadRule<Dim> rule{
        scene_.dt, courant_number(scene_) * scene_.cell, scene_.end, std::min(led_.until, supply_.next()), {}};
    LeadClock<Dim> clock{
        clock_.time, clock_.dt, {}, epochs_.lifetime().in_guard_layer(), led_.until_step - clock_.step};
    std::copy_n(clock_.gravity.begin(), Dim, rule.gravity);
    std::copy_n(clock_.gravity_impulse.begin(), Dim, clock.gravity_impulse);
    const LeadRequest<Dim> request{rule, clock, scales()};
    phases_.time(Phase::agree, "device leads", [&] { leads = engine_->leads(&request); });
    return leads;
}

/// A step that a device makes by itself: the report of the step before is agreed on as in any other.
template <class Real, int Dim>
void Simulation<Real, Dim>::follow() {
    start_agreement(false);  // requests are for when the device stands still
    agree_on_dt();
    if (clock_.dt != led_.dt) throw std::logic_error("a device and its host differ in dt");
    ++counts_.exchanges;
    report_pending_ = true;
    clock_.time += clock_.dt;
    ++clock_.step;
}

/// Pressures of cells and velocities of nodes, while the particles wait (core/fluid/grid_pressure.hpp).
template <class Real, int Dim>
void Simulation<Real, Dim>::make_substeps() {
    Substep substep{0, substeps_, clock_.dt / substeps_};
    const auto run = [&](SubstepStage stage) {
        phases_.time(Phase::nodes, "substep", [&] { engine_->substep(stage, substep, scales()); });
    };
    if (scene_.water.on) {
        run(SubstepStage::sum_flow_boundary);
        phases_.time(Phase::halo, "send halo", [&] { engine_->send_halo(); });
        run(SubstepStage::sum_flow_interior);
        phases_.time(Phase::halo, "receive halo", [&] { engine_->receive_halo(); });
        run(SubstepStage::hold_flow);
        ++counts_.exchanges;
    }
    run(SubstepStage::find_pressures);
    for (; substep.number < substep.count; ++substep.number) {
        run(SubstepStage::sum_boundary);
        phases_.time(Phase::halo, "send halo", [&] { engine_->send_halo(); });
        run(SubstepStage::sum_interior);
        phases_.time(Phase::halo, "receive halo", [&] { engine_->receive_halo(); });
        run(SubstepStage::solve_nodes);
        ++counts_.exchanges;
    }
}

template <class Real, int Dim>
void Simulation<Real, Dim>::bin() {
    if (engine_->leads()) throw std::logic_error("particles are read while the device makes steps by itself");
    phases_.time(Phase::migrate, "bin", [&] { engine_->bin(); });
}

template <class Real, int Dim>
void Simulation<Real, Dim>::apply_body_force() {
    if (!body_force_) return;
    const ParticleView<Real, Dim> p = patch().particles.view();
    each_particle(*this, [&](std::uint32_t s, const std::array<double, Dim>& x) {
        const Vec<double, Dim> b = body_force_(p.id[s], x, clock_.time);
        for (int a = 0; a < Dim; ++a) p.body_force[s][a] = static_cast<Real>(b[a]);
    });
}

/// At times that are the same on all ranks, wherever their run began (core/sleep/sleep.hpp).
template <class Real, int Dim>
void Simulation<Real, Dim>::check_sleep() {
    if (!scene_.sleep.on) return;
    const bool first = clock_.sleep_check < 0;
    if (!first && (clock_.time < clock_.sleep_check + sleep_interval(scene_) ||
                   clock_.step < clock_.sleep_step + least_sleep_steps))
        return;
    structures_.place();
    phases_.time(Phase::migrate, "sleep check",
                 [&] { engine_->check_sleep(first, quantum(), structures_.empty() ? nullptr : &structures_); });
    clock_.sleep_check = clock_.time;
    clock_.sleep_step = clock_.step;
}

/// Structures stand where the last step left them.
template <class Real, int Dim>
void Simulation<Real, Dim>::begin_sums() {
    if (!structures_.empty()) structures_.place();
    SumsOfStep<Dim> sums{method_.mean_of(clock_.step), clock_.gravity, {}};
    for (const TractionSpec& t : scene_.course.tractions)
        sums.load_factors.push_back(t.factor.empty() ? 1 : t.factor.mean_from(clock_.time, clock_.dt));
    engine_->begin_sums(sums, structures_.empty() ? nullptr : &structures_);
}

/// Adds the report of the last step to the budget and to this rank's part of the next agreement.
template <class Real, int Dim>
void Simulation<Real, Dim>::record_step() {
    if (!report_pending_) return;
    const StepReport<Dim> report = engine_->take_report();
    phases_.add(Phase::p2g, report.seconds[0]);
    phases_.add(Phase::nodes, report.seconds[1]);
    phases_.add(Phase::g2p, report.seconds[2]);
    agreement_.report(report, phases_.computing());
    led_.dt = report.next_dt;
    counts_.clamped_boxes += report.clamped;
    budget_.add(report.budget);
    structures_.take(report.felt, report.turning);
    report_pending_ = false;
}

template <class Real, int Dim>
void Simulation<Real, Dim>::start_agreement(bool with_requests) {
    phases_.time(Phase::agree, "take report", [&] { record_step(); });
    const Census census = engine_->census();
    Agreement& own = agreement_.own();
    own.count = census.particles;
    own.asleep_sum = census.asleep;
    own.load = load_of(census.particles, census.asleep);
    own.blocks = census.blocks;
    own.migration_bound = census.migration_bound;
    own.making = epochs_.next().is_ready() ? 0 : 1;
    agreement_.start(with_requests);
}

template <class Real, int Dim>
void Simulation<Real, Dim>::agree_on_dt() {
    phases_.time(Phase::agree, "agree on dt", [&] { agreement_.finish(); });
    const Agreement& agreed = agreement_.reached();
    if (agreed.faults) {
        engine_->receive_halo();  // leave no message behind
        report_faults();
    }
    clock_.signal = agreed.signal;
    clock_.square_speed = agreed.square_speed;
    epochs_.lifetime().step(agreed.in_guard_layer != 0, agreed.moved);
    counts_.add(agreed, comm_.size());
    loads_.add(agreed, agreement_.own());
    if (scene_.dt > 0)
        clock_.dt = scene_.dt;
    else if (clock_.signal > 0)
        choose_step();
    else if (clock_.dt == 0)  // no particle yet; once all have left, dt stays
        clock_.dt = expects_supply() ? (1 + 1e-9) * (supply_.next() - clock_.time) : scene_.end - clock_.time;
    check_step();
    begin_gravity(scene_, plan_places(), *engine_, clock_, budget_);
    engine_->expect_outgoing(agreed.migration_bound);
}

/// By the wave's and the flow's own time (core/courant.hpp).
template <class Real, int Dim>
void Simulation<Real, Dim>::choose_step() {
    const StepChoice choice = moraine::choose_step(scene_, clock_.signal, std::sqrt(clock_.square_speed), shear_);
    clock_.dt = choice.dt;
    substeps_ = choice.substeps;
}

/// Free structures move alike on all ranks: by sums that do not depend on the owners of nodes.
template <class Real, int Dim>
void Simulation<Real, Dim>::begin_structures() {
    std::vector<StructureSums<Dim>> felt;
    std::vector<TurningSums<Dim>> turning;
    if (structures_.any_free())
        phases_.time(Phase::agree, "sum over structures", [&] {
            for (const StructureState<Dim>& state : structures_.states()) {
                felt.push_back(state.pending);
                if (structures_.any_turns()) turning.push_back(state.pending_turning);
            }
            felt = comm_.exact_sums(felt);
            turning = comm_.exact_sums(turning);
            structures_.forget_pending();
        });
    structures_.begin_step(clock_.time, clock_.dt, clock_.gravity, felt, quantum(), turning);
}

template <class Real, int Dim>
StepScales<Dim> Simulation<Real, Dim>::scales() const {
    return {clock_.dt,      clock_.mass_cutoff,     quantum(),
            clock_.gravity, clock_.gravity_impulse, structures_.empty() ? nullptr : &structures_};
}

/// A run that would not see its end: something grew without bound, and no one particle is to blame. Scenes that need
/// more than 1e10 steps are refused at the start.
template <class Real, int Dim>
void Simulation<Real, Dim>::check_step() {
    if (clock_.dt * 1e12 >= scene_.end - clock_.time) return;
    engine_->receive_halo();  // leave no message behind
    throw PhysicsError(
        fmt::format("step {}: dt fell to {:.3g} s at t = {:.6g} s (a wave or a particle of {:.3g} m/s). "
                    "Try a smaller time.cfl?",
                    clock_.step, clock_.dt, clock_.time, clock_.signal));
}

namespace {

/// What happened, and what may help: of the worst of several faults.
std::pair<const char*, const char*> message_of(std::uint32_t faults) {
    if (faults & fault_porosity)
        return {"has pores that closed, or that are all of it",
                "Is material.porosity right, and the soil stiff enough?"};
    if (faults & fault_buried)
        return {"is more than a cell under the ground", "Is the terrain finer or steeper than domain.cell resolves?"};
    if (faults & fault_nan) return {"is not a number", "Try a smaller time.cfl?"};
    if (faults & fault_inverted) return {"was turned inside out (det(I + dL) <= 0)", "Try a smaller time.cfl?"};
    if (faults & fault_left) return {"left the closed domain", "Give that face a wall, or open it?"};
    return {"moved a whole cell or more in one step", "Try a smaller time.cfl?"};
}

}  // namespace

template <class Real, int Dim>
void Simulation<Real, Dim>::report_faults() const {
    FaultQuery<Dim> query;
    engine_->answer(&query);
    const std::vector<FaultRecord<Dim>> all = comm_.all_gather(query.found);
    const FaultRecord<Dim>& first =
        *std::min_element(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
    const auto [what, advice] = message_of(first.faults);
    std::string place;
    for (double x : first.x) place += fmt::format("{}{:.6g}", place.empty() ? "" : ", ", x);
    throw PhysicsError(fmt::format("step {}: particle {} at ({}) m {} ({} block{} with faults). {}", clock_.step,
                                   first.id, place, what, all.size(), all.size() == 1 ? "" : "s", advice));
}

template <class Real, int Dim>
void Simulation<Real, Dim>::conclude() {
    bin();
    record_step();
    const Agreement all = agreement_.conclude();
    if (all.faults) report_faults();
    clock_.signal = all.signal;
    clock_.square_speed = all.square_speed;
}

template class Simulation<float, 2>;
template class Simulation<float, 3>;
template class Simulation<double, 2>;
template class Simulation<double, 3>;

}  // namespace moraine
