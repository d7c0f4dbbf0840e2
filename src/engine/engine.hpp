#pragma once
// How one rank's share is stepped: on the threads of the host (host/host_engine.hpp) or on a device (gpu/).
//
// The simulation keeps the order of a step and agrees with the other ranks on dt and ownership; an engine runs the
// kernels of each part and holds the share. The report of a step (signal speed, faults, sums for the budget) is taken
// once per step, by take_report(): on a device that is the only moment at which the host waits for it.

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "blocks/share_piece.hpp"
#include "core/fluid/grid_pressure.hpp"
#include "core/structures/structure_set.hpp"
#include "core/transfer/method.hpp"
#include "core/transfer/totals.hpp"
#include "engine/agreement.hpp"
#include "engine/engine_query.hpp"
#include "engine/epoch_start.hpp"
#include "engine/lead_rule.hpp"

namespace moraine {

/// What the step control and the budget take from the particles of the last step.
template <int Dim>
struct StepReport {
    double signal = 0;        ///< largest c + |v| [m/s]
    double square_speed = 0;  ///< largest |v|^2, with the grid's pressure [m2/s2]
    double moved = 0;         ///< largest displacement along an axis [cells]
    std::uint32_t faults = 0;
    bool in_guard_layer = false;            ///< when they were binned, by the tables of then (blocks/guard_layer.hpp)
    std::int64_t clamped = 0;               ///< contiguous GIMP boxes held at half a cell
    Budget<Dim> budget;                     ///< to be added
    std::vector<StructureSums<Dim>> felt;   ///< by the structures; empty where there are none
    std::vector<TurningSums<Dim>> turning;  ///< likewise; empty where none turns
    double next_dt = 0;                     ///< that the engine took by itself; 0: it does not lead [s]
    std::array<double, 3> seconds{};  ///< on the device: P2G, nodes, G2P; on the host the caller has the clock [s]
};

/// What holds for the sums of a step, whose dt is not known yet.
template <int Dim>
struct SumsOfStep {
    NodeMean mean = NodeMean::none;         ///< that they find besides mass and momentum, for fluids
    std::array<double, Dim> gravity{};      ///< of the step before [m/s2]
    std::vector<double> load_factors = {};  ///< by traction
};

/// What holds for all particles of a step.
template <int Dim>
struct StepScales {
    double dt;                                      ///< [s]
    double mass_cutoff;                             ///< [kg]
    Quantum quantum;                                ///< of the exact sums
    std::array<double, Dim> gravity;                ///< of this step [m/s2]
    std::array<double, Dim> gravity_impulse;        ///< its integral up to the end of the step [m/s]
    const StructureSet<Dim>* structures = nullptr;  ///< null: the scene has none
};

/// No limit of memory is known.
inline constexpr std::int64_t unlimited_particles = std::int64_t(1) << 60;

/// Occupied blocks of this rank.
struct BlockCounts {
    std::vector<Key> key;  ///< ascending
    std::vector<std::uint32_t> count;
    std::vector<std::int64_t> cells;              ///< that hold particles; empty unless asked for
    std::vector<std::uint8_t> asleep;             ///< 1: the block sleeps; empty in scenes without sleep
    std::int64_t capacity = unlimited_particles;  ///< particles that the memory of this rank can hold
};

/// Sizes of the share in the last binned state.
struct Census {
    std::int64_t particles = 0;
    std::int64_t blocks = 0;         ///< occupied
    MigrationBound migration_bound;  ///< on a device
    std::int64_t asleep = 0;         ///< particles
};

/// What this rank has sent since the run began.
struct Traffic {
    std::int64_t halo_bytes = 0;
    std::int64_t crossed_particles = 0;
};

/// What an engine steps on.
struct EngineDevice {
    std::string name = "cpu";       ///< for the records: "cpu", or a device's own name
    bool leaves_host_free = false;  ///< the host's threads have nothing to do during a step
    std::string compiler;           ///< of kernels that are compiled for the scene, with options; empty: none are
};

/// The blocks that other ranks need, and all others.
enum class SharePart { boundary, interior };

/// The kernels of a substep of the grid's pressure (core/fluid/grid_pressure.hpp).
enum class SubstepStage {
    sum_flow_boundary,  ///< of scenes with water in the ground, once a step: Darcy's flux and what it feels, to the
                        ///< nodes
    sum_flow_interior,
    hold_flow,
    find_pressures,  ///< once a step: the cells that hold particles, and their geometry
    sum_boundary,    ///< forces of the cells' pressures on the nodes
    sum_interior,
    solve_nodes,  ///< velocities; in the last substep also the pressures that particles take
};

/// Asks an engine to step by itself (lead_rule.hpp). What `step` says of dt has no meaning.
template <int Dim>
struct LeadRequest {
    LeadRule<Dim> rule;
    LeadClock<Dim> clock;
    StepScales<Dim> step;
};

template <class Real, int Dim>
class Engine {
  public:
    using Share = Patch<Host, Real, Dim>;
    virtual ~Engine() = default;

    const EngineDevice& device() const { return device_; }

    /// The share in the memory of the host; in the binned state it is that of now. What is changed in it counts after
    /// begin_epoch() with a HostShare. Not collective.
    virtual Share& share() = 0;
    /// Calls f for the share piece by piece, in list order, so that the host need not have capacity for all of a
    /// device's; `only`: the columns that are wanted, all if empty. Binned state only. Not collective.
    using PieceReader = std::function<void(const SharePiece<Real, Dim>&)>;
    virtual void each_piece(const PieceReader& f, const std::vector<std::string>& only = {}) {
        f(whole_of(share(), only));
    }
    /// Answers a question about the particles where they are (engine_query.hpp). Binned state only.
    virtual void answer(const EngineQuery<Dim>& query) = 0;
    virtual Census census() const = 0;
    /// Of the last binning. Not collective; binned state only, unless it leaves the host free.
    virtual BlockCounts block_counts(bool with_cells) = 0;
    virtual Traffic traffic() const = 0;
    /// Waits for the kernels that are queued. Not collective.
    virtual void synchronize() {}

    /// Copies tables to where a later begin_epoch() will want them, if any: may be called by another thread, during a
    /// step. Not collective.
    virtual void prepare(const EpochTables<Dim>& /*tables*/) {}
    /// Begins an epoch with these particles (epoch_start.hpp); what travelled. Binned state only, but for KeptBlocks
    /// with an engine that leaves the host free: there it may begin with the next binning. Collective.
    virtual BlockMoveCount begin_epoch(EpochTables<Dim> tables, const EpochStart<Real, Dim>& start) = 0;
    /// The method has been made anew: with these strengths, and other walls and damping. Binned state only. Not
    /// collective.
    virtual void begin_stage(const std::vector<MaterialSpec>& /*materials*/) {}
    /// From now on absorbing ends act by these, which must outlive the engine. Not collective.
    virtual void hold_ends(const EndNodes<Dim>& /*ends*/) {}
    /// Puts memory into list order where that pays, or always. Binned state only. Not collective.
    virtual void refresh_memory(bool always) = 0;

    /// Puts blocks at rest to sleep and wakes others (core/sleep/sleep.hpp); the `first` check of a run puts none to
    /// sleep. Binned state only. Scenes with sleep only; structures: null where there are none. Collective over peers.
    virtual void check_sleep(bool /*first*/, const Quantum& /*quantum*/, const StructureSet<Dim>* /*structures*/) {}

    /// Whether the engine makes the next step by itself: then the only verb of that step is take_report(), for the
    /// step before. Waits for the device's decision; after `false` all is as after bin(). With a request it
    /// first begins to make steps, if it can and does not yet. Alone only. Not collective.
    virtual bool leads(const LeadRequest<Dim>* /*request*/ = nullptr) { return false; }

    // The parts of a step, in this order. Collective over peers where they send or receive.
    virtual void bin() = 0;  ///< incoming particles; each block's list by cell
    /// In the next round the sums find also the gaps to structures (null: the scene has none), which are kept for the
    /// step.
    virtual void begin_sums(const SumsOfStep<Dim>& sums, const StructureSet<Dim>* structures) = 0;
    virtual void sum(SharePart part) = 0;  ///< P2G: the boundary, and the interior after send_halo()
    virtual void send_halo() = 0;
    /// Before receive_halo(): no more particles leave than `bound`, the same on all ranks. Collective.
    virtual void expect_outgoing(const MigrationBound& /*bound*/) {}
    virtual void receive_halo() = 0;
    virtual void solve_nodes(const Round& round, const StepScales<Dim>& step) = 0;
    /// Between solve_nodes() and gather() of a round that holds (NodeTask::hold); the halo travels between the sums and
    /// the nodes of each substep.
    virtual void substep(SubstepStage stage, const Substep& substep, const StepScales<Dim>& step) = 0;
    virtual void gather(const Round& round, const StepScales<Dim>& step) = 0;
    virtual void send_outgoing(const StepScales<Dim>& step) = 0;

    /// Of the steps since it was last taken. Binned state only. Not collective.
    virtual StepReport<Dim> take_report() = 0;

  protected:
    explicit Engine(EngineDevice device = {}) : device_(std::move(device)) {}

  private:
    EngineDevice device_;
};

/// Place of a particle of an own block [m].
template <class Real, int Dim>
std::array<double, Dim> place_in(const Scene& scene, const Stencil& stencil, const Vec<std::int32_t, Dim>& block,
                                 const Vec<Coordinate<Real>, Dim>& u) {
    std::array<double, Dim> x{};
    for (int a = 0; a < Dim; ++a) {
        const auto i = static_cast<std::size_t>(a);
        x[i] = scene.min[i] + scene.cell * (local_of<Real>(block[a], u[a]) - stencil.offset());
    }
    return x;
}

}  // namespace moraine
