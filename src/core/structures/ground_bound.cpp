#include "core/structures/ground_bound.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace moraine {
namespace {

/// Control points, by their place in the table, on which the spline depends between two places.
struct ControlRange {
    std::int64_t first = 0, last = 0;
};

/// Returns whether the model has all of them.
bool control_points(const Vec<double, 2>* table, int axis, double low, double high, ControlRange& range) {
    const double from = (low - table[0][axis]) * table[1][0], to = (high - table[0][axis]) * table[1][0];
    if (!(from > -0.5 && to < table[3][axis] - 0.5)) return false;  // beyond them heights end, and planes do not
    range.first = static_cast<std::int64_t>(std::floor(from + 0.5));
    range.last = static_cast<std::int64_t>(std::floor(to + 0.5)) + 2;
    return true;
}

/// Of the control points less a plane.
struct Residual {
    double most = -std::numeric_limits<double>::infinity();
    double along = 0, across = 0;  ///< largest difference of neighbours [m]
};

template <int Dim>
Residual residual_of(const Vec<double, 2>* table, const GroundBound<Dim>& plane, const ControlRange (&range)[2]) {
    const auto row = static_cast<std::int64_t>(table[3][0]) + 2;
    const auto* c = reinterpret_cast<const double*>(table + 4);
    const double spacing = 1 / table[1][0];
    const auto at = [&](std::int64_t i, std::int64_t j) {
        double r = c[j * row + i] - plane.slope[0] * (table[0][0] + spacing * double(i - 1) - plane.middle[0]);
        if constexpr (Dim == 3) r -= plane.slope[1] * (table[0][1] + spacing * double(j - 1) - plane.middle[1]);
        return r;
    };
    Residual all;
    for (std::int64_t j = range[1].first; j <= range[1].last; ++j)
        for (std::int64_t i = range[0].first; i <= range[0].last; ++i) {
            const double r = at(i, j);
            all.most = std::max(all.most, r);
            if (i > range[0].first) all.along = std::max(all.along, std::fabs(r - at(i - 1, j)));
            if (j > range[1].first) all.across = std::max(all.across, std::fabs(r - at(i, j - 1)));
        }
    return all;
}

}  // namespace

template <int Dim>
GroundBound<Dim> bound_ground(const Structure<Dim>& ground, const Vec<double, 2>* corners,
                              const Vec<double, Dim>& middle, double half, double reach) {
    const Vec<double, 2>* table = corners + ground.first_corner;
    const double infinity = std::numeric_limits<double>::infinity();
    const double cosine = table[1][1], wide = half + 0.5 * ground.radius / cosine;  // and where feet may be
    GroundBound<Dim> bound{zero_vec<double, Dim>(), middle, infinity, infinity};
    ControlRange range[2] = {};
    for (int a = 0; a < Dim - 1; ++a)
        if (!control_points(table, a, middle[a] - wide, middle[a] + wide, range[a])) return bound;
    bound.slope = ground_at(table, middle).slope;
    const Residual rest = residual_of(table, bound, range);
    const double turns = std::hypot(rest.along, rest.across) * table[1][0];  // d
    const double steepest = magnitude(bound.slope) + turns;                  // m
    const double least = (1 - 2 * turns * std::min(steepest, 0.5)) / std::sqrt(1 + steepest * steepest);
    bound.clear = ground.radius / cosine;  // from here on surface() gives bounds above the reach
    if (least > 0) bound.clear = std::min(bound.clear, reach / least);
    const double rounding = 1e-9 * (half + std::fabs(table[2][0]) + std::fabs(table[2][1]));
    bound.top = rest.most + rounding;
    bound.clear += rounding;
    return bound;
}

template GroundBound<2> bound_ground(const Structure<2>&, const Vec<double, 2>*, const Vec<double, 2>&, double, double);
template GroundBound<3> bound_ground(const Structure<3>&, const Vec<double, 2>*, const Vec<double, 3>&, double, double);

}  // namespace moraine
