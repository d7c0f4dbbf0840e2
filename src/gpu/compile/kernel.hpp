#pragma once
// A kernel on the device at hand, and its launch. What it was compiled from: kernel_store.hpp.

#include <cuda.h>
#include <driver_types.h>

#include <cstddef>
#include <initializer_list>
#include <type_traits>
#include <vector>

namespace moraine::gpu {

/// An argument of a launch, by address: it is copied by the launch.
struct Argument {
    const void* at;
    std::size_t bytes;

    template <class T>
    Argument(const T& value) : at(&value), bytes(sizeof(T)) {
        static_assert(std::is_trivially_copyable_v<T>);
    }
    Argument(const void* data, std::size_t size) : at(data), bytes(size) {}
};

class Kernel {
  public:
    Kernel() = default;
    Kernel(CUfunction function, unsigned threads, unsigned bytes);

    explicit operator bool() const { return function_ != nullptr; }
    unsigned threads() const { return threads_; }  ///< of a thread block

    /// Throws MachineError; std::logic_error where arguments are not what the kernel takes. Asynchronous.
    void operator()(unsigned grid, cudaStream_t stream, std::initializer_list<Argument> arguments,
                    const char* what) const;

  private:
    CUfunction function_ = nullptr;
    unsigned threads_ = 0, bytes_ = 0;
    std::vector<std::size_t> parameters_;  ///< their sizes [bytes]
};

}  // namespace moraine::gpu
