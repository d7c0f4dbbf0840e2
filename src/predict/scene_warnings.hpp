#pragma once
// What a scene may have and is rarely meant: too few cells over a body, a Poisson's ratio that makes steps short for
// nothing, an elasticity so soft that the flow compresses it, a layer in which the transfer is more viscous than the
// fluid, a structure as fast as waves in the soil, a bed into which pressures on cells let a fluid sink. Such a scene
// runs; `moraine check` and a run say so.

#include <string>
#include <vector>

#include "core/scene_spec.hpp"

namespace moraine {

/// One sentence each: problem (why). remedy? Not collective.
std::vector<std::string> scene_warnings(const Scene& scene);

}  // namespace moraine
