#pragma once
// C8: layers of soil on a bed, from thinner than a cell to eight cells thick: how deep particles go, how high the layer
// hovers, how it accelerates and what drags on it.
//
// Gravity makes 24 degrees with the normal of the bed, a plane turned against the grid or the top of a cylinder of
// 80 cells radius. The layer is 16 cells long, or five times as long as it is thick, of rows as far apart as its
// particles, at most h/2; its lowest row begins half of that over the bed. After 40 cells of path (20 on the cylinder)
// by a rigid block the run ends.

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>

#include "core/structures/structure_set.hpp"
#include "verification/run.hpp"

namespace moraine::verification {

enum class Soil { bingham, sand, plug };  ///< plug: a Bingham soil that does not yield

struct SlidingLayer {
    double turn;       ///< of the grid [deg]; below 0: on the cylinder
    double thickness;  ///< [cells]
    InterfaceLaw law;
    Soil soil;
    Transfer transfer;

    bool on_cylinder() const { return turn < 0; }
    std::string name() const {
        const char* laws[] = {"smooth", "rough", "coulomb", "undrained"};
        return fmt::format("{}, {} cells, {}, {}, {}", on_cylinder() ? "cylinder" : fmt::format("{} degrees", turn),
                           thickness, laws[static_cast<int>(law)],
                           soil == Soil::sand ? "sand" : (soil == Soil::plug ? "plug" : "Bingham"),
                           transfer == Transfer::flip ? "FLIP" : "APIC");
    }
};

struct Measured {
    double deepest = 0;       ///< particle under the bed [cells]
    double deep = 0;          ///< share of the particles deeper than 0.15 cells
    double hover = 0;         ///< mean over the layer [cells]
    double acceleration = 0;  ///< over the rigid block's, less 1
    double drag = 0;          ///< over alpha su A, less 1
    double path = 0;          ///< [cells]
};

class LayerProblem {
  public:
    static constexpr double h = 1.25, density = 1900, g = 9.81, slope = 24 * pi / 180, friction = 0.2, cap = 150;
    static constexpr double radius = 80;                                    ///< [cells]
    double length() const { return std::max(16.0, 5 * layer_.thickness); }  ///< [cells]

    explicit LayerProblem(const SlidingLayer& layer)
        : layer_(layer), turn_(layer.on_cylinder() ? 0 : layer.turn * pi / 180) {}

    /// Both from the particles' places.
    double height(const std::array<double, 2>& x) const {
        if (layer_.on_cylinder()) return std::hypot(x[0] - middle_[0], x[1] - middle_[1]) / h - radius;
        return (-(x[0] - middle_[0]) * std::sin(turn_) + (x[1] - middle_[1]) * std::cos(turn_)) / h;
    }
    double along(const std::array<double, 2>& x) const {
        if (layer_.on_cylinder()) return radius * std::atan2(x[0] - middle_[0], x[1] - middle_[1]);
        return ((x[0] - middle_[0]) * std::cos(turn_) + (x[1] - middle_[1]) * std::sin(turn_)) / h;
    }

    /// Acceleration of a rigid block [m/s2].
    double rigid() const {
        const double weight = density * g * layer_.thickness * h;
        switch (layer_.law) {
            case InterfaceLaw::coulomb:
                return g * (std::sin(slope) - friction * std::cos(slope));
            case InterfaceLaw::undrained:
                return g * (std::sin(slope) - cap / weight);
            default:
                return g * std::sin(slope);
        }
    }
    double path() const { return (layer_.on_cylinder() ? 20 : 40) * h; }
    double end() const { return std::sqrt(2 * path() / rigid()); }

    Scene scene() {
        Scene scene;
        scene.transfer = layer_.transfer;
        scene.limits_light_nodes = true;
        scene.dimensions = 2;
        scene.cell = h;
        scene.gravity = turned(g * std::sin(slope), -g * std::cos(slope));
        scene.min = {-200 * h, -200 * h, 0};
        scene.max = {200 * h, 200 * h, 0};
        middle_ = {0.37 * h, layer_.on_cylinder() ? -80.21 * h : 0.29 * h};
        scene.materials.push_back(
            layer_.soil == Soil::sand
                ? material("drucker-prager", density, {{"young", 5e6}, {"poisson", 0.3}, {"friction_angle", 33}})
                : material("bingham", density,
                           {{"young", 2e6},
                            {"poisson", 0.45},
                            {"viscosity", 100},
                            {"yield_stress", layer_.soil == Soil::plug ? 1e6 : 300}}));
        BodySpec body;
        body.shape = BodyShape::table;
        body.file = write_table();
        scene.bodies.push_back(body);
        StructureSpec bed;
        bed.name = "bed";
        bed.law = layer_.law;
        bed.friction = friction;
        bed.alpha = 0.5, bed.su = 2 * cap;
        if (layer_.on_cylinder()) {
            bed.shape = StructureShape::sphere;
            bed.center = {middle_[0], middle_[1], 0};
            bed.radius = radius * h;
        } else {
            bed.normal = turned(0, 1);
            bed.point = {middle_[0], middle_[1], 0};
        }
        scene.structures.push_back(bed);
        return scene;
    }

    /// Rows of squares of volume `size`^2, curved with the bed.
    std::string write_table() {
        const double size = std::min(0.5, layer_.thickness);
        const std::string file =
            (std::filesystem::temp_directory_path() / fmt::format("moraine_layer_{}.csv", getpid())).string();
        std::ofstream out(file);
        out << "x,y,mass\n";
        const auto rows = std::lround(layer_.thickness / size), columns = std::lround(length() / size);
        for (long i = 0; i < columns; ++i)
            for (long j = 0; j < rows; ++j) {
                const double s = (static_cast<double>(i) + 0.5) * size - 0.5 * length();
                const double n = (static_cast<double>(j) + 0.5) * size;
                const Triple at = layer_.on_cylinder() ? Triple{(radius + n) * std::sin(s / radius) * h,
                                                                (radius + n) * std::cos(s / radius) * h, 0}
                                                       : turned(s * h, n * h);
                out << fmt::format("{:.17g},{:.17g},{:.17g}\n", middle_[0] + at[0], middle_[1] + at[1],
                                   density * size * size * h * h);
            }
        return file;
    }

    /// Unit vector along the bed, of a plane.
    Triple down() const { return turned(1, 0); }

  private:
    Triple turned(double s, double n) const {
        return {s * std::cos(turn_) - n * std::sin(turn_), s * std::sin(turn_) + n * std::cos(turn_), 0};
    }

    SlidingLayer layer_;
    double turn_;
    std::array<double, 2> middle_{};
};

/// Mean distance of the particles from the bed less half of the thickness, by columns of two cells but for those near
/// the ends [cells].
inline double hover_of(const LayerProblem& problem, Run<>& run) {
    struct Column {
        double volume = 0, moment = 0;
    };
    constexpr double width = 2;
    std::map<long, Column> columns;
    run.sum([&](const auto& p, std::uint32_t s, const auto&, const auto& x) {
        Column& c = columns[std::lround(std::floor(problem.along(x) / width))];
        const double volume = p.volume[s] / (LayerProblem::h * LayerProblem::h);
        c.volume += volume, c.moment += volume * problem.height(x);
        return 0.0;
    });
    double volume = 0, moment = 0;
    for (const auto& [at, c] : columns) {
        const auto filled = [&](long k) { return columns.count(k) && columns[k].volume > 0.25 * c.volume; };
        if (!(filled(at - 2) && filled(at - 1) && filled(at + 1) && filled(at + 2))) continue;
        volume += c.volume, moment += c.moment - c.volume * 0.5 * c.volume / width;
    }
    return volume > 0 ? moment / volume : 0;
}

inline Measured measure(const SlidingLayer& layer, double share = 1) {
    LayerProblem problem(layer);
    const Scene scene = problem.scene();  // the run refers to it
    Run<> run(scene);
    std::filesystem::remove(scene.bodies[0].file);
    const auto speed = [&] {
        return run.sum([&](const auto& p, std::uint32_t s, const auto&, const auto&) {
            return p.velocity[s][0] * problem.down()[0] + p.velocity[s][1] * problem.down()[1];
        }) / static_cast<double>(run.particles());
    };
    const auto way = [&] {
        return run.sum([&](const auto&, std::uint32_t, const auto& X, const auto& x) {
            return problem.along(x) - problem.along(X);
        }) / static_cast<double>(run.particles());
    };
    const auto drag = [&] {
        const StructureSums<2>& felt = run.sim.structures().state(0).felt;
        return run.sim.quantum().value(felt.sum[0]) * problem.down()[0] +
               run.sim.quantum().value(felt.sum[1]) * problem.down()[1];
    };
    const double end = share * problem.end();
    while (run.time() < 0.5 * end && way() < 0.5 * problem.path() / LayerProblem::h) run.steps(10);
    const double t = run.time(), v = speed(), impulse = drag();
    while (run.time() < end && way() < problem.path() / LayerProblem::h) run.steps(10);
    Measured m;
    m.acceleration = (speed() - v) / (run.time() - t) / problem.rigid() - 1;
    m.drag = (drag() - impulse) / (run.time() - t) / (LayerProblem::cap * problem.length() * LayerProblem::h) - 1;
    m.deepest = run.largest([&](const auto&, std::uint32_t, const auto&, const auto& x) { return -problem.height(x); });
    m.deep = run.sum([&](const auto&, std::uint32_t, const auto&, const auto& x) {
        return problem.height(x) < -0.15 ? 1.0 : 0.0;
    }) / static_cast<double>(run.particles());
    m.hover = hover_of(problem, run);
    m.path = way();
    return m;
}

}  // namespace moraine::verification
