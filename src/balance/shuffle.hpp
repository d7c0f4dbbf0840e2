#pragma once
// For tests: a pseudo-random owner for every block, new at each repartition. A run under it must give
// the same bits as under any other partitioner, because ownership is never correctness.
//
//   owner = mix(mix(key) + round) mod P,  mix: the finalizer of SplitMix64 (Steele, Lea and Flood 2014)

#include "balance/partitioner.hpp"

namespace moraine {

class Shuffle final : public Partitioner {
  public:
    explicit Shuffle(int ranks) : ranks_(ranks) {}

    const char* name() const override { return "shuffle"; }

    std::vector<std::int32_t> owners(std::span<const BlockLoad> blocks, std::int64_t round) const override {
        std::vector<std::int32_t> owner;
        owner.reserve(blocks.size());
        for (const BlockLoad& block : blocks) {
            const std::uint64_t hash = mix(mix(block.key) + static_cast<std::uint64_t>(round));
            owner.push_back(static_cast<std::int32_t>(hash % static_cast<std::uint64_t>(ranks_)));
        }
        return owner;
    }

  private:
    static std::uint64_t mix(std::uint64_t v) {
        v += 0x9e3779b97f4a7c15ULL;
        v = (v ^ (v >> 30)) * 0xbf58476d1ce4e5b9ULL;
        v = (v ^ (v >> 27)) * 0x94d049bb133111ebULL;
        return v ^ (v >> 31);
    }

    int ranks_;
};

}  // namespace moraine
