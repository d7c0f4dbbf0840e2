#pragma once
// A rebalance: one imbalance check at a time, from the wish for one to the tables of the repartition that it may end
// with.
//
//   idle --begin()--> gathering --loads of all ranks are here--> planning --due, and all have planned--> due
//   --take()--> idle
//
// Where plans and tables are made asynchronously (devices) it begins some steps before it is due, and is taken when all
// ranks have planned; elsewhere all of it happens at once. Every rank gathers the same loads and plans alike, so no
// decision is sent. It knows no particle: loads come in, tables and owners go out.

#include <optional>
#include <string>
#include <vector>

#include "balance/imbalance_check.hpp"
#include "blocks/epoch_lifetime.hpp"
#include "blocks/next_epoch.hpp"
#include "comm/async_allgather.hpp"

namespace moraine {

/// Rows of several ranks in key order; a block held by several ranks (seeding) is one entry. Not collective.
std::vector<BlockLoad> merged(const std::vector<BlockLoad>& rows);

template <int Dim>
class Rebalance {
  public:
    enum class State {
        idle,       ///< none is under way
        gathering,  ///< loads are on their way to all ranks
        planning,   ///< every rank plans, and makes the tables of what it planned
        due,        ///< the plan is to be taken now
    };

    /// An imbalance check begins so many steps before it is due where it is asynchronous: about 10 ms on devices, as
    /// long as a plan and tables of 50 000 blocks take. At most half of an interval.
    static constexpr std::int64_t most_steps_ahead = 16;

    /// All must outlive it. Not collective.
    Rebalance(const BalanceSpec& spec, const Comm& comm, const Partitioner& partitioner, RepartitionTrigger& trigger,
              NextEpoch<Dim>& next_epoch)
        : spec_(spec),
          comm_(comm),
          partitioner_(partitioner),
          trigger_(trigger),
          next_epoch_(next_epoch),
          loads_(comm) {}
    Rebalance(const Rebalance&) = delete;
    Rebalance& operator=(const Rebalance&) = delete;
    ~Rebalance() { next_epoch_.wait(); }  // its thread plans with what is here

    /// Whether plans and tables are made asynchronously. The same on all ranks.
    void set_async(bool async) { async_ = async; }
    State state() const { return state_; }
    bool is_under_way() const { return state_ != State::idle; }

    /// Steps from a begin to the step that is due. Ranks that plan together (a collective partitioner) do so when they
    /// meet.
    std::int64_t steps_ahead() const;

    /// Notes that one is wanted if it is time. Alone, a rank has nobody to share with.
    void want(std::int64_t step);

    /// Whether one that is wanted is to begin now. One that would end with the epoch begins after the new epoch, or an
    /// interval later where epochs are short: all would wait for its plan. It takes the steps that it begins ahead, and
    /// is given as many again. moved: largest displacement of a step [cells].
    bool is_to_begin(std::int64_t step, const EpochLifetime& epoch, double moved) const;

    /// What is wanted ends here, without loads: `found` says why. Not collective.
    void skip(ImbalanceCheck found);

    /// Begins to gather. mine: this rank's blocks, keys ascending. Nothing may be under way. Collective.
    void begin(std::int64_t step, std::vector<BlockLoad> mine, ImbalanceCheckInput input);

    /// A step further. making: some rank still makes tables; now: it cannot wait (the epoch is used up). Collective.
    void advance(std::int64_t step, bool making, bool now);

    /// What is due: the tables of the plan, or none where all stays. Waits for the thread that makes them. Not
    /// collective.
    std::optional<EpochTables<Dim>> take();

    /// Blocks have moved; it took so long [s], the same on all ranks.
    void learn(double seconds) { trigger_.learn(planned_.found.terms.migration, seconds); }

    /// The check that ended since this was asked before, or the one of them that repartitioned; no reason: none did.
    ImbalanceCheck take_check() { return std::exchange(last_, {}); }

  private:
    void plan(std::vector<BlockLoad> blocks, std::vector<std::int64_t> counts);
    void end(ImbalanceCheck found);

    const BalanceSpec& spec_;
    const Comm& comm_;
    const Partitioner& partitioner_;
    RepartitionTrigger& trigger_;
    NextEpoch<Dim>& next_epoch_;
    AsyncAllgather<BlockLoad> loads_;  ///< of all ranks

    State state_ = State::idle;
    bool async_ = false;
    std::optional<std::int64_t> wanted_;  ///< since this step, and it has not begun
    std::int64_t due_ = 0;                ///< the step from which it is taken when all ranks have planned
    std::int64_t latest_ = 0;             ///< the step at which they are waited for
    ImbalanceCheckInput input_;
    ImbalanceCheckResult planned_;  ///< by the thread that makes the next epoch
    ImbalanceCheck last_;
};

}  // namespace moraine
