#pragma once
// The default: the Morton curve through the occupied blocks, cut exactly by weight; the segments go to
// the ranks that already hold most of their particles.
//
// The blocks come in key order, which is the order of the curve. A pure function of the blocks: the same
// weights give the same cut, so a balanced flow at rest moves nothing.

#include "balance/cut.hpp"
#include "balance/partitioner.hpp"
#include "balance/relabel.hpp"

namespace moraine {

class MortonPartitioner final : public Partitioner {
  public:
    explicit MortonPartitioner(int ranks) : ranks_(ranks) {}

    const char* name() const override { return "morton"; }

    std::vector<std::int32_t> owners(std::span<const BlockLoad> blocks, std::int64_t) const override {
        std::vector<std::int64_t> weights;
        weights.reserve(blocks.size());
        for (const BlockLoad& block : blocks) weights.push_back(block.weight);
        const std::vector<std::int64_t> cuts = exact_cut(weights, ranks_);

        std::vector<std::int32_t> owner(blocks.size());
        for (std::int32_t p = 0; p < ranks_; ++p)
            for (std::int64_t b = cuts[p]; b < cuts[p + 1]; ++b) owner[b] = p;
        const std::vector<std::int32_t> rank_of = relabel(blocks, owner, ranks_);
        for (std::int32_t& part : owner) part = rank_of[part];
        return owner;
    }

  private:
    int ranks_;
};

}  // namespace moraine
