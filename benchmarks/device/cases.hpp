#pragma once
// The scenes of the device's benchmark: the columns of step/scenes.hpp at the sizes of the targets, a thin deposit, one
// of each method and law, columns of two materials, and columns that grow along one axis with the number of ranks.

#include "step/scenes.hpp"

namespace moraine {

struct DeviceCase {
    std::string name;
    Scene scene;
    bool hashed;  ///< small enough to bring the particles to the host for their hash
};

std::vector<DeviceCase> device_cases(int ranks);

}  // namespace moraine
