#include "core/structures/ground_curvature.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace moraine {
namespace {

constexpr int most_rounds = 400;
constexpr int sweeps = 5;  ///< of a round, between two looks at the curvature

/// k at node (i, j).
double curvature_at(const Ground& g, std::int64_t i, std::int64_t j) {
    const bool flat = g.count[1] == 1;
    const std::int64_t row = g.count[0] + 2, step = flat ? 0 : row;
    const auto* c = reinterpret_cast<const double*>(g.table.data() + 4) + (flat ? 0 : (j + 1) * row) + i + 1;
    const auto first = [&](const double* at, std::int64_t by) { return (at[by] - at[-by]) / (2 * g.spacing); };
    const auto second = [&](const double* at, std::int64_t by) {
        return (at[by] - 2 * at[0] + at[-by]) / (g.spacing * g.spacing);
    };
    const auto across = [&](std::int64_t by, const auto& f) {  // the spline's weights at a node
        return by == 0 ? f(c) : 0.125 * f(c - by) + 0.75 * f(c) + 0.125 * f(c + by);
    };
    const double bx = across(step, [&](const double* at) { return first(at, 1); });
    const double bxx = across(step, [&](const double* at) { return second(at, 1); });
    if (flat) return std::fabs(bxx) / std::pow(1 + bx * bx, 1.5);
    const double by = across(1, [&](const double* at) { return first(at, row); });
    const double byy = across(1, [&](const double* at) { return second(at, row); });
    const double bxy = (first(c + row, 1) - first(c - row, 1)) / (2 * g.spacing);
    const double square = 1 + bx * bx + by * by;
    const double mean = ((1 + by * by) * bxx - 2 * bx * by * bxy + (1 + bx * bx) * byy) / (2 * std::pow(square, 1.5));
    const double gauss = (bxx * byy - bxy * bxy) / (square * square);
    return std::fabs(mean) + std::sqrt(std::max(0.0, mean * mean - gauss));
}

/// Of a node's neighbours along one axis, their mean; where one is missing, on a line through the others.
double mean_of(const Ground& g, std::int64_t k, std::int64_t at, std::int64_t count, std::int64_t step) {
    const auto height = [&](std::int64_t n) { return g.height[static_cast<std::size_t>(n)]; };
    return at == 0 || at + 1 == count ? height(k) : 0.5 * (height(k - step) + height(k + step));
}

void relax(Ground& g, const std::vector<bool>& chosen, std::vector<double>& next) {
    next = g.height;
    for (std::int64_t j = 0; j < g.count[1]; ++j)
        for (std::int64_t i = 0; i < g.count[0]; ++i) {
            const std::int64_t k = j * g.count[0] + i;
            if (!chosen[static_cast<std::size_t>(k)]) continue;
            const double mean = 0.5 * (mean_of(g, k, i, g.count[0], 1) + mean_of(g, k, j, g.count[1], g.count[0]));
            double& z = next[static_cast<std::size_t>(k)];
            z += 0.5 * (mean - z);
        }
    g.height.swap(next);
}

/// Nodes that bend too much, and those next to them; none: all is well.
bool choose(const Ground& g, double most, std::vector<bool>& chosen) {
    chosen.assign(g.height.size(), false);
    bool any = false;
    for (std::int64_t j = 0; j < g.count[1]; ++j)
        for (std::int64_t i = 0; i < g.count[0]; ++i) {
            if (!(curvature_at(g, i, j) > most)) continue;
            any = true;
            for (std::int64_t b = std::max<std::int64_t>(0, j - 1); b <= std::min(g.count[1] - 1, j + 1); ++b)
                for (std::int64_t a = std::max<std::int64_t>(0, i - 1); a <= std::min(g.count[0] - 1, i + 1); ++a)
                    chosen[static_cast<std::size_t>(b * g.count[0] + a)] = true;
        }
    return any;
}

}  // namespace

double least_radius(const Ground& ground) {
    double most = 0;
    for (std::int64_t j = 0; j < ground.count[1]; ++j)
        for (std::int64_t i = 0; i < ground.count[0]; ++i) most = std::max(most, curvature_at(ground, i, j));
    return most > 0 ? 1 / most : std::numeric_limits<double>::infinity();
}

double smooth_ground(Ground& ground, double radius) {
    const std::vector<double> before = ground.height;
    std::vector<bool> chosen;
    std::vector<double> next;
    ground.fit();
    for (int round = 0; choose(ground, 1 / radius, chosen); ++round) {
        if (round == most_rounds) return std::numeric_limits<double>::quiet_NaN();
        for (int k = 0; k < sweeps; ++k) relax(ground, chosen, next);
        ground.fit();
    }
    double change = 0;
    for (std::size_t k = 0; k < before.size(); ++k) change = std::max(change, std::fabs(ground.height[k] - before[k]));
    return change;
}

}  // namespace moraine
