#pragma once
// NVIDIA's run-time compiler, NVRTC, loaded when the first program is to be compiled: a build needs only its header,
// and a run that finds all of its kernels on disk needs nothing.
//
// Options are those of every kernel: no fast math, so that the same text gives the same bits wherever it is compiled.

#include <string>
#include <vector>

#include "gpu/compile/program.hpp"

namespace moraine::gpu {

class RuntimeCompiler {
  public:
    /// Loads the library once. Throws MachineError where there is none.
    static const RuntimeCompiler& instance();

    /// For devices of compute capability `architecture` / 10. Throws MachineError with the compiler's words;
    /// CompilerError where a law in a file may be wrong. Several threads may compile at once.
    CompiledProgram compile(const Program& program, int architecture) const;

    static std::vector<std::string> options(int architecture);
    const std::string& version() const { return version_; }  ///< `NVRTC 13.0`

  private:
    RuntimeCompiler();

    struct Functions;
    const Functions* functions_;
    std::string version_;
};

/// The version by which kernels on disk are found where no library can be loaded: that of the build.
std::string version_of_build();

}  // namespace moraine::gpu
