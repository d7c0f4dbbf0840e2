#pragma once
// The two words by which a particle sleeps (core/sleep/sleep.hpp), in columns of their own beside the rows: only the
// kernels of sleep, messages and files know them, so that no other kernel is passed a pointer more.

#include <cstdint>

namespace moraine::gpu {

/// Null: nobody sleeps in the scene.
struct RestWords {
    std::uint64_t* place = nullptr;
    std::uint64_t* stress = nullptr;
};

}  // namespace moraine::gpu
