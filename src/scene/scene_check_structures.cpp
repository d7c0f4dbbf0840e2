#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "scene/scene_check.hpp"
#include "seeding/seed.hpp"
#include "seeding/structure_seeds.hpp"

namespace moraine {
namespace {

constexpr char axis_name[] = "xyz";

std::string path_of(const StructureSpec& s) {
    return s.shape == StructureShape::ground ? s.name : "structure." + s.name;
}

bool is_zero(const Triple& t) {
    return t == Triple{};
}

void check_shape(const Scene& scene, const StructureSpec& s, const Places& places) {
    const std::string path = path_of(s);
    const bool flat = scene.dimensions == 2;
    if (s.shape == StructureShape::cylinder && flat)
        refuse(places.of(path + ".shape"), path + ".shape = \"cylinder\"", "the scene has 2 dimensions",
               "Use shape = \"sphere\", a circle in 2-D?");
    if (s.shape == StructureShape::plane && is_zero(s.normal))
        refuse(places.of(path + ".normal"), path + ".normal is zero", "it has no direction", "Write normal = [0, 1]?");
    if ((s.shape == StructureShape::cylinder || s.shape == StructureShape::capsule) && s.from == s.to)
        refuse(places.of(path + ".to"), path + " has no length", "from and to are the same",
               "Move one of them, or use shape = \"sphere\"?");
    if (s.shape == StructureShape::box)
        for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
            if (!(s.max[a] > s.min[a]))
                refuse(places.of(path + ".max"), fmt::format("{} has no length along {}", path, axis_name[a]),
                       fmt::format("min {}, max {}", s.min[a], s.max[a]), "Are they exchanged?");
    if (s.shape != StructureShape::polygon) return;
    if (!flat && !places.has(path + ".z"))
        refuse(places.of(path), path + ".z is missing", "a polygon in 3-D is a prism along z", "Add z = [0, 1]?");
    if (flat && places.has(path + ".z"))
        refuse(places.of(path + ".z"), path + ".z is not used", "the scene has 2 dimensions", "Remove it?");
    check_polygon(s.points, path, places.of(path + ".points"));
}

void check_motion(const Scene& scene, const StructureSpec& s, const Places& places) {
    const std::string path = path_of(s) + ".motion";
    const MotionSpec& m = s.motion;
    if (m.kind == StructureMotion::table) {
        if (m.factor.times.empty() || m.factor.times.size() != m.factor.values.size())
            refuse(places.of(path + ".factors"),
                   fmt::format("{} has {} times and {} factors", path, m.factor.times.size(), m.factor.values.size()),
                   "each time has a factor", "Give as many of both, or name a table?");
        if (m.factor.times.front() < 0 ||
            !std::is_sorted(m.factor.times.begin(), m.factor.times.end(), std::less_equal<>()))
            refuse(places.of(path + ".times"), path + ".times do not rise from 0 on", "a time is there once",
                   "Put them in order?");
    }
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
        if (scene.periodic[a] && s.shape == StructureShape::plane && s.normal[a] != 0)
            refuse(places.of(path_of(s) + ".normal"), path_of(s) + fmt::format(" stands across {}", axis_name[a]),
                   "that axis is periodic", fmt::format("Remove {} from domain.periodic?", axis_name[a]));
}

/// What a free structure weighs: by one key, and a plane by no density.
void check_mass(const StructureSpec& s, const Places& places) {
    const std::string path = path_of(s) + ".motion";
    const bool by_mass = places.has(path + ".mass"), by_density = places.has(path + ".density");
    if (!by_mass && !by_density)
        refuse(places.of(path), path + ".mass is missing", "the structure is free", "Add mass = ... or density = ...?");
    if (by_mass && by_density)
        refuse(places.of(path + ".density"), path + ".density beside its mass", "one follows from the other",
               "Remove one of them?");
    if (by_density && s.shape == StructureShape::plane)
        refuse(places.of(path + ".density"), path + ".density of a plane", "a plane has no volume", "Give its mass?");
}

/// Numbers about the axes about which it can turn.
void check_axes(const Scene& scene, const StructureSpec& s, const char* key, const std::vector<double>& values,
                const Places& places) {
    const std::string path = path_of(s) + ".motion." + key;
    const std::size_t axes = scene.dimensions == 2 ? 1 : 3;
    if (!places.has(path) || values.size() == axes) return;
    refuse(places.of(path), fmt::format("{} has {} numbers", path, values.size()),
           fmt::format("in {} dimensions it has {}", scene.dimensions, axes), "Give that many?");
}

void check_turning(const Scene& scene, const StructureSpec& s, const Places& places) {
    const std::string path = path_of(s) + ".motion";
    const MotionSpec& m = s.motion;
    check_axes(scene, s, "angular_velocity", m.angular_velocity, places);
    check_axes(scene, s, "inertia", m.inertia, places);
    for (const char* key : {".inertia", ".angular_velocity"})
        if (m.kind == StructureMotion::free && !m.turns && places.has(path + key))
            refuse(places.of(path + key), path + key + " of a structure that does not turn", "turns is false",
                   "Add turns = true?");
    if (turns(m) && s.shape == StructureShape::plane)
        refuse(places.of(path), path_of(s) + " is a plane that turns", "it has no end, and no centre of mass",
               "Use shape = \"box\"?");
    for (std::size_t a = 0; a < m.inertia.size(); ++a) {
        const double all = std::accumulate(m.inertia.begin(), m.inertia.end(), 0.0);
        if (!(m.inertia[a] > 0) || (m.inertia.size() > 1 && m.inertia[a] > (1 + 1e-9) * (all - m.inertia[a])))
            refuse(places.of(path + ".inertia"), fmt::format("{}.inertia has {}", path, m.inertia[a]),
                   "each is above 0, and none is more than the other two together", "Leave it to the shape?");
    }
}

/// Calls f(seed) for all particles of the scene, a row at a time.
template <class F>
void each_seed(const Scene& scene, const F& f) {
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
        const BodySeeds body(scene, static_cast<int>(b));
        const std::int64_t rows = body.rows();
        const std::int64_t step = scene.bodies[b].shape == BodyShape::table ? rows : 1;
        std::vector<Seed> seeds;
        for (std::int64_t row = 0; row < rows; row += step) {
            seeds.clear();
            body.fill(row, row + step, 1, seeds);
            for (const Seed& s : seeds) f(s);
        }
    }
}

void check_inside(const Scene& scene, const Places& places) {
    const StructuresAtStart structures(scene);
    std::int64_t left = 0;
    each_seed(scene, [&](const Seed& seed) {
        bool cleared = false;
        for (std::size_t k = 0; k < scene.structures.size(); ++k) {
            const StructureSpec& s = scene.structures[k];
            const double distance = structures.distance(k, seed.x);
            cleared = cleared || (s.clear && distance < 0);
            if (s.clear || distance >= -1e-9 * scene.cell) continue;
            refuse(places.of(path_of(s)),
                   fmt::format("{} begins inside {}", path_of(s),
                               path_of(scene.bodies[static_cast<std::size_t>(seed.body)])),
                   fmt::format("a particle at ({:.6g}) is {:.3g} m deep in it",
                               fmt::join(seed.x.begin(), seed.x.begin() + scene.dimensions, ", "), -distance),
                   "Move one of them, or set clear = true to leave such particles out?");
        }
        left += cleared ? 0 : 1;
    });
    if (left == 0)
        refuse(places.of("structure"), "no particle is left", "the structures cover all bodies", "Move one of them?");
}

}  // namespace

void check_structures(const Scene& scene, const Places& places) {
    if (scene.structures.empty()) return;
    for (const StructureSpec& s : scene.structures) {
        if (s.name == "terrain" && s.shape != StructureShape::ground && scene.structures[0].ground)
            refuse(places.of(path_of(s)), "a structure is called terrain", "[terrain] is in the records by that name",
                   "Rename it?");
        check_shape(scene, s, places);
        check_motion(scene, s, places);
        if (s.motion.kind == StructureMotion::free) check_mass(s, places);
        check_turning(scene, s, places);
    }
    check_inside(scene, places);
}

}  // namespace moraine
