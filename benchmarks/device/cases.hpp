#pragma once
// The scenes of the device's benchmark: the columns of step/scenes.hpp at the sizes of the targets, a thin deposit, and
// one of each method and law.

#include "step/scenes.hpp"

namespace moraine {

struct DeviceCase {
    std::string name;
    Scene scene;
    bool hashed;  ///< small enough to bring the particles to the host for their hash
};

std::vector<DeviceCase> device_cases();

}  // namespace moraine
