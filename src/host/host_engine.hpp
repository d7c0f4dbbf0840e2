#pragma once
// The engine of the host: OpenMP threads over blocks, messages by MPI. The plain reference of every other engine.

#include <bit>
#include <memory>

#include "blocks/lattice_fill.hpp"
#include "comm/halo.hpp"
#include "comm/migration.hpp"
#include "core/transfer/gather_call.hpp"
#include "engine/engine.hpp"
#include "host/host_contact.hpp"
#include "host/host_ends.hpp"
#include "host/host_energy.hpp"
#include "host/host_loads.hpp"
#include "host/host_pressures.hpp"
#include "host/host_samples.hpp"
#include "host/host_water.hpp"
#include "host/sleepers.hpp"

namespace moraine {

template <class Real, int Dim>
struct HostSurfaces;

template <class Real, int Dim>
class HostEngine final : public Engine<Real, Dim> {
  public:
    using Share = Patch<Host, Real, Dim>;

    /// All must outlive it. Not collective.
    HostEngine(const Scene& scene, const Comm& comm, const Method<Host, Real, Dim>& method);
    ~HostEngine() override;

    Share& share() override { return patch_; }
    Census census() const override {
        return {patch_.count(), patch_.tiles_in_use(), {}, sleepers_ ? sleepers_->particles() : 0};
    }
    BlockCounts block_counts(bool with_cells) override;
    Traffic traffic() const override;
    void answer(const EngineQuery<Dim>& query) override {
        std::visit([this](auto* asked) { find(*asked); }, query);
    }
    void find(EndQuery<Dim>& query) { measure(query); }
    void measure(EndQuery<Dim>& query);  ///< host_ends.cpp
    void hold_ends(const EndNodes<Dim>& ends) override { ends_ = std::make_unique<HostEnds<Real, Dim>>(ends); }
    /// The sums of a step with another column in place of masses; the next step writes all tiles again.
    void sum_column(Real* mass);

    BlockMoveCount begin_epoch(EpochTables<Dim> tables, const EpochStart<Real, Dim>& start) override {
        return std::visit([&](const auto& with) { return begin(std::move(tables), with); }, start);
    }
    void refresh_memory(bool always) override { patch_.refresh_memory(always ? -1 : 0.1); }

    void check_sleep(bool first, const Quantum& quantum, const StructureSet<Dim>* structures) override;
    void bin() override;
    void begin_sums(const SumsOfStep<Dim>& sums, const StructureSet<Dim>* structures) override {
        if (structures) find_gaps(*structures);
        sums_ = sums;
        if (method_.needs.loads) set_loads(method_.tractions(), sums.load_factors, patch_);
        if (water_) water_->set_weight(sums.gravity);
    }
    void sum(SharePart part) override {
        part == SharePart::boundary ? sum(patch_.boundary(), contact_.pairs.boundary())
                                    : sum(patch_.interior(), contact_.pairs.interior());
    }
    void send_halo() override {
        halo_->start(patch_.grid(), contact_.to_share(), sleepers_ ? sleepers_->asleep() : nullptr);
    }
    void receive_halo() override;
    void solve_nodes(const Round& round, const StepScales<Dim>& step) override;
    void substep(SubstepStage stage, const Substep& substep, const StepScales<Dim>& step) override;
    void gather(const Round& round, const StepScales<Dim>& step) override;
    void send_outgoing(const StepScales<Dim>& step) override;

    StepReport<Dim> take_report() override;

  private:
    BlockMoveCount begin(EpochTables<Dim> tables, const KeptBlocks&) {
        return begin(std::move(tables), HostShare{patch_.binned()});
    }
    BlockMoveCount begin(EpochTables<Dim> tables, const MovedBlocks& moved);
    BlockMoveCount begin(EpochTables<Dim> tables, const HostShare& share);
    BlockMoveCount begin(EpochTables<Dim> tables, const LatticeShare<Real, Dim>& share);
    template <class Query>
    void find(Query& query) {
        find_samples(patch_, query);
    }
    void find(VolumeQuery& query);
    void find(FaultQuery<Dim>& query) { query.found = fault_records_; }
    void find_gaps(const StructureSet<Dim>& structures);
    void sum_pressures(std::span<const std::int32_t> blocks, const Substep& substep);
    void solve_substep(const Substep& substep, const StepScales<Dim>& step);
    NodeRound<Real, Dim> node_round(NodeTask task, double dt, const StepScales<Dim>& step) const;
    void solve(const NodeRound<Real, Dim>& round, const StepScales<Dim>& step);
    template <bool Contact>
    void solve(const NodeRound<Real, Dim>& round, const StepScales<Dim>& step, const ContactField<Dim>& contact);
    template <bool Contact>
    void solve(const NodeRound<Real, Dim>& round, const StepScales<Dim>& step, const ContactField<Dim>& contact,
               std::span<const std::int32_t> nodes);
    template <bool Contact, bool Energy>
    void solve(const NodeRound<Real, Dim>& round, const StepScales<Dim>& step, const ContactField<Dim>& contact,
               std::span<const std::int32_t> nodes);
    void wake_sleepers(const Round& round, const StepScales<Dim>& step);
    HostTerms<Real, Dim> terms_of(const Round& round, const Shifting<Real, Dim>* shifting) const;
    TransferCall<Real, Dim> transfer_call(std::span<const std::int32_t> blocks);
    void sum(std::span<const std::int32_t> blocks, const std::vector<ContactPair>& pairs);
    void record_step(const StepScales<Dim>& step, bool moved);
    void note_fault(std::int32_t block, const BlockOutcome& out, bool moved);
    void lose(std::uint32_t slot, const StepScales<Dim>& step);

    const Scene& scene_;
    const Comm& comm_;
    const Method<Host, Real, Dim>& method_;
    PointToPoint halo_messages_, migration_messages_;
    Share patch_;
    std::unique_ptr<Halo<Real, Dim>> halo_;
    std::unique_ptr<Migration<Host, Real, Dim>> migration_;
    std::unique_ptr<Sleepers<Real, Dim>> sleepers_;  ///< null: none sleep in this scene
    Traffic ended_;                                  ///< of the epochs before
    StepReport<Dim> report_;
    std::vector<FaultRecord<Dim>> fault_records_;
    Host::Array<ExactSum> impulse_;
    SumsOfStep<Dim> sums_;
    bool moving_ = false;  ///< migration under way: not binned

    HostContact<Dim> contact_;
    HostPressures<Real, Dim> pressures_;
    std::unique_ptr<HostWater<Real, Dim>> water_;  ///< null: none in the ground
    HostEnergy<Real, Dim> energy_;
    std::unique_ptr<HostSurfaces<Real, Dim>> surfaces_;  ///< null: structures act at nodes (Bed::nodes)
    std::unique_ptr<HostEnds<Real, Dim>> ends_;          ///< null: none absorb
};

/// Cells of a block that hold particles.
template <class Real, int Dim>
std::int64_t occupied_cells(Patch<Host, Real, Dim>& patch, std::span<const std::uint32_t> slots) {
    std::uint64_t seen = 0;
    for (std::uint32_t s : slots) seen |= std::uint64_t(1) << patch.cell_of_slot(s);
    return std::popcount(seen);
}

/// Of blocks that are not yet those of an epoch.
template <class Real, int Dim>
BlockCounts counts_of(Patch<Host, Real, Dim>& patch, const BinnedBlocks& binned, bool with_cells) {
    BlockCounts counts{binned.key, binned.count, {}, {}};
    std::size_t at = 0;
    for (std::size_t b = 0; with_cells && b < binned.key.size(); at += binned.count[b], ++b)
        counts.cells.push_back(occupied_cells(patch, std::span(binned.slot).subspan(at, binned.count[b])));
    const std::uint64_t* rest = patch.particles.view().rest_place;
    at = 0;
    for (std::size_t b = 0; rest && b < binned.key.size(); at += binned.count[b], ++b)
        counts.asleep.push_back((rest[binned.slot[at]] & rest_word::asleep) != 0);
    return counts;
}

}  // namespace moraine
