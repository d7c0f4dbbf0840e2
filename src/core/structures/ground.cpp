#include "core/structures/ground.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace moraine {

namespace {

/// Solves (c_{i-1} + 6 c_i + c_{i+1}) / 8 = b_i in place for n values `step` apart; the ends keep theirs, which is the
/// same as a line beyond them.
void fit_line(double* b, std::int64_t n, std::int64_t step, std::vector<double>& upper) {
    upper.assign(static_cast<std::size_t>(n), 0.0);
    for (std::int64_t i = 1; i + 1 < n; ++i) {
        const double pivot = 6 - upper[static_cast<std::size_t>(i - 1)];
        upper[static_cast<std::size_t>(i)] = 1 / pivot;
        b[i * step] = (8 * b[i * step] - b[(i - 1) * step]) / pivot;
    }
    for (std::int64_t i = n - 2; i > 0; --i) b[i * step] -= upper[static_cast<std::size_t>(i)] * b[(i + 1) * step];
}

/// Points that go on in a line at both ends, of n values from `b` on, `step` apart.
void extend_line(double* b, std::int64_t n, std::int64_t step) {
    const double* last = b + (n - 1) * step;
    b[-step] = n > 1 ? 2 * b[0] - b[step] : b[0];
    b[n * step] = n > 1 ? 2 * last[0] - last[-step] : last[0];
}

/// Largest slope between neighbours `step` apart, of n in a row.
double steepest(const double* c, std::int64_t n, std::int64_t step, double spacing) {
    double most = 0;
    for (std::int64_t i = 0; i + 1 < n; ++i) most = std::max(most, std::fabs(c[(i + 1) * step] - c[i * step]));
    return most / spacing;
}

void append_pairs(const std::vector<double>& c, std::vector<Vec<double, 2>>& table) {
    for (std::size_t k = 0; k < c.size(); k += 2) table.push_back({{c[k], k + 1 < c.size() ? c[k + 1] : 0.0}});
}

}  // namespace

void Ground::fit() {
    const std::int64_t nx = count[0], ny = count[1];
    const bool flat = ny == 1;  // a profile: one row, and none beside it
    const std::int64_t row = nx + 2, rows = flat ? 1 : ny + 2;
    std::vector<double> c(static_cast<std::size_t>(row * rows), 0.0), upper;
    double* node = c.data() + (flat ? 0 : row) + 1;
    for (std::int64_t j = 0; j < ny; ++j) {
        std::copy_n(height.data() + j * nx, nx, node + j * row);
        fit_line(node + j * row, nx, 1, upper);
    }
    for (std::int64_t i = 0; i < nx && !flat; ++i) fit_line(node + i, ny, row, upper);
    for (std::int64_t j = 0; j < ny; ++j) extend_line(node + j * row, nx, 1);
    for (std::int64_t i = -1; i <= nx && !flat; ++i) extend_line(node + i, ny, row);
    double along = 0, across = 0;
    for (std::int64_t j = 0; j < rows; ++j) along = std::max(along, steepest(c.data() + j * row, row, 1, spacing));
    for (std::int64_t i = 0; i < row && !flat; ++i)
        across = std::max(across, steepest(c.data() + i, rows, row, spacing));
    const auto [low, high] = std::minmax_element(c.begin(), c.end());
    table = {{{first[0], first[1]}},
             {{1 / spacing, 1 / std::sqrt(1 + along * along + across * across)}},
             {{*low, *high}},
             {{static_cast<double>(nx), static_cast<double>(ny)}}};
    append_pairs(c, table);
}

void append_bed(const Ground& ground, const std::vector<double>& values, std::vector<Vec<double, 2>>& table) {
    const std::int64_t nx = ground.count[0], ny = ground.count[1];
    const std::int64_t below = ny == 1 ? 0 : 1;  // a profile has no row beside its own
    std::vector<double> c;
    for (std::int64_t j = -below; j < ny + below; ++j)
        for (std::int64_t i = -1; i <= nx; ++i)
            c.push_back(values[static_cast<std::size_t>(std::clamp<std::int64_t>(j, 0, ny - 1) * nx +
                                                        std::clamp<std::int64_t>(i, 0, nx - 1))]);
    append_pairs(c, table);
}

double raster_value(const Ground& raster, double x, double y) {
    const std::array<double, 2> place{x, y};
    std::array<std::int64_t, 2> low{};
    std::array<double, 2> part{};
    for (std::size_t a = 0; a < 2; ++a) {
        const double t = (place[a] - raster.first[a]) / raster.spacing, last = static_cast<double>(raster.count[a] - 1);
        if (!(t >= -0.5 - 1e-9 && t <= last + 0.5 + 1e-9)) return std::numeric_limits<double>::quiet_NaN();
        const double inside = std::clamp(t, 0.0, last);
        low[a] = std::min(static_cast<std::int64_t>(inside), std::max<std::int64_t>(raster.count[a] - 2, 0));
        part[a] = inside - static_cast<double>(low[a]);
    }
    double sum = 0, weights = 0;
    for (std::int64_t j = 0; j < 2; ++j)
        for (std::int64_t i = 0; i < 2; ++i) {
            const double w = (i == 0 ? 1 - part[0] : part[0]) * (j == 0 ? 1 - part[1] : part[1]);
            if (!(w > 0)) continue;
            const double value = raster.height[static_cast<std::size_t>((low[1] + j) * raster.count[0] + low[0] + i)];
            if (!std::isnan(value)) sum += w * value, weights += w;
        }
    return weights > 0 ? sum / weights : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace moraine
