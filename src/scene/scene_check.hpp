#pragma once
// What must hold between the keys of a scene before it can run; each key alone has been checked by
// scene_values.hpp.

#include "core/scene_spec.hpp"
#include "io/input_error.hpp"

namespace moraine {

/// Where a body stands in the scene: "body.NAME", "release.NAME".
inline std::string path_of(const BodySpec& body) {
    return (body.shape == BodyShape::layer    ? "release."
            : body.shape == BodyShape::inflow ? "inflow."
                                              : "body.") +
           body.name;
}

/// What keeps a scene from something: where it is written, what it is, why, and a remedy.
struct Hindrance {
    std::string key, what;
    const char *why, *help;
};

/// Whether a scene can have substeps (core/fluid/grid_pressure.hpp).
bool bears_substeps(const Scene& scene);

/// Of a profile of the material; what has its pressures on cells has one of each.
bool is_of_stiffness_or_density(const MaterialSpec& m, const ProfileSpec& profile);

/// Domain, walls, transfer, balance, output, bodies and time: all but the particles. Throws InputError. Not collective.
void check_scene(const Scene& scene, const Places& places);

/// The step, fixed or by the waves of the start: not so small that the end is out of reach, not so large that nothing
/// could be right. The materials and bodies must be whole.
void check_time(const Scene& scene, const Places& places);

/// Which methods output.energy_budget knows.
void check_energy_budget(const Scene& scene, const Places& places);

/// What absorbing ends bear, and what they cannot do with.
void check_ends(const Scene& scene, const Places& places);

/// What surfaces that act where they are need (Bed::surface).
void check_bed(const Scene& scene, const Places& places);

/// What water in the ground needs, and what it cannot do with.
void check_water(const Scene& scene, const Places& places);

/// What sleeping blocks, and a record of who would sleep, cannot do with. Of a scene that is whole.
void check_sleep(const Scene& scene, const Places& places);

/// Bodies: whole, inside the domain, not too many.
void check_bodies(const Scene& scene, const Places& places);

/// Structures: whole definitions, and no particle inside one. Takes time as those do.
void check_structures(const Scene& scene, const Places& places);

/// Structures that meet others: of shapes that can, and none in another or in a wall at the start.
void check_collisions(const Scene& scene, const Places& places);

/// Refuses corners on a line and edges that cross, which would make area and inside disagree. `path`: who has them;
/// `place`: where they are written.
void check_polygon(const std::vector<std::array<double, 2>>& points, const std::string& path, const std::string& place);

/// Bodies: not empty, not one in another, by their particles. Takes time as they do.
void check_particles(const Scene& scene, const Places& places);

}  // namespace moraine
