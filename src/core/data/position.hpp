#pragma once
// Where a particle is: per axis a fixed-point number relative to its block's binning origin, in cells.
//
//   u = 2 bits of cell, the rest fraction;   x = min + h (4 B + u / 2^bits - offset)
//
// offset is 1/2 for stencils of three nodes (binned at floor(x/h - 1/2), block 0 starts at node -1)
// and 0 for linear and cubic. The cell is the top bits, a change of block is a carry, and no kernel
// calls floor() on a position. An fp32 offset of up to 4 cells would be 8 times coarser, round up
// across a face now and then, and stall at small speeds.

#include <cmath>
#include <cstdint>

#include "core/data/vec.hpp"

namespace moraine {

template <class Real>
struct Fixed;

template <>
struct Fixed<float> {
    using Unsigned = std::uint32_t;
    using Signed = std::int32_t;
};

template <>
struct Fixed<double> {
    using Unsigned = std::uint64_t;
    using Signed = std::int64_t;
};

template <class Real>
using Coordinate = typename Fixed<Real>::Unsigned;

template <class Real>
inline constexpr int fraction_bits = int(sizeof(Real)) * 8 - 2;

/// One cell as a fixed-point number.
template <class Real>
inline constexpr Coordinate<Real> one_cell = Coordinate<Real>(1) << fraction_bits<Real>;

/// Cell of the block along one axis, 0 to 3.
template <class Real>
MORAINE_HD int cell_of(Coordinate<Real> u) {
    return static_cast<int>(u >> fraction_bits<Real>);
}

/// Place within the cell, 0 to 1 [cells].
template <class Real>
MORAINE_HD Real fraction_of(Coordinate<Real> u) {
    using Signed = typename Fixed<Real>::Signed;
    return static_cast<Real>(static_cast<Signed>(u & (one_cell<Real> - 1))) * (Real(1) / Real(one_cell<Real>));
}

/// Moves u by `cells` (magnitude below 1) and returns the change of block: -1, 0 or 1.
template <class Real>
MORAINE_HD int advance(Coordinate<Real>& u, Real cells) {
    using std::llrint;
    using Signed = typename Fixed<Real>::Signed;
    const Signed step = static_cast<Signed>(llrint(cells * Real(one_cell<Real>)));
    const Coordinate<Real> old = u;
    u += static_cast<Coordinate<Real>>(step);
    return step >= 0 ? (u < old ? 1 : 0) : (u > old ? -1 : 0);
}

/// Block and fixed-point place of `local` = (x - min)/h + offset. Not for kernels.
template <class Real>
struct Place {
    std::int32_t block;
    Coordinate<Real> u;
};

template <class Real>
Place<Real> place(double local) {
    double block = std::floor(local / 4);
    double scaled = std::nearbyint((local - 4 * block) * double(one_cell<Real>));
    if (scaled >= 4 * double(one_cell<Real>)) block += 1, scaled = 0;
    return {static_cast<std::int32_t>(block), static_cast<Coordinate<Real>>(scaled)};
}

/// Inverse of place(): (x - min)/h + offset.
template <class Real>
MORAINE_HD double local_of(std::int32_t block, Coordinate<Real> u) {
    return 4.0 * block + double(u) / double(one_cell<Real>);
}

}  // namespace moraine
