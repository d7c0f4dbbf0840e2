#pragma once
// The simulation: one rank's part of the run, and THE STEP (the last function below).
//
// Between steps the share of a rank is told by its lists; output, checkpoints and balancing read it
// only in the binned state, and never change dt or the answer.

#include <fmt/format.h>

#include <bit>
#include <functional>
#include <memory>
#include <optional>

#include "balance/calibration.hpp"
#include "balance/measured_cost.hpp"
#include "balance/partitioner.hpp"
#include "balance/weight.hpp"
#include "comm/agreement.hpp"
#include "comm/async_allgather.hpp"
#include "comm/block_move.hpp"
#include "comm/epoch_lifetime.hpp"
#include "comm/host_engine.hpp"
#include "comm/key_order.hpp"
#include "comm/next_epoch.hpp"
#include "comm/phases.hpp"
#include "core/error.hpp"
#include "core/hash.hpp"
#include "core/method.hpp"
#include "core/totals.hpp"
#include "seeding/lattice_seeds.hpp"
#include "seeding/seed_state.hpp"
#include "seeding/structure_seeds.hpp"
#include "simulation/rebalance.hpp"
#include "simulation/run_clock.hpp"

namespace moraine {

/// Cost of a block on one core, from benchmark_step --costs [ps per particle, occupied cell, block]: the cell
/// term came out as nothing.
inline constexpr CostModel host_costs{130000, 0, 8000000};
/// The same on one H200 in single: least squares over benchmark_device's cases costs-* (benchmarks/device/results.md)
/// with what a step takes whatever its share is (0.1 ms), which no cut changes; in double about twice that. Cuts depend
/// on the ratio alone, and measured steps set the scale.
inline constexpr CostModel device_costs{81, 296, 0};

/// Counts over the whole run. Those of a rank are summed when they are reported.
struct RunCounts {
    std::int64_t repartitions = 0;        ///< same on all ranks
    std::int64_t epochs = 0;              ///< that were renewed in place; same on all ranks
    std::int64_t migrated_particles = 0;  ///< sent by this rank in repartitions
    std::int64_t migrated_blocks = 0;
    std::int64_t crossed_particles = 0;  ///< walked from this rank to others
    std::int64_t halo_bytes = 0;         ///< sent by this rank
    std::int64_t clamped_boxes = 0;      ///< contiguous GIMP boxes held at half a cell, particle-steps
    double imbalance_sum = 0;            ///< over steps, of particles; same on all ranks
    double imbalance_max = 0;
    double imbalance_time_sum = 0;  ///< of measured compute time
    double seconds_lost = 0;        ///< to imbalance: slowest rank less mean [s]; same on all ranks
    std::int64_t steps = 0;         ///< of this process: what the means are over
    double particle_steps = 0;
};

/// What can be asked of all ranks, as bits of Agreement::stop.
inline constexpr std::uint32_t ask_stop = 1;        ///< a signal: checkpoint and end
inline constexpr std::uint32_t ask_checkpoint = 2;  ///< the wall clock: checkpoint

template <class Real, int Dim>
class Simulation {
  public:
    using Share = Patch<Host, Real, Dim>;
    using EngineMaker = std::function<std::unique_ptr<Engine<Real, Dim>>(const Method<Host, Real, Dim>&)>;
    using Acceleration = std::function<Vec<double, Dim>(std::uint64_t id, const std::array<double, Dim>& x, double t)>;

    /// On the host, or on what `make_engine` makes for the method. Scene and comm must outlive it. Collective.
    Simulation(const Scene& scene, const Comm& comm, const EngineMaker& make_engine = {});

    /// Fills the ranks with the scene's bodies. Collective; throws InputError where a body is wrong.
    void seed();

    /// Whether a scene of lattices alone (seeding/lattice_seeds.hpp) is made where it will be stepped, each block by
    /// its owner, and not on the host, by rows of its bodies. The particles are the same to the bit. By itself it is
    /// where the engine leaves the host free. Before seed().
    void seed_in_place(bool in_place) { in_place_ = in_place; }

    /// Takes over what a checkpoint held: `blocks` of all ranks, in key order, and a reader of rows.
    /// read(first row, count, slots) fills the slots of this rank. Collective.
    using ReadRows = std::function<void(const std::vector<std::pair<std::int64_t, std::int64_t>>& ranges,
                                        std::span<const std::uint32_t> slots)>;
    void restore(const std::vector<Key>& keys, const std::vector<std::int64_t>& counts, const RunClock<Dim>& clock,
                 const Budget<Dim>& budget, const std::vector<std::int64_t>& partitioner_state, const ReadRows& read);

    /// One time step. Throws PhysicsError, the same on all ranks, when the step before went wrong. Collective.
    void step();

    /// Brings the share into the binned state. Collective.
    void bin();

    /// Bins, adds up, and throws PhysicsError if the last step went wrong. Collective.
    void conclude();

    /// A imbalance check if one is due now, and a new epoch if the old one is used up. Collective.
    void balance();

    /// Occupied blocks of all ranks and who holds them, in key order; bins the particles first. Collective.
    std::vector<BlockLoad> block_loads();

    /// Acceleration that each particle feels besides gravity (manufactured solutions). Before seed(); on the host only.
    void set_body_force(Acceleration acceleration);

    /// Whether the next epoch is made asynchronously, from when the guard layer is reached. By itself it is where the
    /// engine leaves the host free. The same on all ranks.
    void make_epochs_async(bool async) {
        async_ = async;
        rebalance_.set_async(async);
    }

    /// Recomputes the signal speed after particles were changed from outside. Collective.
    void refresh_signal();

    const Scene& scene() const { return scene_; }
    const RunClock<Dim>& clock() const { return clock_; }
    /// Counts of the finished epochs.
    const RunCounts& counts() const { return counts_; }
    /// With those of the epoch under way.
    RunCounts counts_so_far() const;
    const Budget<Dim>& budget() const { return budget_; }
    /// The imbalance check that ended since this was asked before, or the one of them that repartitioned; no reason:
    /// none did.
    ImbalanceCheck take_imbalance_check() { return rebalance_.take_check(); }
    const Agreement& agreement() const { return agreed_; }
    Phases& phases() { return phases_; }
    Share& patch() { return engine_->share(); }
    const Engine<Real, Dim>& engine() const { return *engine_; }
    const Method<Host, Real, Dim>& method() const { return method_; }
    const Partitioner& partitioner() const { return *partitioner_; }
    const RepartitionTrigger& trigger() const { return trigger_; }
    Quantum quantum() const { return {clock_.quantum_scale}; }
    const StructureSet<Dim>& structures() const { return structures_; }
    StructureSet<Dim>& structures() { return structures_; }

    /// What a signal handler or a wall clock asks for; travels with the next agreement (Agreement::stop).
    void ask(std::uint32_t what) { asked_ |= what; }

    /// Calls f(slot, x [m]) for this rank's particles in list order, block by block. Binned state only.
    void each_particle(const std::function<void(std::uint32_t slot, const std::array<double, Dim>& x)>& f) const;
    /// Calls f(piece) for this rank's share, piece by piece (comm/engine.hpp). Binned state only. Not collective.
    template <class F>
    void each_piece(const std::vector<std::string>& columns, const F& f) const {
        engine_->each_piece(f, columns);
    }
    /// The columns of its particles, without rows.
    std::vector<ColumnBytes> columns() const { return Particles<Host, Real, Dim>(method_.needs).columns(); }
    /// Occupied blocks of this rank. Binned state only. Not collective.
    BlockCounts block_counts() { return engine_->block_counts(false); }
    /// Place of a particle of a piece [m].
    std::array<double, Dim> place_of(const SharePiece<Real, Dim>& piece, int block, std::uint32_t slot) const {
        return place_in<Real, Dim>(scene_, method_.stencil, piece.tables.position[static_cast<std::size_t>(block)],
                                   piece.p.position[slot]);
    }

    /// Totals of the whole run. Binned state only. Collective.
    Totals<Dim> totals() const;
    /// Hash of the state; `with_lists` includes each particle's block and place in its list. Collective.
    std::uint64_t state_hash(bool with_lists = false) const;
    /// -sum m g . (x - domain.min) [J]
    double potential_energy(const Totals<Dim>& totals) const;
    /// Exact sum over ranks of a budget entry. Collective.
    double sum_of(const ExactSum& mine) const;
    /// Over ranks of all sums of a structure, one after the other. Collective.
    std::vector<StructureSums<Dim>> sum_of(const std::vector<StructureSums<Dim>>& mine) const;
    /// Volume per column of cells along x, over the domain [m3]. Collective.
    std::vector<double> column_volumes() const;

  private:
    void start_agreement();
    void agree_on_dt();
    void record_step();
    void check_step();
    void report_faults() const;
    void apply_body_force();
    void agree_on_forces();
    StepScales<Dim> scales() const {
        return {clock_.dt, clock_.mass_cutoff, quantum(), clock_.gravity_impulse,
                structures_.empty() ? nullptr : &structures_};
    }

    bool weighs_cells() const { return weight_.is_cost(); }
    std::vector<BlockLoad> loads_of(const BlockCounts& mine) const;
    std::vector<BlockLoad> gather_loads(const BlockCounts& mine) const;
    void calibrate(const BlockCounts& mine);
    EpochTables<Dim> next_epoch(const std::vector<BlockLoad>& loads);
    void begin_epoch(const BinnedBlocks& binned);
    void request_next_epoch();
    void start_next_epoch();
    void renew_epoch();
    bool is_balanced(ImbalanceCheck& found) const;
    void take_times(TriggerInput& terms) const;
    void synchronize();
    bool must_synchronize() const { return !(async_ && engine_->leaves_host_free()); }
    void begin_check();
    void continue_check();
    void repartition(EpochTables<Dim> tables);
    void seed_rows();
    void seed_lattice();
    BinnedBlocks seed_share();
    Key place_seed(const Seed& seed, std::uint32_t slot);
    void sort_blocks(BinnedBlocks& binned) const;
    void set_scales();
    Totals<Dim> totals_of(const SharePiece<Real, Dim>& piece, int block) const;

    const Scene& scene_;
    const Comm& comm_;
    Method<Host, Real, Dim> method_;
    DomainBlocks<Dim> domain_;
    std::unique_ptr<Partitioner> partitioner_;
    RepartitionTrigger trigger_;
    BlockWeight weight_;
    Calibration calibration_;
    MeasuredCost measured_cost_;

    std::unique_ptr<Engine<Real, Dim>> engine_;
    AgreementReduction reduction_;

    RunClock<Dim> clock_;
    RunCounts counts_;
    Budget<Dim> budget_;
    StructureSet<Dim> structures_;
    std::vector<StructureSums<Dim>> forces_;  ///< of the last step on free structures, over all ranks
    Agreement agreed_, own_;
    Phases phases_;
    Acceleration body_force_;
    EpochLifetime epoch_;
    NextEpoch<Dim> next_epoch_;
    Rebalance<Dim> rebalance_;
    AsyncAllgather<Key> keys_;    ///< occupied blocks of all ranks, that the next epoch is made from
    bool in_place_ = false;       ///< lattices are seeded by the engine
    bool async_ = false;          ///< epochs are made asynchronously
    double computed_ = 0;         ///< computing time up to the last step [s]
    double checked_seconds_ = 0;  ///< the same up to the last imbalance check, and the steps of that moment
    std::int64_t checked_step_ = 0;
    double time_lost_ = 0;     ///< to imbalance since the last repartition [s]
    double move_seconds_ = 0;  ///< of the last repartition
    std::int64_t last_repartition_ = 0;
    std::uint32_t asked_ = 0;
    bool report_pending_ = false;  ///< a step's report is still with the engine
};

// The step. Every message between ranks is visible here. A device queues the work and is waited for once, where the
// agreement starts.

template <class Real, int Dim>
void Simulation<Real, Dim>::step() {
    bin();  // incoming particles of the last step; each block's list is binned by cell
    apply_body_force();
    for (const Round& round : method_.rounds) {
        const bool first = &round == &method_.rounds.front();
        phases_.time(Phase::p2g, [&] { engine_->sum_boundary(); });
        if (first) start_agreement();  // stable dt, displacement, faults: one reduction, overlapped
        phases_.time(Phase::halo, [&] { engine_->send_halo(); });
        phases_.time(Phase::p2g, [&] { engine_->sum_interior(); });
        if (first) agree_on_dt();
        if (first && structures_.any_free()) agree_on_forces();  // what they felt: one exact sum
        if (first) structures_.begin_step(clock_.time, clock_.dt, forces_, quantum());
        phases_.time(Phase::halo, [&] { engine_->receive_halo(); });
        phases_.time(Phase::nodes, [&] { engine_->solve_nodes(round, scales()); });
        phases_.time(Phase::g2p, [&] { engine_->gather(round, scales()); });
    }
    phases_.time(Phase::migrate, [&] { engine_->send_outgoing(scales()); });
    report_pending_ = true;
    clock_.time += clock_.dt;
    structures_.end_step(clock_.time, clock_.dt);
    ++clock_.step;
}

}  // namespace moraine

#include "simulation/simulation_epoch.ipp"
#include "simulation/simulation_records.ipp"
#include "simulation/simulation_start.ipp"
#include "simulation/simulation_step.ipp"
