#include <doctest/doctest.h>

#include "core/courant.hpp"
#include "scene/read_scene.hpp"
#include "scene/scene_text.hpp"

using namespace moraine;

TEST_CASE("a scene is read into its fields") {
    const Scene s = read_text(good_scene);
    CHECK(s.name == "scene");
    CHECK(s.source.title == "good");
    CHECK(s.dimensions == 2);
    CHECK(s.gravity == Triple{0, -9.81, 0});
    CHECK(s.max == Triple{4, 2, 0});
    CHECK(s.cell == 0.1);
    CHECK(s.cfl == 0.4);
    CHECK(s.dt == 0);
    CHECK(s.output.fields == std::vector<std::string>{"velocity"});
    REQUIRE(s.materials.size() == 1);
    CHECK(s.materials[0].law == "von-mises");
    CHECK(s.materials[0].parameters.size() == 9);
    CHECK(s.materials[0].parameters[2] == 2000);
    CHECK(s.materials[0].parameters[8] == 10);  // xi95 by default
    REQUIRE(s.bodies.size() == 2);
    CHECK(s.bodies[1].shape == BodyShape::sphere);
    CHECK(s.bodies[1].radius == 0.5);
    CHECK(s.bodies[1].particles_per_cell[1] == 2);
    CHECK(s.walls[1][0].kind == WallKind::friction);
    CHECK(s.walls[1][0].friction == 0.3);
    CHECK(s.walls[0][1].kind == WallKind::none);
}

TEST_CASE("a scene that names no transfer takes APIC, or FLIP with linear shapes, and the step of that method") {
    const std::string text = replaced(replaced(good_scene, "cfl = 0.4\n", ""), "poisson = 0.45", "poisson = 0.3");
    const Scene wide = read_text(text), linear = read_text(text, {"numerics.shape=linear"});
    CHECK(wide.transfer == Transfer::apic);
    CHECK(wide.cfl == doctest::Approx(0.8 * stable_courant(Shape::quadratic, Transfer::apic, StressUpdate::usl)));
    CHECK(linear.transfer == Transfer::flip);
    CHECK(linear.cfl == standard_courant(linear));
    CHECK(read_text(text, {"numerics.transfer=flip"}).transfer == Transfer::flip);
    CHECK(read_text(text, {"numerics.transfer=flip"}).flip == 1);
    CHECK(read_text(text, {"numerics.transfer=aflip"}).flip == 0.95);
    CHECK(read_text(text, {"numerics.transfer=aflip", "numerics.flip=1"}).flip == 1);
}

TEST_CASE("a fluid takes pressures on cells by itself where the scene can have them, and what it says instead") {
    const std::string mud = replaced(
        replaced(replaced(good_scene, "von-mises", "newtonian"), "su = 2.0e3", "viscosity = 50.0"), "cfl = 0.4\n", "");
    const auto takes_cells = [](const Scene& s) {
        const MaterialSpec& m = s.materials[0];
        const bool cells = m.volumetric == Volumetric::grid;
        CHECK((m.pressure_smoothing == 0.22) == cells);
        CHECK((m.particle_shifting == 0.2) == cells);
        CHECK((s.transfer == Transfer::aflip) == cells);
        CHECK(s.flip == (cells ? 0.95 : 1));
        CHECK(s.cfl == standard_courant(s));
        CHECK(s.substeps == (cells ? 10 : 1));
        return cells;
    };
    const std::vector<std::string> stiff{"material.clay.poisson=0.49"};
    const auto with = [&](const char* set) { return std::vector<std::string>{stiff[0], set}; };
    const std::string ball =
        "\n[[structure]]\nname = \"ball\"\nshape = \"sphere\"\ncenter = [1.0, 1.0]\nradius = 0.3\nclear = true\n";
    CHECK(takes_cells(read_text(mud, stiff)));
    CHECK(read_text(mud, stiff).bed == Bed::nodes);
    CHECK(takes_cells(read_text(mud + ball, stiff)));
    CHECK(read_text(mud + ball, stiff).bed == Bed::surface);
    CHECK(takes_cells(read_text(mud + ball, with("numerics.bed=surface"))));
    CHECK(!takes_cells(read_text(mud + ball, with("numerics.bed=nodes"))));
    CHECK(read_text(replaced(good_scene, "cfl = 0.4\n", "") + ball, {"material.clay.poisson=0.3"}).bed == Bed::nodes);
    CHECK(!takes_cells(read_text(mud, {"material.clay.poisson=0.4"})));
    CHECK(!takes_cells(read_text(mud, with("numerics.shape=cubic"))));
    CHECK(!takes_cells(read_text(mud, with("material.clay.volumetric=particle"))));
    const std::string clay = replaced(good_scene, "cfl = 0.4\n", "");
    const Scene undrained = read_text(clay + ball, stiff);
    CHECK(undrained.materials[0].volumetric == Volumetric::grid);
    CHECK(!has_fluid_terms(undrained.materials[0]));
    CHECK(undrained.transfer == Transfer::aflip);
    CHECK(undrained.substeps == 1);
    for (const char* set : {"material.clay.volumetric=cell", "numerics.bed=nodes", "material.clay.poisson=0.4"})
        CHECK(read_text(clay + ball, {"material.clay.poisson=0.49", set}).transfer == Transfer::apic);
    CHECK(read_text(mud, with("numerics.transfer=apic")).materials[0].volumetric == Volumetric::grid);
    const Scene sleeps = read_text(mud, with("numerics.sleep=on"));
    CHECK(sleeps.materials[0].volumetric == Volumetric::grid);
    CHECK(sleeps.transfer == Transfer::apic);
}

TEST_CASE("what a scene leaves out is as in core/scene_spec.hpp") {
    const Scene s = read_text(replaced(replaced(good_scene, "cfl = 0.4\n", ""), "fields = [\"velocity\"]\n", ""),
                              {"material.clay.poisson=0.3"});
    const Scene standard;
    CHECK(s.cfl == standard_courant(s));
    CHECK(s.dt == standard.dt);
    CHECK(s.shape == standard.shape);
    CHECK(s.transfer == standard.transfer);
    CHECK(s.flip == standard.flip);
    CHECK(s.stress_update == standard.stress_update);
    CHECK(s.precision == standard.precision);
    CHECK(s.damping == standard.damping);
    CHECK(s.boundary_spline == standard.boundary_spline);
    CHECK(s.balance.partitioner == standard.balance.partitioner);
    CHECK(s.balance.weight == standard.balance.weight);
    CHECK(s.balance.trigger == standard.balance.trigger);
    CHECK(s.balance.interval == standard.balance.interval);
    CHECK(s.balance.threshold == standard.balance.threshold);
    CHECK(s.balance.axis == standard.balance.axis);
    CHECK(s.seed == standard.seed);
    CHECK(s.bodies[0].particles_per_cell == BodySpec{}.particles_per_cell);
    CHECK(s.bodies[0].jitter == 0);
    CHECK_FALSE(s.bodies[0].geostatic);
    CHECK(s.bodies[0].wave.wavelength == 0);
}

TEST_CASE("names become the right choice") {
    const Scene s = read_text(good_scene, {"numerics.shape=gimp-contiguous", "numerics.transfer=tpic",
                                           "numerics.stress_update=musl", "numerics.precision=single",
                                           "numerics.boundary=plain", "balance.trigger=every", "balance.axis=y"});
    CHECK(s.shape == Shape::gimp_contiguous);
    CHECK(s.transfer == Transfer::tpic);
    CHECK(s.stress_update == StressUpdate::musl);
    CHECK(s.precision == Precision::single_);
    CHECK_FALSE(s.boundary_spline);
    CHECK(s.balance.trigger == Trigger::every);
    CHECK(s.balance.axis == 1);
}

TEST_CASE("--set changes a key, a table of a list, and what was not there") {
    const Scene s =
        read_text(good_scene, {"domain.cell=0.05", "title=two message", "gravity=[0, -1]", "material.clay.su=3e3",
                               "body.disk.velocity=[1.0, 2.0]", "wall.y-min.kind=no-slip", "wall.x-max.kind=open",
                               "body.block.geostatic.surface=1.0", "seed=7", "wall.y-min.friction=0.1",
                               "wall.y-min.kind=friction"});
    CHECK(s.cell == 0.05);
    CHECK(s.source.title == "two message");
    CHECK(s.gravity[1] == -1);
    CHECK(s.materials[0].parameters[2] == 3000);
    CHECK(s.bodies[1].velocity == Triple{1, 2, 0});
    CHECK(s.walls[0][1].kind == WallKind::open);
    CHECK(s.walls[1][0].friction == 0.1);
    CHECK(s.bodies[0].geostatic);
    CHECK(s.bodies[0].geostatic_surface == 1);
    CHECK(s.seed == 7);
}

TEST_CASE("a periodic axis has periodic ends") {
    const Scene s = read_text(good_scene, {"domain.periodic=[\"x\"]"});
    CHECK(s.periodic[0]);
    CHECK_FALSE(s.periodic[1]);
    CHECK(s.walls[0][0].kind == WallKind::periodic);
    CHECK(s.walls[0][1].kind == WallKind::periodic);
}

TEST_CASE("a fixed step replaces cfl") {
    CHECK(read_text(replaced(good_scene, "cfl = 0.4", "dt = 1.0e-4")).dt == 1e-4);
    CHECK(said_of_set("time.dt=1e-4") ==
          "--set time.dt=1e-4: time.cfl and time.dt are both given "
          "(a step is by cfl or fixed). Remove one of them?");
}

TEST_CASE("every scene that comes with the program can be run") {
    for (const char* name : {"first_scene",         "slurry_runout",    "slurry_runout_3d",   "granular_column",
                             "elastic_bar",         "reference",        "reference_terrain",  "valley",
                             "sliding_block",       "pipe_penetration", "strip_footing",      "tbar",
                             "mud_dam_break",       "submarine_slide",  "submarine_slide_3d", "viscous_current",
                             "soft_clay_footing",   "stability",        "undercut_bed",       "erodible_bed",
                             "retrogressive_slope", "reference_water"}) {
        CAPTURE(name);
        CHECK_NOTHROW(read_scene(inputs_folder() + "/" + name + ".toml"));
    }
    CHECK_NOTHROW(read_scene(inputs_folder() + "/slurry_runout_3d.toml", {"domain.cell=0.2"}));
    CHECK_NOTHROW(read_scene(inputs_folder() + "/slurry_runout_3d.toml", {"domain.cell=0.05"}));
    CHECK_NOTHROW(read_scene(inputs_folder() + "/granular_column.toml", {"domain.cell=0.002"}));
}
