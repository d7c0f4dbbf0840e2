#include "balance/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace moraine {

namespace {

constexpr double fading = 0.8;   ///< of older samples, per call
constexpr double lambda = 0.02;  ///< of the proportions that the build brings
constexpr double least = 0.1;    ///< of its proportion that a term keeps

/// Solves the 3 x 3 system of a positive definite matrix.
std::array<double, 3> solve(std::array<std::array<double, 3>, 3> m, std::array<double, 3> b) {
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t i = k + 1; i < 3; ++i) {
            const double factor = m[i][k] / m[k][k];
            for (std::size_t j = k; j < 3; ++j) m[i][j] -= factor * m[k][j];
            b[i] -= factor * b[k];
        }
    for (std::size_t k = 3; k-- > 0;) {
        for (std::size_t j = k + 1; j < 3; ++j) b[k] -= m[k][j] * b[j];
        b[k] /= m[k][k];
    }
    return b;
}

}  // namespace

/// Of each term [s].
std::array<double, 3> Calibration::predicted(const CostSample& s) const {
    return {1e-12 * static_cast<double>(start_.a) * s.particles, 1e-12 * static_cast<double>(start_.c) * s.cells,
            1e-12 * static_cast<double>(start_.d) * s.blocks};
}

void Calibration::add(std::span<const CostSample> samples) {
    for (auto& row : normal_)
        for (double& x : row) x *= fading;
    for (double& x : right_) x *= fading;
    measured_ *= fading, expected_ *= fading;
    for (const CostSample& s : samples) {
        if (s.seconds <= 0 || s.particles <= 0) continue;
        std::array<double, terms> feature = predicted(s);
        measured_ += s.seconds;
        for (double& f : feature) expected_ += f, f /= s.seconds;
        for (std::size_t i = 0; i < terms; ++i) {
            right_[i] += feature[i];
            for (std::size_t j = 0; j < terms; ++j) normal_[i][j] += feature[i] * feature[j];
        }
    }
}

CostModel Calibration::model() const {
    if (measured_ <= 0 || expected_ <= 0) return start_;
    // In units of s: features are then near one, whatever the machine.
    const double scale = measured_ / expected_;
    std::array<std::array<double, terms>, terms> matrix{};
    std::array<double, terms> right{};
    for (std::size_t i = 0; i < terms; ++i) {
        right[i] = scale * right_[i] + lambda;
        for (std::size_t j = 0; j < terms; ++j) matrix[i][j] = scale * scale * normal_[i][j] + (i == j ? lambda : 0);
    }
    const std::array<double, terms> factor = solve(matrix, right);
    const auto refined = [&](std::int64_t constant, double f) {
        return std::llround(static_cast<double>(constant) * scale * std::max(least, f));
    };
    return {refined(start_.a, factor[0]), refined(start_.c, factor[1]), refined(start_.d, factor[2])};
}

}  // namespace moraine
