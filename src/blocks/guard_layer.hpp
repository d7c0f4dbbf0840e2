#pragma once
// The guard layer: cells from which a block that the topology lacks is near.
//
// A topology is used up when a particle could leave it, and that is seen one step late: what the particles of step n
// reached is agreed on in step n + 1, and tables are renewed after it. Who is in the guard layer for the first time
// still has 3 cells to go, less what it moved in that step; no step moves a particle a whole cell. A sum of the largest
// displacements of all steps, the rule before, asks nobody where he is: a drop that spins in its place used it up.

#include <array>
#include <cstdint>

#include "core/data/block.hpp"

namespace moraine {

/// Bit per cell of a block: less than 3 cells away from its neighbour at offset `code`.
template <int Dim>
constexpr std::uint64_t guard_layer_towards(int code) {
    std::uint64_t guard_layer = 0;
    for (int cell = 0; cell < Block<Dim>::cells; ++cell) {
        bool near = true;
        for (int a = 0; a < Dim; ++a) {
            const int place = cell >> 2 * a & 3, eta = Block<Dim>::offset(code, a);
            near = near && (eta == 0 || (eta > 0 ? place > 0 : place < 3));
        }
        guard_layer |= std::uint64_t(near) << cell;
    }
    return guard_layer;
}

/// The same of all offsets.
template <int Dim>
inline constexpr auto guard_layers = [] {
    std::array<std::uint64_t, Block<Dim>::offsets> all{};
    for (int code = 0; code < Block<Dim>::offsets; ++code)
        all[static_cast<std::size_t>(code)] = guard_layer_towards<Dim>(code);
    return all;
}();

}  // namespace moraine
