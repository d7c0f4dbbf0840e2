#pragma once
// What must hold between the keys of a scene before it can run; each key alone has been checked by
// scene_values.hpp.

#include "core/scene.hpp"
#include "io/scene_error.hpp"

namespace moraine {

/// Domain, walls, balance, output and bodies. Throws InputError. Not collective.
void check_scene(const Scene& scene, const Places& places);

/// Bodies: inside the domain, not empty, not one in another (by their particles).
void check_bodies(const Scene& scene, const Places& places);

/// Structures: whole definitions, and no particle inside one.
void check_structures(const Scene& scene, const Places& places);

/// Refuses corners on a line and edges that cross, which would make area and inside disagree. `path`: who has them.
void check_polygon(const std::vector<std::array<double, 2>>& points, const std::string& path, const Places& places);

}  // namespace moraine
