#pragma once
// The elastic block of the contact problems C1 to C7, on a rigid plane through the origin at any angle to the grid.

#include "core/structures/structure_set.hpp"
#include "records/time_series.hpp"
#include "verification/run.hpp"

namespace moraine::verification {

/// Sizes of the block, and gravity.
struct Brick {
    double h = 0.0125;  ///< cell [m]
    double density = 1000, height = 0.05, width = 0.1, gravity = 9.81;
    double slope = 0;  ///< gravity against the plane's normal [rad]
    double tilt = 0;   ///< of the plane against the grid [rad]
    double lift = 0;   ///< of the plane over a node [cells]
    double speed = 0;  ///< along the plane at the start [m/s]

    double mass() const { return density * height * width; }  ///< per metre [kg]
    double weight() const { return mass() * gravity; }
};

inline Triple turned(double along, double up, double angle) {
    return {along * std::cos(angle) - up * std::sin(angle), along * std::sin(angle) + up * std::cos(angle), 0};
}

inline Scene block_scene(const Brick& b, InterfaceLaw law) {
    Scene scene;
    scene.transfer = Transfer::flip;
    scene.dimensions = 2;
    scene.cell = b.h;
    scene.min = {-80 * b.h, -80 * b.h, 0};
    scene.max = {80 * b.h, 80 * b.h, 0};
    if (b.tilt == 0) make_periodic(scene, 0);
    scene.gravity = turned(b.gravity * std::sin(b.slope), -b.gravity * std::cos(b.slope), b.tilt);
    scene.materials.push_back(material("linear-elastic", b.density, {{"young", 1e6}, {"poisson", 0.3}}));
    BodySpec body;
    body.velocity = turned(b.speed, 0, b.tilt);
    body.min = {0, b.lift * b.h, 0};
    body.max = {b.width, b.lift * b.h + b.height, 0};
    if (b.tilt != 0) {
        body.shape = BodyShape::polygon;
        for (const auto& [x, y] :
             {std::pair(0.0, 0.0), std::pair(b.width, 0.0), std::pair(b.width, b.height), std::pair(0.0, b.height)}) {
            const Triple corner = turned(x, y + b.lift * b.h, b.tilt);
            body.points.push_back({corner[0], corner[1]});
        }
    }
    scene.bodies.push_back(body);
    StructureSpec plane;
    plane.name = "plane";
    plane.normal = turned(0, 1, b.tilt);
    plane.point = turned(0, b.lift * b.h, b.tilt);
    plane.law = law;
    plane.friction = std::tan(15 * pi / 180);
    scene.structures.push_back(plane);
    return scene;
}

/// A run that knows how far its particles have moved in the mean, and what the first structure felt.
struct ContactRun {
    explicit ContactRun(const Scene& scene) : scene_(scene), run(scene_) {}

    void until(double time) {
        while (run.time() < time) run.steps(100);
    }

    /// Mean displacement along a direction [m].
    double moved(const Triple& along) {
        const double n = run.sum([](const auto&, std::uint32_t, const auto&, const auto&) { return 1.0; });
        const double sum = run.sum([&](const auto&, std::uint32_t, const auto& X, const auto& x) {
            double way = 0;
            for (std::size_t a = 0; a < 2; ++a)
                way += along[a] * std::remainder(x[a] - X[a], scene_.max[a] - scene_.min[a]);
            return way;
        });
        return sum / n;
    }

    /// Impulse on the first structure along a direction since the start [N s].
    double impulse(const Triple& along) {
        std::vector<StructureSums<2>> felt;
        for (const StructureState<2>& s : run.sim.structures().states()) felt.push_back(s.felt);
        const StructureSums<2> all = run.sim.comm().exact_sums(felt)[0];
        return run.sim.quantum().value(all.sum[0]) * along[0] + run.sim.quantum().value(all.sum[1]) * along[1];
    }

  private:
    Scene scene_;

  public:
    Run<> run;
};

}  // namespace moraine::verification
