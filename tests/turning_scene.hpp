#pragma once
// A scene whose structures turn.

#include "sample_scenes.hpp"

namespace moraine::test {

/// layers_on_slope() with a plank that is free in place of the disk, and a rod that turns as it is told. Slope, plank
/// and rod are so near that all are felt within 0.02 s.
inline Scene turning_on_slope(int dimensions) {
    Scene s = layers_on_slope(dimensions);
    StructureSpec &plank = s.structures[1], &rod = s.structures[2];
    plank.name = "plank", plank.shape = StructureShape::box, plank.law = InterfaceLaw::coulomb, plank.friction = 0.4;
    s.structures[0].point = {0, 0.57, 0};
    plank.min = {1.5, 1.02, 0.15}, plank.max = {2.1, 1.2, 0.7}, plank.motion.velocity = {1, -5, 0};
    rod.from[0] = rod.to[0] = 3.3;
    plank.motion.turns = true;
    plank.motion.angular_velocity = dimensions == 2 ? std::vector<double>{-4} : std::vector<double>{1, 0.5, -4};
    rod.motion.angular_velocity = dimensions == 2 ? std::vector<double>{6} : std::vector<double>{1, 2, 6};
    return s;
}

}  // namespace moraine::test
