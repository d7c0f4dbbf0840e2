#pragma once
// A scene with tractions.

#include "sample_scenes.hpp"
#include "seeding/traction_place.hpp"

namespace moraine::test {

/// Blocks between walls, pressed and sheared from above: one by a dead load that grows, one, which slides, by a
/// follower.
inline Scene blocks_under_load(int dimensions) {
    const auto up = static_cast<std::size_t>(dimensions - 1);
    Scene s;
    s.dimensions = dimensions;
    s.transfer = Transfer::flip;
    s.cell = 0.1;
    s.max = dimensions == 2 ? Triple{2.4, 1.4, 0} : Triple{2.4, 0.8, 1.4};
    s.gravity[up] = -9.81;
    for (std::size_t a = 0; a <= up; ++a) s.walls[a][0].kind = s.walls[a][1].kind = WallKind::free_slip;
    s.walls[up][0] = {WallKind::friction, 0.4};
    s.materials = {material("linear-elastic", 1500, {{"young", 2e5}, {"poisson", 0.3}}),
                   material("von-mises", 1600, {{"young", 2e5}, {"poisson", 0.4}, {"su", 2000}})};
    for (int k = 0; k < 2; ++k) {
        Triple min = {k == 0 ? 0.0 : 1.3, 0, 0}, max = {k == 0 ? 0.9 : 2.1, 0.8, 0};
        max[up] = 0.9;
        s.bodies.push_back(box(min, max, k));
        s.bodies.back().seeding = Seeding::lattice;
        TractionSpec load;
        load.body = k, load.follows = k == 1;
        load.normal[up] = 1, load.pressure = k == 0 ? 3000 : 2000, load.shear[0] = k == 0 ? 500 : -800;
        load.depth = 3 * s.cell;
        load.spacing = line_spacing(s, load);
        s.course.tractions.push_back(load);
    }
    s.bodies[1].velocity = {1, 0, 0};
    s.course.tractions[0].factor = {{0, 0.05}, {0.2, 1}};
    return s;
}

}  // namespace moraine::test
