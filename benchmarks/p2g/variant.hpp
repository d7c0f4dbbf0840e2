#pragma once
// A way to sum particles to nodes: `sum` is timed, then `bring` (tiles to grid; nothing for variants
// that write the grid itself), timed on its own.

#include <functional>
#include <string>
#include <vector>

#include "p2g/sample.hpp"

namespace moraine {

template <class Real>
struct Variant {
    std::string name;
    std::function<void()> sum;
    std::function<void(GridSums<Real>&)> bring;
    double bytes;     ///< moved by `sum` between core and memory, per particle, estimated
    const char* why;  ///< it won or lost
    int threads = 1;
};

/// Bytes of a particle that each pass must read.
template <class Real>
inline constexpr double read_bytes = 4 + 14 * double(sizeof(Real));

/// Bytes of a block's tile, per particle.
template <class Real>
inline constexpr double tile_bytes = double(node_reals * sizeof(Real)) * Sample<Real>::tile_nodes / 512;

}  // namespace moraine
