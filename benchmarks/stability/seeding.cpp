#include "stability/seeding.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "verification/random_scene.hpp"

namespace moraine {

namespace {

using verification::Draw;
using Point = std::array<double, 2>;

constexpr int tries = 30;             ///< around a point, before it is given up
constexpr double disk_density = 0.7;  ///< particles times distance^2 over area, as the tries fill it

/// The points by cells of distance / sqrt(2), each of which holds one at most.
class Sieve {
  public:
    Sieve(const Triple& min, const Triple& max, double distance)
        : min_(min), max_(max), distance_(distance), cell_(distance / std::numbers::sqrt2) {
        for (std::size_t a = 0; a < 2; ++a) n_[a] = static_cast<int>((max[a] - min[a]) / cell_) + 1;
        at_.assign(static_cast<std::size_t>(n_[0] * n_[1]), -1);
    }
    bool take(const Point& x) {
        int c[2];
        for (std::size_t a = 0; a < 2; ++a) {
            if (x[a] < min_[a] || x[a] > max_[a]) return false;
            c[a] = static_cast<int>((x[a] - min_[a]) / cell_);
        }
        for (int j = std::max(0, c[1] - 2); j <= std::min(n_[1] - 1, c[1] + 2); ++j)
            for (int i = std::max(0, c[0] - 2); i <= std::min(n_[0] - 1, c[0] + 2); ++i) {
                const int other = at_[static_cast<std::size_t>(i + n_[0] * j)];
                if (other < 0) continue;
                const Point& y = points[static_cast<std::size_t>(other)];
                if (std::hypot(x[0] - y[0], x[1] - y[1]) < distance_) return false;
            }
        at_[static_cast<std::size_t>(c[0] + n_[0] * c[1])] = static_cast<int>(points.size());
        points.push_back(x);
        return true;
    }
    std::vector<Point> points;

  private:
    Triple min_, max_;
    double distance_, cell_;
    int n_[2]{};
    std::vector<int> at_;
};

void write_table(const std::vector<Point>& points, double mass, const std::string& path) {
    std::ofstream file(path);
    file << "x,y,mass\n";
    for (const Point& x : points) file << fmt::format("{:.17g},{:.17g},{:.17g}\n", x[0], x[1], mass);
    if (!file) throw std::runtime_error(path + " cannot be written");
}

}  // namespace

std::string Filling::name() const {
    switch (kind) {
        case jittered:
            return fmt::format("jitter {:g}", amount);
        case poisson_disk:
            return "Poisson disks";
        case rotated:
            return fmt::format("lattice at {:g} degrees", amount);
        default:
            return "lattice";
    }
}

std::vector<Point> poisson_disk(const Triple& min, const Triple& max, double distance, std::uint64_t seed) {
    Draw draw(seed);
    Sieve sieve(min, max, distance);
    sieve.take({draw.between(min[0], max[0]), draw.between(min[1], max[1])});
    std::vector<std::size_t> active{0};
    while (!active.empty()) {
        const auto pick = static_cast<std::size_t>(draw.below(static_cast<int>(active.size())));
        const Point from = sieve.points[active[pick]];
        bool found = false;
        for (int k = 0; k < tries && !found; ++k) {
            const double angle = draw.between(0, 2 * std::numbers::pi), r = distance * draw.between(1, 2);
            found = sieve.take({from[0] + r * std::cos(angle), from[1] + r * std::sin(angle)});
        }
        if (found)
            active.push_back(sieve.points.size() - 1);
        else
            active.erase(active.begin() + static_cast<std::ptrdiff_t>(pick));
    }
    return sieve.points;
}

std::vector<Point> turned_lattice(const Triple& min, const Triple& max, double spacing, double degrees) {
    const double c = std::cos(degrees * std::numbers::pi / 180), s = std::sin(degrees * std::numbers::pi / 180);
    const double middle[2] = {(min[0] + max[0]) / 2, (min[1] + max[1]) / 2};
    const int reach = static_cast<int>(std::hypot(max[0] - min[0], max[1] - min[1]) / (2 * spacing)) + 1;
    std::vector<Point> points;
    for (int j = -reach; j < reach; ++j)
        for (int i = -reach; i < reach; ++i) {
            const double along = (i + 0.5) * spacing, across = (j + 0.5) * spacing;
            const Point x{middle[0] + c * along - s * across, middle[1] + s * along + c * across};
            if (x[0] >= min[0] && x[0] < max[0] && x[1] >= min[1] && x[1] < max[1]) points.push_back(x);
        }
    return points;
}

void fill_body(Scene& scene, const Filling& filling, std::uint64_t seed, const std::string& folder) {
    BodySpec& body = scene.bodies[0];
    scene.seed = seed;
    if (filling.kind == Filling::jittered) body.seeding = Seeding::jittered, body.jitter = filling.amount;
    if (filling.kind == Filling::lattice || filling.kind == Filling::jittered) return;
    const double spacing = scene.cell / body.particles_per_cell[0];
    const auto points = filling.kind == Filling::rotated
                            ? turned_lattice(body.min, body.max, spacing, filling.amount)
                            : poisson_disk(body.min, body.max, spacing * std::sqrt(disk_density), seed);
    const double area = (body.max[0] - body.min[0]) * (body.max[1] - body.min[1]);
    body.file = folder + "/seeds.csv";
    body.shape = BodyShape::table;
    const double density = scene.materials[static_cast<std::size_t>(body.material)].density;
    write_table(points, density * area / static_cast<double>(points.size()), body.file);
}

}  // namespace moraine
