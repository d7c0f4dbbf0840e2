#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <regex>
#include <set>
#include <string>

#include "core/transfer/kernel_key.hpp"
#include "gpu/compile/kernel_sources.hpp"
#include "gpu/compile/runtime_compiler.hpp"
#include "gpu/kernels/programs.hpp"
#include "loaded_scene.hpp"
#include "scene/read_scene.hpp"
#include "surface_scenes.hpp"
#include "turning_scene.hpp"

using namespace moraine;

namespace {

Scene shipped(const std::string& name) {
    return read_scene(std::string(MORAINE_INPUTS) + "/" + name + ".toml");
}

/// Largest number before `words` in the compiler's log; -1: nowhere.
int largest(const std::string& log, const std::string& words) {
    const std::regex number("([0-9]+) " + words);
    int most = -1;
    for (std::sregex_iterator it(log.begin(), log.end(), number), end; it != end; ++it)
        most = std::max(most, std::stoi((*it)[1]));
    return most;
}

}  // namespace

TEST_CASE("the headers of kernels travel in the program") {
    std::set<std::string> names;
    for (const SourceFile& source : gpu::kernel_sources().files) names.insert(source.name);
    for (const char* wanted : {"gpu/kernels/p2g/p2g_plan.cuh", "core/material/law_list.hpp", "cmath", "cuda/std/tuple"})
        CHECK(names.count(wanted) == 1);
}

TEST_CASE("one program has each kernel and each header of its parts once") {
    const KernelKey key = kernel_key(shipped("granular_column"));
    const std::vector<gpu::Program> parts = gpu::programs_of(key);
    const gpu::Program all = gpu::merged(parts);
    std::size_t kernels = 0;
    for (const gpu::Program& part : parts) kernels += part.kernels.size();
    CHECK(all.kernels.size() == kernels);
    CHECK(std::set<std::string>(all.headers.begin(), all.headers.end()).size() == all.headers.size());
    for (const gpu::Program& part : parts)
        for (const gpu::ProgramKernel& kernel : part.kernels)
            CHECK(all.text().find(kernel.expression) != std::string::npos);
}

// Beyond 64 bytes registers are spilled for good; below, NVRTC's 64-bit addresses of shared memory cost one or two,
// which no benchmark shows (docs/adr/0004). NVRTC keeps what it made where there is a driver, and has no log of that.
TEST_CASE("kernels of shipped scenes compile, and their registers suffice") {
    setenv("CUDA_CACHE_DISABLE", "1", 1);
    const std::vector<std::string> names =
        std::getenv("MORAINE_LONG_TESTS")
            ? std::vector<std::string>{"granular_column",    "slurry_runout", "slurry_runout_3d", "submarine_slide",
                                       "submarine_slide_3d", "strip_footing", "valley",           "undercut_bed"}
            : std::vector<std::string>{"granular_column", "slurry_runout_3d"};
    for (const std::string& name : names) {
        CAPTURE(name);
        const gpu::Program program = gpu::merged(gpu::programs_of(kernel_key(shipped(name))));
        const gpu::CompiledProgram compiled = gpu::RuntimeCompiler::instance().compile(program, 90);
        CHECK(compiled.names.size() == program.kernels.size());
        CHECK(compiled.image.size() > 1000);
        CHECK(largest(compiled.log, "bytes spill stores") <= 64);
        CHECK(largest(compiled.log, "bytes spill stores") >= 0);
    }
}

TEST_CASE("only programs of scenes with a structure that turns know of turning, and their registers suffice") {
    for (int dimensions : {2, 3})
        for (Precision precision : {Precision::single_, Precision::double_}) {
            CAPTURE(dimensions);
            Scene scene = test::wet(test::on_surface(test::turning_on_slope(dimensions)), 1);
            scene.precision = precision;
            const auto knows = [&] {
                return gpu::merged(gpu::programs_of(kernel_key(scene))).text().find("MORAINE_TURNS") !=
                       std::string::npos;
            };
            CHECK(knows());
            gpu::Program program = gpu::surfaces_program(kernel_key(scene));
            program = gpu::merged({program, gpu::nodes_program(kernel_key(scene), true, false)});
            const gpu::CompiledProgram compiled = gpu::RuntimeCompiler::instance().compile(program, 90);
            CHECK(compiled.names.size() == program.kernels.size());
            CHECK(largest(compiled.log, "bytes spill stores") <= 64);
            for (StructureSpec& s : scene.structures) s.motion.turns = false, s.motion.angular_velocity.clear();
            CHECK(!knows());
        }
}

TEST_CASE("only programs of scenes with tractions know of them, and their registers suffice") {
    for (int dimensions : {2, 3})
        for (Precision precision : {Precision::single_, Precision::double_})
            for (bool one_material : {false, true}) {
                CAPTURE(dimensions);
                CAPTURE(one_material);
                Scene scene = test::blocks_under_load(dimensions);
                scene.precision = precision;
                if (one_material)
                    scene.bodies.pop_back(), scene.materials.pop_back(), scene.course.tractions.pop_back();
                const auto program = [&] { return gpu::merged(gpu::programs_of(kernel_key(scene))); };
                const gpu::CompiledProgram compiled = gpu::RuntimeCompiler::instance().compile(program(), 90);
                CHECK(compiled.names.size() == program().kernels.size());
                CHECK(largest(compiled.log, "bytes spill stores") <= 64);
                CHECK(program().text().find("load_term") != std::string::npos);
                scene.course.tractions.clear();
                CHECK(program().text().find("load_term") == std::string::npos);
            }
}

TEST_CASE("what does not compile is told with the compiler's words") {
    const gpu::Program wrong{"a wrong program", {"gpu/kernels/p2g/p2g_plan.cuh"}, {{"no_such_kernel<3>", "1", "0"}}};
    std::string words;
    try {
        gpu::RuntimeCompiler::instance().compile(wrong, 90);
    } catch (const std::exception& e) {
        words = e.what();
    }
    CHECK(words.find("a wrong program") != std::string::npos);
    CHECK(words.find("no_such_kernel") != std::string::npos);
}
