#pragma once
// How one rank's share is stepped: on the threads of the host (comm/host_engine.hpp) or on a device (gpu/).
//
// The simulation knows the order of a step and speaks with the other ranks about dt and ownership; an engine does the
// work of each part and holds the share. What a step tells (signal speed, faults, sums for the budget) is taken once
// per step, by take_report(): on a device that is the only moment at which the host waits for it.

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "comm/agreement.hpp"
#include "comm/block_move.hpp"
#include "comm/lead_rule.hpp"
#include "comm/share_piece.hpp"
#include "core/lattice.hpp"
#include "core/method.hpp"
#include "core/over_filling.hpp"
#include "core/plan_samples.hpp"
#include "core/structure_set.hpp"
#include "core/totals.hpp"

namespace moraine {

/// What the particles of the last step tell the step control and the budget.
template <int Dim>
struct StepReport {
    double signal = 0;        ///< largest c + |v| [m/s]
    double square_speed = 0;  ///< largest |v|^2, with the grid's pressure [m2/s2]
    double moved = 0;         ///< largest displacement along an axis [cells]
    std::uint32_t faults = 0;
    bool in_guard_layer = false;           ///< when they were binned, by the tables of then (comm/guard_layer.hpp)
    std::int64_t clamped = 0;              ///< contiguous GIMP boxes held at half a cell
    Budget<Dim> budget;                    ///< to be added
    std::vector<StructureSums<Dim>> felt;  ///< by the structures; empty where there are none
    double next_dt = 0;                    ///< that the engine took by itself; 0: it does not lead [s]
    std::array<double, 3> seconds{};       ///< on the device: P2G, nodes, G2P; on the host the caller has the clock [s]
};

/// A particle that went wrong.
template <int Dim>
struct FaultRecord {
    std::uint64_t id;
    std::uint32_t faults;
    std::array<double, Dim> x;  ///< [m]
};

/// What holds for all particles of a step.
template <int Dim>
struct StepScales {
    double dt;                                      ///< [s]
    double mass_cutoff;                             ///< [kg]
    Quantum quantum;                                ///< of the exact sums
    std::array<double, Dim> gravity_impulse;        ///< integral of gravity up to the end of the step [m/s]
    const StructureSet<Dim>* structures = nullptr;  ///< null: the scene has none
};

/// Occupied blocks of this rank.
struct BlockCounts {
    std::vector<Key> key;  ///< ascending
    std::vector<std::uint32_t> count;
    std::vector<std::int64_t> cells;   ///< that hold particles; empty unless asked for
    std::vector<std::uint8_t> asleep;  ///< 1: the block sleeps; empty in scenes without sleep
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

template <class Real, int Dim>
class Engine {
  public:
    static constexpr std::int64_t unlimited = std::int64_t(1) << 60;
    using Share = Patch<Host, Real, Dim>;
    virtual ~Engine() = default;

    virtual std::string device() const = 0;  ///< for the records: "cpu", or a device's name
    /// Whether the host's threads are free while it steps. Not collective.
    virtual bool leaves_host_free() const { return false; }

    /// The share in the memory of the host; in the binned state it is that of now. What is changed in it counts after
    /// adopt(). Not collective.
    virtual Share& share() = 0;
    /// Calls f for the share piece by piece, in list order, so that the host need not have capacity for all of a
    /// device's; `only`: the columns that are wanted, all if empty. Binned state only. Not collective.
    using PieceReader = std::function<void(const SharePiece<Real, Dim>&)>;
    virtual void each_piece(const PieceReader& f, const std::vector<std::string>& only = {}) {
        f(whole_of(share(), only));
    }
    virtual Census census() const = 0;
    /// Particles that the memory of this rank can hold, by what those of now take. Not collective.
    virtual std::int64_t capacity() const { return unlimited; }
    /// Waits for what is under way. Not collective.
    virtual void synchronize() {}
    /// Of the last binning. Not collective; binned state only, unless it leaves the host free.
    virtual BlockCounts block_counts(bool with_cells) = 0;

    /// Begins an epoch with what the host's share holds; `binned` are blocks of tables.own. Collective.
    virtual void adopt(EpochTables<Dim> tables, const BinnedBlocks& binned) = 0;
    /// Begins an epoch with what the lattice has in the blocks of tables.own. Collective.
    virtual void adopt(EpochTables<Dim> tables, const LatticeTables<Real, Dim>& lattice) = 0;
    /// Tables that renew() or repartition() will get, if any: may be called by another thread, during a step. Not
    /// collective.
    virtual void prepare(const EpochTables<Dim>& /*tables*/) {}
    /// Begins an epoch with the same particles, now or with the next binning. Binned state only, unless it leaves the
    /// host free. Collective.
    virtual void renew(EpochTables<Dim> tables) = 0;
    /// Begins an epoch in which this rank's occupied block i belongs to owner[i]: blocks travel. Binned state only.
    /// Collective.
    virtual BlockMoveCount repartition(EpochTables<Dim> tables, std::span<const std::int32_t> owner) = 0;
    /// Volumes at the nodes that this rank counts; nothing where an engine cannot tell. Binned state only. Collective
    /// over peers.
    virtual std::optional<NodeVolumes> node_volumes() { return std::nullopt; }
    /// Adds to each column of a map the layers in which this rank has particles. Scenes in 3-D, binned state only. Not
    /// collective.
    virtual void find_layers(const PlanColumns& columns, std::vector<Layers>& layers) = 0;
    /// Adds the particles of this rank to the sums of a map's columns, and returns the largest |v|^2 of all [m2/s2].
    /// Scenes in 3-D, binned state only. Not collective.
    virtual double sum_columns(const PlanColumns& columns, std::vector<std::int64_t>& sums) = 0;
    /// The particles of this rank near lines, which are the same in all calls; in any order. Scenes in 3-D, binned
    /// state only. Not collective.
    virtual std::vector<NearParticle> particles_near(const PlanLines& lines) = 0;
    /// Puts memory into list order where that pays, or always. Binned state only. Not collective.
    virtual void refresh_memory(bool always) = 0;

    /// Who falls asleep and who wakes (core/sleep.hpp); the `first` of a run puts nobody to sleep. Binned state only.
    /// Scenes with sleep only; structures: null where there are none. Collective over peers.
    virtual void check_sleep(bool /*first*/, const Quantum& /*quantum*/, const StructureSet<Dim>* /*structures*/) {}

    /// Begins steps that it makes by itself, dt included (lead_rule.hpp), behind the one under way: at most
    /// clock.steps. Returns whether it does. What `step` says of dt means nothing. Alone only. Not collective.
    virtual bool take_lead(const LeadRule<Dim>& /*rule*/, const LeadClock<Dim>& /*clock*/,
                           const StepScales<Dim>& /*step*/) {
        return false;
    }
    /// Whether it makes the step behind the last report taken by itself: that one has no parts, but its report. Waits
    /// until it is known. Where it ends here, all is as after bin(). Not collective.
    virtual bool leads() { return false; }

    // The parts of a step, in this order. Collective over peers where they send or receive.
    virtual void bin() = 0;  ///< incoming particles; each block's list by cell
    /// The gaps to them are found with the sums of the next round, and kept for the step. Scenes with structures only.
    virtual void find_gaps(const StructureSet<Dim>& structures) = 0;
    /// Which mean the sums of this step make besides.
    virtual void sum_mean(NodeMean /*mean*/) {}
    virtual void sum_boundary() = 0;
    virtual void send_halo() = 0;
    virtual void sum_interior() = 0;
    /// Before the gather: no more leave than `bound`, the same on all ranks. Collective.
    virtual void expect_outgoing(const MigrationBound& /*bound*/) {}
    virtual void receive_halo() = 0;
    virtual void solve_nodes(const Round& round, const StepScales<Dim>& step) = 0;
    // Between solve_nodes and the gather of a round that holds (NodeTask::hold): the grid's pressure
    // (grid_pressure.hpp). The halo travels once per substep.
    virtual void find_cells(const Substep& /*first*/) {}
    virtual void sum_boundary_cells(const Substep& /*substep*/) {}
    virtual void sum_interior_cells(const Substep& /*substep*/) {}
    virtual void solve_substep(const Substep& /*substep*/, const StepScales<Dim>& /*step*/) {}
    virtual void gather(const Round& round, const StepScales<Dim>& step) = 0;
    virtual void send_outgoing(const StepScales<Dim>& step) = 0;

    /// Of the steps since it was last taken. Binned state only. Not collective.
    virtual StepReport<Dim> take_report() = 0;
    /// The first particle of each block with faults, or of the share. Not collective.
    virtual std::vector<FaultRecord<Dim>> fault_records() = 0;
    virtual Traffic traffic() const = 0;
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
