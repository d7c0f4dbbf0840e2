#include <doctest/doctest.h>

#include <chrono>
#include <filesystem>

#include "scene/scene_text.hpp"

using namespace moraine;

TEST_CASE("a misspelt key names the nearest") {
    CHECK(said_of("cfl = 0.4", "clf = 0.4") ==
          "scene.toml:10: time.clf is not a key (no such key). Did you mean time.cfl?");
    CHECK(said_of("young =", "yuong =") ==
          "scene.toml:17: material.clay.yuong is not a key (no such key). Did you mean material.clay.young?");
    CHECK(said_of("radius =", "raduis =") ==
          "scene.toml:31: body.disk.raduis is not a key (no such key). Did you mean body.disk.radius?");
    CHECK(said_of("[output]", "[ouput]") == "scene.toml:11: ouput is not a key (no such key). Did you mean output?");
    CHECK(said_of_set("numeric.shape=linear") ==
          "--set numeric.shape=linear: numeric is not a key (no such key). Did you mean numerics?");
}

TEST_CASE("a key in the wrong table names the right one") {
    CHECK(said_of("title = \"good\"", "precision = \"single\"") ==
          "scene.toml:1: precision is not a key (no such key). Did you mean numerics.precision?");
}

TEST_CASE("a key of another law is refused") {
    CHECK(said_of("su = 2.0e3", "su = 2.0e3\ncohesion = 1.0").starts_with("scene.toml:20: material.clay.cohesion"));
}

TEST_CASE("a key of another shape is refused") {
    CHECK(said_of("max = [1.0, 1.0]", "max = [1.0, 1.0]\nradius = 1.0") ==
          "scene.toml:26: body.block.radius is not used (it is for shape sphere). Remove it, or set body.block.shape?");
}

TEST_CASE("a wrong type names the right one") {
    CHECK(said_of("end = 1.0", "end = \"20\"") ==
          "scene.toml:9: time.end is a string (must be a number [s]). Did you mean 20, without quotes?");
    CHECK(said_of("dimensions = 2", "dimensions = 2.5") ==
          "scene.toml:2: dimensions is the number 2.5 (must be a whole number). Look up dimensions in "
          "inputs/reference.toml?");
    CHECK(said_of("max = [4.0, 2.0]", "max = 4.0").starts_with("scene.toml:6: domain.max is the number 4"));
    CHECK(said_of("min = [0.0, 0.0]", "min = [0.0]") ==
          "scene.toml:5: domain.min has 1 number (must be one number for each dimension [m]). Give 2?");
    CHECK(said_of("[time]\nend = 1.0\ncfl = 0.4", "time = 1.0").find("scene.toml:8: domain.time is not a key") == 0);
    CHECK(said_about("material = 1\n" + good_scene).find("TOML") != std::string::npos);
    CHECK(said_of("[[wall]]", "[wall]").starts_with("scene.toml:32: wall is a table (must be a list of tables)"));
    CHECK(said_of("fields = [\"velocity\"]", "fields = \"velocity\"").find("a list of strings") != std::string::npos);
}

TEST_CASE("a number out of range names the range") {
    CHECK(said_of("density = 1600.0", "density = -1600.0") ==
          "scene.toml:16: material.clay.density = -1600 (must be > 0). Did you mean 1600?");
    CHECK(said_of("poisson = 0.45", "poisson = 0.6") ==
          "scene.toml:18: material.clay.poisson = 0.6 (must be in (-1, 0.5)). Did you mean 0.49?");
    CHECK(said_of("cfl = 0.4", "cfl = 1.6") ==
          "scene.toml:10: time.cfl = 1.6 (must be in (0, 1.5]). Did you mean 1.5?");
    CHECK(said_of("cfl = 0.4", "cfl = 0").starts_with("scene.toml:10: time.cfl = 0 (must be in (0, 1.5])"));
    CHECK(said_of("cell = 0.1", "cell = nan").starts_with("scene.toml:7: domain.cell = nan (must be a finite number)"));
    CHECK(said_of("end = 1.0", "end = inf").starts_with("scene.toml:9: time.end = inf (must be a finite number)"));
    CHECK(said_of("max = [4.0, 2.0]", "max = [4.0, nan]").starts_with("scene.toml:6: domain.max = nan"));
    CHECK(said_of_set("material.clay.poisson=0.6") ==
          "--set material.clay.poisson=0.6: material.clay.poisson = 0.6 (must be in (-1, 0.5)). Did you mean 0.49?");
    CHECK(said_of_set("body.disk.particles_per_cell=0").find("in [1, 32]") != std::string::npos);
}

TEST_CASE("a word that is none of the choices names the nearest") {
    CHECK(said_of_set("numerics.shape=quadratc") ==
          "--set numerics.shape=quadratc: numerics.shape = \"quadratc\" (must be one of linear, gimp, "
          "gimp-contiguous, quadratic, cubic). Did you mean quadratic?");
    CHECK(said_of_set("numerics.transfer=apik").ends_with("Did you mean apic?"));
    CHECK(said_of_set("numerics.stress_update=ulf").ends_with("Did you mean usf?"));
    CHECK(said_of("law = \"von-mises\"", "law = \"von-misses\"").ends_with("Did you mean von-mises?"));
    CHECK(said_of("face = \"y-min\"", "face = \"ymin\"").ends_with("Did you mean y-min?"));
    CHECK(said_of_set("balance.partitioner=metsi").ends_with("Did you mean metis?"));
}

TEST_CASE("a missing key is named, with the table that needs it") {
    CHECK(
        said_of("su = 2.0e3\n", "") ==
        "scene.toml:13: material.clay.su is missing (must be a number or a profile [Pa]). Add su = ... to this table?");
    CHECK(said_of("dimensions = 2\n", "").starts_with("scene.toml: dimensions is missing"));
    CHECK(said_of("cell = 0.1\n", "").starts_with("scene.toml:4: domain.cell is missing"));
    CHECK(said_of("friction = 0.3\n", "").starts_with("scene.toml:32: wall.y-min.friction is missing"));
    CHECK(said_of("name = \"disk\"\n", "").starts_with("scene.toml:26: body.2.name is missing"));
}

TEST_CASE("a material that is not there is refused") {
    CHECK(said_of("material = \"clay\"", "material = \"caly\"") ==
          "scene.toml:22: body.block.material = \"caly\" (there is no such material). Did you mean clay?");
}

TEST_CASE("what a law says of its parameters together is an error of the scene") {
    CHECK(said_of_set("material.clay.rate_log=0.1").find("material.clay: rate_reference is missing") !=
          std::string::npos);
}

TEST_CASE("two tables of one name are refused") {
    CHECK(said_of("name = \"disk\"", "name = \"block\"").starts_with("scene.toml:26: body.block is there twice"));
    CHECK(said_about(good_scene + "[[wall]]\nface = \"y-min\"\nkind = \"no-slip\"\n")
              .starts_with("scene.toml:36: wall.y-min is there twice"));
    CHECK(said_of("name = \"disk\"", "name = \"a b\"").find("letters, digits") != std::string::npos);
}

TEST_CASE("a name has at most 64 characters") {
    CHECK(said_of("name = \"disk\"", "name = \"" + std::string(64, 'd') + "\"").empty());
    const std::string said = said_of("name = \"disk\"", "name = \"" + std::string(65, 'd') + "\"");
    CHECK(said.starts_with("scene.toml:27: "));
    CHECK(said.find(" has 65 characters (a name has at most 64). Shorten it?") != std::string::npos);
}

TEST_CASE("a structure without a shape is refused, and so is one of a name that is there twice") {
    CHECK(said_about(good_scene + "[[structure]]\nname = \"pipe\"\n").find("structure.pipe.shape is missing") !=
          std::string::npos);
    const std::string disk = "[[structure]]\nname = \"pipe\"\nshape = \"sphere\"\ncenter = [0.1, 0.9]\nradius = 0.01\n";
    CHECK(said_about(good_scene + disk + disk).find("structure.pipe is there twice") != std::string::npos);
}

TEST_CASE("what is not TOML is refused with its line") {
    CHECK(said_of("cell = 0.1", "cell = = 0.1").starts_with("scene.toml:7: "));
}

TEST_CASE("a file that is not there is refused") {
    CHECK_THROWS_WITH_AS(read_scene("nowhere.toml"),
                         "nowhere.toml: the scene cannot be read (No such file or directory). Is the path right?",
                         InputError);
    CHECK_THROWS_AS(read_scene(inputs_folder()), InputError);
}

TEST_CASE(
    "keys too deep for the parser's stack are refused with their line, and points of numbers and strings are no "
    "levels") {
    std::string deep = "a";
    for (int level = 1; level < 50000; ++level) deep += ".a";
    for (const std::string& text : {"[" + deep + "]\n", deep + " = 1\n", "x = {" + deep + " = 1}\n"})
        CHECK(said_about("title = \"\\\" # '\" # \"\n" + text) ==
              "scene.toml:2: the key is too deep (more than 32 levels). Is it a key of inputs/reference.toml?");
    CHECK(said_about("title = \"\"\"\n\n\"\"\"\n" + deep + " = 1\n").starts_with("scene.toml:4: the key is too deep"));
    CHECK(said_of_set(deep + "=1").find("the key is too deep") != std::string::npos);
    CHECK(said_of_set("time.end={" + deep + "=1}").find("the key is too deep") != std::string::npos);
    const std::string dots(100, '.');
    CHECK(said_of("cell = 0.1", "cell = 0.1 # \"" + dots).empty());
    CHECK(said_about("x = \"" + dots + "\"\n").find("x is not a key") != std::string::npos);
    std::string numbers = "0.5";
    for (int k = 0; k < 100; ++k) numbers += ", 0.5";
    CHECK(said_about("x = [" + numbers + "]\n").find("x is not a key") != std::string::npos);
}

TEST_CASE("a very long key is refused at once and quoted in part") {
    const auto start = std::chrono::steady_clock::now();
    const std::string said = said_about(std::string(1000000, 'x') + " = 1\n");
    CHECK(said.starts_with("scene.toml:1: xxx"));
    CHECK(said.find("x ... x") != std::string::npos);
    CHECK(said.size() < 2000);
    CHECK(said_about(std::string(5000000, 'x') + " = 1\n").find("it has more than 4 MiB") != std::string::npos);
    CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(5));
}

TEST_CASE("control characters of a scene reach no terminal") {
    CHECK(said_of("cell = 0.1", "\"ce\\u0000\\u001b[31m\\nll\" = 0.1")
              .find("domain.ce\\u0000\\u001b[31m\\u000all is not a key") != std::string::npos);
}

TEST_CASE("what is no file with an end is refused") {
    const TestFolder folder;
    std::filesystem::create_symlink("loop.toml", folder.file("loop.toml"));
    CHECK_THROWS_WITH_AS(read_scene(folder.file("loop.toml")),
                         (folder.file("loop.toml") +
                          ": the scene cannot be read (Too many levels of symbolic links). Is the path right?")
                             .c_str(),
                         InputError);
    CHECK_THROWS_WITH_AS(
        read_scene("/dev/zero"),
        "/dev/zero: the scene cannot be read (it has more than 4 MiB). Is this a scene? Particles can be a "
        "table, body.file?",
        InputError);
}

TEST_CASE("what is said of a key fits the scene's dimensions and the file that has the key") {
    CHECK(said_of_set("body.disk.velocity=[nan,0]") ==
          "--set body.disk.velocity=[nan,0]: body.disk.velocity = nan (must be a finite number). Did you mean [0, 0], "
          "the default?");
    CHECK(said_of_set("gravity=9.81").ends_with("Write it as in gravity = [0, 0]?"));
    CHECK(said_of_set("domain.cell=0").ends_with("Look up cell in inputs/reference.toml?"));
    CHECK(said_of("[output]", "[hazard]\ncell = 0\n[output]")
              .ends_with("Look up cell in inputs/reference_terrain.toml?"));
}

TEST_CASE("a bad --set is refused") {
    CHECK(said_of_set("domain.cell").find("must be KEY=VALUE") != std::string::npos);
    CHECK(said_of_set("body.disc.radius=1").find("there is no body \"disc\" (no such name). Did you mean disk?") !=
          std::string::npos);
    CHECK(said_of_set("body.radius=1").find("Write body.NAME.KEY=VALUE?") != std::string::npos);
    CHECK(said_of_set("wall.ymax.kind=open").find("must be one of x-min") != std::string::npos);
    CHECK(said_of_set("domain.cell.x=1").find("cell has no keys") != std::string::npos);
    CHECK(said_of_set("time.end=2\ntime.cfl=9").find("time.end is a string") != std::string::npos);
}
