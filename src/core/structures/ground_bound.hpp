#pragma once
// A plane over the ground of one block: what stands above it needs no foot point.
//
//   b(x) <= top + s . (x - middle)        for x within the block, and as far beyond it as a foot point may be
//
// s is the slope of the ground at the block's middle. b less the plane s is a spline whose control points are those of
// b less the plane at their nodes, as N reproduces lines: it lies between the least and the largest of them, and its
// slope between their differences, which are at most d. The distance by one foot point q
// (core/structures/structure.hpp) is
//   n_z (g - (grad b(q) - mean of grad b from x to q) . (q - x))  >=  g (1 - 2 d k) / sqrt(1 + m^2)
// with g = z - b(x), m = |s| + d and k = min(m, 1 / 2), since |q - x| = g |grad b| / (1 + |grad b|^2). So whoever is
// more than `clear` above the plane is out of the reach of contact, whatever the exact distance. Results do not change:
// only what would be thrown away is not computed. A plane per block follows slopes, which a largest height per cell
// does not; it holds for an epoch, as pairs of blocks and structures do (blocks/contact_pairs.hpp).

#include "core/structures/structure.hpp"

namespace moraine {

template <int Dim>
struct GroundBound {
    Vec<double, Dim> slope;   ///< s; the last component is zero [-]
    Vec<double, Dim> middle;  ///< of the block [m]
    double top;               ///< height of the plane there [m]
    double clear;             ///< [m]; infinite: nothing is known

    /// Height over the plane.
    MORAINE_HD double above(const Vec<double, Dim>& x) const {
        double height = x[Dim - 1] - top;
        for (int a = 0; a < Dim - 1; ++a) height -= slope[a] * (x[a] - middle[a]);
        return height;
    }
    /// Whether a point of the block is certainly not in the ground.
    MORAINE_HD bool is_over(const Vec<double, Dim>& x) const { return above(x) > 0; }
    /// Whether it is certainly further off than the reach.
    MORAINE_HD bool is_clear(const Vec<double, Dim>& x) const { return above(x) > clear; }
    /// Whether all of the block is.
    bool is_clear_block(double half) const {
        double height = middle[Dim - 1] - half - top;
        for (int a = 0; a < Dim - 1; ++a) height -= std::fabs(slope[a]) * half;
        return height > clear;
    }
};

/// Of a block of side 2 `half` around `middle`; `reach`: from where distances do not matter. All in metres.
template <int Dim>
GroundBound<Dim> bound_ground(const Structure<Dim>& ground, const Vec<double, 2>* corners,
                              const Vec<double, Dim>& middle, double half, double reach);

}  // namespace moraine
