#pragma once
// The simulation: one rank's part of a run. THE STEP is the first function of simulation.cpp.
//
// Between steps a rank's share is what its lists name; output, checkpoints and balancing read it only in the binned
// state (diagnostics.hpp), and never change dt or the answer.

#include <functional>
#include <memory>

#include "balance/partitioner.hpp"
#include "comm/host_groups.hpp"
#include "comm/phases.hpp"
#include "core/data/error.hpp"
#include "core/transfer/method.hpp"
#include "engine/engine.hpp"
#include "simulation/measured_loads.hpp"
#include "simulation/rebalance.hpp"
#include "simulation/run_clock.hpp"
#include "simulation/run_counts.hpp"
#include "simulation/run_epochs.hpp"
#include "simulation/step_agreement.hpp"
#include "simulation/supply.hpp"

namespace moraine {

/// What is known of the steps that a device makes by itself.
struct LedSteps {
    double until = -1;  ///< the particles are not read before [s]
    std::int64_t until_step = -1;
    bool follows = false;  ///< in this step
    double dt = 0;         ///< that the engine took by itself [s]
};

template <class Real, int Dim>
class Simulation {
  public:
    using Share = Patch<Host, Real, Dim>;
    using EngineMaker = std::function<std::unique_ptr<Engine<Real, Dim>>(const Method<Host, Real, Dim>&)>;
    using Acceleration = std::function<Vec<double, Dim>(std::uint64_t id, const std::array<double, Dim>& x, double t)>;

    /// On the host, or on what `make_engine` makes for the method. Scene and comm must outlive it. Collective.
    Simulation(const Scene& scene, const Comm& comm, const EngineMaker& make_engine = {});
    ~Simulation();

    /// Fills the ranks with the scene's bodies. Collective; throws InputError where a body is wrong.
    void seed();
    /// Whether a scene of lattices alone (seeding/lattice_seeds.hpp) is made where it will be stepped, each block by
    /// its owner, and not on the host, by rows of its bodies. The particles are the same to the bit. By itself it is
    /// where the engine leaves the host free. Before seed().
    void seed_in_place(bool in_place) { in_place_ = in_place; }
    /// Acceleration that each particle feels besides gravity (manufactured solutions). Before seed(); on the host only.
    void set_body_force(Acceleration acceleration);

    /// Balancing gives no rank more particles than this, nor more than its engine can hold; the least of all ranks
    /// counts.
    void hold_at_most(std::int64_t particles) { most_ = particles; }

    /// Takes over what a checkpoint held: `blocks` of all ranks, in key order, and a reader of rows.
    /// read(first row, count, slots) fills the slots of this rank. Collective.
    using ReadRows = std::function<void(const std::vector<std::pair<std::int64_t, std::int64_t>>& ranges,
                                        std::span<const std::uint32_t> slots)>;
    void restore(const std::vector<Key>& keys, const std::vector<std::int64_t>& counts, const RunClock<Dim>& clock,
                 const Budget<Dim>& budget, const std::vector<std::int64_t>& partitioner_state, const ReadRows& read);

    /// Promises that the particles are not read before the first step at or past `time`, nor before `step`. Until then
    /// a device may make steps by itself (engine/lead_rule.hpp), ahead of the clock; without the promise it does not.
    void leave_alone_until(double time, std::int64_t step) { led_.until = time, led_.until_step = step; }

    /// One time step. Throws PhysicsError, the same on all ranks, when the step before went wrong. Collective.
    void step();
    /// Particles of a supply come in; an imbalance check if one is due now, and a new epoch if the old one is used up.
    /// Collective.
    void balance();

    /// The stage under way; null: the scene has none.
    const StageSpec* stage() const {
        return clock_.stages.empty() ? nullptr : &scene_.course.stages[clock_.stages.size() - 1];
    }
    bool is_last_stage() const { return clock_.stages.size() == scene_.course.stages.size(); }
    /// Whether another one is to begin before the next step. The same on all ranks.
    bool stage_is_over(bool at_rest) const {
        return !is_last_stage() && (clock_.time >= stage()->until || (at_rest && stage()->until_rest));
    }
    /// Begins the next stage, between steps. Collective.
    void begin_stage();
    /// Takes these bodies away, between steps: the budget goes on as if they had never been there. Collective.
    void remove_bodies(const std::vector<int>& bodies);

    /// Brings the share into the binned state. Collective.
    void bin();
    /// Bins, adds up, and throws PhysicsError if the last step went wrong. Collective.
    void conclude();
    /// Recomputes the signal speed after particles were changed from outside. Collective.
    void refresh_signal();
    void refresh_speed();
    /// What a signal handler or a wall clock asks for; travels with the next agreement (Agreement::stop).
    void ask(std::uint32_t what) { agreement_.ask(what); }
    /// Whether this rank is writing an output meanwhile; travels with the next agreement (Agreement::writing).
    void say_writing(bool writing) { agreement_.say_writing(writing); }
    /// Whether the next epoch is made asynchronously, from when the guard layer is reached. By itself it is where the
    /// engine leaves the host free. The same on all ranks.
    void make_epochs_async(bool async);

    /// Whether some are still to come in.
    bool expects_supply() const { return supply_.next() < scene_.end; }

    const Scene& scene() const { return scene_; }
    const Comm& comm() const { return comm_; }
    const Method<Host, Real, Dim>& method() const { return method_; }
    const Engine<Real, Dim>& engine() const { return *engine_; }
    const HostOfRank& hosts() const { return hosts_; }
    const Partitioner& partitioner() const { return *partitioner_; }
    const RepartitionTrigger& trigger() const { return trigger_; }
    /// Whether the last step was one that a device made by itself.
    bool follows() const { return led_.follows; }
    const RunClock<Dim>& clock() const { return clock_; }
    const Budget<Dim>& budget() const { return budget_; }
    const Agreement& agreement() const { return agreement_.reached(); }
    Quantum quantum() const { return {clock_.quantum_scale}; }
    Phases& phases() { return phases_; }
    const StructureSet<Dim>& structures() const { return structures_; }
    StructureSet<Dim>& structures() { return structures_; }
    /// Counts of the finished epochs.
    const RunCounts& counts() const { return counts_; }
    /// With those of the epoch under way.
    RunCounts counts_so_far() const;
    /// The imbalance check that ended since this was asked before, or the one of them that repartitioned; no reason:
    /// none did.
    ImbalanceCheck take_imbalance_check() { return rebalance_.take_check(); }

    /// This rank's share on the host, and piece by piece: f(piece) as in engine/engine.hpp. Binned state only.
    Share& patch() { return engine_->share(); }
    template <class F>
    void each_piece(const std::vector<std::string>& columns, const F& f) const {
        engine_->each_piece(f, columns);
    }
    /// The columns of its particles, without rows.
    std::vector<ColumnBytes> columns() const { return Particles<Host, Real, Dim>(method_.needs).columns(); }
    /// Answers a question about this rank's particles (engine/engine_query.hpp). Binned state only.
    template <class Query>
    Query answer(Query query) const {
        engine_->answer(&query);
        return query;
    }
    /// Occupied blocks of this rank. Binned state only. Not collective.
    BlockCounts block_counts() const { return engine_->block_counts(false); }
    PlanPlaces plan_places() const {
        return {{scene_.min[0], scene_.min[1], scene_.min[2]}, scene_.cell, method_.stencil.offset()};
    }
    /// Of all ranks, with their owners, in key order; bins the particles first. Collective.
    std::vector<BlockLoad> block_loads();

  private:
    // simulation.cpp: the parts of a step
    bool engine_leads();
    void follow();
    void start_agreement(bool with_requests);
    void record_step();
    void agree_on_dt();
    void choose_step();
    void make_substeps();
    void check_step();
    void report_faults() const;
    void begin_structures();
    void apply_body_force();
    void check_sleep();
    void begin_sums();
    StepScales<Dim> scales() const;

    // simulation_epoch.cpp: owners of blocks
    void begin_epoch(const BinnedBlocks& binned);
    void synchronize();
    void begin_check();
    void continue_check(bool now);
    void repartition(EpochTables<Dim> tables);

    // simulation_supply.cpp
    void admit();

    // simulation_start.cpp
    void make_method();
    void measure(EndQuery<Dim>& query);
    void seed_rows();
    void seed_lattice();
    void set_scales();

    const Scene& scene_;
    const Comm& comm_;
    Method<Host, Real, Dim> method_;
    DomainBlocks<Dim> domain_;
    HostOfRank hosts_;
    std::unique_ptr<Partitioner> partitioner_;
    RepartitionTrigger trigger_;
    MeasuredLoads loads_;
    std::unique_ptr<Engine<Real, Dim>> engine_;
    StepAgreement agreement_;

    RunClock<Dim> clock_;
    int substeps_ = 1;                               ///< of this step
    const double shear_ = shear_wave_share(scene_);  ///< c_s / c, the largest [-]
    RunCounts counts_;
    Budget<Dim> budget_;
    StructureSet<Dim> structures_;
    Phases phases_;
    Acceleration body_force_;
    Supply supply_;
    RunEpochs<Real, Dim> epochs_;
    Rebalance<Dim> rebalance_;
    std::int64_t most_ = unlimited_particles;  ///< particles that this rank has memory for
    bool in_place_ = false;                    ///< lattices are seeded by the engine
    LedSteps led_;
    bool report_pending_ = false;  ///< a step's report is still with the engine
};

}  // namespace moraine
