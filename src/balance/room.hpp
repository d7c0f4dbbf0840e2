#pragma once
// Memory as a second constraint of a partition: no rank is given more particles than it can hold.

#include "balance/partitioner.hpp"

namespace moraine {

/// Particles of the fullest rank. Not collective.
std::int64_t fullest(std::span<const BlockLoad> blocks, std::span<const std::int32_t> owners, int ranks);

/// Those of `options` under which no rank holds more than `most` particles. Not collective.
std::vector<Option> that_fit(std::vector<Option> options, std::span<const BlockLoad> blocks, int ranks,
                             std::int64_t most);

}  // namespace moraine
