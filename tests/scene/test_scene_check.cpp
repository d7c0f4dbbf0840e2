#include <doctest/doctest.h>

#include "scene/scene_check.hpp"
#include "scene/scene_text.hpp"

using namespace moraine;

namespace {

bool says(const std::string& message, const std::string& part) {
    INFO(message);
    CHECK(message.find(part) != std::string::npos);
    return message.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("a domain that is not a whole number of cells is refused") {
    CHECK(said_of("max = [4.0, 2.0]", "max = [4.0, 2.03]") ==
          "scene.toml:6: the domain has 20.3 cells along y (must be a whole number: walls lie on nodes). Did you mean "
          "domain.max = 2 along y?");
    CHECK(
        said_of("max = [4.0, 2.0]", "max = [4.0, -2.0]").starts_with("scene.toml:6: the domain has no length along y"));
}

TEST_CASE("rounding of lengths is not an error") {
    CHECK(said_about(good_scene, {"domain.max=[4.2, 2.1]", "domain.cell=0.1"}).empty());
    CHECK(said_about(good_scene, {"domain.min=[-0.3, 0.0]", "domain.max=[4.2, 2.1]"}).empty());
}

TEST_CASE("a periodic length that is not whole blocks is refused") {
    CHECK(said_of_set("domain.periodic=[\"x\"]").empty());
    CHECK(said_about(good_scene, {"domain.periodic=[\"x\"]", "domain.max=[4.2, 2.0]"}) ==
          "--set domain.periodic=[\"x\"]: the periodic axis x has 42 cells (must be whole blocks of 4 cells). Did you "
          "mean domain.max = 4.4 along x?");
}

TEST_CASE("a wall on a periodic axis is refused") {
    says(said_of_set("domain.periodic=[\"y\"]"), "scene.toml:32: wall y-min stands on a periodic axis");
}

TEST_CASE("an axis that the scene has not is refused") {
    says(said_of_set("domain.periodic=[\"z\"]"), "the axis z is not there");
    says(said_of_set("balance.axis=z"), "balance.axis = \"z\" (the scene has 2 dimensions)");
    says(said_of("face = \"y-min\"", "face = \"z-min\""), "scene.toml:32: wall.z-min is not there");
}

TEST_CASE("a domain that is too large for keys is refused") {
    says(said_of_set("domain.cell=1e-9"), "4e+09 cells along x");
}

TEST_CASE("an output field that is not there is refused") {
    CHECK(said_of("fields = [\"velocity\"]", "fields = [\"velocty\"]") ==
          "scene.toml:12: output.fields has \"velocty\" (no such field in this scene). Did you mean velocity?");
    CHECK(said_of_set("output.fields=[\"stress\", \"pressure\", \"body\"]").empty());
    says(said_of_set("output.fields=[\"mass\", \"mass\"]"), "output.fields has \"mass\" twice");
    says(said_of_set("output.labels=[\"id\", \"ranks\"]"), "output.labels has \"ranks\"");
    CHECK(said_of_set("output.labels=[]").empty());
}

TEST_CASE("a body outside the domain is refused") {
    CHECK(said_of("max = [1.0, 1.0]", "max = [1.0, 2.5]") ==
          "scene.toml:20: body.block reaches from 0 to 2.5 along y (the domain from 0 to 2). Move the body or widen "
          "domain.min, domain.max?");
    says(said_of("center = [2.0, 1.0]", "center = [3.9, 1.0]"), "scene.toml:26: body.disk reaches from 3.4 to 4.4");
}

TEST_CASE("bodies that overlap are refused") {
    says(said_of("center = [2.0, 1.0]", "center = [1.2, 1.0]"), "scene.toml:26: body.disk overlaps body.block");
}

TEST_CASE("bodies may touch") {
    CHECK(said_of("shape = \"sphere\"\ncenter = [2.0, 1.0]\nradius = 0.5",
                  "shape = \"box\"\nmin = [1.0, 0.0]\nmax = [2.0, 1.0]")
              .empty());
}

TEST_CASE("a thin body between the particles of another is an overlap") {
    says(said_of("shape = \"sphere\"\ncenter = [2.0, 1.0]\nradius = 0.5",
                 "shape = \"box\"\nmin = [0.5, 0.0]\nmax = [0.51, 1.5]"),
         "overlaps");
}

TEST_CASE("the first particle of a box that is in another box is named") {
    says(said_of("shape = \"sphere\"\ncenter = [2.0, 1.0]\nradius = 0.5",
                 "shape = \"box\"\nmin = [0.52, 0.3]\nmax = [2.0, 0.4]"),
         "body.disk overlaps body.block (both have (0.544667, 0.325))");
    CHECK(said_of("shape = \"sphere\"\ncenter = [2.0, 1.0]\nradius = 0.5",
                  "shape = \"box\"\nmin = [0.0, 1.0]\nmax = [1.0, 1.5]")
              .empty());
}

TEST_CASE("the order of the bodies does not hide an overlap") {
    const std::string thin_first =
        replaced(good_scene, "min = [0.0, 0.0]\nmax = [1.0, 1.0]", "min = [0.5, 0.0]\nmax = [0.51, 1.0]");
    says(said_about(replaced(thin_first, "shape = \"sphere\"\ncenter = [2.0, 1.0]\nradius = 0.5",
                             "shape = \"box\"\nmin = [0.0, 0.0]\nmax = [1.0, 1.5]")),
         "body.disk overlaps body.block");
}

TEST_CASE("a body without particles is refused") {
    says(said_of("radius = 0.5", "radius = 0.001"), "scene.toml:26: body.disk has no particles");
    const std::string no_body = good_scene.substr(0, good_scene.find("[[body]]"));
    says(said_about(no_body), "the scene has no body");
}

TEST_CASE("a box without length is refused") {
    says(said_of("max = [1.0, 1.0]", "max = [0.0, 1.0]"), "body.block has no length along x");
}

TEST_CASE("a polygon that crosses itself, or has no area, is refused") {
    const std::string disk = "shape = \"sphere\"\ncenter = [2.0, 1.0]\nradius = 0.5";
    const std::string polygon = "shape = \"polygon\"\npoints = ";
    CHECK(said_of(disk, polygon + "[[2, 0], [3, 0], [3, 1], [2, 1]]").empty());
    says(said_of(disk, polygon + "[[2, 0], [3, 1], [3, 0], [2, 1]]"), "scene.toml:30: body.disk crosses itself");
    says(said_of(disk, polygon + "[[2, 0], [3, 0], [2.5, 0]]"), "body.disk has no area");
    says(said_of(disk, polygon + "[[2, 0], [3, 0]]"), "body.disk.points has 2 points");
    says(said_of(disk, "z = [0, 1]\n" + polygon + "[[2, 0], [3, 0], [3, 1]]"), "body.disk.z is not used");
}

TEST_CASE("geostatic stress needs weight") {
    says(said_about(good_scene, {"gravity=[0, 0]", "body.block.geostatic.surface=1"}), "gravity is zero");
}

TEST_CASE("a state at the start that is not used, or cannot be, is refused") {
    says(said_about(good_scene, {"body.disk.over_consolidation_ratio=2"}),
         "body.disk.over_consolidation_ratio is not used (law von-mises keeps no preconsolidation pressure). Remove "
         "it?");
    std::string scene = good_scene;
    const std::size_t from = scene.find("law = "), to = scene.find("[[body]]");
    scene.replace(from, to - from,
                  "law = \"modified-cam-clay\"\ndensity = 1600.0\ncompression_index = 0.2\nswelling_index = 0.04\n"
                  "critical_state_ratio = 1.0\npoisson = 0.3\nreference_void_ratio = 0.3\n");
    CHECK(said_about(scene, {"body.disk.over_consolidation_ratio=2"}).empty());
    says(said_about(scene, {"body.block.geostatic.surface=1", "body.block.over_consolidation_ratio=2"}),
         "body.block: the void ratio at the start is not above 0");
}

TEST_CASE("a step that is not stable with the method is refused, but 0.5 is taken with any") {
    CHECK(said_about(good_scene, {"time.cfl=0.76"}).empty());
    says(said_about(good_scene, {"time.cfl=0.77"}),
         "time.cfl = 0.77 is more than is stable (0.76 with this shape, transfer and stress update). At most 0.76, or "
         "leave it out?");
    CHECK(said_about(good_scene, {"time.cfl=0.86", "numerics.transfer=apic"}).empty());
    says(said_about(good_scene, {"time.cfl=0.87", "numerics.transfer=apic"}), "(0.86 with");
    CHECK(said_about(good_scene, {"time.cfl=1.1", "numerics.shape=cubic", "numerics.transfer=apic"}).empty());
    says(said_about(good_scene, {"time.cfl=1.1", "numerics.shape=gimp", "numerics.transfer=flip"}), "(0.61 with");
    CHECK(said_about(good_scene, {"time.cfl=0.5", "numerics.shape=linear"}).empty());
    says(said_about(good_scene, {"time.cfl=0.51", "numerics.shape=linear"}),
         "(0.14 with this shape, transfer and stress update). At most 0.5, or leave it out?");
    says(said_about(good_scene, {"time.cfl=0.67", "numerics.shape=gimp-contiguous"}), "(0.66 with");
}

TEST_CASE("a fixed step whose end is out of reach, or that waves cross in no time, is refused") {
    const std::string text = replaced(good_scene, "cfl = 0.4\n", "");
    CHECK(said_about(text, {"time.dt=1e-9"}).empty());
    CHECK(said_about(text, {"time.dt=1e-30"}) ==
          "--set time.dt=1e-30: time.dt = 1e-30 needs 1e+30 steps to time.end (at most 1e+10). By cfl it would be "
          "0.0018 s?");
    CHECK(said_about(text, {"time.dt=0.2"}).empty());
    says(said_about(text, {"time.dt=1e30"}), "time.dt = 1e+30 lets waves cross 3.4e+32 cells (unstable above about 1");
}

TEST_CASE("waves or speeds that leave the end out of reach are refused") {
    const std::string message = said_of("young = 5.0e5", "young = 1.0e300");
    says(message, "scene.toml:13: body.block with waves of 4.9e+148 m/s needs 1.2e+150 steps to time.end");
    says(message, "Are young [Pa]");
    says(said_of_set("material.clay.density=1e-300"), "needs");
    says(said_of_set("body.disk.velocity=[1e200, 0.0]"), "body.disk with waves");
    says(said_of_set("time.end=1e12"), "steps to time.end");
}

TEST_CASE("an affine transfer with linear shapes is refused") {
    CHECK(said_about(good_scene, {"numerics.shape=linear", "numerics.transfer=apic"}) ==
          "--set numerics.transfer=apic: numerics.transfer = \"apic\" with shape \"linear\" (the inertia D of a hat's "
          "weights is zero at nodes, and rounding grows there). Use shape = \"quadratic\", or transfer = \"flip\"?");
    says(said_about(good_scene, {"numerics.shape=linear", "numerics.transfer=tpic"}), "transfer = \"pic\"?");
    says(said_about(good_scene, {"numerics.shape=linear", "numerics.transfer=aflip"}), "transfer = \"flip\"?");
    CHECK(said_about(good_scene, {"numerics.shape=linear", "numerics.transfer=pic"}).empty());
    CHECK(said_about(good_scene, {"numerics.shape=gimp", "numerics.transfer=apic"}).empty());
}

TEST_CASE("substeps by the scene are ten where it can have them, and else one") {
    const std::string mud = replaced(replaced(good_scene, "von-mises", "newtonian"), "su = 2.0e3", "viscosity = 50.0");
    const auto substeps = [&](const std::vector<std::string>& more) {
        std::vector<std::string> sets{"numerics.substeps=auto", "material.clay.volumetric=grid"};
        sets.insert(sets.end(), more.begin(), more.end());
        return read_text(mud, sets).substeps;
    };
    CHECK(substeps({}) == 10);
    CHECK(substeps({"material.clay.poisson=0.4"}) == 1);
    CHECK(substeps({"material.clay.volumetric=particle"}) == 1);
    says(said_about(mud, {"numerics.substeps=most"}), "must be \"auto\", or a whole number");
}

TEST_CASE(
    "the grid's pressure is for what flows, its substeps for nearly incompressible fluids without free structures") {
    const std::string mud = replaced(replaced(good_scene, "von-mises", "newtonian"), "su = 2.0e3", "viscosity = 50.0");
    const std::string grid = "material.clay.volumetric=grid", stiff = "material.clay.poisson=0.49";
    CHECK(said_about(mud, {grid}).empty());
    CHECK(said_about(mud, {grid, stiff, "numerics.substeps=10"}).empty());
    const std::string elastic = replaced(replaced(good_scene, "von-mises", "linear-elastic"), "su = 2.0e3", "");
    says(said_about(elastic, {grid}), "it is for fluids and undrained clays");
    CHECK(said_about(good_scene, {grid}).empty());
    says(said_about(good_scene, {grid, stiff, "numerics.substeps=4"}), "substeps are for fluids");
    says(said_about(mud, {grid, "numerics.shape=cubic"}), "it is for quadratic splines");
    says(said_about(mud, {grid, "numerics.stress_update=musl"}), "with this stress_update or transfer");
    says(said_about(mud, {"material.clay.volumetric=particle", stiff, "numerics.substeps=4"}),
         "a material has its pressure on particles");
    says(said_about(mud, {grid, "material.clay.poisson=0.3", "numerics.substeps=4"}), "below 0.45");
    says(said_about(mud, {grid, stiff, "numerics.substeps=11"}), "numerics.substeps");
    const std::string ball =
        "\n[[structure]]\nname = \"ball\"\nshape = \"sphere\"\ncenter = [1.0, 1.0]\nradius = 0.3\nclear = true\n";
    CHECK(said_about(mud + ball, {grid, stiff, "numerics.substeps=4"}).empty());
    says(said_about(mud + ball + "[structure.motion]\nkind = \"free\"\nmass = 10.0\n",
                    {grid, stiff, "numerics.substeps=4"}),
         "with structure.ball, which is free");
}

TEST_CASE("smoothing and shifting are for what flows, without means of cells") {
    const std::string mud = replaced(replaced(good_scene, "von-mises", "newtonian"), "su = 2.0e3", "viscosity = 50.0");
    const std::string smooth = "material.clay.pressure_smoothing=0.22", shift = "material.clay.particle_shifting=0.1";
    const std::string elastic = replaced(replaced(good_scene, "von-mises", "linear-elastic"), "su = 2.0e3", "");
    CHECK(said_about(mud, {smooth, shift}).empty());
    CHECK(
        said_about(elastic, {shift}) ==
        "--set material.clay.particle_shifting=0.1: material.clay.particle_shifting with law \"linear-elastic\" (it is "
        "for fluids and undrained clays: bingham, herschel-bulkley, newtonian, tresca, von-mises). Remove it?");
    says(said_about(elastic, {smooth}), "material.clay.pressure_smoothing with law");
    CHECK(said_about(good_scene, {smooth, shift}).empty());
    says(said_about(mud, {smooth, "material.clay.volumetric=cell"}), "means of cells smooth pressures already");
}
