#include "gpu/compile/runtime_compiler.hpp"

#include <dlfcn.h>
#include <nvrtc.h>

#include <array>
#include <iterator>
#include <memory>

#include "compile/system_compiler.hpp"
#include "core/data/error.hpp"
#include "gpu/compile/kernel_sources.hpp"

namespace moraine::gpu {

namespace {

/// Where the library may be: what the loader finds, then where the build found it.
constexpr const char* places[] = {"libnvrtc.so." MORAINE_NVRTC_MAJOR, MORAINE_NVRTC_LIBRARY, "libnvrtc.so"};

std::string version_name(int major, int minor) {
    return "NVRTC " + std::to_string(major) + "." + std::to_string(minor);
}

}  // namespace

struct RuntimeCompiler::Functions {
    decltype(&::nvrtcVersion) version;
    decltype(&::nvrtcCreateProgram) create;
    decltype(&::nvrtcDestroyProgram) destroy;
    decltype(&::nvrtcAddNameExpression) add_name;
    decltype(&::nvrtcCompileProgram) compile;
    decltype(&::nvrtcGetProgramLogSize) log_size;
    decltype(&::nvrtcGetProgramLog) log;
    decltype(&::nvrtcGetCUBINSize) image_size;
    decltype(&::nvrtcGetCUBIN) image;
    decltype(&::nvrtcGetLoweredName) lowered_name;
    decltype(&::nvrtcGetErrorString) error;

    explicit Functions(void* library) {
        const auto take = [&](auto& function, const char* name) {
            void* found = dlsym(library, name);
            if (!found)
                throw MachineError(std::string("NVRTC has no ") + name + " (" + dlerror() +
                                   "). Is it of CUDA 12.4 or newer?");
            function = reinterpret_cast<std::decay_t<decltype(function)>>(found);
        };
        take(version, "nvrtcVersion"), take(create, "nvrtcCreateProgram"), take(destroy, "nvrtcDestroyProgram");
        take(add_name, "nvrtcAddNameExpression"), take(compile, "nvrtcCompileProgram");
        take(log_size, "nvrtcGetProgramLogSize"), take(log, "nvrtcGetProgramLog");
        take(image_size, "nvrtcGetCUBINSize"), take(image, "nvrtcGetCUBIN");
        take(lowered_name, "nvrtcGetLoweredName"), take(error, "nvrtcGetErrorString");
    }
};

RuntimeCompiler::RuntimeCompiler() {
    void* library = nullptr;
    for (const char* place : places)
        if (!library) library = dlopen(place, RTLD_NOW | RTLD_LOCAL);
    if (!library)
        throw MachineError(std::string("Kernels for this scene have to be compiled, and there is no libnvrtc.so.") +
                           MORAINE_NVRTC_MAJOR + " (" + dlerror() +
                           "). Install NVRTC of the CUDA toolkit, or give --kernel-cache a folder that `moraine "
                           "kernels` has filled?");
    static const Functions functions(library);
    functions_ = &functions;
    int major = 0, minor = 0;
    functions_->version(&major, &minor);
    version_ = version_name(major, minor);
}

const RuntimeCompiler& RuntimeCompiler::instance() {
    static const RuntimeCompiler compiler;
    return compiler;
}

std::string version_of_build() {
    return "NVRTC " MORAINE_NVRTC_VERSION;
}

std::vector<std::string> RuntimeCompiler::options(int architecture) {
    return {"--std=c++20", "--gpu-architecture=sm_" + std::to_string(architecture),
            "--device-as-default-execution-space", "--ptxas-options=-v"};
}

CompiledProgram RuntimeCompiler::compile(const Program& program, int architecture) const {
    const Functions& rtc = *functions_;
    std::vector<const char*> names, texts;
    for (const SourceFile& source : kernel_sources().files) names.push_back(source.name), texts.push_back(source.text);
    nvrtcProgram made = nullptr;
    const auto check = [&](nvrtcResult result, const char* what) {
        if (result == NVRTC_SUCCESS) return;
        std::size_t size = 0;
        std::string log;
        if (made && rtc.log_size(made, &size) == NVRTC_SUCCESS && size > 1) {
            log.resize(size);
            rtc.log(made, log.data());
            log.resize(size - 1);
        }
        if (made) rtc.destroy(&made);
        const std::string words = std::string(what) + " (" + program.name + ") failed (" + rtc.error(result) + ")" +
                                  (log.empty() ? "." : ":\n" + log);
        if (program.texts.empty()) throw MachineError(words);
        throw CompilerError(words);  // of a law in a file
    };
    const std::string text = program.text(), name = "kernels.cu";
    check(rtc.create(&made, text.c_str(), name.c_str(), static_cast<int>(names.size()), texts.data(), names.data()),
          "Preparing kernels");
    for (const ProgramKernel& kernel : program.kernels)
        check(rtc.add_name(made, kernel.expression.c_str()), "Naming kernels");
    const std::vector<std::string> words = options(architecture);
    std::vector<const char*> given;
    for (const std::string& word : words) given.push_back(word.c_str());
    check(rtc.compile(made, static_cast<int>(given.size()), given.data()), "Compiling kernels");
    CompiledProgram compiled;
    for (const ProgramKernel& kernel : program.kernels) {
        const char* lowered = nullptr;
        check(rtc.lowered_name(made, kernel.expression.c_str(), &lowered), "Finding kernels");
        compiled.names.emplace_back(lowered);
    }
    std::size_t size = 0;
    check(rtc.image_size(made, &size), "Taking kernels");
    compiled.image.resize(size);
    check(rtc.image(made, compiled.image.data()), "Taking kernels");
    if (rtc.log_size(made, &size) == NVRTC_SUCCESS && size > 1) {
        compiled.log.resize(size);
        rtc.log(made, compiled.log.data());
        compiled.log.resize(size - 1);
    }
    rtc.destroy(&made);
    return compiled;
}

}  // namespace moraine::gpu
