#pragma once
// The kernels of this process on its device: compiled when they are first wanted, from disk where another run has
// compiled them.

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "compile/compile_cache.hpp"
#include "gpu/compile/kernel.hpp"
#include "gpu/compile/program.hpp"

namespace moraine::gpu {

class KernelStore {
  public:
    /// Of the process, for the device that is current in each call: kernels are the driver's, and live as long as its
    /// context.
    static KernelStore& instance();

    /// Where compiled programs are kept from now on, and who hears that some are being compiled; null: nobody.
    void keep_in(CompileCache cache, std::function<void(const std::string&)> tell);

    /// Loads what is not in memory, as one program: from disk, or compiled now.
    void prepare(const std::vector<Program>& programs);

    /// The kernels of a program, in order: compiled now where prepare() did not name it. Valid until the end.
    const std::vector<Kernel>& kernels(const Program& program);

  private:
    CompileCache cache_{kernel_cache_folder("")};
    std::function<void(const std::string&)> tell_;
    /// By device and text: a kernel is one of the device that was current when it was loaded.
    std::map<std::pair<int, std::string>, std::vector<Kernel>> loaded_;
};

/// Compiler and options of kernels for the current device, for records.
std::string compiler_of_device();

/// Compute capability of the current device, times 10.
int architecture_of_device();

/// A program that is not on disk for an architecture is compiled and kept; needs no device.
void compile_to_disk(const CompileCache& cache, const Program& program, int architecture,
                     const std::function<void(const std::string&)>& tell);

}  // namespace moraine::gpu
