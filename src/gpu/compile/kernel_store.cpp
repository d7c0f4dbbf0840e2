#include "gpu/compile/kernel_store.hpp"

#include <cuda_runtime_api.h>

#include <set>

#include "gpu/compile/cuda_driver.hpp"
#include "gpu/compile/kernel_sources.hpp"
#include "gpu/compile/runtime_compiler.hpp"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

namespace {

std::string key_of(const Program& program, int architecture, const std::string& version) {
    return CompileCache::key(program.text(), RuntimeCompiler::options(architecture), version, kernel_sources().hash);
}

/// From disk, by the compiler of the build or by the one that is here; else compiled now, and kept.
CompiledProgram find_or_compile(const CompileCache& cache, const Program& program, int architecture,
                                const std::function<void(const std::string&)>& tell) {
    if (const auto found = cache.find(key_of(program, architecture, version_of_build())))
        if (auto compiled = unpacked(*found)) return std::move(*compiled);
    const RuntimeCompiler& compiler = RuntimeCompiler::instance();
    const std::string content = cache.find_or_make(key_of(program, architecture, compiler.version()), [&] {
        if (tell)
            tell(
                "Compiling " + std::to_string(program.kernels.size()) + " device kernels for sm_" +
                std::to_string(architecture) + " by " + compiler.version() +
                (cache.folder().empty() ? " (not kept)" : " (once: they are kept in " + cache.folder().string() + ")"));
        return packed(compiler.compile(program, architecture));
    });
    if (auto compiled = unpacked(content)) return std::move(*compiled);
    return compiler.compile(program, architecture);
}

std::vector<Kernel> load(const Program& program, const CompiledProgram& compiled) {
    const Driver& driver = Driver::instance();
    CUlibrary library = nullptr;
    check(driver.load_library(&library, compiled.image.data(), nullptr, nullptr, 0, nullptr, nullptr, 0),
          "Loading kernels");
    CUdeviceptr at = 0;
    std::size_t bytes = 0;
    check(driver.global_of_library(&at, &bytes, library, facts_name), "Loading kernels");
    std::vector<unsigned> facts(bytes / sizeof(unsigned));
    check(cudaMemcpy(facts.data(), reinterpret_cast<const void*>(at), bytes, cudaMemcpyDeviceToHost),
          "Loading kernels");
    if (facts.size() != 2 * program.kernels.size() || compiled.names.size() != program.kernels.size())
        throw MachineError("The kernels of " + program.name + " do not fit this program. Another --kernel-cache?");
    std::vector<Kernel> kernels;
    for (std::size_t k = 0; k < compiled.names.size(); ++k) {
        CUkernel kernel = nullptr;
        CUfunction function = nullptr;
        check(driver.kernel_of_library(&kernel, library, compiled.names[k].c_str()), "Loading kernels");
        check(driver.function_of_kernel(&function, kernel), "Loading kernels");
        kernels.emplace_back(function, facts[2 * k], facts[2 * k + 1]);
    }
    return kernels;
}

int current_device() {
    int device = 0;
    check(cudaGetDevice(&device), "Asking for the device");
    return device;
}

}  // namespace

int architecture_of_device() {
    const int device = current_device();
    int major = 0, minor = 0;
    check(cudaDeviceGetAttribute(&major, cudaDevAttrComputeCapabilityMajor, device), "Asking the device");
    check(cudaDeviceGetAttribute(&minor, cudaDevAttrComputeCapabilityMinor, device), "Asking the device");
    return 10 * major + minor;
}

std::string compiler_of_device() {
    std::string words = version_of_build();
    for (const std::string& option : RuntimeCompiler::options(architecture_of_device())) words += ' ' + option;
    return words;
}

void compile_to_disk(const CompileCache& cache, const Program& program, int architecture,
                     const std::function<void(const std::string&)>& tell) {
    find_or_compile(cache, program, architecture, tell);
}

KernelStore& KernelStore::instance() {
    static KernelStore store;
    return store;
}

void KernelStore::keep_in(CompileCache cache, std::function<void(const std::string&)> tell) {
    cache_ = std::move(cache);
    tell_ = std::move(tell);
}

void KernelStore::prepare(const std::vector<Program>& programs) {
    const int device = current_device();
    std::vector<Program> wanted;
    std::set<std::string> texts;
    for (const Program& program : programs)
        if (std::string text = program.text(); !loaded_.count({device, text}) && texts.insert(text).second)
            wanted.push_back(program);
    const int architecture = architecture_of_device();
    if (wanted.empty()) return;
    const Program all = merged(wanted);
    const std::vector<Kernel> kernels = load(all, find_or_compile(cache_, all, architecture, tell_));
    auto next = kernels.begin();
    for (const Program& program : wanted) {
        const auto end = next + static_cast<std::ptrdiff_t>(program.kernels.size());
        loaded_[{device, program.text()}].assign(next, end);
        next = end;
    }
}

const std::vector<Kernel>& KernelStore::kernels(const Program& program) {
    const std::pair key(current_device(), program.text());
    if (!loaded_.count(key)) prepare({program});
    return loaded_.at(key);
}

}  // namespace moraine::gpu
