#pragma once
// The epoch to come: its topology and tables, made at once or asynchronously, during the steps of the present one.
//
// Asynchronously: what is occupied is looked at early, a thread of its own makes the tables from that, and they are
// taken when the present epoch is used up. Meanwhile particles walk on, into blocks that were empty when they were
// looked at. Those blocks are in both topologies, because nobody moves 4 cells meanwhile, and belong to one rank in
// both, because a block keeps its owner as long as it is in the topology, or goes to whom the new topology says with
// all that is in it then (a repartition). Devices that waited for their tables lost 5 ms per epoch of 20 000 blocks
// (benchmarks/runout).

#include <future>
#include <optional>

#include "blocks/epoch.hpp"

namespace moraine {

template <int Dim>
class NextEpoch {
  public:
    using OwnerAt = std::function<std::int32_t(const BlockPosition<Dim>&)>;
    using Prepare = std::function<void(const EpochTables<Dim>&)>;

    /// owner_at as for make_topology(). prepare: what else is done with tables that take() will give, by the same
    /// thread. `domain` must outlive it. Not collective, as all here.
    NextEpoch(const DomainBlocks<Dim>& domain, const Stencil& stencil, int rank, OwnerAt owner_at, Prepare prepare = {})
        : domain_(domain),
          stencil_(stencil),
          rank_(rank),
          owner_at_(std::move(owner_at)),
          prepare_(std::move(prepare)) {}

    /// Of an epoch that begins now with these blocks, in key order. What was under way is forgotten.
    EpochTables<Dim> make(std::vector<OccupiedBlock> occupied);

    /// Begins to make one in which blocks stay where they are. keys: occupied ones, rank by rank, ascending in each;
    /// counts: of each rank. async: by a thread of its own, else by take().
    void start(std::vector<Key> keys, std::vector<std::int64_t> counts, bool async);

    /// The same of a repartition. occupied(): in key order, with the owners to be; none: all stays, and take() has
    /// nothing. Called by the thread that makes the tables; count: about how many.
    void start_repartition(std::size_t count, std::function<std::vector<OccupiedBlock>()> occupied, bool async);
    bool under_way() const { return made_.valid(); }
    /// take() would not wait for another thread.
    bool is_ready() const;
    /// Until no other thread runs what start_repartition() was given.
    void wait() const;

    /// What was started; waits for it. None: no block is occupied that was not when the present epoch was made, or all
    /// stays where it is; the present tables serve on.
    std::optional<EpochTables<Dim>> take();

    /// Of any block of the domain: of one that is not in the present epoch, who is asked for by position, or who has
    /// the block before it in key order. The same on all ranks.
    std::int32_t owner_near(Key key) const;
    /// Of blocks of the present epoch, own or not; keys ascend.
    std::vector<std::int32_t> owners_of(const std::vector<Key>& keys) const;

  private:
    struct Made {
        std::vector<OccupiedBlock> occupied;
        Topology<Dim> topology;
        std::optional<EpochTables<Dim>> tables;
    };

    /// blocks(): what is occupied, made by the same thread. stays: blocks keep their owners.
    template <class Blocks>
    void launch(bool async, bool stays, std::size_t count, Blocks blocks);
    Made made_of(std::vector<OccupiedBlock> occupied, bool stays, std::int64_t serial) const;

    const DomainBlocks<Dim>& domain_;
    const Stencil stencil_;
    const int rank_;
    const OwnerAt owner_at_;
    const Prepare prepare_;
    std::vector<OccupiedBlock> occupied_;  ///< of all ranks, when the present epoch was made
    Topology<Dim> topology_;               ///< of the present epoch
    std::int64_t made_so_far_ = 0;
    std::future<Made> made_;  ///< last: reads what is above
};

}  // namespace moraine
