#pragma once
// A small valley made in code: two layers fall on ground that bends both ways, with values of its law by raster, and a
// barrier stands in it.

#include <cmath>
#include <memory>

#include "core/sample_ground.hpp"
#include "sample_scenes.hpp"

namespace moraine::test {

/// rasters: mu, xi and su vary over the bed.
inline Scene small_valley(InterfaceLaw law, bool rasters) {
    Scene s = column();
    s.cell = 0.1;
    s.max = {3, 1.2, 1.6};
    s.periodic = {};
    for (auto& axis : s.walls)
        for (auto& wall : axis) wall.kind = WallKind::open;
    s.damping = 0;
    s.gravity = {0, 0, -9.81};
    const auto height = [](double x, double y) { return 0.9 - 0.35 * x + 0.05 * x * x + 0.3 * (y - 0.6) * (y - 0.6); };
    Ground ground = ground_of({-0.55, -0.55}, 26, 0.17, false, height);
    if (rasters)
        for (std::size_t k = 0; k < ground.height.size(); ++k) {
            const double wave = std::sin(0.7 * static_cast<double>(k));
            ground.friction.push_back(0.2 + 0.1 * wave);
            ground.xi.push_back(400 + 100 * wave);
            ground.su.push_back(500 + 200 * wave);
        }
    StructureSpec bed, barrier;
    bed.name = "terrain", bed.shape = StructureShape::ground, bed.ground = std::make_shared<Ground>(ground);
    bed.law = law, bed.friction = 0.3, bed.xi = 500, bed.density = 1500, bed.alpha = 0.5, bed.su = 600;
    barrier.name = "barrier", barrier.shape = StructureShape::box, barrier.law = InterfaceLaw::voellmy;
    barrier.friction = 0.2, barrier.xi = 300, barrier.density = 1500;
    barrier.min = {1.7, 0.3, 0.2}, barrier.max = {1.83, 0.7, 0.7};
    s.structures = {bed, barrier};
    s.materials = {material("drucker-prager", 1500, {{"young", 1e6}, {"poisson", 0.3}, {"friction_angle", 30}}),
                   material("von-mises", 1500, {{"young", 1e6}, {"poisson", 0.4}, {"su", 2000}})};
    s.bodies = {box({0.4, 0.3, 0.93}, {1.3, 0.9, 1.13}, 0), box({0.5, 0.4, 1.25}, {1.1, 0.8, 1.4}, 1)};
    for (BodySpec& body : s.bodies) body.velocity = {2, 0.3, -3};
    return s;
}

}  // namespace moraine::test
