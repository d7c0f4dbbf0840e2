// Water in the ground: the keys of [water], and what it cannot do with yet. Those of [[material]] and [[wall]] stand
// with theirs.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "core/gravity.hpp"
#include "core/material/laws.hpp"
#include "core/transfer/method.hpp"
#include "core/transfer/scene_walls.hpp"
#include "scene/scene_check.hpp"
#include "scene/scene_keys.hpp"
#include "seeding/seed_state.hpp"

namespace moraine {
namespace {

using enum KeyType;
using S = Scene;
using V = KeyValue;

const std::vector<KeyRow<Scene>> rows = in_tables<Scene>({
    {{.table = "water",
      .name = "table",
      .unit = "m",
      .standard = "",
      .meaning = "Height of still water at the start, along gravity: pore pressures begin hydrostatic, and a body's "
                 "geostatic stresses effective. Left out: pore pressure begins at 0."},
     [](S& s, const V& v) { s.water.table = v.real; }},
    {{.name = "density", .unit = "kg/m3", .standard = "1000.0", .range = above_zero, .meaning = "Of the water."},
     [](S& s, const V& v) { s.water.density = v.real; }},
    {{.name = "bulk",
      .unit = "Pa",
      .standard = "2.2e9",
      .range = above_zero,
      .meaning = "Bulk modulus of the water; a softer one makes longer steps (docs/guide/choose-law.md)."},
     [](S& s, const V& v) { s.water.bulk = v.real; }},
    {{.name = "cavitation",
      .unit = "Pa",
      .standard = "1.0e5",
      .range = from_zero,
      .meaning = "Tension, below the air's pressure, at which the water cavitates: pores bear no more. 0: none."},
     [](S& s, const V& v) { s.water.cavitation = v.real; }},
    {{.name = "outside",
      .type = choice,
      .standard = "\"dry\"",
      .choices = {"dry", "submerged"},
      .meaning = "Around the ground: nothing, or still water up to the table, above all soil; it carries the soil's "
                 "buoyancy, and steps know pore pressures in excess of it."},
     [](S& s, const V& v) { s.water.submerged = v.choice == 1; }},
});

/// What water in the ground has not been shown to be right with.
std::optional<Hindrance> water_hindered_by(const Scene& scene) {
    if (scene.shape != Shape::quadratic)
        return Hindrance{"water", "this numerics.shape", "pressures on cells are for quadratic splines",
                         "Use shape = \"quadratic\"?"};
    if (scene.stress_update != StressUpdate::usl || scene.transfer == Transfer::fmpm)
        return Hindrance{"water", "this stress_update or transfer", "pressures and velocities go on together, once",
                         "Use stress_update = \"usl\" and no fmpm?"};
    if (scene.damping > 0)
        return Hindrance{"numerics.damping", "numerics.damping", "it would brake the water, too", "Leave it out?"};
    if (scene.sleep.on || scene.output.sleep_forecast)
        return Hindrance{"water", "numerics.sleep or its forecast", "what consolidates moves slowly, but does not rest",
                         "Leave one of them out?"};
    if (!scene.structures.empty())
        return Hindrance{"structure." + scene.structures.front().name, "structure." + scene.structures.front().name,
                         "contact would count pore pressure as effective stress", "Use walls?"};
    if (!scene.course.stages.empty())
        return Hindrance{"stage." + scene.course.stages.front().name, "[[stage]]",
                         "what it changes is not known to water", "Restart with --set?"};
    if (gravity_changes(scene))
        return Hindrance{scene.course.gravity.empty() ? "shaking" : "gravity_table", "a gravity that changes",
                         "the weight of water is that of a gravity that stays", "Leave one of them out?"};
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t s = 0; s < 2; ++s) {
            const WallSpec& wall = scene.walls[a][s];
            if (wall.absorbs)
                return Hindrance{fmt::format("wall.{}-{}.kind", "xyz"[a], s == 0 ? "min" : "max"), "an absorbing wall",
                                 "it knows one wave, and water has two", "Use no-slip or free-slip?"};
        }
    for (const BodySpec& b : scene.bodies)
        if (b.release_time > 0 || b.stage > 0 || b.hydrograph || b.shape == BodyShape::layer)
            return Hindrance{path_of(b), path_of(b), "only bodies of the start have a state of their water",
                             "Use a [[body]]?"};
    for (const MaterialSpec& m : scene.materials)
        if (m.volumetric == Volumetric::grid && !(m.porosity > 0))
            return Hindrance{"material." + m.name, "volumetric = \"grid\" of material." + m.name,
                             "cells have one pressure, and that is the water's", "Use \"cell\" or \"particle\"?"};
    return std::nullopt;
}

void check_porous(const Scene& scene, const MaterialSpec& m, const Places& places) {
    const std::string path = "material." + m.name, porosity = path + ".porosity";
    const LawInfo& law = *find_law(m.law);
    if (!scene.water.on)
        refuse(places.of(porosity), porosity + " without [water]", "there is no water to fill the pores",
               "Add [water], or leave porosity out?");
    if (!(m.conductivity > 0))
        refuse(places.of(path), path + " has a porosity and no conductivity", "Darcy's law needs one",
               "Add conductivity = ... [m/s], say 1e-9 of clay or 1e-4 of sand?");
    const bool isotropic = std::any_of(law.parameters.begin(), law.parameters.end(),
                                       [](const Parameter& p) { return std::string_view(p.key) == "poisson"; });
    if (law.flows || !isotropic || law.has_initial_state || law.of_file())
        refuse(places.of(porosity), fmt::format("{} with law \"{}\"", porosity, m.law),
               law.flows ? "its strength is of total stress" : "it has not been shown with pore pressures",
               "Use drucker-prager or linear-elastic?");
    if (m.volumetric != Volumetric::grid)
        refuse(places.of(path + ".volumetric"), path + ".volumetric with porosity",
               "saturated soil has its mean stress and pore pressure on cells", "Leave it out?");
    if (!m.profiles.empty())
        refuse(places.of(path), path + " has a property over depth or place, and porosity", "not known together yet",
               "Give numbers?");
    const double grains = (m.density - m.porosity * scene.water.density) / (1 - m.porosity);
    if (!(grains > scene.water.density))
        refuse(places.of(path + ".density"), fmt::format("{}.density = {:.6g}", path, m.density),
               fmt::format("it is of soil with its water, so that grains would have {:.4g} kg/m3", grains),
               "About 2000?");
}

/// Bodies against the height of still water.
void check_table(const Scene& scene, const Places& places) {
    if (!scene.water.table) {
        if (scene.water.submerged)
            refuse(places.of("water.outside"), "water.outside = \"submerged\" without a table",
                   "the water above the soil has a height", "Add table = ... [m]?");
        return;
    }
    const auto up = static_cast<std::size_t>(up_axis(scene));
    for (std::size_t a = 0; a < 3; ++a)
        if (scene.gravity[up] >= 0 || (a != up && scene.gravity[a] != 0))
            refuse(places.of("water.table"), "water.table without gravity straight down an axis",
                   "still water has no level", "Set gravity, or leave table out?");
    const double table = *scene.water.table, slack = 1e-9 * (scene.max[up] - scene.min[up]);
    double top = scene.min[up];
    for (const BodySpec& body : scene.bodies) {
        if (!(scene.materials[static_cast<std::size_t>(body.material)].porosity > 0)) continue;
        const double upper = body.shape == BodyShape::table ? table : extent_of(body, scene.dimensions).upper[up];
        top = std::max(top, upper);
        if (upper > table + slack)
            refuse(places.of("water.table"),
                   fmt::format("{} reaches {:.6g} m, above water.table = {:.6g}", path_of(body), upper, table),
                   "soil with a porosity is full of water", "Cut it there, and give what is above a material without?");
    }
    if (!scene.water.submerged && table > top + slack)
        refuse(places.of("water.table"),
               fmt::format("water.table = {:.6g} is above all soil, which reaches {:.6g} m", table, top),
               "water that stands on the ground is not there", "Use outside = \"submerged\"?");
}

}  // namespace

const std::vector<KeyRow<Scene>>& water_rows() {
    return rows;
}

void check_water(const Scene& scene, const Places& places) {
    bool wet = false;
    for (const MaterialSpec& m : scene.materials) {
        const std::string conductivity = "material." + m.name + ".conductivity";
        if (places.has(conductivity) && !(m.porosity > 0))
            refuse(places.of(conductivity), conductivity + " without porosity", "there are no pores to flow through",
                   "Add porosity = ..., or leave it out?");
        if (!(m.porosity > 0)) continue;
        wet = true;
        check_porous(scene, m, places);
    }
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t s = 0; s < 2; ++s)
            if (const std::string key = fmt::format("wall.{}-{}.drainage", "xyz"[a], s == 0 ? "min" : "max");
                scene.walls[a][s].drains && !scene.water.on)
                refuse(places.of(key), key + " = \"open\" without [water]", "there is no water to drain",
                       "Add [water], or leave it out?");
    if (!scene.water.on) return;
    if (!wet)
        refuse(places.of("water"), "[water] without a material that has a porosity", "there is no soil for it to be in",
               "Add porosity and conductivity to a material?");
    if (const std::optional<Hindrance> found = water_hindered_by(scene))
        refuse(places.of(found->key), "[water] with " + found->what, found->why, found->help);
    check_table(scene, places);
}

}  // namespace moraine
