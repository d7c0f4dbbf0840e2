#pragma once
// The fused step's device memory and launches: nodes, fused, overfull blocks, who came.

#include "device_lab/add_incoming.cuh"
#include "device_lab/fused.cuh"
#include "device_lab/share.cuh"

namespace moraine::gpu::lab {

/// Capacity: particles of a thread block; Large: of one that has a multiprocessor for itself.
template <int Capacity_, int Passes_, int Resident_, int Large_, bool Ahead_ = false, bool Clocks_ = false>
struct FusedPlan {
    static constexpr int Capacity = Capacity_, Passes = Passes_, Resident = Resident_, Large = Large_;
    static constexpr bool Ahead = Ahead_, Clocks = Clocks_;
};

/// The program's nodes_kernel, which can begin early.
template <class Real>
__global__ void __launch_bounds__(node_threads) nodes_after(const __grid_constant__ NodeWork<Real, 3> w) {
    constexpr int cells = Block<3>::cells;
    let_next_launch_begin();
    wait_for_launch_before();
    const int c = int(blockIdx.x) * (node_threads / cells) + int(threadIdx.x) / cells, n = int(threadIdx.x) % cells;
    const TilesAround<3> around(w.view.table, w.view.grid.tile_of, c);
    if (__all_sync(all_lanes, around.own == 0)) return;
    Quad<Real> sums, force;
    const bool counted = sum_tiles<3, 3>(w.view.grid.tiles, around, n, sums, force);
    ExactSum impulse[3];
    if (around.own != 0) solve_node<3, false, false, false, Real, 3>(w, c, n, sums, force, counted, impulse);
    fold_sums(impulse, w.view.accounts[blockIdx.x % account_parts].impulse);
}

/// to[slot[k]] = from[k].
template <class T>
__global__ void spread_kernel(std::size_t n, const std::uint32_t* slot, const T* from, T* to) {
    const std::size_t k = std::size_t(blockIdx.x) * blockDim.x + threadIdx.x;
    if (k < n) to[slot[k]] = from[k];
}

template <class Real, class Law, class Plan>
class FusedShare {
  public:
    static constexpr const char* phases[] = {"nodes", "fused", "overfull", "incoming"};
    static constexpr int phase_count = 4;
    static constexpr std::uint32_t region = 1024;  // slots
    static constexpr auto kernel =
        fused_step<Real, Law, Plan::Capacity, Plan::Passes, Plan::Resident, Plan::Ahead, Plan::Clocks>;
    static constexpr auto large_kernel = fused_step<Real, Law, Plan::Large, Plan::Passes, 1, false, false>;
    static constexpr std::size_t bytes = sizeof(Held<Real, Plan::Capacity, Plan::Passes, Plan::Ahead>);
    static constexpr std::size_t large_bytes = sizeof(Held<Real, Plan::Large, Plan::Passes, false>);

    /// reversed: the order in which blocks are worked off, which must not matter.
    FusedShare(const Column<Real>& column, const Motion& motion, const Law& law, bool reversed = false)
        : motion_(motion),
          law_(law),
          own_(column.box.own),
          memory_(column.box, std::size_t(column.box.own) * region, column.particle.size()) {
        check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, int(bytes)), "Asking");
        check(cudaFuncSetAttribute(large_kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, int(large_bytes)),
              "Asking for all shared memory");
        const auto own = std::size_t(own_);
        std::vector<Region> regions(own, Region{0, 0, 0, 0});
        std::vector<std::int32_t> tile_of(own, -1), occupied(own, -1);
        std::vector<std::uint32_t> slot(column.particle.size());
        for (int b = 0; b < own_; ++b) {
            const std::uint32_t first = column.first[b], n = column.first[b + 1] - first;
            if (n == 0) continue;
            if (n > region) throw MachineError("A region is too small.");
            regions[b] = {n, n, 0, 0};
            tile_of[b] = b, occupied[std::size_t(occupied_++)] = b;
            for (std::uint32_t k = 0; k < n; ++k) slot[first + k] = std::uint32_t(b) * region + k;
        }
        place_rows(column, motion, slot);
        if (reversed) std::reverse(occupied.begin(), occupied.begin() + occupied_);
        region_.assign(regions), memory_.tile_of.assign(tile_of), occupied_list_.assign(occupied);
        exit_at_.resize(own * (exits + 1)), claimed_.resize(own), zero(claimed_);
        report_.resize(own), zero(report_), overfull_.resize(own);
        counts_.assign(std::vector<std::uint32_t>{0, 0, 0, std::uint32_t(occupied_), 0, 0, 1});
        clocks_.resize(std::size(clock_names)), zero(clocks_);
        check(cudaDeviceGetAttribute(&processors_, cudaDevAttrMultiProcessorCount, 0), "Asking");
        first_tiles(column, slot);
    }

    template <class Mark>
    void step(const Mark& mark) {
        const FusedStep<Real> s = arguments();
        const NodeWork<Real, 3> nodes = node_work(s.v, motion_);
        const Real inverse_density = Real(1 / motion_.density), cell = Real(1);
        const Chosen occupied{occupied_list_.data(), counts_.data() + 3}, overfull{overfull_.data(), s.overfulls};
        launch(nodes_after<Real>, (nodes.view.table.node_blocks + 3) / 4, node_threads, 0, nodes);
        mark(0);
        const int all = occupied_ + occupied_ / 64, at_once = Plan::Resident * processors_;
        launch(kernel, Plan::Ahead ? std::min(all, at_once) : all, 192, bytes, s, occupied, law_, inverse_density,
               cell);
        mark(1);
        launch(large_kernel, processors_, 192, large_bytes, s, overfull, law_, inverse_density, cell);
        mark(2);
        launch(add_incoming<Real>, incoming_resident<Real> * processors_, 32 * incoming_warps<Real>, 0, s);
        mark(3);
    }
    /// Whether each launch may begin while the one before it ends.
    void link(bool linked) { linked_ = linked; }
    cudaStream_t stream() const { return stream_; }

    const Memory<Real>& memory() const { return memory_; }
    std::vector<Region> regions() const { return region_.host(); }
    std::vector<std::uint32_t> homes() const { return home_.host(); }
    std::uint32_t overfulls() const { return counts_.host()[5]; }
    std::vector<unsigned long long> clocks() const { return clocks_.host(); }
    bool failed() const { return counts_.host()[4] != 0; }

  private:
    template <class... Parameters, class... Arguments>
    void launch(void (*function)(Parameters...), int grid, int threads, std::size_t shared,
                const Arguments&... arguments) const {
        cudaLaunchAttribute early{};
        early.id = cudaLaunchAttributeProgrammaticStreamSerialization;
        early.val.programmaticStreamSerializationAllowed = 1;
        cudaLaunchConfig_t config{};
        config.gridDim = dim3(unsigned(grid)), config.blockDim = dim3(unsigned(threads));
        config.dynamicSmemBytes = shared, config.stream = stream_;
        config.attrs = &early, config.numAttrs = linked_ ? 1 : 0;
        check(cudaLaunchKernelEx(&config, function, arguments...), "Launching");
    }

    FusedStep<Real> arguments() const {
        FusedStep<Real> s{};
        s.v = memory_.view(motion_), s.g = gather_args<Real>(motion_);
        s.capacity = region, s.region = region_.data(), s.exit_at = exit_at_.data(), s.home = home_.data();
        s.number = counts_.data() + 6, s.claimed = claimed_.data(), s.report = report_.data();
        s.ticket = counts_.data() + 1;
        s.overfull = overfull_.data(), s.overfulls = counts_.data() + 2, s.overfulls_all = counts_.data() + 5;
        s.occupied = occupied_list_.data(), s.occupieds = counts_.data() + 3;
        s.tile_of = memory_.tile_of.data(), s.error = counts_.data() + 4, s.clocks = clocks_.data();
        return s;
    }

    void place_rows(const Column<Real>& column, const Motion& motion, const std::vector<std::uint32_t>& slots) {
        const std::size_t n = slots.size();
        const auto grid = unsigned((n + 255) / 256);
        Array<std::uint32_t> slot, numbers;
        Array<Row<Real>> from;
        slot.assign(slots);
        std::vector<Row<Real>> rows(n);
        for (int r = 0; r < core_rows<3>; ++r) {
            for (std::size_t k = 0; k < n; ++k) rows[k] = first_row(column.particle[k], motion, r);
            from.assign(rows);
            spread_kernel<<<grid, 256>>>(n, slot.data(), from.data(), memory_.row[r].data());
        }
        numbers.resize(n), home_.resize(std::size_t(own_) * region);
        count_up(std::uint32_t(n), numbers.data(), nullptr);
        spread_kernel<<<grid, 256>>>(n, slot.data(), numbers.data(), home_.data());
        check(cudaDeviceSynchronize(), "Placing particles");
    }

    /// Of the particles as they begin, by the program's P2G.
    void first_tiles(const Column<Real>& column, const std::vector<std::uint32_t>& slots) {
        Array<std::uint32_t> first, cell_first, slot;
        first.assign(column.first), cell_first.assign(column.cell_first), slot.assign(slots);
        View<Real, 3> v = memory_.view(motion_);
        v.list = {first.data(), cell_first.data(), slot.data()};
        P2gLaunch<LabCase<Real>>::ready()(v, {occupied_list_.data(), counts_.data() + 3}, p2g_grid<3>(occupied_),
                                          Real(1), nullptr);
        check(cudaDeviceSynchronize(), "First tiles");
    }

    Motion motion_;
    Law law_;
    int own_, occupied_ = 0, processors_ = 0;
    bool linked_ = false;
    LabStream stream_;
    Memory<Real> memory_;
    Array<Region> region_;
    Array<std::uint16_t> exit_at_;
    Array<unsigned long long> clocks_;
    Array<std::uint32_t> home_, claimed_;
    Array<std::uint32_t> counts_;  ///< -, ticket, overfull, occupied, error, overfull in all steps, step
    Array<std::int32_t> overfull_, occupied_list_;
    Array<BlockReport> report_;
};

}  // namespace moraine::gpu::lab
