#pragma once
// Ground from a function of place.

#include <array>
#include <cstdint>

#include "core/structures/ground.hpp"

namespace moraine::test {

/// Heights of f(x, y) at n x n nodes from `first` on, or n for a profile [m].
template <class F>
Ground ground_of(std::array<double, 2> first, std::int64_t n, double spacing, bool profile, const F& f) {
    Ground g;
    g.first = first;
    g.spacing = spacing;
    g.count = {n, profile ? 1 : n};
    for (std::int64_t j = 0; j < g.count[1]; ++j)
        for (std::int64_t i = 0; i < n; ++i)
            g.height.push_back(f(g.first[0] + spacing * double(i), g.first[1] + spacing * double(j)));
    g.fit();
    return g;
}

}  // namespace moraine::test
