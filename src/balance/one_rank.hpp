#pragma once
// A partitioner that rank 0 alone computes; the others are sent what it says.
//
// For libraries. Every rank could run one on its own, on MPI_COMM_SELF, but two answers that differ in one block
// would be a hang: METIS draws from the C library's rand(), Zoltan from a generator of its own that the whole process
// shares, both compute in floating point, and a job may run on unlike machines. The answer is 4 bytes a
// block. Parallel partitioning would save rank 0 time and memory, but its answer would depend on the number of
// ranks and on who holds what.

#include <mpi.h>

#include "balance/partitioner.hpp"
#include "core/data/error.hpp"

namespace moraine {

class OneRank final : public Partitioner {
  public:
    OneRank(std::unique_ptr<Partitioner> computed, const Comm& comm) : computed_(std::move(computed)), comm_(comm) {}

    const char* name() const override { return computed_->name(); }
    bool is_collective() const override { return true; }

    /// Collective.
    std::vector<std::int32_t> owners(std::span<const BlockLoad> blocks, std::int64_t round) const override {
        std::vector<std::int32_t> owner(blocks.size());
        std::string refused, failed;
        if (comm_.is_root()) try {
                owner = computed_->owners(blocks, round);
            } catch (const InputError& e) {
                refused = e.what();
            } catch (const MachineError& e) {
                failed = e.what();
            }
        comm_.agree_no_error<InputError>(refused);
        comm_.agree_no_error<MachineError>(failed);
        MPI_Bcast(owner.data(), static_cast<int>(owner.size()), MPI_INT32_T, 0, comm_.handle());
        return owner;
    }

    /// Collective.
    std::vector<Option> options(std::span<const BlockLoad> blocks, std::int64_t round) const override {
        return {{PlanKind::relabelled, owners(blocks, round)}};
    }

  private:
    std::unique_ptr<Partitioner> computed_;
    const Comm& comm_;
};

}  // namespace moraine
