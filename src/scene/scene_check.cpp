#include "scene/scene_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/gravity.hpp"
#include "core/material/laws.hpp"
#include "core/transfer/method.hpp"
#include "io/deflate.hpp"
#include "scene/scene_keys.hpp"
#include "scene/scene_stages.hpp"

namespace moraine {
namespace {

constexpr char axis_name[] = "xyz";
constexpr double side_of_block = 4;  // cells

/// Cells along an axis, not rounded.
double cells(const Scene& scene, std::size_t a) {
    return (scene.max[a] - scene.min[a]) / scene.cell;
}

/// The domain's upper end if it had `count` cells, in words.
std::string end_for(const Scene& scene, std::size_t a, double count) {
    return fmt::format("Did you mean {} = {:.10g} along {}?", "domain.max", scene.min[a] + count * scene.cell,
                       axis_name[a]);
}

void check_domain(const Scene& scene, const Places& places) {
    // A key holds 2^20 blocks an axis each way in 3-D; 2^27 in 2-D keep the index of a cell below 2^29.
    const double most = std::ldexp(1, scene.dimensions == 3 ? 20 : 27);
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a) {
        const double length = scene.max[a] - scene.min[a];
        if (!(length > 0))
            refuse(places.of("domain.max"), fmt::format("the domain has no length along {}", axis_name[a]),
                   fmt::format("min {}, max {}", scene.min[a], scene.max[a]), "Are they exchanged?");
        const double count = cells(scene, a);
        if (count / side_of_block + 2 > most)
            refuse(places.of("domain.cell"), fmt::format("the domain has {:.3g} cells along {}", count, axis_name[a]),
                   fmt::format("at most {:.0f} fit", side_of_block * (most - 2)), "Use a larger domain.cell?");
        const double whole = std::max(1.0, std::round(count));
        if (std::abs(count - whole) > 1e-9 * whole)
            refuse(places.of("domain.max"), fmt::format("the domain has {:.10g} cells along {}", count, axis_name[a]),
                   "must be a whole number: walls lie on nodes", end_for(scene, a, whole));
        if (scene.periodic[a] && std::fmod(whole, side_of_block) != 0)
            refuse(places.of("domain.periodic"),
                   fmt::format("the periodic axis {} has {:.0f} cells", axis_name[a], whole),
                   "must be whole blocks of 4 cells",
                   end_for(scene, a, side_of_block * std::max(1.0, std::round(whole / side_of_block))));
    }
}

void check_axes(const Scene& scene, const Places& places) {
    for (std::size_t a = 0; a < 3; ++a) {
        if (scene.periodic[a] && static_cast<int>(a) >= scene.dimensions)
            refuse(places.of("domain.periodic"), "the axis z is not there", "the scene has 2 dimensions", "Remove it?");
        for (std::size_t s = 0; s < 2; ++s)
            if (scene.periodic[a] && places.has(fmt::format("wall.{}-{}", axis_name[a], s == 0 ? "min" : "max")))
                refuse(places.of(fmt::format("wall.{}-{}", axis_name[a], s == 0 ? "min" : "max")),
                       fmt::format("wall {}-{} stands on a periodic axis", axis_name[a], s == 0 ? "min" : "max"),
                       "a periodic axis has no ends",
                       fmt::format("Remove it, or {} from domain.periodic?", axis_name[a]));
    }
    if (scene.balance.axis >= scene.dimensions)
        refuse(places.of("balance.axis"), "balance.axis = \"z\"", "the scene has 2 dimensions", "Did you mean \"x\"?");
}

/// C = grad v of a hat is (v_1 - v_0) / h however near a node the particle is, where D = f (1 - f) h2 tends to zero: a
/// rounding of the light node's velocity becomes a C that carries energy once the particle is in mid-cell.
void check_transfer(const Scene& scene, const Places& places) {
    if (scene.transfer == Transfer::fmpm && scene.stress_update != StressUpdate::usl)
        refuse(places.of("numerics.stress_update"), "numerics.stress_update with transfer \"fmpm\"",
               "its rounds are the terms of a series, and stress follows the last",
               "Remove it, or take transfer = \"apic\"?");
    if (!is_affine(scene.transfer) || scene.shape != Shape::linear) return;
    const char* transfer = scene.transfer == Transfer::apic   ? "apic"
                           : scene.transfer == Transfer::tpic ? "tpic"
                                                              : "aflip";
    refuse(places.of("numerics.transfer"), fmt::format("numerics.transfer = \"{}\" with shape \"linear\"", transfer),
           "the inertia D of a hat's weights is zero at nodes, and rounding grows there",
           fmt::format("Use shape = \"quadratic\", or transfer = \"{}\"?",
                       scene.transfer == Transfer::tpic ? "pic" : "flip"));
}

constexpr const char* for_what_flows =
    "it is for fluids and undrained clays: bingham, herschel-bulkley, newtonian, tresca, von-mises";

/// Smoothing and shifting are for what remembers no shape.
void check_fluid_terms(const Scene& scene, const Places& places) {
    for (const MaterialSpec& m : scene.materials) {
        if (!has_fluid_terms(m)) continue;
        const std::string path = "material." + m.name;
        const std::string key = path + (m.particle_shifting > 0 ? ".particle_shifting" : ".pressure_smoothing");
        if (!find_law(m.law)->flows)
            refuse(places.of(key), fmt::format("{} with law \"{}\"", key, m.law), for_what_flows, "Remove it?");
        if (m.volumetric == Volumetric::cell)
            refuse(places.of(path + ".volumetric"), path + ".volumetric = \"cell\" with " + key,
                   "means of cells smooth pressures already, and crowd particles", "Remove one of them?");
    }
}

std::optional<Hindrance> substeps_hindered_by(const Scene& scene) {
    for (const MaterialSpec& m : scene.materials)
        if (m.volumetric != Volumetric::grid)
            return Hindrance{"numerics.substeps", "material." + m.name, "a material has its pressure on particles",
                             "Use volumetric = \"grid\" for all?"};
    if (scene.dt > 0) return Hindrance{"numerics.substeps", "time.dt", "the step follows from speeds", "Use time.cfl?"};
    for (const StructureSpec& s : scene.structures)
        if (s.motion.kind == StructureMotion::free)
            return Hindrance{"numerics.substeps", fmt::format("structure.{}, which is free", s.name),
                             "structures move once in a step", "Remove it?"};
    for (const MaterialSpec& m : scene.materials)
        if (!find_law(m.law)->is_fluid)
            return Hindrance{"numerics.substeps", fmt::format("law \"{}\" of material.{}", m.law, m.name),
                             "substeps are for fluids: bingham, herschel-bulkley, newtonian", "Remove it?"};
    for (const MaterialSpec& m : scene.materials)
        if (poisson_ratio(m) < 0.45)
            return Hindrance{"material." + m.name + ".poisson", "this Poisson's ratio",
                             "below 0.45 shear is nearly as fast as pressure", "Remove it?"};
    return std::nullopt;
}

/// What the pressure on the grid's cells is for, and what its substeps need.
void check_grid_pressure(const Scene& scene, const Places& places) {
    for (const MaterialSpec& m : scene.materials) {
        if (m.volumetric != Volumetric::grid) continue;
        const std::string key = "material." + m.name + ".volumetric";
        const std::string what = key + " = \"grid\"";
        if (!find_law(m.law)->flows && !(m.porosity > 0))
            refuse(places.of(key), fmt::format("{} with law \"{}\"", what, m.law), for_what_flows,
                   "Use \"cell\" or \"particle\"?");
        if (scene.shape != Shape::quadratic)
            refuse(places.of(key), what + " with this numerics.shape", "it is for quadratic splines",
                   "Use shape = \"quadratic\"?");
        if (scene.stress_update != StressUpdate::usl || scene.transfer == Transfer::fmpm)
            refuse(places.of(key), what + " with this stress_update or transfer",
                   "pressures and velocities go on together, once", "Use stress_update = \"usl\" and no fmpm?");
    }
    for (const MaterialSpec& m : scene.materials)
        if (uses_grid_pressure(scene) && m.volumetric != Volumetric::grid && has_fluid_terms(m))
            refuse(places.of("material." + m.name),
                   "material." + m.name + " smooths or shifts without volumetric = \"grid\"",
                   "beside one whose pressure is the grid's", "Use it for both?");
    if (scene.substeps == 1) return;
    if (const std::optional<Hindrance> found = substeps_hindered_by(scene))
        refuse(places.of(found->key), fmt::format("numerics.substeps = {} with {}", scene.substeps, found->what),
               found->why, found->help);
}

void check_names(const std::string& key, const std::vector<std::string>& names, const std::vector<std::string>& valid,
                 const Places& places) {
    for (auto name = names.begin(); name != names.end(); ++name) {
        if (std::find(valid.begin(), valid.end(), *name) == valid.end())
            refuse(places.of(key), fmt::format("{} has {}", key, quote(*name)), "no such field in this scene",
                   suggest(*name, valid));
        if (std::find(names.begin(), name, *name) != name)
            refuse(places.of(key), fmt::format("{} has {} twice", key, quote(*name)), "a file has one array of a name",
                   "Remove one?");
    }
}

void check_fields(const Scene& scene, const Places& places) {
    check_names("output.fields", scene.output.fields, output_field_names(scene), places);
    check_names("output.labels", scene.output.labels, output_label_names(), places);
    if (scene.output.on_cells && scene.output.every > 1)
        refuse(places.of("output.every"),
               fmt::format("output.every = {} with fields_on = \"cells\"", scene.output.every),
               "cells are means over all of their particles", "Leave it out?");
    const auto& fields = scene.output.fields;
    if (scene.output.on_cells && std::find(fields.begin(), fields.end(), "body") != fields.end())
        refuse(places.of("output.fields"), "output.fields has \"body\" with fields_on = \"cells\"",
               "bodies have no mean", "Leave it out?");
    if (scene.output.on_cells && scene.water.submerged &&
        std::find(fields.begin(), fields.end(), "pore_pressure") != fields.end())
        refuse(places.of("output.fields"), "output.fields has \"pore_pressure\" with fields_on = \"cells\"",
               "of submerged soil particles hold what is in excess of still water", "Use fields_on = \"particles\"?");
    if (scene.output.deflate && !can_deflate())
        refuse(places.of("output.compression"), "output.compression = \"deflate\"",
               "the program was built without zlib", "Leave it out?");
}

void check_starts(const Scene& scene, const Places& places) {
    const bool weightless = gravity_at(scene, 0) == Triple{};
    for (const BodySpec& body : scene.bodies) {
        const std::string path = path_of(body);
        if (body.geostatic && weightless)
            refuse(places.of(path + ".geostatic"), path + ".geostatic without weight", "gravity is zero at the start",
                   "Set gravity, or a table that does not begin with 0?");
        if (body.wave.wavelength > 0 && body.wave.axis >= scene.dimensions)
            refuse(places.of(path + ".wave.axis"), path + ".wave.axis = \"z\"", "the scene has 2 dimensions",
                   "Did you mean \"x\"?");
    }
}

}  // namespace

bool bears_substeps(const Scene& scene) {
    return !substeps_hindered_by(scene);
}

void check_scene(const Scene& scene, const Places& places) {
    check_domain(scene, places);
    check_axes(scene, places);
    check_transfer(scene, places);
    check_fluid_terms(scene, places);
    check_water(scene, places);
    check_grid_pressure(scene, places);
    check_fields(scene, places);
    check_starts(scene, places);
    check_bodies(scene, places);
    check_time(scene, places);
    check_sleep(scene, places);
    check_energy_budget(scene, places);
    check_bed(scene, places);
    check_stages(scene, places);
    check_ends(scene, places);
}

}  // namespace moraine
