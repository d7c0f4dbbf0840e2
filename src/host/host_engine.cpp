#include "host/host_engine.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/host_surfaces.hpp"

namespace moraine {

template <class Real, int Dim>
HostEngine<Real, Dim>::HostEngine(const Scene& scene, const Comm& comm, const Method<Host, Real, Dim>& method)
    : scene_(scene),
      comm_(comm),
      method_(method),
      halo_messages_(comm, 1),
      migration_messages_(comm, 2),
      patch_(method.needs, method.stencil.width),
      contact_{scene.bed != Bed::surface || scene.structures.empty()},
      pressures_(method, patch_),
      energy_(scene, method, patch_) {
    if (!contact_.at_nodes)
        surfaces_ = std::make_unique<HostSurfaces<Real, Dim>>(method, patch_, scene.cell, scene.output.energy_budget);
    if (scene.water.on) water_ = std::make_unique<HostWater<Real, Dim>>(scene, method, patch_, pressures_);
    if (scene.sleep.on) sleepers_ = std::make_unique<Sleepers<Real, Dim>>(scene, comm, method, patch_);
}

template <class Real, int Dim>
HostEngine<Real, Dim>::~HostEngine() = default;

template <class Real, int Dim>
BlockCounts HostEngine<Real, Dim>::block_counts(bool with_cells) {
    return counts_of(patch_, patch_.binned(), with_cells);
}

template <class Real, int Dim>
BlockMoveCount HostEngine<Real, Dim>::begin(EpochTables<Dim> tables, const HostShare& share) {
    ended_ = traffic();
    halo_.reset();
    migration_.reset();
    patch_.install(std::move(tables), share.binned);
    if (sleepers_) sleepers_->begin_epoch();
    if (surfaces_) surfaces_->blocks.made.in_epoch = false;
    contact_.forget();
    if (ends_) ends_->begin_epoch();
    halo_ = std::make_unique<Halo<Real, Dim>>(patch_.tables(), halo_messages_, method_.stencil.width,
                                              lanes_besides<Dim>(method_));
    migration_ = std::make_unique<Migration<Host, Real, Dim>>(patch_, migration_messages_);
    return {};
}

template <class Real, int Dim>
BlockMoveCount HostEngine<Real, Dim>::begin(EpochTables<Dim> tables, const LatticeShare<Real, Dim>& share) {
    const LatticeTables<Real, Dim>& lattice = share.lattice;
    BinnedBlocks binned;
    std::vector<std::uint32_t> first{0};
    std::vector<Vec<std::int32_t, Dim>> position;
    for (std::size_t b = 0; b < tables.own.size(); ++b) {
        const std::uint32_t count = lattice.view().count(tables.position[b]);
        if (count == 0) continue;
        binned.key.push_back(tables.own[b]);
        binned.count.push_back(count);
        position.push_back(tables.position[b]);
        first.push_back(first.back() + count);
    }
    binned.slot = patch_.start_over(first.back());
    const ParticleView<Real, Dim> p = patch_.particles.view();
    Host::launch(static_cast<std::int64_t>(position.size()), [&](int b) {
        const auto i = static_cast<std::size_t>(b);
        fill_block(lattice.view(), position[i], first[i], p);
    });
    return begin(std::move(tables), HostShare{binned});
}

template <class Real, int Dim>
BlockMoveCount HostEngine<Real, Dim>::begin(EpochTables<Dim> tables, const MovedBlocks& moved) {
    BlockMoveCount count;
    const BinnedBlocks next =
        move_blocks(comm_, patch_, patch_.binned(), {moved.owner.begin(), moved.owner.end()}, count);
    begin(std::move(tables), HostShare{next});
    return count;
}

template <class Real, int Dim>
Traffic HostEngine<Real, Dim>::traffic() const {
    Traffic t = ended_;
    if (halo_) t.halo_bytes += halo_->bytes();
    if (migration_) t.crossed_particles += migration_->crossed();
    return t;
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::bin() {
    if (!moving_) return;
    migration_->finish();
    if (sleepers_) sleepers_->wake_entered();
    report_.in_guard_layer = patch_.is_in_guard_layer();
    moving_ = false;
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::check_sleep(bool first, const Quantum& quantum, const StructureSet<Dim>* structures) {
    const ContactField<Dim> field = structures ? structures->field() : ContactField<Dim>{};
    sleepers_->check(first, quantum, structures ? &field : nullptr, report_.budget);
}

template <class Real, int Dim>
TransferCall<Real, Dim> HostEngine<Real, Dim>::transfer_call(std::span<const std::int32_t> blocks) {
    return {method_.context,
            patch_.particles.view(),
            patch_.table(),
            patch_.list(),
            patch_.grid(),
            blocks.data(),
            static_cast<std::int64_t>(blocks.size()),
            sums_.mean,
            method_.grid_bulk()};
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::find_gaps(const StructureSet<Dim>& structures) {
    if (contact_.begin(structures, patch_.tables(), tile_side(method_.stencil.width))) halo_->reserve(contact_.pairs);
    if (surfaces_) surfaces_->blocks.find(contact_.field, structures.any_moves());
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::sum(std::span<const std::int32_t> blocks, const std::vector<ContactPair>& pairs) {
    const TransferCall<Real, Dim> call = transfer_call(sleepers_ ? sleepers_->to_sum(blocks, sums_.mean) : blocks);
    const auto count = static_cast<std::int64_t>(pairs.size());
    const bool weighs = contact_.finding && energy_.is_counted();
    const std::vector<double> held = weighs ? energy_.potentials_of(pairs, sums_.gravity) : std::vector<double>{};
    if (contact_.finding)
        Host::launch(count, LimitDepth<Real, Dim>{call.particles.position, method_.ends, call.table, call.list,
                                                  contact_.field, pairs.data(), static_cast<int>(count),
                                                  call.particles.id, &contact_.buried, contact_.pairs.bounds()});
    if (weighs) energy_.note_put_out(held, energy_.potentials_of(pairs, sums_.gravity));
    method_.kernels.p2g(call, method_.cell);
    if (sleepers_) sleepers_->keep_masses();
    if (contact_.to_share())
        method_.kernels.gaps(call,
                             {contact_.field, contact_.gaps.data(), pairs.data(), count, contact_.pairs.bounds()});
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::receive_halo() {
    halo_->finish(patch_.grid(), patch_.tile_of(), contact_.to_share(), sleepers_ ? sleepers_->asleep() : nullptr);
    contact_.finding = false;
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::sum_column(Real* mass) {
    const auto sum_part = [&](std::span<const std::int32_t> blocks) {
        TransferCall<Real, Dim> call = transfer_call(blocks);
        call.particles.mass = mass;
        call.mean = NodeMean::none;
        call.grid_bulk = nullptr;
        method_.kernels.p2g(call, method_.cell);
    };
    sum_part(patch_.boundary());
    send_halo();
    sum_part(patch_.interior());
    receive_halo();
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::find(VolumeQuery& query) {
    sum_column(patch_.particles.view().volume);
    std::vector<NodeVolumes> volumes(patch_.node_blocks().size());
    Host::launch_teams(static_cast<std::int64_t>(volumes.size()),
                       CountVolumes<Real, Dim>{method_.capacity, patch_.table(), patch_.grid(), method_.stencil.width,
                                               method_.stencil.origin, std::pow(scene_.cell, -Dim), volumes.data()});
    if (sleepers_) sleepers_->forget_tiles();
    query.volumes = {};
    for (const NodeVolumes& v : volumes) query.volumes.add(v);
}

/// The terms of a round. shifting: null where it does not shift.
template <class Real, int Dim>
HostTerms<Real, Dim> HostEngine<Real, Dim>::terms_of(const Round& round, const Shifting<Real, Dim>* shifting) const {
    const Real* bulk = method_.grid_bulk();
    const FluidTerms<Real>* fluid = method_.fluid();
    const bool limits = round.nodes == NodeTask::solve || round.nodes == NodeTask::hold;
    return {LightTerm<Real>{limits ? method_.stiffness() : nullptr, method_.limits},
            SmoothingTerm<Real>{shifting && !bulk ? nullptr : fluid, bulk ? pressures_.cells() : nullptr},
            PressureTerm<Real>{water_ ? nullptr : bulk, pressures_.cells()},
            water_ ? water_->term() : WaterTerm<Real, Dim>{},
            BoxTerm{},
            TractionTerm{},
            MeansTerm<Real>{method_.averaged()},
            ShiftingTerm<Real, Dim>{fluid, fluid ? shifting : nullptr, bulk ? pressures_.held() : nullptr}};
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::gather(const Round& round, const StepScales<Dim>& step) {
    Shifting<Real, Dim> shifting{
        method_.capacity, static_cast<Real>(std::pow(scene_.cell, -Dim)), method_.ends, {}, {}};
    const bool shifts = sums_.mean == NodeMean::volume && method_.shifts();
    if (shifts && surfaces_)
        shifting.surfaces = surfaces_->blocks.space();
    else if (shifts && step.structures)
        shifting.contact = step.structures->field();
    GatherCall<Real, Dim> gather{method_.stress(),
                                 method_.ends,
                                 {round.gather, method_.tpic, method_.flip, static_cast<Real>(step.dt)},
                                 {patch_.moves(), patch_.outgoing_count(), patch_.shuffled(), patch_.outcome()}};
    gather.terms = terms_of(round, shifts ? &shifting : nullptr);
    if (sleepers_) wake_sleepers(round, step);
    method_.kernels.g2p(transfer_call(sleepers_ ? sleepers_->awake() : patch_.blocks()), gather);
    if (sleepers_) sleepers_->stay();
    if (&round == &method_.rounds.front()) fault_records_.clear();
    record_step(step, (round.gather & (gather_motion | gather_second_motion)) != 0);
}

/// Adds up what the round did; `moved`: particles have been moved by it.
template <class Real, int Dim>
void HostEngine<Real, Dim>::record_step(const StepScales<Dim>& step, bool moved) {
    for (std::int32_t b : patch_.blocks()) {
        const BlockOutcome& out = patch_.outcome(b);
        report_.signal = std::max(report_.signal, out.signal);
        report_.square_speed = std::max(report_.square_speed, out.square_speed);
        report_.moved = std::max(report_.moved, out.moved);
        report_.faults |= out.faults;
        if (out.faults) note_fault(b, out, moved);
        report_.clamped += out.clamped;
        report_.budget.work.add(step.quantum.of(out.work));
        if (method_.needs.loads) count_loads(out, step.quantum, report_.budget);
        if (water_) count_weight(out, step.quantum, report_.budget);
    }
    if (Buried<Dim>& buried = contact_.buried; buried.id != Buried<Dim>{}.id) {
        report_.faults |= fault_buried;
        fault_records_.push_back({buried.id, fault_buried, {}});
        std::copy_n(buried.x.e, Dim, fault_records_.back().x.begin());
        buried = {};
    }
    for (std::size_t k = 0; k < impulse_.size(); ++k) report_.budget.impulse[k % Dim].add(impulse_[k]);
    if (surfaces_) surfaces_->forces.take_impulse(report_.budget.impulse);
    energy_.record(step, moved, report_.budget.energy);
    if (water_) water_->count(report_.budget.water);
}

/// Records the faulty particle of a block, before binning moves it on.
template <class Real, int Dim>
void HostEngine<Real, Dim>::note_fault(std::int32_t block, const BlockOutcome& out, bool moved) {
    const ListView<Dim> list = patch_.list();
    const ParticleView<Real, Dim> p = patch_.particles.view();
    FaultRecord<Dim> fault_record{out.faulty_id, out.faults, {}};
    for (std::uint32_t k = list.first[block]; k < list.first[block + 1]; ++k) {
        const std::uint32_t s = list.slot[k];
        if (p.id[s] != out.faulty_id) continue;
        fault_record.x = place_in<Real, Dim>(scene_, method_.stencil, patch_.table().position[block], p.position[s]);
        const int code = moved ? move_code(patch_.moves()[k]) : Block<Dim>::centre;  // else a code of another step
        for (int a = 0; a < Dim && code < Block<Dim>::offsets; ++a)
            fault_record.x[static_cast<std::size_t>(a)] += 4 * scene_.cell * Block<Dim>::offset(code, a);
    }
    fault_records_.push_back(fault_record);
}

template <class Real, int Dim>
void HostEngine<Real, Dim>::send_outgoing(const StepScales<Dim>& step) {
    migration_->start([&](std::uint32_t slot) { lose(slot, step); });
    moving_ = true;
}

/// A particle that left through an open wall.
template <class Real, int Dim>
void HostEngine<Real, Dim>::lose(std::uint32_t slot, const StepScales<Dim>& step) {
    const ParticleView<Real, Dim> p = patch_.particles.view();
    const double m = static_cast<double>(p.mass[slot]);
    Budget<Dim>& budget = report_.budget;
    budget.lost_mass.add(step.quantum.of(m));
    for (int a = 0; a < Dim; ++a) {
        const auto i = static_cast<std::size_t>(a);
        budget.lost_momentum[i].add(step.quantum.of(m * static_cast<double>(p.velocity[slot][a])));
        budget.lost_gravity_impulse[i].add(step.quantum.of(m * step.gravity_impulse[i]));
    }
    ++budget.lost_count;
}

template <class Real, int Dim>
StepReport<Dim> HostEngine<Real, Dim>::take_report() {
    return std::exchange(report_, StepReport<Dim>{});
}

template class HostEngine<float, 2>;
template class HostEngine<float, 3>;
template class HostEngine<double, 2>;
template class HostEngine<double, 3>;

}  // namespace moraine
