// Keys of the tables that are written as often as needed: [[material]], [[body]], [[wall]].
#include "scene/scene_keys.hpp"

namespace moraine {
namespace {

using enum KeyType;
using M = MaterialSpec;
using B = BodySpec;
using W = FacedWall;
using V = KeyValue;

std::vector<std::string> law_choices() {
    std::vector<std::string> names = law_names();
    names.emplace_back("file");
    return names;
}

const std::vector<KeyRow<MaterialSpec>> materials = in_tables<MaterialSpec>({
    {{.table = "material", .name = "name", .type = name, .meaning = "By which bodies and --set refer to it."},
     [](M& m, const V& v) { m.name = v.text; }},
    {{.name = "law",
      .type = choice,
      .choices = law_choices(),
      .meaning = "Constitutive law; it says which of the keys below are used."},
     [](M& m, const V& v) { m.law = v.text; }},
    // The name of a law, by which scene_laws.cpp has loaded it.
    {{.name = "source",
      .type = text,
      .only = {"file"},
      .meaning = "C++ header with a law of your own, which says its keys; compiled where --allow-code is given "
                 "(docs/guide/tutorials/own-law.md)."},
     [](M& m, const V& v) { m.law = v.text; }},
    {{.name = "density",
      .type = real_or_profile,
      .unit = "kg/m3",
      .range = above_zero,
      .meaning = "Of the unstrained material."},
     [](M& m, const V& v) { m.density = v.real; }},
    {{.name = "volumetric",
      .type = choice,
      .standard = "",
      .choices = {"particle", "cell", "grid"},
      .meaning =
          "Volumetric rate and pressure: each particle's; the mean of a cell, against locking near nu = 0.5; or, "
          "for fluids and undrained clays, on the cells of the grid, with exact integrals in full ones. Left out: grid "
          "where all is fluid "
          "that says none of these three keys, and the scene can have it (docs/guide/choose-method.md), else "
          "particle."},
     [](M& m, const V& v) { m.volumetric = static_cast<Volumetric>(v.choice); }},
    {{.name = "pressure_smoothing",
      .standard = "0.0",
      .range = from_zero,
      .meaning =
          "For fluids and undrained clays (bingham, herschel-bulkley, newtonian, tresca, von-mises): the share of "
          "its pressure that a particle takes from the grid while a wave crosses a cell; 0: none. Left out: 0.22 "
          "where a fluid takes grid by itself."},
     [](M& m, const V& v) { m.pressure_smoothing = v.real; }},
    {{.name = "particle_shifting",
      .standard = "0.0",
      .range = {0, 0.4},
      .meaning = "For the same: how far particles are shifted out of over-filled nodes while a wave crosses a cell, in "
                 "cells per filling and cell; 0: not at all. Left out: 0.2 where a fluid takes grid by itself."},
     [](M& m, const V& v) { m.particle_shifting = v.real; }},
    {{.name = "porosity",
      .standard = "",
      .range = {0, 1, true, true},
      .meaning = "Share of the volume that is pores, full of the scene's [water]: density is with it, and the law's "
                 "stress is effective. Left out: no water."},
     [](M& m, const V& v) { m.porosity = v.real; }},
    {{.name = "conductivity",
      .unit = "m/s",
      .standard = "",
      .range = above_zero,
      .meaning = "Hydraulic conductivity k of Darcy's law, of soil with a porosity."},
     [](M& m, const V& v) { m.conductivity = v.real; }},
});

const std::vector<KeyRow<BodySpec>> bodies = in_tables<BodySpec>({
    {{.table = "body", .name = "name", .type = name, .meaning = "By which --set refers to it."},
     [](B& b, const V& v) { b.name = v.text; }},
    // Resolved to Scene::materials by the reader, which knows their names.
    {{.name = "material", .type = name, .meaning = "Name of a material."}, [](B&, const V&) {}},
    {{.name = "shape",
      .type = choice,
      .choices = {"box", "polygon", "sphere", "table"},
      .meaning = "A polygon in 3-D is a prism along z, a sphere in 2-D a disk, a table a file of particles."},
     [](B& b, const V& v) { b.shape = static_cast<BodyShape>(v.choice); }},
    {{.name = "min", .type = vector, .unit = "m", .only = {"box"}, .meaning = "Lower corner."},
     [](B& b, const V& v) { b.min = v.triple(); }},
    {{.name = "max", .type = vector, .unit = "m", .only = {"box"}, .meaning = "Upper corner."},
     [](B& b, const V& v) { b.max = v.triple(); }},
    {{.name = "points",
      .type = points,
      .unit = "m",
      .only = {"polygon"},
      .meaning = "Corners in x and y, either way round."},
     [](B& b, const V& v) { b.points = v.points; }},
    {{.name = "z",
      .type = pair,
      .unit = "m",
      .standard = "",
      .only = {"polygon"},
      .meaning = "Ends of the prism; needed in 3-D, not used in 2-D."},
     [](B& b, const V& v) { b.min[2] = v.numbers[0], b.max[2] = v.numbers[1]; }},
    {{.name = "center", .type = vector, .unit = "m", .only = {"sphere"}, .meaning = "Of the sphere."},
     [](B& b, const V& v) { b.center = v.triple(); }},
    {{.name = "radius", .unit = "m", .range = above_zero, .only = {"sphere"}, .meaning = "Of the sphere."},
     [](B& b, const V& v) { b.radius = v.real; }},
    {{.name = "file",
      .type = text,
      .only = {"table"},
      .meaning = ".csv or .h5 with x, y, z and, if wanted, vx, vy, vz [m/s] and mass [kg]; relative to the scene."},
     [](B& b, const V& v) { b.file = v.text; }},
    {{.name = "particles_per_cell",
      .type = per_axis,
      .standard = "2",
      .range = {1, 32},
      .meaning = "Along each axis; boxes round it to fit, so that their volume is exact."},
     [](B& b, const V& v) {
         for (std::size_t a = 0; a < v.numbers.size(); ++a) b.particles_per_cell[a] = static_cast<int>(v.numbers[a]);
     }},
    {{.name = "seeding",
      .type = choice,
      .standard = "\"lattice\"",
      .choices = {"lattice", "jittered"},
      .only = {"box", "polygon", "sphere"},
      .meaning = "Particles on a lattice, or moved from it at random."},
     [](B& b, const V& v) { b.seeding = static_cast<Seeding>(v.choice); }},
    {{.name = "jitter",
      .standard = "0.25",
      .range = {0, 0.5},
      .only = {"box", "polygon", "sphere"},
      .meaning = "Largest move along an axis over the particles' spacing; used by seeding jittered."},
     [](B& b, const V& v) { b.jitter = v.real; }},
    {{.name = "velocity",
      .type = vector,
      .unit = "m/s",
      .standard = "[0, 0, 0]",
      .meaning = "At the start; a table's own velocities are added."},
     [](B& b, const V& v) { b.velocity = v.triple(); }},
    {{.name = "over_consolidation_ratio",
      .standard = "1.0",
      .range = from_one,
      .meaning = "Of the preconsolidation pressure over that of a yield surface through the stress of the start; for "
                 "laws that keep one."},
     [](B& b, const V& v) { b.start.over_consolidation_ratio = v.real; }},

    {{.table = "body.wave",
      .name = "velocity",
      .type = vector,
      .unit = "m/s",
      .meaning = "Amplitude: v += velocity sin(2 pi (x[axis] - origin) / wavelength) at the start."},
     [](B& b, const V& v) { b.wave.velocity = v.triple(); }},
    {{.name = "axis",
      .type = choice,
      .standard = "\"x\"",
      .choices = {"x", "y", "z"},
      .meaning = "Along which the velocity varies."},
     [](B& b, const V& v) { b.wave.axis = v.choice; }},
    {{.name = "origin", .unit = "m", .standard = "0.0", .meaning = "A place where it is zero."},
     [](B& b, const V& v) { b.wave.origin = v.real; }},
    {{.name = "wavelength", .unit = "m", .range = above_zero, .meaning = "Length of one period."},
     [](B& b, const V& v) { b.wave.wavelength = v.real; }},

    {{.table = "body.geostatic",
      .name = "surface",
      .unit = "m",
      .meaning = "Height of the free surface: the start is sigma_v = -density g (surface - height)."},
     [](B& b, const V& v) { b.geostatic = true, b.geostatic_surface = v.real; }},
    {{.name = "k0", .standard = "1.0", .range = from_zero, .meaning = "sigma_h / sigma_v; 1: a fluid's pressure."},
     [](B& b, const V& v) { b.geostatic_k0 = v.real; }},
});

const std::vector<KeyRow<FacedWall>> walls = in_tables<FacedWall>({
    {{.table = "wall",
      .name = "face",
      .type = choice,
      .choices = {"x-min", "x-max", "y-min", "y-max", "z-min", "z-max"},
      .meaning = "Face of the domain; --set refers to the wall by it. A face without a wall is as kind none."},
     [](W& w, const V& v) { w.face = v.choice; }},
    {{.name = "kind",
      .type = choice,
      .choices = {"none", "no-slip", "free-slip", "friction", "open", "undrained", "voellmy", "absorbing"},
      .meaning =
          "open: what leaves is counted and gone; none: a particle that gets there ends the run; undrained and "
          "voellmy: as the laws of structures, by a plane wall-FACE of structures.csv; absorbing: lets waves out, "
          "and bears what ground at rest on it weighs."},
     [](W& w, const V& v) {
         constexpr int first_law = 5, absorbing = 7;
         w.wall.kind = v.choice < first_law ? static_cast<WallKind>(v.choice) : WallKind::law;
         w.wall.absorbs = v.choice == absorbing;
         if (v.choice >= first_law && !w.wall.absorbs)
             w.bed.law = v.choice == first_law ? InterfaceLaw::undrained : InterfaceLaw::voellmy;
     }},
    {{.name = "material",
      .type = text,
      .standard = "",
      .only = {"absorbing"},
      .meaning = "Of what is behind it, whose density and wave speeds it has; left out: the soil beside it goes on."},
     [](W& w, const V& v) { w.wall.material = v.text; }},
    {{.name = "drainage",
      .type = choice,
      .standard = "\"closed\"",
      .choices = {"closed", "open"},
      .meaning = "Whether water of the ground passes: open, the pore pressure behind is 0."},
     [](W& w, const V& v) { w.wall.drains = v.choice == 1; }},
    {{.name = "friction", .range = from_zero, .only = {"friction", "voellmy"}, .meaning = "Coulomb coefficient."},
     [](W& w, const V& v) { w.wall.friction = w.bed.friction = v.real; }},
    {{.name = "alpha", .range = {0, 1}, .only = {"undrained"}, .meaning = "Share of su that the wall can bear."},
     [](W& w, const V& v) { w.bed.alpha = v.real; }},
    {{.name = "su",
      .type = real_or_choice,
      .unit = "Pa",
      .range = above_zero,
      .choices = {"soil"},
      .only = {"undrained"},
      .meaning = "Undrained shear strength at the wall, as of structures."},
     [](W& w, const V& v) { w.bed.su = v.real, w.bed.soil_su = v.choice >= 0; }},
    {{.name = "xi",
      .unit = "m/s2",
      .range = above_zero,
      .only = {"voellmy"},
      .meaning = "Voellmy's coefficient of turbulent friction, as of structures."},
     [](W& w, const V& v) { w.bed.xi = v.real; }},
    {{.name = "density",
      .unit = "kg/m3",
      .standard = "",
      .range = above_zero,
      .only = {"voellmy"},
      .meaning = "Of the soil that slides; left out: that of the materials, if it is one."},
     [](W& w, const V& v) { w.bed.density = v.real; }},
});

}  // namespace

const std::vector<KeyRow<MaterialSpec>>& material_rows() {
    return materials;
}
const std::vector<KeyRow<BodySpec>>& body_rows() {
    return bodies;
}
const std::vector<KeyRow<FacedWall>>& wall_rows() {
    return walls;
}

}  // namespace moraine
