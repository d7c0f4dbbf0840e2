#pragma once
// A scene whose structures turn.

#include "sample_scenes.hpp"

namespace moraine::test {

/// layers_on_slope() with a plank that is free in place of the disk, and a rod that turns as it is told.
inline Scene turning_on_slope(int dimensions) {
    Scene s = layers_on_slope(dimensions);
    StructureSpec &plank = s.structures[1], &rod = s.structures[2];
    plank.name = "plank", plank.shape = StructureShape::box, plank.law = InterfaceLaw::coulomb, plank.friction = 0.4;
    plank.min = {1.5, 1.06, 0.15}, plank.max = {2.1, 1.24, 0.7};
    plank.motion.turns = true;
    plank.motion.angular_velocity = dimensions == 2 ? std::vector<double>{-4} : std::vector<double>{1, 0.5, -4};
    rod.motion.angular_velocity = dimensions == 2 ? std::vector<double>{6} : std::vector<double>{1, 2, 6};
    return s;
}

}  // namespace moraine::test
