#pragma once
// A scene with ends that absorb.

#include "sample_scenes.hpp"

namespace moraine::test {

/// Ground at rest on ends that absorb, below and beside it, which a block strikes: waves go out. A stone flies over it
/// from block to block of cells.
inline Scene ground_on_ends(int dimensions) {
    const auto up = static_cast<std::size_t>(dimensions - 1);
    Scene s;
    s.dimensions = dimensions;
    s.transfer = Transfer::flip;
    s.cell = 0.1;
    s.max = dimensions == 2 ? Triple{2, 1.6, 0} : Triple{1.6, 0.8, 1.6};
    s.gravity[up] = -9.81;
    for (std::size_t a = 0; a <= up; ++a) s.walls[a][0].kind = s.walls[a][1].kind = WallKind::free_slip;
    for (WallSpec* wall : {&s.walls[0][0], &s.walls[0][1], &s.walls[up][0]})
        wall->kind = WallKind::law, wall->absorbs = true;
    s.materials = {material("linear-elastic", 1500, {{"young", 1e6}, {"poisson", 0.3}})};
    Triple top = s.max, min = {0.6, 0.2, 0}, max = {1.1, 0.6, 0};
    top[up] = 0.8, min[up] = 0.8, max[up] = 0.9;
    Triple stone_min = {0.2, 0.2, 0}, stone_max = {0.5, 0.5, 0};
    stone_min[up] = 1.2, stone_max[up] = 1.4;
    s.bodies = {box({0, 0, 0}, top, 0), box(min, max, 0), box(stone_min, stone_max, 0)};
    s.bodies[0].geostatic = true, s.bodies[0].geostatic_surface = 0.8, s.bodies[0].geostatic_k0 = 3.0 / 7;
    s.bodies[1].velocity = {0.3, 0, 0}, s.bodies[1].velocity[up] = -0.5;
    s.bodies[2].velocity = {8, 0, 0};
    return s;
}

}  // namespace moraine::test
