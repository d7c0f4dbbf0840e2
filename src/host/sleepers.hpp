#pragma once
// Which blocks of a host's share sleep (core/sleep/sleep.hpp), and what their tiles still hold.
//
// Whether a block sleeps is a bit of its particles, all of them or none; this keeps the same by own block, for one
// epoch. A kept tile is right while its block has the same tile and nothing else has been written there; else it is
// summed again, with the same bits. So keeping tiles is speed alone, and never correctness.

#include <array>
#include <span>
#include <vector>

#include "blocks/patch.hpp"
#include "comm/point_to_point.hpp"
#include "core/data/host.hpp"
#include "core/sleep/sleep_contact.hpp"
#include "core/transfer/method.hpp"
#include "core/transfer/totals.hpp"

namespace moraine {

template <class Real, int Dim>
class Sleepers {
  public:
    using Share = Patch<Host, Real, Dim>;

    /// All must outlive it. Not collective.
    Sleepers(const Scene& scene, const Comm& comm, const Method<Host, Real, Dim>& method, Share& share);

    /// The share has new tables. Not collective.
    void begin_epoch();
    /// Wakes the blocks that a binning has brought particles to. Not collective.
    void wake_entered();
    /// Structures as the kernels see them; null: there are none.
    using Structures = const ContactField<Dim>*;

    /// A sleep check; the first of a run puts nobody to sleep. Collective over peers.
    void check(bool first, const Quantum& quantum, Structures structures, Budget<Dim>& budget);

    /// Those of `blocks` whose tiles a P2G with this mean has to make: the awake ones, and where a tile is not right.
    /// They count as made. Holds until it is called again. Not collective.
    std::span<const std::int32_t> to_sum(std::span<const std::int32_t> blocks, NodeMean mean);
    /// P2G has made those. Not collective.
    void keep_masses();
    /// All tiles have been written by others. Not collective.
    void forget_tiles() { ++forgotten_; }

    /// Once ghosts have told whether they sleep: splits the node blocks into those whose tiles are all of sleepers,
    /// which are not solved, and the others; near structures none is still, nor where near_of (empty: nowhere) is not
    /// negative. Returns whether keep_still_nodes() has to follow. Not collective.
    bool find_still_nodes(Structures structures, std::span<const std::int32_t> near_of);
    std::span<const std::int32_t> still_nodes() const { return still_; }
    std::span<const std::int32_t> other_nodes() const { return other_; }
    /// The still nodes hold what a step of 1 s makes of them, impulses too: all is in proportion to dt, since they have
    /// no momentum. Not collective.
    void keep_still_nodes(const ExactSum* impulse, const Quantum& quantum);

    /// Between nodes and gather: wakes who has a fast node or a structure that moves near, and takes what the nodes
    /// would have given the others into the budget. Not collective.
    void wake_by_nodes(double dt, const Quantum& quantum, Structures structures, Budget<Dim>& budget);
    /// The still nodes of who woke: they have to be solved for the gather after all; their impulses are counted.
    std::span<const std::int32_t> woken_nodes() const { return woken_nodes_; }
    /// Own blocks that are awake, empty ones too. Not collective.
    std::span<const std::int32_t> awake();
    /// What a gather leaves of blocks that it leaves out: all stay. Not collective.
    void stay();

    std::uint8_t* asleep() { return asleep_.data(); }  ///< by own block, then ghost
    bool is_asleep(int block) const { return asleep_[static_cast<std::size_t>(block)] != 0; }
    std::int64_t particles() const;  ///< that sleep

  private:
    /// Which memory, place and mean a tile was made in and with.
    struct TileMark {
        std::int64_t memory = -1;
        std::int32_t tile = -1;
        NodeMean mean = NodeMean::none;
        bool operator==(const TileMark&) const = default;
    };

    double activity(int block, Structures structures) const;
    double activity_around(int block) const;
    void put_to_sleep(int block, const Quantum& quantum, Budget<Dim>& budget);
    void wake(int block);
    void settle(int block);
    void mark(int block);
    HeldByNodes<Dim> held_by_nodes(int block, bool still) const;
    int still_corners(int block) const;
    void list_still_nodes_of(int block);
    const std::vector<std::int32_t>& sleepers();
    std::span<const std::uint32_t> slots(int block) const;

    const Scene& scene_;
    const Method<Host, Real, Dim>& method_;
    Share& share_;
    PointToPoint messages_;
    const SleepRule rule_;
    std::vector<std::uint8_t> asleep_;       ///< by own block, then ghost
    std::vector<TileMark> made_;             ///< by own block, of its tile
    std::vector<std::vector<Real>> masses_;  ///< by own block, of a sleeper's tile [kg]
    std::int64_t forgotten_ = 0;
    std::vector<double> activity_;                       ///< by own block, then ghost
    std::vector<std::int32_t> awake_, sleepers_, sums_;  ///< lists of own blocks
    bool listed_ = false;                                ///< awake_ and sleepers_ are those of now
    std::vector<HeldByNodes<Dim>> held_;                 ///< by sleeper, at nodes that are solved
    std::vector<std::uint8_t> is_still_;                 ///< by node block
    std::vector<std::int32_t> still_, other_, woken_nodes_;
    bool still_known_ = false;                            ///< what follows is of the still nodes of now
    std::vector<HeldByNodes<Dim>> held_still_;            ///< by own block, in a step of 1 s
    std::vector<std::array<double, Dim>> still_impulse_;  ///< by still node block, likewise [kg m/s]
};

}  // namespace moraine
