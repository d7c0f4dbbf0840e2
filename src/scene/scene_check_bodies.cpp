#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/data/error.hpp"
#include "core/material/laws.hpp"
#include "predict/lattice_prediction.hpp"
#include "scene/scene_check.hpp"
#include "scene/scene_profiles.hpp"
#include "scene/scene_stages.hpp"
#include "seeding/seed.hpp"
#include "seeding/seed_state.hpp"
#include "seeding/seed_table.hpp"

namespace moraine {
namespace {

constexpr char axis_name[] = "xyz";

void check_form(const Scene& scene, const BodySpec& body, const Places& places) {
    const std::string path = path_of(body);
    const bool prism = body.shape == BodyShape::polygon;
    if (prism && scene.dimensions == 3 && !places.has(path + ".z"))
        refuse(places.of(path), path + ".z is missing", "a polygon in 3-D is a prism along z", "Add z = [0, 1]?");
    if (prism && scene.dimensions == 2 && places.has(path + ".z"))
        refuse(places.of(path + ".z"), path + ".z is not used", "the scene has 2 dimensions", "Remove it?");
    if (body.shape == BodyShape::box)
        for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
            if (!(body.max[a] > body.min[a]))
                refuse(places.of(path + ".max"), fmt::format("{} has no length along {}", path, axis_name[a]),
                       fmt::format("min {}, max {}", body.min[a], body.max[a]), "Are they exchanged?");
}

using Point = std::array<double, 2>;

double turn(const Point& a, const Point& b, const Point& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
}

void check_crossings(const std::vector<Point>& points, const std::string& path, const std::string& place) {
    const std::size_t n = points.size();
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 2; j < n; ++j) {
            const Point &a = points[i], &b = points[i + 1], &c = points[j], &d = points[(j + 1) % n];
            if (turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0)
                refuse(place, path + " crosses itself", fmt::format("the edges after points {} and {}", i + 1, j + 1),
                       "Put the points in order?");
        }
}

void check_extent(const Scene& scene, const BodySpec& body, const Extent& e, const Places& places) {
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a) {
        const double slack = 1e-9 * (scene.max[a] - scene.min[a]);
        if (e.lower[a] < scene.min[a] - slack || e.upper[a] > scene.max[a] + slack)
            refuse(
                places.of(path_of(body)),
                fmt::format("{} reaches from {} to {} along {}", path_of(body), e.lower[a], e.upper[a], axis_name[a]),
                fmt::format("the domain from {} to {}", scene.min[a], scene.max[a]),
                "Move the body or widen domain.min, domain.max?");
    }
}

/// An id has 48 bits for the place in the lattice.
void check_lattice(const Scene& scene, const BodySpec& body, const Places& places) {
    const Extent e = extent_of(body, scene.dimensions);
    double points = 1;
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
        points *= (e.upper[a] - e.lower[a]) / scene.cell * body.particles_per_cell[a] + 2;
    if (points > std::ldexp(1, 48))
        refuse(places.of(path_of(body)), fmt::format("{} spans {:.3g} particles", path_of(body), points),
               "ids have space for 2^48 a body", "Use a larger domain.cell?");
}

/// Calls f(seeds) for a part of the body at a time, so that the memory stays small, until it returns true.
template <class F>
void each_part(const Scene& scene, std::size_t body, const F& f) {
    const BodySeeds all(scene, static_cast<int>(body));
    const std::int64_t rows = all.rows();
    const std::int64_t step = scene.bodies[body].shape == BodyShape::table ? rows : 1;
    std::vector<Seed> seeds;
    for (std::int64_t row = 0; row < rows; row += step) {
        seeds.clear();
        all.fill(row, row + step, 1, seeds);
        if (f(seeds)) return;
    }
}

/// Smallest box around the particles of a body.
Extent extent_of_particles(const Scene& scene, std::size_t body) {
    constexpr double far = 1e300;
    Extent e{{far, far, far}, {-far, -far, -far}};
    each_part(scene, body, [&](const std::vector<Seed>& seeds) {
        for (const Seed& s : seeds)
            for (std::size_t a = 0; a < 3; ++a) {
                e.lower[a] = std::min(e.lower[a], s.x[a]);
                e.upper[a] = std::max(e.upper[a], s.x[a]);
            }
        return false;
    });
    return e;
}

Extent extent_in(const Scene& scene, std::size_t body) {
    if (scene.bodies[body].shape == BodyShape::table) return extent_of_particles(scene, body);
    return extent_of(scene.bodies[body], scene.dimensions);
}

bool may_touch(const Extent& a, const Extent& b, int dimensions) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(dimensions); ++k)
        if (a.upper[k] < b.lower[k] || b.upper[k] < a.lower[k]) return false;
    return true;
}

/// A particle of body a in body b. Two boxes are asked axis by axis, whatever their particles.
std::optional<Triple> overlap(const Scene& scene, std::size_t a, std::size_t b) {
    const BodySpec &mine = scene.bodies[a], &other = scene.bodies[b];
    if (mine.shape == BodyShape::box && mine.seeding == Seeding::lattice && other.shape == BodyShape::box)
        return first_inside(scene, mine, other);
    std::optional<Triple> found;
    each_part(scene, a, [&](const std::vector<Seed>& seeds) {
        const auto at = std::find_if(seeds.begin(), seeds.end(),
                                     [&](const Seed& s) { return is_inside(other, scene.dimensions, s.x); });
        if (at != seeds.end()) found = at->x;
        return found.has_value();
    });
    return found;
}

/// Refuses a particle of body a in body b.
void check_overlap(const Scene& scene, const Places& places, std::size_t a, std::size_t b) {
    const std::optional<Triple> found = overlap(scene, a, b);
    if (!found) return;
    const std::string name = path_of(scene.bodies[std::max(a, b)]);
    refuse(places.of(name), fmt::format("{} overlaps {}", name, path_of(scene.bodies[std::min(a, b)])),
           fmt::format("both have ({:.6g})", fmt::join(found->begin(), found->begin() + scene.dimensions, ", ")),
           "Move or shrink one of them?");
}

/// Each pair, both ways: a thin body may pass between the other's particles.
void check_overlaps(const Scene& scene, const Places& places) {
    const std::size_t n = scene.bodies.size();
    if (n < 2) return;
    std::vector<Extent> extents;
    for (std::size_t b = 0; b < n; ++b) extents.push_back(extent_in(scene, b));
    for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < a; ++b)
            if (scene.bodies[a].release_time == scene.bodies[b].release_time && !scene.bodies[a].hydrograph &&
                !scene.bodies[b].hydrograph && meet(scene, a, b) &&
                may_touch(extents[a], extents[b], scene.dimensions)) {
                check_overlap(scene, places, a, b);
                check_overlap(scene, places, b, a);
            }
}

/// A law's scalars at the start, from the body's keys and stress.
void check_start(const Scene& scene, const BodySpec& body, const Places& places) {
    const MaterialSpec& material = scene.materials[static_cast<std::size_t>(body.material)];
    const LawInfo& law = *find_law(material.law);
    const std::string path = path_of(body), ratio = path + ".over_consolidation_ratio";
    if (!law.has_initial_state && body.start.over_consolidation_ratio != 1)
        refuse(places.of(ratio), ratio + " is not used", "law " + material.law + " keeps no preconsolidation pressure",
               "Remove it?");
    for (const Vec<double, 3>& stress : {Vec<double, 3>{}, deepest_stress(scene, body)})
        if (const char* problem = law.problem_at_start(material.parameters.data(), body.start, stress))
            throw InputError(fmt::format("{}: {}: {}", places.of(path), path, problem));
    if (const double wave = law.wave_modulus(material.parameters.data(), body.start); law.of_file() && !(wave > 0))
        refuse(places.of(path), fmt::format("{} begins with a wave modulus of {} Pa", path, wave),
               "the time step follows from it, so it must be above 0", "Does wave_modulus() return K + 4G/3?");
}

}  // namespace

void check_polygon(const std::vector<Point>& points, const std::string& path, const std::string& place) {
    check_crossings(points, path, place);
    double twice_area = 0;
    for (std::size_t i = 1; i + 1 < points.size(); ++i) twice_area += turn(points[0], points[i], points[i + 1]);
    if (twice_area == 0) refuse(place, path + " has no area", "its points lie on a line", "Move one of them?");
}

void check_bodies(const Scene& scene, const Places& places) {
    if (scene.bodies.empty())
        refuse(places.of("body"), "the scene has no body", "nothing would move", "Write one as [[body]]?");
    if (scene.bodies.size() > 65535)
        refuse(places.of("body"), fmt::format("{} bodies", scene.bodies.size()), "at most 65535",
               "Put particles of one material into one table?");
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
        const BodySpec& body = scene.bodies[b];
        const bool draped = body.shape == BodyShape::layer || body.shape == BodyShape::inflow;
        if (body.shape != BodyShape::table) {
            if (body.shape == BodyShape::polygon)
                check_polygon(body.points, path_of(body), places.of(path_of(body) + ".points"));
            if (body.shape == BodyShape::layer)
                check_polygon(body.points, path_of(body), path_of_file(scene, body.file));
            check_form(scene, body, places);
            if (!draped) check_extent(scene, body, extent_of(body, scene.dimensions), places);
            check_lattice(scene, body, places);
        }
        check_start(scene, body, places);
    }
}

void check_particles(const Scene& scene, const Places& places) {
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
        const BodySpec& body = scene.bodies[b];
        if (body.shape == BodyShape::inflow && body.hydrograph->time[0] >= scene.end) continue;  // a run of no time
        const BodySeeds seeds(scene, static_cast<int>(b));
        std::int64_t particles = 0;
        for (std::int64_t r = 0; r < seeds.rows() && particles == 0; ++r) particles = seeds.count(r, r + 1);
        if (body.shape == BodyShape::layer || body.shape == BodyShape::inflow)
            check_extent(scene, body, extent_of_particles(scene, b), places);
        if (particles == 0)
            refuse(places.of(path_of(body)), fmt::format("{} has no particles", path_of(body)),
                   "it is smaller than their spacing", "Use a smaller domain.cell or more particles_per_cell?");
        check_properties(scene, b, places);
    }
    check_overlaps(scene, places);
}

}  // namespace moraine
