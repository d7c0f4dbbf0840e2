#include "seeding/inflow.hpp"

#include <algorithm>
#include <cmath>

#include "core/structures/ground.hpp"
#include "seeding/seed_layer.hpp"

namespace moraine {
namespace {

/// Integral at the rows of what is linear between them.
std::vector<double> sums_of(const std::vector<double>& time, const std::vector<double>& rate) {
    std::vector<double> sums{0};
    for (std::size_t k = 1; k < time.size(); ++k)
        sums.push_back(sums.back() + 0.5 * (rate[k] + rate[k - 1]) * (time[k] - time[k - 1]));
    return sums;
}

}  // namespace

Inflow::Inflow(const Scene& scene, const BodySpec& body)
    : body_(body),
      time_(body.hydrograph->time),
      discharge_(body.hydrograph->discharge),
      speed_(body.hydrograph->speed),
      ways_(sums_of(time_, speed_)),
      volumes_(sums_of(time_, discharge_)) {
    place_columns(scene.cell / body.particles_per_cell[1]);
    cut_layers(scene.cell / body.particles_per_cell[0], scene.cell / body.particles_per_cell[2], scene.end);
}

/// The row behind which t lies; the last but one is the last.
std::size_t Inflow::row_at(double t) const {
    const auto above = std::upper_bound(time_.begin(), time_.end(), t);
    const auto row = std::max<std::ptrdiff_t>(above - time_.begin() - 1, 0);
    return std::min(static_cast<std::size_t>(row), time_.size() - 2);
}

double Inflow::integral_at(const std::vector<double>& rate, const std::vector<double>& sums, double t) const {
    const std::size_t k = row_at(t);
    const double u = std::clamp(t - time_[k], 0.0, time_[k + 1] - time_[k]);
    const double change = (rate[k + 1] - rate[k]) / (time_[k + 1] - time_[k]);
    return sums[k] + u * (rate[k] + 0.5 * change * u);
}

double Inflow::speed_at(double t) const {
    const std::size_t k = row_at(t);
    const double u = std::clamp((t - time_[k]) / (time_[k + 1] - time_[k]), 0.0, 1.0);
    return speed_[k] + u * (speed_[k + 1] - speed_[k]);
}

/// When s has gone so far; it is on its way there.
double Inflow::time_at(double way) const {
    const auto above = std::upper_bound(ways_.begin(), ways_.end(), way);
    const std::size_t k =
        std::min(static_cast<std::size_t>(std::max<std::ptrdiff_t>(above - ways_.begin() - 1, 0)), ways_.size() - 2);
    const double left = way - ways_[k], change = (speed_[k + 1] - speed_[k]) / (time_[k + 1] - time_[k]);
    return time_[k] + 2 * left / (speed_[k] + std::sqrt(std::max(0.0, speed_[k] * speed_[k] + 2 * change * left)));
}

/// As many as the spacing goes into each piece of the line.
void Inflow::place_columns(double spacing) {
    for (std::size_t k = 0; k + 1 < body_.points.size(); ++k) {
        const std::array<double, 2>&from = body_.points[k], &to = body_.points[k + 1];
        const double dx = to[0] - from[0], dy = to[1] - from[1], length = std::hypot(dx, dy);
        const std::int64_t count = std::max<std::int64_t>(1, std::llround(length / spacing));
        for (std::int64_t i = 0; i < count; ++i) {
            const double t = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
            Column c{{from[0] + t * dx, from[1] + t * dy}, {-dy / length, dx / length}, 0};
            const auto slope = ground_at<3>(body_.ground->table.data(), {{c.x[0], c.x[1], 0}}).slope;
            const double rise = (slope[0] * dx + slope[1] * dy) / length;
            c.share = length / static_cast<double>(count) * std::sqrt(1 + rise * rise);
            length_ += c.share;
            columns_.push_back(c);
        }
    }
    for (Column& c : columns_) c.share /= length_;
}

void Inflow::cut_layers(double thickness, double spacing, double end) {
    const double last = std::min(time_.back(), end), way = way_at(last);
    std::int64_t number = 0;
    double before = 0, before_way = 0;
    const auto add = [&](double time, double at) {
        const double sum = volume_at(time), part = sum - before, thick = at - before_way;
        before = sum, before_way = at;
        if (!(part > 0 && thick > 0)) return;
        const double depth = part / (length_ * thick);
        const std::int64_t particles = std::max<std::int64_t>(1, std::llround(depth / spacing));
        layers_.push_back({time, at, thick, part, depth, speed_at(time), number, particles});
        number += particles * static_cast<std::int64_t>(columns_.size());
        volume_ += part;
    };
    const auto whole = static_cast<std::int64_t>(std::floor(way / thickness * (1 + 1e-12)));
    for (std::int64_t k = 1; k < whole; ++k)
        add(time_at(static_cast<double>(k) * thickness), static_cast<double>(k) * thickness);
    add(last, way);  // the last one is up to twice as thick as the others
}

std::int64_t Inflow::count(std::int64_t first, std::int64_t last) const {
    std::int64_t sum = 0;
    for (std::int64_t k = first; k < last; ++k)
        sum += layers_[static_cast<std::size_t>(k)].particles * static_cast<std::int64_t>(columns_.size());
    return sum;
}

double Inflow::deepest() const {
    double most = 0;
    for (const LayerOf& layer : layers_) most = std::max(most, layer.depth);
    return most;
}

Inflow::Foot Inflow::foot_of(const Column& column, double ahead) const {
    const Vec<double, 2>* table = body_.ground->table.data();
    const auto slope_along = [&](const GroundPoint<3>& b) {
        return b.slope[0] * column.across[0] + b.slope[1] * column.across[1];
    };
    const double rise = slope_along(ground_at<3>(table, {{column.x[0], column.x[1], 0}}));
    const double plan = ahead / std::sqrt(1 + rise * rise);
    const double x = column.x[0] + plan * column.across[0], y = column.x[1] + plan * column.across[1];
    const GroundPoint<3> b = ground_at<3>(table, {{x, y, 0}});
    const double sec = secant_of(b);
    const double there = slope_along(b), run = std::sqrt(1 + there * there);
    return {{x, y, b.height},
            {-b.slope[0] / sec, -b.slope[1] / sec, 1 / sec},
            {column.across[0] / run, column.across[1] / run, there / run}};
}

double peak_depth(const BodySpec& body) {
    double length = 0, most = 0;
    for (std::size_t k = 1; k < body.points.size(); ++k)
        length += std::hypot(body.points[k][0] - body.points[k - 1][0], body.points[k][1] - body.points[k - 1][1]);
    const Hydrograph& h = *body.hydrograph;
    for (std::size_t k = 0; k < h.time.size(); ++k) most = std::max(most, h.discharge[k] / h.speed[k] / length);
    return most;
}

}  // namespace moraine
