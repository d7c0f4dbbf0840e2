// The parts of Simulation::step(), in the order in which it calls them.

namespace moraine {

template <class Real, int Dim>
void Simulation<Real, Dim>::bin() {
    phases_.time(Phase::migrate, [&] { engine_->bin(); });
}

/// Takes what the last step tells into the budget and into what the next agreement must know.
template <class Real, int Dim>
void Simulation<Real, Dim>::record_step() {
    if (!report_pending_) return;
    const StepReport<Dim> report = engine_->take_report();
    phases_.add(Phase::p2g, report.seconds[0]);
    phases_.add(Phase::nodes, report.seconds[1]);
    phases_.add(Phase::g2p, report.seconds[2]);
    own_ = Agreement{};
    own_.signal = report.signal;
    own_.moved = report.moved;
    own_.faults = report.faults;
    own_.in_guard_layer = report.in_guard_layer;
    own_.seconds = phases_.computing() - computed_;
    computed_ = phases_.computing();
    counts_.clamped_boxes += report.clamped;
    budget_.add(report.budget);
    structures_.take(report.felt);
    report_pending_ = false;
}

template <class Real, int Dim>
void Simulation<Real, Dim>::start_agreement() {
    phases_.time(Phase::agree, [&] { record_step(); });
    const Census census = engine_->census();
    own_.count = census.particles;
    own_.blocks = census.blocks;
    own_.migration_bound = census.migration_bound;
    own_.making = next_epoch_.is_ready() ? 0 : 1;
    own_.stop = asked_;
    asked_ = 0;
    reduction_.start(own_);
}

template <class Real, int Dim>
void Simulation<Real, Dim>::agree_on_dt() {
    phases_.time(Phase::agree, [&] { agreed_ = reduction_.finish(); });
    if (agreed_.faults) {
        engine_->receive_halo();  // leave no message behind
        report_faults();
    }
    clock_.signal = agreed_.signal;
    epoch_.step(agreed_.in_guard_layer != 0, agreed_.moved);
    const double mean = static_cast<double>(agreed_.count_sum) / comm_.size();
    const double imbalance = mean > 0 ? static_cast<double>(agreed_.count) / mean : 1;
    counts_.imbalance_sum += imbalance;
    counts_.imbalance_max = std::max(counts_.imbalance_max, imbalance);
    const double mean_seconds = agreed_.seconds_sum / comm_.size();
    counts_.imbalance_time_sum += mean_seconds > 0 ? agreed_.seconds / mean_seconds : 1;
    time_lost_ += agreed_.seconds - mean_seconds;
    counts_.seconds_lost += agreed_.seconds - mean_seconds;
    if (weight_.is_time())
        measured_cost_.add({own_.seconds, agreed_.seconds, agreed_.seconds_sum,
                            weight_.with_blocks(own_.count, own_.blocks),
                            weight_.with_blocks(agreed_.count_sum, agreed_.blocks)});
    ++counts_.steps;
    counts_.particle_steps += static_cast<double>(agreed_.count_sum);
    if (scene_.dt > 0)
        clock_.dt = scene_.dt;
    else if (clock_.signal > 0)
        clock_.dt = courant_number(scene_) * scene_.cell / clock_.signal;
    else if (clock_.dt == 0)  // nothing is there, nor was; once all have left, time goes on as before
        clock_.dt = scene_.end - clock_.time;
    check_step();
    for (std::size_t a = 0; a < Dim; ++a) clock_.gravity_impulse[a] += scene_.gravity[a] * clock_.dt;
    engine_->expect_outgoing(agreed_.migration_bound);
}

/// Free structures are moved alike on all ranks: by a sum that is the same whoever owns the nodes.
template <class Real, int Dim>
void Simulation<Real, Dim>::agree_on_forces() {
    phases_.time(Phase::agree, [&] {
        std::vector<StructureSums<Dim>> mine;
        for (const StructureState<Dim>& state : structures_.states()) mine.push_back(state.pending);
        forces_ = sum_of(mine);
        structures_.forget_pending();
    });
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

/// What happened, and what may help: of the worst of several faults.
inline std::pair<const char*, const char*> message_of(std::uint32_t faults) {
    if (faults & fault_nan) return {"is not a number", "Try a smaller time.cfl?"};
    if (faults & fault_inverted) return {"was turned inside out (det(I + dL) <= 0)", "Try a smaller time.cfl?"};
    if (faults & fault_left) return {"left the closed domain", "Give that face a wall, or open it?"};
    return {"moved a whole cell or more in one step", "Try a smaller time.cfl?"};
}

template <class Real, int Dim>
void Simulation<Real, Dim>::report_faults() const {
    const std::vector<FaultRecord<Dim>> all = comm_.all_gather(engine_->fault_records());
    const FaultRecord<Dim>& first =
        *std::min_element(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
    const auto [what, advice] = message_of(first.faults);
    std::string place;
    for (double x : first.x) place += fmt::format("{}{:.6g}", place.empty() ? "" : ", ", x);
    throw PhysicsError(fmt::format("step {}: particle {} at ({}) m {} ({} block{} with faults). {}", clock_.step,
                                   first.id, place, what, all.size(), all.size() == 1 ? "" : "s", advice));
}

template <class Real, int Dim>
void Simulation<Real, Dim>::apply_body_force() {
    if (!body_force_) return;
    const ParticleView<Real, Dim> p = engine_->share().particles.view();
    each_particle([&](std::uint32_t s, const std::array<double, Dim>& x) {
        const Vec<double, Dim> b = body_force_(p.id[s], x, clock_.time);
        for (int a = 0; a < Dim; ++a) p.body_force[s][a] = static_cast<Real>(b[a]);
    });
}

}  // namespace moraine
