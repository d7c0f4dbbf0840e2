#include <doctest/doctest.h>

#include <chrono>
#include <cmath>

#include "app/check_report.hpp"
#include "particle_pressures.hpp"
#include "predict/prediction.hpp"
#include "predict/scene_warnings.hpp"
#include "scene/scene_text.hpp"
#include "terrain_scene.hpp"

using namespace moraine;

TEST_CASE("the prediction counts particles and mass exactly, and occupied blocks") {
    const Prediction p = predict(read_scene(inputs_folder() + "/slurry_runout.toml"));
    CHECK(p.particles == 20000);
    CHECK(p.mass == doctest::Approx(75000).epsilon(1e-12));
    // 100 x 50 cells, binned half a cell further: cells 0 to 100 and 0 to 50, in blocks of 4.
    CHECK(p.blocks == 26 * 13);
}

TEST_CASE("the prediction's step is that of the wave and the speed of the start, or fixed") {
    const double c = std::sqrt(2.5e5 * 0.505 / (1.495 * 0.01) / 1500);
    const std::string path = inputs_folder() + "/slurry_runout.toml";
    const Prediction p = predict(read_scene(path, test::particle_pressures({"body.reservoir.velocity=[3.0, 4.0]"})));
    CHECK(p.dt == doctest::Approx(0.8 * 0.86 * 0.1 / (c + 5)));
    CHECK(p.steps == std::ceil(20 / p.dt));
    CHECK(predict(read_scene(path, test::particle_pressures({"time.dt=1e-3"}))).steps == 20000);
}

TEST_CASE("a periodic axis has no block beyond its end") {
    const std::string path = inputs_folder() + "/slurry_runout.toml";
    const std::vector<std::string> full{"domain.max=[10.0, 7.5]", "domain.cell=0.125", "wall.x-min.kind=none"};
    CHECK(predict(read_scene(path, full)).blocks == 21 * 11);
    const std::string text = replaced(replaced(good_scene, "max = [4.0, 2.0]", "max = [0.8, 2.0]\nperiodic = [\"x\"]"),
                                      "max = [1.0, 1.0]", "max = [0.8, 1.0]");
    const Scene scene = read_text(text.substr(0, text.find("[[body]]\nname = \"disk\"")));
    CHECK(predict(scene).blocks == 2 * 3);
}

TEST_CASE("a structure faster than 0.3 of the waves is warned of, however its motion is said") {
    const auto said = [](const std::string& motion) {
        const std::string ball =
            "[[structure]]\nname = \"ball\"\nshape = \"sphere\"\ncenter = [3.5, 1.5]\nradius = 0.2\n";
        const auto all = scene_warnings(read_text(good_scene + ball + "motion = { " + motion + " }\n"));
        return all.empty() ? "" : all.back();
    };  // waves: 34.4 m/s
    CHECK(said("kind = \"velocity\", velocity = [6.0, 8.0]").empty());
    CHECK(
        said("kind = \"velocity\", velocity = [12.0, 16.0]").starts_with("structure.ball moves at Mach 0.58 (20 m/s"));
    CHECK(
        said("kind = \"free\", mass = 1.0, velocity = [0.0, -11.0]").starts_with("structure.ball moves at Mach 0.32"));
    CHECK(said("kind = \"sinusoid\", amplitude = [0.2, 0.0], period = 0.1")
              .starts_with("structure.ball moves at Mach 0.36"));
    CHECK(said("kind = \"sinusoid\", amplitude = [0.2, 0.0], period = 0.2").empty());
    const std::string table = "kind = \"table\", velocity = [1.0, 0.0], times = [0, 1], factors = ";
    CHECK(said(table + "[0, -20]").starts_with("structure.ball moves at Mach 0.58"));
    CHECK(said(table + "[0, -10]").empty());
}

TEST_CASE("memory follows particles, precision and ranks") {
    const std::string path = inputs_folder() + "/slurry_runout_3d.toml";
    const std::string cell = "domain.cell=0.2", flip = "numerics.transfer=flip";
    const Scene scene = read_scene(path, test::particle_pressures({cell, flip, "balance.interval=10"}));
    const Prediction p = predict(scene);
    const double one = bytes_per_rank(scene, p, 1);
    // position, velocity, stress, volume, mass, ln J; id, body, list; the law's scalars
    CHECK(one / static_cast<double>(p.particles) > 24 + 24 + 48 + 24 + 8 + 2 + 12);
    CHECK(one / static_cast<double>(p.particles) < 260);
    const double quarter = bytes_per_rank(scene, p, 4);  // and the apron of a smaller share
    CHECK(quarter > one / 4);
    CHECK(quarter < 1.1 * one / 4);
    const Scene apic = read_scene(path, test::particle_pressures({cell}));
    CHECK(bytes_per_rank(apic, p, 1) - one == doctest::Approx(72.0 * static_cast<double>(p.particles)));
    const Scene held =
        read_scene(path, test::particle_pressures({cell, flip, "output.asynchronous=on", "output.every=2"}));
    const double output = predict_output(held, p).row_bytes * static_cast<double>(p.particles) / 2;
    CHECK(bytes_per_rank(held, p, 1) - one == doctest::Approx(output).epsilon(1e-4));
    const Scene single = read_scene(path, test::particle_pressures({cell, flip, "numerics.precision=single"}));
    CHECK(bytes_per_rank(single, p, 1) < 0.65 * one);  // ids, lists and the written positions stay
}

TEST_CASE("memory follows who would sleep where that is recorded, not block loads alone") {
    const auto bytes = [](const std::string& loads, const std::string& sleep) {
        const Scene scene = read_scene(inputs_folder() + "/undercut_bed.toml",
                                       {"output.block_loads=" + loads, "numerics.sleep=" + sleep});
        const Prediction p = predict(scene);
        return bytes_per_rank(scene, p, 1) / static_cast<double>(p.particles);
    };
    CHECK(bytes("on", "off") == bytes("off", "off"));
    CHECK(bytes("sleep", "off") - bytes("off", "off") == doctest::Approx(48));
    CHECK(bytes("sleep", "on") == bytes("off", "on"));
}

TEST_CASE("memory of hazard maps follows the soil, not the domain, and is told of all of it") {
    Scene scene = test::small_valley(InterfaceLaw::voellmy, false);
    scene.source.path = "valley";
    Prediction p = predict(scene);
    const double none = bytes_per_rank(scene, p, 1), of_host = host_bytes_with_device(scene, p, 1, false);
    CHECK(check_report(scene, {}).find("hazard maps") == std::string::npos);
    scene.hazard.cell = 0.1;
    const double maps = bytes_per_rank(scene, p, 1) - none;
    CHECK(maps > 240 * 10 * 10);
    CHECK(maps < 240 * 80 * 80);
    CHECK(host_bytes_with_device(scene, p, 1, false) - of_host == doctest::Approx(maps));
    CHECK(bytes_per_rank(scene, p, 4) - bytes_per_rank(test::small_valley(InterfaceLaw::voellmy, false), p, 4) ==
          doctest::Approx(maps / 4));
    CHECK(check_report(scene, {}).find("64 bytes more for each column that soil comes to: 0.0 MB in all") !=
          std::string::npos);
    scene.max[0] = 26000, scene.max[1] = 12000, scene.hazard.cell = 1;
    CHECK(map_bytes_at_most(scene) == doctest::Approx(64 * 26e3 * 12e3));
    CHECK(bytes_per_rank(scene, p, 1) < none + maps);
}

TEST_CASE("boxes on a lattice are predicted in closed form as particle by particle, and in no time") {
    const std::string path = inputs_folder() + "/slurry_runout_3d.toml";
    for (const char* precision : {"single", "double"})
        for (const char* size : {"[5.0, 5.0, 5.0]", "[4.97, 3.31, 2.05]"}) {
            CAPTURE(size);
            Scene scene = read_scene(path, {std::string("body.reservoir.max=") + size, "domain.cell=0.2",
                                            std::string("numerics.precision=") + precision});
            scene.bodies[0].wave = {{0, 0.5, 1}, 1, 0.3, 0.7};
            const Prediction closed = predict(scene);
            scene.bodies[0].seeding = Seeding::jittered;  // by nothing
            const Prediction counted = predict(scene);
            CHECK(closed.particles == counted.particles);
            CHECK(closed.blocks == counted.blocks);
            CHECK(closed.node_blocks == counted.node_blocks);
            CHECK(closed.dt == counted.dt);
            CHECK(closed.mass == doctest::Approx(counted.mass).epsilon(1e-12));
        }
    const auto start = std::chrono::steady_clock::now();
    CHECK(predict(read_scene(path, {"domain.cell=0.01"})).particles == 1000000000);
    CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(30));
}

TEST_CASE("beside devices the host's memory follows blocks where a lattice is made there, else particles") {
    const std::string path = inputs_folder() + "/slurry_runout_3d.toml";
    Scene scene = read_scene(path, {"domain.cell=0.01", "numerics.precision=single"});
    Prediction p = predict(scene);
    const double quarter = host_bytes_with_device(scene, p, 4, false);
    CHECK(quarter < 4e9);
    CHECK(host_bytes_with_device(scene, p, 4, true) > quarter + 10e9);
    p.particles *= 10;
    CHECK(host_bytes_with_device(scene, p, 4, false) == quarter);
    scene.bodies[0].seeding = Seeding::jittered;
    CHECK(host_bytes_with_device(scene, p, 4, false) > 0.25 * 100 * static_cast<double>(p.particles));
}

TEST_CASE("outputs are predicted by their bytes, times and steps between") {
    const std::string path = inputs_folder() + "/slurry_runout_3d.toml";
    const Scene scene = read_scene(
        path, test::particle_pressures({"output.fields=[\"velocity\"]", "output.precision=single", "output.labels=[]",
                                        "output.interval=0.3", "output.every=10", "time.end=1.0", "time.dt=1e-3"}));
    const OutputPrediction o = predict_output(scene, predict(scene));
    CHECK(o.row_bytes == 24);
    CHECK(o.rows == std::ceil(static_cast<double>(predict(scene).particles) / 10));
    CHECK(o.outputs == 5);  // at 0, 0.3, 0.6, 0.9 and the end
    CHECK(o.steps == 250);
    const Scene whole = read_scene(path, {"output.interval=0"});
    CHECK(predict_output(whole, predict(whole)).outputs == 2);
}

TEST_CASE("the report names all that a run will need") {
    const std::string report = check_report(read_scene(inputs_folder() + "/elastic_bar.toml"), {.ranks = 4});
    for (const char* word : {"particles  800", "blocks", "dt", "steps", "output", "memory", "4 ranks"}) {
        CAPTURE(word);
        CHECK(report.find(word) != std::string::npos);
    }
}
