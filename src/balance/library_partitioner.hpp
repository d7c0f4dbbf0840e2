#pragma once
// A partitioner whose parts a library finds; they go to the ranks that already hold most of their particles.
//
// Libraries are asked only where there is something to decide: a single rank owns all, a block heavier than the
// mean of what is left gets a rank of its own, and so does every block where there are no more blocks than ranks.

#include <functional>

#include "balance/partitioner.hpp"
#include "comm/host_groups.hpp"

namespace moraine {

class LibraryPartitioner final : public Partitioner {
  public:
    /// A part in [0, parts) for each block, in key order; more blocks than parts, at least 2 parts, some weight.
    using Find = std::function<std::vector<std::int32_t>(std::span<const BlockLoad> blocks, int parts)>;

    /// `hosts`: of each rank; of one host, or nothing, parts may go to any rank.
    LibraryPartitioner(const char* name, int ranks, Find find, HostOfRank hosts = {})
        : name_(name), ranks_(ranks), find_(std::move(find)), hosts_(std::move(hosts)) {}

    const char* name() const override { return name_; }
    std::vector<std::int32_t> owners(std::span<const BlockLoad> blocks, std::int64_t round) const override;
    std::vector<Option> options(std::span<const BlockLoad> blocks, std::int64_t round) const override {
        return {{PlanKind::relabelled, owners(blocks, round)}};
    }

  private:
    std::vector<std::int32_t> parts(std::span<const BlockLoad> blocks) const;

    const char* name_;
    int ranks_;
    Find find_;
    HostOfRank hosts_;
};

}  // namespace moraine
