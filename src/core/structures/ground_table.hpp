#pragma once
// The table by which kernels know a ground (core/structures/ground.hpp): pairs of doubles.
//
// [0] place of node (0, 0); [1] 1 / a and the least cosine of slope that the control points allow; [2] lowest and
// highest control point; [3] nodes along x and y; from [4] on the control points, one more at each end of an axis than
// nodes, x fastest. What varies over the bed (friction, a largest shear stress) may follow as tables of the same form,
// of the values at the nodes: N spreads them over a node and a half, and no value goes beyond those around it.

#include <cstddef>

#include "core/data/vec.hpp"

namespace moraine {

template <int Dim>
struct GroundPoint {
    double height;           ///< b [m]
    Vec<double, Dim> slope;  ///< grad b; the last component is zero [-]
};

/// Of the three control points around t [nodes]; `first`: the lowest of them.
MORAINE_HD void ground_weights(double t, int count, int& first, double* w, double* dw) {
    const double last = count - 0.5;
    t = t < -0.5 ? -0.5 : (t > last ? last : t);
    first = static_cast<int>(t + 0.5);  // not negative: towards zero is down
    if (first > count - 1) first = count - 1;
    const double f = t - first, below = 0.5 - f, above = 0.5 + f;
    w[0] = 0.5 * below * below, w[1] = 0.75 - f * f, w[2] = 0.5 * above * above;
    dw[0] = -below, dw[1] = -2 * f, dw[2] = above;
}

/// b and its slope at x [m]; outside the model those of its edge.
template <int Dim>
MORAINE_HD GroundPoint<Dim> ground_at(const Vec<double, 2>* table, const Vec<double, Dim>& x) {
    const double inverse = table[1][0];
    double w[2][3], dw[2][3];
    int first[2] = {0, 0};
    for (int a = 0; a < Dim - 1; ++a)
        ground_weights((x[a] - table[0][a]) * inverse, static_cast<int>(table[3][a]), first[a], w[a], dw[a]);
    const double* c = reinterpret_cast<const double*>(table + 4) + first[0];
    GroundPoint<Dim> p{0, zero_vec<double, Dim>()};
    if constexpr (Dim == 2) {
        p.height = w[0][0] * c[0] + w[0][1] * c[1] + w[0][2] * c[2];
        p.slope[0] = inverse * (dw[0][0] * c[0] + dw[0][1] * c[1] + dw[0][2] * c[2]);
    } else {
        const auto row = static_cast<std::size_t>(table[3][0]) + 2;
        c += static_cast<std::size_t>(first[1]) * row;
        for (int j = 0; j < 3; ++j, c += row) {
            const double sum = w[0][0] * c[0] + w[0][1] * c[1] + w[0][2] * c[2];
            p.height += w[1][j] * sum;
            p.slope[0] += inverse * w[1][j] * (dw[0][0] * c[0] + dw[0][1] * c[1] + dw[0][2] * c[2]);
            p.slope[1] += inverse * dw[1][j] * sum;
        }
    }
    return p;
}

/// Of table number `which` behind the heights' own, at x [m].
template <int Dim>
MORAINE_HD double bed_value(const Vec<double, 2>* table, int which, const Vec<double, Dim>& x) {
    double w[2][3] = {}, dw[3], sum = 0;
    int first[2] = {0, 0};
    for (int a = 0; a < Dim - 1; ++a)
        ground_weights((x[a] - table[0][a]) * table[1][0], static_cast<int>(table[3][a]), first[a], w[a], dw);
    const auto row = static_cast<std::size_t>(table[3][0]) + 2;
    const std::size_t rows = Dim == 2 ? 1 : static_cast<std::size_t>(table[3][1]) + 2;
    const auto* c =
        reinterpret_cast<const double*>(table + 4 + static_cast<std::size_t>(1 + which) * ((row * rows + 1) / 2));
    c += static_cast<std::size_t>(first[1]) * row + static_cast<std::size_t>(first[0]);
    for (int j = 0; j < (Dim == 2 ? 1 : 3); ++j, c += row)
        sum += (Dim == 2 ? 1.0 : w[1][j]) * (w[0][0] * c[0] + w[0][1] * c[1] + w[0][2] * c[2]);
    return sum;
}

}  // namespace moraine
