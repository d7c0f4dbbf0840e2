#pragma once
// The sleeping blocks of one device: their state for an epoch, and the lists that a step's kernels run over
// (gpu/kernels/sleep/sleep.hpp). What host/sleepers.hpp is to the host.
//
// No function waits for the device. Tiles of sleeping blocks are kept from step to step while their number is that of
// the sums that wrote them.

#include <memory>
#include <vector>

#include "core/transfer/method.hpp"
#include "core/transfer/totals.hpp"
#include "gpu/kernels/sleep/sleep.hpp"
#include "gpu/kernels/sleep/waves.hpp"
#include "gpu/memory/pool_array.hpp"
#include "gpu/memory/stream.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
class DeviceSleepers {
  public:
    using V = View<Real, Dim>;

    /// All must outlive it. Not collective.
    DeviceSleepers(const Scene& scene, const KernelKey& key, const Method<Host, Real, Dim>& method,
                   const std::uint16_t* material_of);

    /// New tables: find() must follow. Asynchronous, as all functions below.
    void open(std::size_t own, std::size_t ghosts, cudaStream_t stream);
    /// All tiles are lost, or have been written by others.
    void forget_tiles() { ++made_; }
    /// There are so many tiles now.
    void resize_tiles(std::size_t tiles, cudaStream_t stream);

    /// Once the lists are made, by tables that change now: former_first are the lists' bounds of before.
    void wake_entered(const V& view, const RestWords& rest, const std::uint32_t* former_first, cudaStream_t stream) {
        gpu::wake_entered(view, state(rest), former_first, stream);
    }
    /// Finds the sleeping blocks by the present tables, and wakes those that particles have entered; former_first: as
    /// in wake_entered(), null: no particle has moved. count() or report() write the counts; they are there once the
    /// stream has been waited for.
    void find(const V& view, const RestWords& rest, const std::uint32_t* former_first, cudaStream_t stream);
    void count(cudaStream_t stream) { count_sleepers(accounts_.data(), report_.device(), stream); }
    /// With what sleep took; makes the step's report, too.
    void report(const ReportWork<Dim>& step, cudaStream_t stream) {
        fold_reports(step, accounts_.data(), report_.device(), stream);
    }
    /// Finds the blocks that moving structures keep awake: in a sleep check and in every step.
    void keep_awake(const V& view, const ContactField<Dim>& structures, cudaStream_t stream);
    /// A sleep check: the activity of the own blocks; then, once that of ghosts is there, change() puts blocks to sleep
    /// and wakes others.
    void find_activity(const V& view, const RestWords& rest, cudaStream_t stream) {
        gpu::find_activity(view, state(rest), stream);
    }
    std::vector<double> activity(cudaStream_t stream) const { return activity_.host(stream); }
    void set_activity(const std::vector<double>& of_blocks) { activity_.assign(of_blocks, nullptr); }
    void change(const V& view, const RestWords& rest, bool first, const Quantum& quantum, cudaStream_t stream);

    /// part: 0 is the boundary, 1 the interior. Those of `chosen` whose tiles P2G has to make.
    Chosen to_sum(const V& view, const RestWords& rest, int part, const Chosen& chosen, NodeMean mean,
                  const Launch& launch);
    /// P2G has made all of them.
    void summed(const V& view, const RestWords& rest, cudaStream_t stream);
    /// Between nodes and gather, once a step; near: by node block, some structure is near, null: there is none;
    /// boundary: 1 where some peer needs the block.
    void hold(const V& view, const RestWords& rest, const std::uint8_t* near, const Quantum& quantum,
              const std::uint8_t* boundary, cudaStream_t stream);
    /// The blocks that are awake after hold().
    Chosen awake(int part) const { return chosen(2 + part); }

    std::uint8_t* asleep() const { return asleep_.data(); }  ///< own blocks, then ghosts
    /// Own blocks whose tiles are as they were sent before; null: none is.
    const std::uint8_t* kept() const { return made_ == summed_ ? kept_.data() : nullptr; }
    std::int64_t particles() const { return static_cast<std::int64_t>(report_->particles); }  ///< that sleep
    /// What sleep took since the binning before the last.
    void add_taken(Budget<Dim>& budget) const;
    /// Of own blocks, as the last binning left them.
    std::vector<std::uint8_t> binned(cudaStream_t stream) const { return binned_.host(stream); }

  private:
    SleepView<Dim> state(const RestWords& rest) const;
    void find_waves(const V& view, cudaStream_t stream);
    ListToMake list(int number) const;
    Chosen chosen(int number) const;

    const Method<Host, Real, Dim>& method_;
    const std::uint16_t* material_of_;
    const SleepRule rule_;
    std::vector<WaveKernel<Real, Dim>> waves_;  ///< by material
    PoolArray<std::uint8_t> asleep_, binned_, kept_;
    PoolArray<std::uint8_t> kept_awake_;  ///< own; empty: no structure moves
    PoolArray<double> activity_, wave_;
    PoolArray<TileMark> marks_;
    PoolArray<Real> masses_;  ///< of tiles, where substeps write to them
    Array<SleepAccount<Dim>> accounts_;
    PoolArray<std::int32_t> lists_;  ///< of blocks to sum, then awake: boundary and interior each
    Array<std::uint32_t> counts_;    ///< likewise
    Pinned<SleepAccount<Dim>> report_;
    std::size_t own_ = 0;
    std::int32_t made_ = 0;     ///< number of what makes tiles
    std::int32_t summed_ = -1;  ///< that of the last sums
    bool empty_[2]{};           ///< the lists of blocks to sum
    bool waves_known_ = false;
};

}  // namespace moraine::gpu
