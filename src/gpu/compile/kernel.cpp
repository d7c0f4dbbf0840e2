#include "gpu/compile/kernel.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "gpu/compile/cuda_driver.hpp"

namespace moraine::gpu {

namespace {

constexpr std::size_t most_arguments = 8;

}  // namespace

Kernel::Kernel(CUfunction function, unsigned threads, unsigned bytes)
    : function_(function), threads_(threads), bytes_(bytes) {
    const Driver& driver = Driver::instance();
    if (bytes > 0)
        check(driver.set_attribute(function, CU_FUNC_ATTRIBUTE_MAX_DYNAMIC_SHARED_SIZE_BYTES, static_cast<int>(bytes)),
              "Asking for the shared memory of a kernel");
    std::size_t offset = 0, size = 0;
    while (driver.parameter(function, parameters_.size(), &offset, &size) == CUDA_SUCCESS) parameters_.push_back(size);
}

void Kernel::operator()(unsigned grid, cudaStream_t stream, std::initializer_list<Argument> arguments,
                        const char* what) const {
    std::array<void*, most_arguments> at{};
    const bool fits = arguments.size() == parameters_.size() && arguments.size() <= most_arguments &&
                      std::equal(arguments.begin(), arguments.end(), parameters_.begin(),
                                 [](const Argument& a, std::size_t bytes) { return a.bytes == bytes; });
    if (!fits) throw std::logic_error(std::string(what) + ": a kernel does not take what its launch gives it");
    std::transform(arguments.begin(), arguments.end(), at.begin(),
                   [](const Argument& a) { return const_cast<void*>(a.at); });
    check(Driver::instance().launch(function_, grid, 1, 1, threads_, 1, 1, bytes_, stream, at.data(), nullptr), what);
}

}  // namespace moraine::gpu
