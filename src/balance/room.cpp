#include "balance/room.hpp"

#include <algorithm>

namespace moraine {

std::int64_t fullest(std::span<const BlockLoad> blocks, std::span<const std::int32_t> owners, int ranks) {
    std::vector<std::int64_t> held(static_cast<std::size_t>(ranks), 0);
    for (std::size_t b = 0; b < blocks.size(); ++b) held[static_cast<std::size_t>(owners[b])] += blocks[b].particles;
    return *std::max_element(held.begin(), held.end());
}

std::vector<Option> that_fit(std::vector<Option> options, std::span<const BlockLoad> blocks, int ranks,
                             std::int64_t most) {
    std::erase_if(options, [&](const Option& o) { return fullest(blocks, o.owners, ranks) > most; });
    return options;
}

}  // namespace moraine
