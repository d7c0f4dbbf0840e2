#include <doctest/doctest.h>

#include <chrono>
#include <cmath>
#include <filesystem>

#include "particle_pressures.hpp"
#include "predict/capacity.hpp"
#include "scene/scene_text.hpp"

using namespace moraine;

namespace {

const std::string slurry = inputs_folder() + "/slurry_runout_3d.toml";

/// What is said of the 3-D slurry, by FLIP, with cells of `cell` on a machine; empty if it fits.
std::string said(const std::string& cell, const Machine& machine) {
    try {
        read_scene(slurry, test::particle_pressures({"domain.cell=" + cell, "numerics.transfer=flip"}),
                   [&](const Scene& s) { check_capacity(s, machine); });
    } catch (const InputError& e) {
        const std::string message = e.what();
        return message.substr(message.find("slurry_runout_3d.toml"));
    }
    return "";
}

}  // namespace

TEST_CASE(
    "the estimate has the particles of boxes and tables exactly, of others within 2 %, and the blocks within 15 %") {
    for (const char* name : {"slurry_runout", "slurry_runout_3d", "granular_column", "elastic_bar", "first_scene"}) {
        CAPTURE(name);
        const Scene scene = read_scene(inputs_folder() + "/" + name + ".toml");
        const Prediction rough = estimate(scene), exact = predict(scene);
        CHECK(rough.particles == exact.particles);
        CHECK(static_cast<double>(rough.blocks) == doctest::Approx(static_cast<double>(exact.blocks)).epsilon(0.15));
    }
    const Scene all = read_scene(inputs_folder() + "/reference.toml");
    CHECK(static_cast<double>(estimate(all).particles) ==
          doctest::Approx(static_cast<double>(predict(all).particles)).epsilon(0.02));
}

TEST_CASE("a scene that needs more memory than the machine has is refused with what would do") {
    CHECK(said("0.1", {1, 1, 24e9}).empty());
    CHECK(said("0.02", {1, 1, 24e9}) ==
          "slurry_runout_3d.toml: 1.25e+08 particles need 25.8 GB of memory for 1 rank here (this machine has 24 GB). "
          "Use 2 such machines with 1 rank each, or a domain.cell of 0.021 m?");
    CHECK(said("0.02", {2, 1, 24e9}).empty());
    CHECK(said("0.02", {2, 2, 24e9})
              .find("for 2 ranks here (this machine has 24 GB). Use 2 such machines with 2 ranks "
                    "each") != std::string::npos);
    CHECK(said("0.02", {1, 1, 0}).empty());
}

TEST_CASE("of a run on devices the memory of the host beside them counts") {
    Machine four{4, 4, 128e9};
    CHECK(said("0.008", four).find("1.95e+09 particles need 40") != std::string::npos);  // in all ranks
    four.devices = true;
    CHECK(said("0.008", four).find("Or --no-particles?") != std::string::npos);
    four.writes_particles = false;
    CHECK(said("0.008", four).empty());
}

TEST_CASE("more particles than a rank can number are refused at once, whatever the memory") {
    const auto start = std::chrono::steady_clock::now();
    CHECK(said("0.001", {64, 1, 0}) ==
          "slurry_runout_3d.toml: 1e+12 particles on 64 ranks (a rank numbers at most 2147483647). Use 513 ranks, or a "
          "domain.cell of 0.002 m?");
    CHECK(said("0.001", {1, 1, 24e9}).find("on 1 rank (a rank numbers") != std::string::npos);
    CHECK(said("0.0001", {1, 1, 0}).find("body.reservoir spans 1e+15 particles (ids have space") != std::string::npos);
    CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(5));
}

TEST_CASE("the least limit of a control group and of those above it counts") {
    const TestFolder folder;
    const auto put = [&](const std::string& path, const std::string& text) {
        std::filesystem::create_directories(std::filesystem::path(folder.file(path)).parent_path());
        folder.write(path, text);
    };
    const auto allowed = [&](const std::string& words) {
        return control_group_memory(folder.write("self", words), folder.file("mount"));
    };
    CHECK(allowed("") == 0);
    CHECK(allowed("0::/\n") == 0);
    put("mount/system.slice/memory.max", "max\n");
    put("mount/system.slice/job_7/memory.max", "4000000000\n");
    put("mount/system.slice/job_7/step_0/memory.max", "max\n");
    CHECK(allowed("0::/system.slice/job_7/step_0\n") == 4e9);
    CHECK(allowed("0::/system.slice\n") == 0);
    put("mount/system.slice/memory.max", "3000000000\n");
    CHECK(allowed("0::/system.slice/job_7/step_0\n") == 3e9);
    put("mount/memory/slurm/job_8/memory.limit_in_bytes", "2000000000\n");
    put("mount/memory/slurm/memory.limit_in_bytes", "9223372036854771712\n");
    CHECK(allowed("5:cpu,cpuacct:/slurm/job_8\n4:memory:/slurm/job_8/task_0\n0::/\n") == 2e9);
    put("mount/memory.max", "1000000000\n");  // of a container: all that is seen is the root
    CHECK(allowed("0::/\n") == 1e9);
    CHECK(allowed("nonsense\n") == 1e9);
}

TEST_CASE("this machine has memory") {
    CHECK(host_memory() > 1e8);
    CHECK(host_memory() < 1e15);
}

TEST_CASE("a rank has memory for the particles that would just not be refused") {
    const auto holds = [](const Machine& machine) {
        return particles_in_memory(read_scene(slurry, test::particle_pressures({"domain.cell=0.02"})), machine);
    };
    const auto ranks_of_four = [&](double memory) { return holds({8, 4, memory}); };
    CHECK(static_cast<double>(ranks_of_four(64e9)) == doctest::Approx(2.0 * static_cast<double>(ranks_of_four(32e9))));
    const double one = static_cast<double>(holds({1, 1, 24e9}));
    const std::string needs = said("0.02", {1, 1, 24e9});  // 125 million particles by FLIP, 25.8 GB
    REQUIRE_FALSE(needs.empty());
    CHECK(one < 1.25e8 * 24 / 25.8);  // these have an affine field besides
    CHECK(one > 0.6 * 1.25e8 * 24 / 25.8);
    CHECK(holds({8, 4, 0}) == 2147483647);
}

TEST_CASE("a rank of a scene that begins empty has memory for what its inflows bring, without bound if nothing comes") {
    Scene scene = read_scene(inputs_folder() + "/reference_terrain.toml", {"time.end=60"});
    std::erase_if(scene.bodies, [](const BodySpec& body) { return body.shape != BodyShape::inflow; });
    REQUIRE(scene.bodies.size() == 1);
    const std::int64_t holds = particles_in_memory(scene, {1, 1, 8e9});
    CHECK(holds > 1'000'000);
    CHECK(holds < 80'000'000);
    scene.bodies.clear();
    CHECK(particles_in_memory(scene, {1, 1, 8e9}) == 2147483647);
}
