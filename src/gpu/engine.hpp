#pragma once
// The engine of one device: the share lives there; the host sees it for output, checkpoints and block moves only.
//
// A step is queued on one stream:  binning, report, P2G | nodes, G2P, outgoing particles.  At the bar the host waits
// once, for the report of the step before (dt needs it), while P2G runs; what concerns the boundary (its P2G, the halo,
// its G2P, who leaves it) goes on a concurrent stream, ahead of the interior. Nothing
// is allocated in a step, but when the flow has come to occupy more blocks than there are tiles (then P2G has found
// empty lists, and is queued again) or more particles may arrive than there is capacity for.

#include <cuda_runtime.h>

#include <memory>
#include <optional>
#include <span>

#include "comm/engine.hpp"
#include "gpu/device_sleepers.hpp"
#include "gpu/engine_kernels.hpp"
#include "gpu/exchange/exchange.hpp"
#include "gpu/kernels/cells/lists.hpp"
#include "gpu/kernels/gaps/gaps.hpp"
#include "gpu/kernels/samples/samples.hpp"
#include "gpu/kernels/step_report.hpp"
#include "gpu/lead.hpp"
#include "gpu/material_gathers.hpp"
#include "gpu/memory/device_tables.hpp"
#include "gpu/memory/particles.hpp"
#include "gpu/memory/refresh_clock.hpp"
#include "gpu/memory/stopwatch.hpp"
#include "gpu/memory/stream.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
class DeviceEngine final : public Engine<Real, Dim> {
  public:
    using Share = Patch<Host, Real, Dim>;

    /// On the current device. transports: needed where there are several ranks. All but transports must outlive it.
    /// refresh_interval: steps between memory refreshes; 0: by what the particles take. Collective.
    DeviceEngine(const Scene& scene, const Comm& comm, const Method<Host, Real, Dim>& method,
                 const TransportFactory* transports, int refresh_interval = 0);

    std::string device() const override { return name_; }
    bool leaves_host_free() const override { return true; }
    Share& share() override;
    Census census() const override { return census_; }
    std::int64_t capacity() const override;
    void synchronize() override { stream_.wait(); }
    BlockCounts block_counts(bool with_cells) override;

    using PieceReader = typename Engine<Real, Dim>::PieceReader;
    void each_piece(const PieceReader& f, const std::vector<std::string>& only) override;

    void adopt(EpochTables<Dim> tables, const BinnedBlocks& binned) override;
    void adopt(EpochTables<Dim> tables, const LatticeTables<Real, Dim>& lattice) override;
    void prepare(const EpochTables<Dim>& tables) override;
    void renew(EpochTables<Dim> tables) override;
    BlockMoveCount repartition(EpochTables<Dim> tables, std::span<const std::int32_t> owner) override;
    std::optional<NodeVolumes> node_volumes() override;
    void find_layers(const PlanColumns& columns, std::vector<Layers>& layers) override;
    double sum_columns(const PlanColumns& columns, std::vector<std::int64_t>& sums) override;
    std::vector<NearParticle> particles_near(const PlanLines& lines) override;
    void refresh_memory(bool) override {}  // every few steps, by itself

    bool take_lead(const LeadRule<Dim>& rule, const LeadClock<Dim>& clock, const StepScales<Dim>& step) override;
    bool leads() override;

    void check_sleep(bool first, const Quantum& quantum, const StructureSet<Dim>* structures) override;
    void bin() override;
    void find_gaps(const StructureSet<Dim>& structures) override;
    void sum_mean(NodeMean mean) override { mean_ = mean; }
    void sum_boundary() override;
    void send_halo() override;
    void sum_interior() override;
    void receive_halo() override;
    void expect_outgoing(const MigrationBound& bound) override;
    void solve_nodes(const Round& round, const StepScales<Dim>& step) override;
    void find_cells(const Substep& first) override;
    void sum_boundary_cells(const Substep& substep) override;
    void sum_interior_cells(const Substep& substep) override;
    void solve_substep(const Substep& substep, const StepScales<Dim>& step) override;
    void gather(const Round& round, const StepScales<Dim>& step) override;
    void send_outgoing(const StepScales<Dim>&) override;

    StepReport<Dim> take_report() override;
    std::vector<FaultRecord<Dim>> fault_records() override;
    Traffic traffic() const override;

  private:
    void take_fluids();
    void take_tables(EpochTables<Dim> tables);
    void change_tables();
    void open_epoch();
    std::size_t capacity_for(std::size_t particles) const;
    void begin(std::size_t particles, std::size_t blocks, std::size_t most);
    void count_boundary();
    void count_migration_bound();
    void grow_tiles();
    void make_tiles(std::size_t tiles);
    void sum();
    bool limits(const Round& round) const {
        return (round.nodes == NodeTask::solve || round.nodes == NodeTask::hold) && method_.stiffness();
    }
    NodeRound<Real, Dim> node_round(NodeTask task, double dt, const StepScales<Dim>& step) const;
    LightMarks<Real> light_marks_of(const Round& round) const;
    void hold(const Round& round, const StepScales<Dim>& step);
    CellTask<Real> cell_task(const Substep& substep) const;
    void sum_part(int part, cudaStream_t stream);
    void find_sleepers();
    void report(const std::uint32_t* former_first);
    ReportWork<Dim> report_work(Report<Dim>* to) const {
        return {accounts_.data(), lists_.particles(), lists_.occupied(), lists_.in_guard_layer(), counters_.data(), to};
    }
    void report_lead();
    void take_entry(StepReport<Dim>& report);
    bool can_lead() const;
    void queue_lead();
    void capture_lead(LeadGraph& graph, const StepScales<Dim>& step, const Columns<Real, Dim>& columns);
    std::vector<LeadLaunch> lead_launches() const;
    std::vector<std::uint64_t> lead_key(const Columns<Real, Dim>& columns, const StepScales<Dim>& step) const;
    HaloSleepers halo_sleepers() const;
    RecordLayout records() const { return record_layout(particles_.view(), particles_.rest()); }
    std::size_t tile_quads() const {
        return static_cast<std::size_t>(2 * power<Dim>(tile_side(method_.stencil.width)));
    }
    void hold_sleepers(const StepScales<Dim>& step);
    Chosen awake_of(int part) const { return sleepers_ ? sleepers_->awake(part) : chosen_of(part); }
    void run_nodes(const NodeRound<Real, Dim>& round, const Quantum& quantum, const LightMarks<Real>& marks,
                   const NodeContact<Dim>* contact);
    NodeContact<Dim> node_contact(const StructureSet<Dim>& structures);
    FluidArgs<Real> fluid_args() const;
    FluidGatherArgs<Real, Dim> gather_args(const Round& round, const StepScales<Dim>& step) const;
    void gather_part(int part, const Round& round, const FluidGatherArgs<Real, Dim>& args, const Launch& launch);
    void gather_blocks(const Chosen& chosen, const Chosen* limited, const Round& round,
                       const FluidGatherArgs<Real, Dim>& args, const Lanes& lanes);
    void refresh();
    void refresh_and_grow(std::size_t most);
    void set_stored(std::size_t n);
    const Report<Dim>& last_report() const;
    void take_census();
    int blocks_of(int part) const { return part == 0 ? boundary_blocks_ : interior_blocks(); }
    Chosen chosen_of(int part) const { return part == 0 ? lists_.boundary() : lists_.interior(); }
    std::vector<ListRange> ranges() const;
    void bound_cells();
    void install(EpochTables<Dim> tables, const std::vector<ListRange>& blocks);
    View<Real, Dim> view() const;
    int interior_blocks() const { return static_cast<int>(census_.blocks) - boundary_blocks_; }

    const Scene& scene_;
    const Method<Host, Real, Dim>& method_;
    std::string name_;
    std::size_t memory_;  ///< of the device [bytes]
    Stream stream_;
    Event reported_;

    Kernels<Real, Dim> kernels_;
    NodeMean mean_ = NodeMean::none;
    Array<FluidTerms<Real>> fluid_;   ///< by body
    FluidTerms<Real> first_fluid_{};  ///< of the first one
    PressureState<Real, Dim> pressure_;
    Array<ExactSum> volumes_;                                ///< of NodeVolumes
    std::unique_ptr<MaterialGathers<Real, Dim>> materials_;  ///< of blocks of one material; null: none is apart

    Share share_;  ///< the host's
    bool share_is_of_now_ = true;
    std::unique_ptr<Exchange<Real, Dim>> exchange_;  ///< none: this rank is alone
    EpochTables<Dim> epoch_;
    Tables<Dim> tables_, next_tables_;
    ListTables next_list_tables_;
    Routes next_routes_;
    std::optional<EpochTables<Dim>> pending_;  ///< of the epoch that begins with the next binning
    Stream upload_{Stream::Rank::apart}, reading_{Stream::Rank::apart};
    int device_ = 0;
    std::int64_t prepared_ = 0;  ///< serial of the tables that next_tables_ and next_routes_ hold; 0: of none
    Lists<Dim> lists_;
    DeviceParticles<Real, Dim> particles_;
    PoolArray<Quad<Real>> tiles_, nodes_;
    PoolArray<std::int32_t> node_of_;  ///< 0, 1, 2, ...
    Array<Vec<Real, Dim>> half_size_;
    Array<std::uint16_t> material_of_;
    Array<std::uint8_t> averaged_;                   ///< by body; empty: all or none
    Array<Stiffness<Real>> stiffness_;               ///< by body; empty: nothing is limited
    PoolArray<std::uint8_t> light_marks_, limited_;  ///< of node blocks, of own blocks
    PoolArray<std::int32_t> limited_blocks_;         ///< LimitedBlocks of the boundary, then of the interior
    Array<std::uint32_t> limited_count_;             ///< of both
    Real full_mass_ = 0;                             ///< the largest of the bodies' [kg]
    Array<Real> gradient_;
    Array<Account<Dim>> accounts_;
    DeviceStructures<Dim> structures_;
    DeviceGaps<Dim> gaps_;
    DeviceNearBlocks<Dim> near_blocks_;
    ContactField<Dim> contact_{};      ///< of this step's gaps
    NodeContact<Dim> node_contact_{};  ///< of this step's nodes
    bool finding_ = false;             ///< gaps, in this round
    bool limiting_ = false;            ///< depths, once a step: the sums may be made twice
    DeviceSamples samples_;
    std::unique_ptr<DeviceSleepers<Real, Dim>> sleepers_;  ///< null: none sleep in this scene
    Array<Counters> counters_;
    Pinned<Report<Dim>> report_;
    std::unique_ptr<Lead<Dim>> lead_;                      ///< null: the host makes dt
    StepScales<Dim> lead_scales_{};                        ///< of the lead under way, but for dt
    const Report<Dim>* told_ = nullptr;                    ///< the last report, where the device made it by itself
    const Columns<Real, Dim>* columns_of_lead_ = nullptr;  ///< those that a graph is captured for
    Stopwatch watch_;  ///< of the steps: binning with P2G, nodes, G2P; not of waiting

    Census census_;
    int boundary_blocks_ = 0;  ///< occupied, as far as known: makes grids, any number is right
    std::size_t tile_capacity_ = 0;
    std::size_t ghost_capacity_ = 0;
    std::size_t stored_ = 0;  ///< slots in use when the last report was made
    RefreshClock refresh_clock_;
    std::size_t cache_;         ///< of the device [bytes]
    std::uint32_t faults_ = 0;  ///< of the last report
    std::uint64_t faulty_id_ = 0;
    bool moving_ = false;              ///< the last step's moves are not binned
    bool summed_ = false;              ///< P2G of this round is queued, the nodes are not
    bool unreported_ = false;          ///< the last step is binned, but not reported: the device has led
    std::uint64_t layout_ = 0;         ///< serial of what else launches depend on: tables, memory
    bool timed_ = false;               ///< the watch runs since binning
    bool report_is_of_epoch_ = false;  ///< no epoch has begun since the report was made
};

}  // namespace moraine::gpu
