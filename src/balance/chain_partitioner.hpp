#pragma once
// Partitioners that cut a chain exactly by weight; the parts go to the ranks that already hold most of their
// particles.
//
//   morton        the blocks along the Morton curve, which is the order in which they come (the default)
//   hilbert       the blocks along the Hilbert curve
//   equal-slabs   the occupied layers of blocks along balance.axis, as wholes: slabs of equal load
//
// A pure function of the blocks: the same weights give the same cut, so a balanced flow at rest moves
// nothing. options() adds the parts in natural order and the cut that moves least. Where ranks are on several hosts
// parts in a row stay on one (host_relabel.hpp), in natural order too.

#include <functional>

#include "balance/least_migration.hpp"
#include "balance/partitioner.hpp"
#include "comm/host_groups.hpp"

namespace moraine {

/// Of each block its link of the chain; links are numbered from 0 without gaps.
using Links = std::vector<std::int32_t>;

Links links_along_morton(std::span<const BlockLoad> blocks);
Links links_along_hilbert(const Layout& layout, std::span<const BlockLoad> blocks);
Links links_by_layer(const Layout& layout, int axis, std::span<const BlockLoad> blocks);

class ChainPartitioner final : public Partitioner {
  public:
    using Order = std::function<Links(std::span<const BlockLoad>)>;

    /// `hosts`: of each rank; of one host, or nothing, parts may go to any rank.
    ChainPartitioner(const char* name, int ranks, Order order, HostOfRank hosts = {})
        : name_(name), ranks_(ranks), order_(std::move(order)), hosts_(std::move(hosts)) {}

    const char* name() const override { return name_; }
    std::vector<std::int32_t> owners(std::span<const BlockLoad> blocks, std::int64_t round) const override;

    /// natural, relabelled and, where it differs from them, least migration.
    std::vector<Option> options(std::span<const BlockLoad> blocks, std::int64_t round) const override;

    /// The same under the limit; none only where the chain has no such cut.
    std::optional<std::vector<Option>> options_within(std::span<const BlockLoad> blocks,
                                                      std::int64_t most) const override;

  private:
    std::vector<Option> options_of(std::span<const BlockLoad> blocks, const Links& links,
                                   std::span<const std::int64_t> weights, const std::vector<std::int64_t>& cuts,
                                   const MemoryLimit& memory) const;
    std::vector<std::int32_t> relabelled(std::span<const BlockLoad> blocks, std::span<const std::int32_t> parts,
                                         std::span<const std::int32_t> wanted = {}) const;

    const char* name_;
    int ranks_;
    Order order_;
    HostOfRank hosts_;
};

}  // namespace moraine
