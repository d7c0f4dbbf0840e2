#include "scene/scene_tractions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/particles/particle_state.hpp"
#include "scene/scene_check.hpp"
#include "scene/scene_keys.hpp"
#include "seeding/seed_state.hpp"
#include "seeding/traction_place.hpp"

namespace moraine {
namespace {

using enum KeyType;
using T = TractionText;
using V = KeyValue;

const std::vector<KeyRow<TractionText>> rows{
    {{.table = "traction", .name = "name", .type = name, .meaning = "By which --set and stages refer to it."},
     [](T& t, const V& v) { t.spec.name = v.text; }},
    {{.table = "traction",
      .name = "body",
      .type = name,
      .meaning = "Name of a box or polygon, on whose surface it is."},
     [](T& t, const V& v) { t.body = v.text; }},
    {{.table = "traction",
      .name = "side",
      .type = choice,
      .standard = "",
      .choices = {"x-min", "x-max", "y-min", "y-max", "z-min", "z-max"},
      .meaning = "Of a box: the face that is loaded. Left out: what faces along normal."},
     [](T& t, const V& v) { t.face = v.choice; }},
    {{.table = "traction",
      .name = "normal",
      .type = vector,
      .standard = "",
      .meaning = "Outward direction of the flat part that is loaded; left out, with side: up, against gravity."},
     [](T& t, const V& v) { t.spec.normal = v.triple(); }},
    {{.table = "traction",
      .name = "area",
      .type = points,
      .unit = "m",
      .standard = "",
      .meaning = "Polygon in x and y around what is loaded of it at the start; left out: all of it."},
     [](T& t, const V& v) { t.spec.area = v.points; }},
    {{.table = "traction",
      .name = "pressure",
      .unit = "Pa",
      .standard = "0.0",
      .meaning = "Towards the body. Stages may set it."},
     [](T& t, const V& v) { t.spec.pressure = v.real; }},
    {{.table = "traction",
      .name = "shear",
      .type = vector,
      .unit = "Pa",
      .standard = "",
      .meaning = "Along the surface; left out: none. Stages may set it."},
     [](T& t, const V& v) { t.spec.shear = v.triple(); }},
    {{.table = "traction",
      .name = "kind",
      .type = choice,
      .standard = "\"dead\"",
      .choices = {"dead", "follower"},
      .meaning =
          "Dead: keeps its direction, per area of the start. Follower: turns with the surface, per area of now."},
     [](T& t, const V& v) { t.spec.follows = v.choice == 1; }},
    {{.table = "traction",
      .name = "table",
      .type = name,
      .standard = "",
      .meaning = "Name of a table; pressure and shear are times this. Each step takes the mean over the length of the "
                 "step before, from its begin on."},
     [](T& t, const V& v) { t.table = v.text; }},
    {{.table = "traction",
      .name = "depth",
      .unit = "m",
      .standard = "",
      .range = {0, std::numeric_limits<double>::infinity(), true, false},
      .meaning =
          "Of the soil that takes it; left out: 3 cells. Stress is right from the surface on, with an error that "
          "falls with this depth."},
     [](T& t, const V& v) { t.spec.depth = v.real; }},
};

double dot(const Triple& a, const Triple& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

int body_named(const Scene& scene, const std::string& wanted, const std::string& path, const Places& places) {
    std::vector<std::string> names;
    for (const BodySpec& body : scene.bodies) names.push_back(body.name);
    const auto found = std::find(names.begin(), names.end(), wanted);
    if (found == names.end())
        refuse(places.of(path), fmt::format("{} = {}", path, quote(wanted)), "there is no such body",
               suggest(wanted, names));
    const BodySpec& body = scene.bodies[static_cast<std::size_t>(found - names.begin())];
    if (body.shape != BodyShape::box && body.shape != BodyShape::polygon)
        refuse(places.of(path), fmt::format("{} = {}", path, quote(wanted)), "tractions are on flat parts",
               "Name a body of shape \"box\" or \"polygon\"?");
    return static_cast<int>(found - names.begin());
}

/// Outward, of length 1.
Triple normal_of(const Scene& scene, const TractionText& text, const std::string& path, const Places& places) {
    Triple normal{};
    const bool given = places.has(path + ".normal"), faced = text.face >= 0;
    if (given && faced)
        refuse(places.of(path + ".normal"), path + ".normal and side are both given", "a side has its normal",
               "Remove one of them?");
    if (faced) {
        if (text.face / 2 >= scene.dimensions)
            refuse(places.of(path + ".side"), path + ".side is along z", "the scene has 2 dimensions",
                   "Use x-min, x-max, y-min or y-max?");
        normal[static_cast<std::size_t>(text.face / 2)] = text.face % 2 == 1 ? 1 : -1;
        return normal;
    }
    normal = text.spec.normal;
    if (!given)
        for (std::size_t a = 0; a < 3; ++a) normal[a] = -scene.gravity[a];
    const double size = std::sqrt(dot(normal, normal));
    if (!(size > 0))
        refuse(places.of(given ? path + ".normal" : path), given ? path + ".normal is zero" : path + " has no side",
               given ? "it is a direction" : "without gravity nothing is up", "Say side or normal?");
    for (double& n : normal) n /= size;
    return normal;
}

/// Methods in which a traction is not what it says.
std::optional<Hindrance> tractions_hindered_by(const Scene& scene) {
    if (scene.sleep.on || scene.output.sleep_forecast)
        return Hindrance{"traction", "with numerics.sleep or its forecast", "sleepers would not feel what changes",
                         "Leave one of them out?"};
    if (uses_grid_pressure(scene) && !scene.water.on)
        return Hindrance{"traction", "with volumetric = \"grid\"", "pressures of cells do not know it",
                         "Use volumetric = \"cell\"?"};
    for (const MaterialSpec& m : scene.materials)
        if (has_fluid_terms(m))
            return Hindrance{"traction", "with pressure_smoothing or particle_shifting",
                             "what they move is not the soil under a surface", "Leave one of them out?"};
    return std::nullopt;
}

}  // namespace

const std::vector<KeyRow<TractionText>>& traction_rows() {
    return rows;
}

TractionSpec complete_traction(const Scene& scene, const TractionText& text, const std::string& path,
                               const Places& places) {
    TractionSpec spec = text.spec;
    spec.body = body_named(scene, text.body, path + ".body", places);
    spec.normal = normal_of(scene, text, path, places);
    const BodySpec& body = scene.bodies[static_cast<std::size_t>(spec.body)];
    if (body.shape == BodyShape::box &&
        std::none_of(spec.normal.begin(), spec.normal.end(), [](double n) { return std::fabs(n) > 1 - 1e-9; }))
        refuse(places.of(path), path + " is on a box, whose faces do not look that way", "their normals are axes",
               "Say side = \"y-max\", or a polygon?");
    if (!places.has(path + ".pressure") && !places.has(path + ".shear"))
        refuse(places.of(path), path + " has no pressure and no shear", "it would do nothing", "Give one of them?");
    if (const double out = dot(spec.shear, spec.normal); std::fabs(out) > 1e-9 * std::sqrt(dot(spec.shear, spec.shear)))
        refuse(places.of(path + ".shear"), path + ".shear leaves the surface", "what is across it is the pressure",
               "Give its part along the surface?");
    if (!spec.area.empty()) check_polygon(spec.area, path, places.of(path + ".area"));
    if (spec.depth == 0) spec.depth = 3 * scene.cell;
    spec.spacing = line_spacing(scene, spec);
    if (spec.depth < spec.spacing)
        refuse(places.of(path + ".depth"), fmt::format("{}.depth = {}", path, shortest(spec.depth)),
               fmt::format("particles are {:.4g} m apart", spec.spacing), "Give 3 cells?");
    return spec;
}

std::vector<TractionSpec> tractions_in_stage(const Scene& scene, const std::vector<TractionText>& texts,
                                             const Places& places) {
    std::vector<TractionSpec> all = scene.course.tractions;
    for (std::size_t k = 0; k < all.size(); ++k) {
        TractionText text = texts[k];
        all[k].pressure = text.spec.pressure;
        all[k].shear = text.spec.shear;
        if (const double out = dot(all[k].shear, all[k].normal);
            std::fabs(out) > 1e-9 * std::sqrt(dot(all[k].shear, all[k].shear)))
            refuse(places.of("traction." + all[k].name + ".shear"),
                   "traction." + all[k].name + ".shear leaves the surface", "what is across it is the pressure",
                   "Give its part along the surface?");
    }
    return all;
}

void check_tractions(const Scene& scene, const Places& places) {
    const std::vector<TractionSpec>& all = scene.course.tractions;
    if (all.empty()) return;
    if (const std::optional<Hindrance> found = tractions_hindered_by(scene))
        refuse(places.of("traction." + all.front().name), fmt::format("traction.{} {}", all.front().name, found->what),
               found->why, found->help);
    if (all.size() > most_tractions)
        refuse(places.of("traction." + all.back().name), fmt::format("the scene has {} tractions", all.size()),
               fmt::format("{} are the most", most_tractions), "Make one of those that are alike?");
    for (const TractionSpec& t : all) {
        const std::string path = "traction." + t.name;
        const LoadedPart part = loaded_part(scene, t);
        if (!(part.area > 0))
            refuse(places.of(path), path + " loads nothing",
                   path_of(scene.bodies[static_cast<std::size_t>(t.body)]) + " has no surface there that faces so",
                   "Another normal, or a larger area?");
        if (part.through > 0)
            refuse(places.of(path),
                   fmt::format("{}: {} is thinner than {:.4g} m under {:.3g} % of it", path,
                               path_of(scene.bodies[static_cast<std::size_t>(t.body)]), t.depth,
                               100 * part.through / part.area),
                   "its depth would reach another surface", "A smaller depth or cell?");
    }
}

}  // namespace moraine
