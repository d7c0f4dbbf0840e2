#pragma once
// What all ranks agree on once per step, in one reduction that runs while the halo travels.
//
// Few ranks (16) tell each other directly: one message each way, as long as the halo's, so that a step waits for no
// other. A reduction of MPI takes up to 2 log2 P in turn, and goes on only while somebody waits for it.
//
// Only minima, maxima, bit-ors and integer sums feed back into the run, so it is the same on any
// number of ranks. Faults and requests to stop travel along: all ranks learn of them together.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "comm/comm.hpp"

namespace moraine {

/// Most particles that can leave in one step, where devices must have capacity for them before they do.
struct MigrationBound {
    std::int64_t block = 0;  ///< out of one block to one peer
    std::int64_t pair = 0;   ///< from one rank to another

    void take_most(const MigrationBound& other) {
        block = std::max(block, other.block);
        pair = std::max(pair, other.pair);
    }
};

/// What can be asked of all ranks, as bits of Agreement::stop.
inline constexpr std::uint32_t ask_stop = 1;        ///< a signal: checkpoint and end
inline constexpr std::uint32_t ask_checkpoint = 2;  ///< the wall clock: checkpoint

struct Agreement {
    double signal = 0;                 ///< max: c + |v| [m/s]
    double square_speed = 0;           ///< max: |v|^2, with the grid's pressure [m2/s2]
    double moved = 0;                  ///< max: displacement of the last step [cells]
    double seconds = 0;                ///< max: compute time of the last step, without waiting [s]
    double seconds_sum = 0;            ///< sum; reported only
    std::int64_t count = 0;            ///< max: particles of a rank
    std::int64_t count_sum = 0;        ///< sum
    std::int64_t asleep_sum = 0;       ///< sum: of these, of sleeping blocks
    std::int64_t load = 0;             ///< max: particles of a rank, sleepers by what they cost (balance/weight.hpp)
    std::int64_t load_sum = 0;         ///< sum
    std::int64_t blocks = 0;           ///< sum: occupied
    MigrationBound migration_bound;    ///< max
    std::uint32_t faults = 0;          ///< or: bits of Fault
    std::uint32_t in_guard_layer = 0;  ///< or: 1 some particle could leave the topology soon (blocks/guard_layer.hpp)
    std::uint32_t making = 0;          ///< or: 1 the next epoch is still being made
    std::uint32_t writing = 0;         ///< or: 1 an output is being written asynchronously
    std::uint32_t stop = 0;            ///< or: ask_stop, ask_checkpoint
};

/// One reduction at a time: start, other work, finish.
class AgreementReduction {
  public:
    explicit AgreementReduction(const Comm& comm);
    ~AgreementReduction();
    AgreementReduction(const AgreementReduction&) = delete;
    AgreementReduction& operator=(const AgreementReduction&) = delete;

    /// Collective, as is finish().
    void start(const Agreement& mine);
    Agreement finish();

  private:
    const Comm& comm_;
    MPI_Datatype type_ = MPI_DATATYPE_NULL;
    MPI_Op op_ = MPI_OP_NULL;
    std::vector<MPI_Request> requests_;
    Agreement mine_;
    std::vector<Agreement> of_ranks_;  ///< the first: of all, where MPI reduces
};

}  // namespace moraine
