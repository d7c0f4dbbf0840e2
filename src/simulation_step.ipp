// The parts of Simulation::step(), in the order in which it calls them.

namespace moraine {

template <class Space, class Real, int Dim>
void Simulation<Space, Real, Dim>::file() {
    if (!moving_) return;
    phases_.time(Phase::migrate, [&] { migration_->finish(); });
    moving_ = false;
}

template <class Space, class Real, int Dim>
void Simulation<Space, Real, Dim>::start_agreement() {
    own_.count = patch_->count();
    own_.stop = asked_;
    asked_ = 0;
    reduction_.start(own_);
}

template <class Space, class Real, int Dim>
double Simulation<Space, Real, Dim>::agree_on_dt() {
    phases_.time(Phase::agree, [&] { agreed_ = reduction_.finish(); });
    if (agreed_.faults) {
        halo_->finish(patch_->grid(), patch_->tile_of());  // leave no message behind
        report_faults();
    }
    clock_.signal = agreed_.signal;
    wandered_ += agreed_.moved;
    const double mean = static_cast<double>(agreed_.count_sum) / comm_.size();
    const double imbalance = mean > 0 ? static_cast<double>(agreed_.count) / mean : 1;
    counts_.imbalance_sum += imbalance;
    counts_.imbalance_max = std::max(counts_.imbalance_max, imbalance);
    const double mean_seconds = agreed_.seconds_sum / comm_.size();
    counts_.imbalance_time_sum += mean_seconds > 0 ? agreed_.seconds / mean_seconds : 1;
    time_lost_ += agreed_.seconds - mean_seconds;
    ++counts_.steps;
    counts_.particle_steps += static_cast<double>(agreed_.count_sum);
    clock_.dt = scene_.dt > 0 ? scene_.dt : scene_.cfl * scene_.cell / clock_.signal;
    return clock_.dt;
}

/// Notes who went wrong in a block, before filing moves it on.
template <class Space, class Real, int Dim>
void Simulation<Space, Real, Dim>::note_offence(std::int32_t block) {
    const BlockOutcome& out = patch_->outcome(block);
    const ListView<Dim> list = patch_->list();
    const ParticleView<Real, Dim> p = patch_->particles.view();
    Offence offence{out.offender, out.faults, {}};
    for (std::uint32_t k = list.first[block]; k < list.first[block + 1]; ++k) {
        if (p.id[list.slot[k]] != out.offender) continue;
        offence.x = position_of(block, list.slot[k]);
        const int code = move_code(patch_->moves()[k]);
        for (int a = 0; a < Dim && code < Block<Dim>::offsets; ++a)
            offence.x[static_cast<std::size_t>(a)] += 4 * scene_.cell * Block<Dim>::offset(code, a);
    }
    offences_.push_back(offence);
}

template <class Space, class Real, int Dim>
void Simulation<Space, Real, Dim>::report_faults() const {
    const std::vector<Offence> all = comm_.all_gather(offences_);
    const Offence& first =
        *std::min_element(all.begin(), all.end(), [](const Offence& a, const Offence& b) { return a.id < b.id; });
    const char* what = first.faults & fault_nan        ? "is not a number"
                       : first.faults & fault_inverted ? "was turned inside out (det(I + dL) <= 0)"
                       : first.faults & fault_left     ? "left the closed domain"
                                                       : "moved a whole cell or more in one step";
    const char* advice = first.faults & fault_left ? "Give that face a wall, or open it?" : "Try a smaller time.cfl?";
    std::string place;
    for (double x : first.x) place += fmt::format("{}{:.6g}", place.empty() ? "" : ", ", x);
    throw PhysicsError(fmt::format("step {}: particle {} at ({}) m {} ({} block{} with faults). {}", clock_.step,
                                   first.id, place, what, all.size(), all.size() == 1 ? "" : "s", advice));
}

template <class Space, class Real, int Dim>
TransferCall<Real, Dim> Simulation<Space, Real, Dim>::transfer_call(std::span<const std::int32_t> blocks) {
    return {method_.context,
            patch_->particles.view(),
            patch_->table(),
            patch_->list(),
            patch_->grid(),
            blocks.data(),
            static_cast<std::int64_t>(blocks.size())};
}

template <class Space, class Real, int Dim>
void Simulation<Space, Real, Dim>::p2g(std::span<const std::int32_t> blocks) {
    phases_.time(Phase::p2g, [&] { method_.kernels.p2g(transfer_call(blocks), method_.cell); });
}

template <class Space, class Real, int Dim>
void Simulation<Space, Real, Dim>::nodes(const Round& round) {
    const std::span<const std::int32_t> needed = patch_->node_blocks();
    impulse_.resize(needed.size() * Dim);
    const SolveNodes<Real, Dim> kernel{method_.context.walls,
                                       patch_->table(),
                                       patch_->grid(),
                                       needed.data(),
                                       method_.stencil.width,
                                       method_.stencil.origin,
                                       round.nodes,
                                       static_cast<Real>(clock_.dt),
                                       method_.gravity,
                                       method_.damping,
                                       static_cast<Real>(clock_.mass_cutoff),
                                       quantum(),
                                       impulse_.data()};
    phases_.time(Phase::nodes, [&] { Space::launch_teams(static_cast<std::int64_t>(needed.size()), kernel); });
}

template <class Space, class Real, int Dim>
void Simulation<Space, Real, Dim>::g2p(const Round& round) {
    const GatherCall<Real, Dim> gather{method_.stress(), method_.ends,      round.gather,
                                       method_.tpic,     method_.flip,      static_cast<Real>(clock_.dt),
                                       patch_->moves(),  patch_->leavers(), patch_->shuffled(),
                                       patch_->outcome()};
    phases_.time(Phase::g2p, [&] { method_.kernels.g2p(transfer_call(patch_->blocks()), gather); });
}

/// Books what the round did: work, impulses, faults; and what the next agreement must know.
template <class Space, class Real, int Dim>
void Simulation<Space, Real, Dim>::account(const Round& round) {
    const bool first = &round == &method_.rounds.front();
    if (first) {
        own_ = Agreement{};
        offences_.clear();
    }
    for (std::int32_t b : patch_->blocks()) {
        const BlockOutcome& out = patch_->outcome(b);
        own_.signal = std::max(own_.signal, out.signal);
        own_.moved = std::max(own_.moved, out.moved);
        own_.faults |= out.faults;
        if (out.faults) note_offence(b);
        counts_.clamped_boxes += out.clamped;
        ledger_.work.add(quantum().of(out.work));
    }
    for (std::size_t k = 0; k < impulse_.size(); ++k) ledger_.impulse[k % Dim].add(impulse_[k]);
    if (&round != &method_.rounds.back()) return;
    own_.seconds = phases_.computing() - computed_;
    computed_ = phases_.computing();
    for (int a = 0; a < Dim; ++a)
        clock_.pull[static_cast<std::size_t>(a)] += scene_.gravity[static_cast<std::size_t>(a)] * clock_.dt;
}

/// A particle that left through an open wall.
template <class Space, class Real, int Dim>
void Simulation<Space, Real, Dim>::lose(std::uint32_t slot) {
    const ParticleView<Real, Dim> p = patch_->particles.view();
    const double m = static_cast<double>(p.mass[slot]);
    ledger_.lost_mass.add(quantum().of(m));
    for (int a = 0; a < Dim; ++a) {
        const auto i = static_cast<std::size_t>(a);
        ledger_.lost_momentum[i].add(quantum().of(m * static_cast<double>(p.velocity[slot][a])));
        ledger_.lost_pull[i].add(quantum().of(m * clock_.pull[i]));
    }
    ++ledger_.lost_count;
}

template <class Space, class Real, int Dim>
void Simulation<Space, Real, Dim>::apply_body_force() {
    if (!body_force_) return;
    const ParticleView<Real, Dim> p = patch_->particles.view();
    each_particle([&](std::uint32_t s, const std::array<double, Dim>& x) {
        const Vec<double, Dim> b = body_force_(p.id[s], x, clock_.time);
        for (int a = 0; a < Dim; ++a) p.body_force[s][a] = static_cast<Real>(b[a]);
    });
}

}  // namespace moraine
