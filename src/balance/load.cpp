#include "balance/load.hpp"

namespace moraine {

std::vector<std::int64_t> loads_of_ranks(std::span<const BlockLoad> blocks, std::span<const std::int32_t> owners,
                                         int ranks, std::int64_t BlockLoad::*column) {
    std::vector<std::int64_t> loads(static_cast<std::size_t>(ranks), 0);
    for (std::size_t b = 0; b < blocks.size(); ++b)
        if (owners[b] >= 0) loads[static_cast<std::size_t>(owners[b])] += blocks[b].*column;
    return loads;
}

std::vector<std::int32_t> present_owners(std::span<const BlockLoad> blocks) {
    std::vector<std::int32_t> owners;
    owners.reserve(blocks.size());
    for (const BlockLoad& block : blocks) owners.push_back(block.owner);
    return owners;
}

}  // namespace moraine
