#pragma once
// The engine of one device: the share lives there; the host reads it for output, checkpoints and block moves only.
//
// A step is queued on one stream:  binning, report, P2G | nodes, G2P, outgoing particles.  At the bar the host waits
// once, for the report of the step before (dt needs it), while P2G runs. The boundary's kernels (its P2G, the halo, its
// G2P, outgoing particles) go on a concurrent stream, ahead of the interior. A step allocates nothing, but when the
// flow occupies more blocks than there are tiles (then P2G has found empty lists, and is queued again) or when more
// particles may arrive than there is capacity for.
//
// The state is in parts: kernels, bodies, epoch, particles, contact, fluid, light nodes, reports, exchange, sleepers,
// lead. The engine is the order in which they work.

#include <cuda_runtime.h>

#include <memory>

#include "engine/engine.hpp"
#include "gpu/body_tables.hpp"
#include "gpu/contact_state.hpp"
#include "gpu/device_sleepers.hpp"
#include "gpu/engine_kernels.hpp"
#include "gpu/epoch_state.hpp"
#include "gpu/exchange/exchange.hpp"
#include "gpu/fluid_state.hpp"
#include "gpu/kernels/ends/ends.hpp"
#include "gpu/kernels/loads/loads.hpp"
#include "gpu/kernels/samples/samples.hpp"
#include "gpu/lead.hpp"
#include "gpu/light_state.hpp"
#include "gpu/material_gathers.hpp"
#include "gpu/particle_store.hpp"
#include "gpu/step_reports.hpp"
#include "gpu/surface_state.hpp"

namespace moraine::gpu {

/// What is added to tiles, besides the sums of P2G.
template <class Real, int Dim>
struct AddedForces {
    std::unique_ptr<DeviceLoads<Real, Dim>> loads;  ///< null: the scene has no tractions
    std::unique_ptr<DeviceEnds<Real, Dim>> ends;    ///< null: none absorb
};

template <class Real, int Dim>
class DeviceEngine final : public Engine<Real, Dim> {
  public:
    using Share = Patch<Host, Real, Dim>;

    /// On the current device. transports: needed where there are several ranks. All but transports must outlive it.
    /// refresh_interval: steps between memory refreshes; 0: by what the particles take. Collective.
    DeviceEngine(const Scene& scene, const Comm& comm, const Method<Host, Real, Dim>& method,
                 const TransportFactory* transports, int refresh_interval = 0);
    ~DeviceEngine() override;

    Share& share() override;
    using PieceReader = typename Engine<Real, Dim>::PieceReader;
    void each_piece(const PieceReader& f, const std::vector<std::string>& only) override;
    void answer(const EngineQuery<Dim>& query) override {
        std::visit([this](auto* asked) { find(*asked); }, query);
    }
    void find(GravityQuery<Dim>& query);
    void find(EndQuery<Dim>&) { throw std::logic_error("the host measures absorbing ends"); }
    Census census() const override { return census_; }
    BlockCounts block_counts(bool with_cells) override;
    Traffic traffic() const override;
    void synchronize() override { stream_.wait(); }

    void prepare(const EpochTables<Dim>& tables) override { epoch_.prepare(tables); }
    BlockMoveCount begin_epoch(EpochTables<Dim> tables, const EpochStart<Real, Dim>& start) override {
        return std::visit([&](const auto& with) { return begin(std::move(tables), with); }, start);
    }
    void refresh_memory(bool) override {}  // every few steps, by itself
    void begin_stage(const std::vector<MaterialSpec>& materials) override {
        kernels_.take_strengths(materials);
        if (materials_) materials_->take_strengths(materials);
        if (added_.loads) added_.loads->take(method_.tractions());
        ++epoch_.layout;  // graphs of leads know the stage before
    }
    void hold_ends(const EndNodes<Dim>& ends) override { added_.ends = std::make_unique<DeviceEnds<Real, Dim>>(ends); }

    bool leads(const LeadRequest<Dim>* request) override;

    void check_sleep(bool first, const Quantum& quantum, const StructureSet<Dim>* structures) override;
    void bin() override;
    void begin_sums(const SumsOfStep<Dim>& sums, const StructureSet<Dim>* structures) override;
    void sum(SharePart part) override;
    void send_halo() override;
    void expect_outgoing(const MigrationBound& bound) override;
    void receive_halo() override;
    void solve_nodes(const Round& round, const StepScales<Dim>& step) override;
    void substep(SubstepStage stage, const Substep& substep, const StepScales<Dim>& step) override;
    void gather(const Round& round, const StepScales<Dim>& step) override;
    void send_outgoing(const StepScales<Dim>&) override;
    StepReport<Dim> take_report() override;

  private:
    // engine_epoch.cpp, engine_share.cpp: epochs, capacity, blocks as a whole
    BlockMoveCount begin(EpochTables<Dim> tables, const KeptBlocks&);
    BlockMoveCount begin(EpochTables<Dim> tables, const MovedBlocks& travelling);
    BlockMoveCount begin(EpochTables<Dim> tables, const HostShare& share);
    BlockMoveCount begin(EpochTables<Dim> tables, const LatticeShare<Real, Dim>& share);
    void begin_with(std::size_t particles, std::size_t blocks, std::size_t most);
    void install(EpochTables<Dim> tables, const std::vector<ListRange>& blocks);
    void change_tables();
    void open_epoch();
    void bound_cells();
    void count_boundary();
    void count_migration_bound();
    std::int64_t capacity() const;
    std::size_t capacity_for(std::size_t particles) const;
    void make_tiles(std::size_t tiles);
    void grow_tiles();
    void refresh();
    void refresh_and_grow(std::size_t most);
    void set_stored(std::size_t n);

    // engine_samples.cpp, engine_fluid.cpp, engine_step.cpp: answers
    void find(LayerQuery& query);
    void find(ColumnQuery& query);
    void find(LineQuery& query);
    void find(VolumeQuery& query);
    void find(FaultQuery<Dim>& query);

    // engine_step.cpp and engine_fluid.cpp: sums, nodes, reports
    void queue_sums();
    void sum_part(int part, cudaStream_t stream);
    void run_nodes(const NodeRound<Real, Dim>& round, const Quantum& quantum, const LightMarks<Real>& marks,
                   const NodeContact<Dim>* contact);
    NodeRound<Real, Dim> node_round(NodeTask task, double dt, const StepScales<Dim>& step) const;
    LightMarks<Real> light_marks_of(const Round& round) const;
    bool limits(const Round& round) const {
        return (round.nodes == NodeTask::solve || round.nodes == NodeTask::hold) && method_.stiffness();
    }
    void report(const std::uint32_t* former_first);
    void take_census();

    // engine_pressure.cpp: the grid's pressure
    void hold(const Round& round, const StepScales<Dim>& step);
    void find_pressures(const Substep& first, const StepScales<Dim>& step);
    void sum_pressures(SharePart part, const Substep& substep);
    void solve_substep(const Substep& substep, const StepScales<Dim>& step);

    // engine_gather.cpp; part: 0 is the boundary, 1 the interior
    FluidGatherArgs<Real, Dim> gather_args(const Round& round, const StepScales<Dim>& step) const;
    void gather_part(int part, const Round& round, const FluidGatherArgs<Real, Dim>& args, const Launch& launch);
    void gather_blocks(const Chosen& chosen, const Chosen* limited, const Round& round,
                       const FluidGatherArgs<Real, Dim>& args, const Lanes& lanes);
    Chosen chosen_of(int part) const { return part == 0 ? epoch_.lists.boundary() : epoch_.lists.interior(); }
    Chosen awake_of(int part) const { return sleepers_ ? sleepers_->awake(part) : chosen_of(part); }
    int blocks_of(int part) const { return part == 0 ? boundary_blocks_ : interior_blocks(); }
    int interior_blocks() const { return static_cast<int>(census_.blocks) - boundary_blocks_; }
    View<Real, Dim> view() const;

    // engine_sleep.cpp
    void find_sleepers();
    void hold_sleepers(const StepScales<Dim>& step);
    HaloSleepers halo_sleepers() const;

    // engine_lead.cpp
    bool can_lead() const;
    bool begin_lead(const LeadRequest<Dim>& request);
    void queue_lead();
    void capture_lead(bool next, const StepScales<Dim>& step, const Columns<Real, Dim>& columns);
    void report_lead();

    const Scene& scene_;
    const Method<Host, Real, Dim>& method_;
    const std::size_t memory_;  ///< of the device [bytes]
    Stream stream_;
    Stream reading_{Stream::Rank::apart};
    Share share_;  ///< the host's
    bool share_is_of_now_ = true;

    EpochState<Real, Dim> epoch_;
    ParticleStore<Real, Dim> store_;
    Kernels<Real, Dim> kernels_;
    BodyTables<Real, Dim> bodies_;
    ContactState<Dim> contact_;
    FluidState<Real, Dim> fluid_;
    LightState<Real, Dim> light_;
    StepReports<Dim> reports_;
    DeviceSamples samples_;
    std::unique_ptr<MaterialGathers<Real, Dim>> materials_;  ///< of blocks of one material; null: none is apart
    std::unique_ptr<Exchange<Real, Dim>> exchange_;          ///< null: this rank is alone
    std::unique_ptr<DeviceSleepers<Real, Dim>> sleepers_;    ///< null: none sleep in this scene
    std::unique_ptr<SurfaceState<Real, Dim>> surfaces_;      ///< null: structures act at nodes (Bed::nodes)
    AddedForces<Real, Dim> added_;
    std::unique_ptr<Lead<Real, Dim>> lead_;  ///< null: the host makes dt

    Census census_;
    int boundary_blocks_ = 0;  ///< occupied, as far as known: makes grids, any number is right
    bool moving_ = false;      ///< the last step's moves are not binned
    bool summed_ = false;      ///< P2G of this round is queued, the nodes are not
};

}  // namespace moraine::gpu
