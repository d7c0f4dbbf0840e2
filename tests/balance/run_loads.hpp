#pragma once
// The loads of a run: inputs/slurry_runout_3d.toml with domain.cell=0.2, after 100, 600, 1100 and 1700 steps.

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "balance/load.hpp"

namespace moraine {

inline const Layout run_layout{3, {31, 31, 8}};

/// By step; blocks in key order, nobody's, weighed by particles.
inline std::map<std::int64_t, std::vector<BlockLoad>> loads_of_run() {
    std::map<std::int64_t, std::vector<BlockLoad>> loads;
    std::ifstream file(SLURRY_LOADS);
    std::string line;
    std::getline(file, line);  // names
    std::int64_t step = 0, particles = 0;
    BlockPosition<3> at{};
    char comma = 0;
    while (std::getline(file, line)) {
        std::istringstream row(line);
        for (row >> step >> comma >> at[1] >> comma >> at[2] >> comma >> at[0]; row >> comma >> particles; ++at[0])
            loads[step].push_back({Morton<3>::encode(at), particles, particles, -1});
    }
    for (auto& [when, blocks] : loads)
        std::sort(blocks.begin(), blocks.end(), [](const BlockLoad& a, const BlockLoad& b) { return a.key < b.key; });
    return loads;
}

}  // namespace moraine
