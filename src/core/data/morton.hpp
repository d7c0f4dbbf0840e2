#pragma once
// Morton order of blocks: the bits of the block's position, interleaved, x lowest.
//
// The position is biased, so a key is never negative and blocks below the domain's corner sort
// first. 2-D: 31 bits an axis; 3-D: 21. The order is pinned by the static_asserts below: a changed
// order must break the build, not a restart file.

#include <array>
#include <cstdint>

#include "core/data/vec.hpp"

namespace moraine {

using Key = std::uint64_t;

template <int Dim>
using BlockPosition = std::array<std::int32_t, Dim>;  ///< in blocks, from the domain's lower corner

template <int Dim>
struct Morton {
    static constexpr int bits = Dim == 2 ? 31 : 21;
    static constexpr std::int32_t bias = std::int32_t(1) << (bits - 1);

    /// Spread the lower bits of v so that Dim - 1 zeros stand between neighbours.
    static constexpr std::uint64_t spread(std::uint64_t v) {
        if constexpr (Dim == 2) {
            v &= 0x7fffffffULL;
            v = (v | (v << 16)) & 0x0000ffff0000ffffULL;
            v = (v | (v << 8)) & 0x00ff00ff00ff00ffULL;
            v = (v | (v << 4)) & 0x0f0f0f0f0f0f0f0fULL;
            v = (v | (v << 2)) & 0x3333333333333333ULL;
            v = (v | (v << 1)) & 0x5555555555555555ULL;
        } else {
            v &= 0x1fffffULL;
            v = (v | (v << 32)) & 0x001f00000000ffffULL;
            v = (v | (v << 16)) & 0x001f0000ff0000ffULL;
            v = (v | (v << 8)) & 0x100f00f00f00f00fULL;
            v = (v | (v << 4)) & 0x10c30c30c30c30c3ULL;
            v = (v | (v << 2)) & 0x1249249249249249ULL;
        }
        return v;
    }

    static constexpr std::uint64_t gather(std::uint64_t v) {
        if constexpr (Dim == 2) {
            v &= 0x5555555555555555ULL;
            v = (v | (v >> 1)) & 0x3333333333333333ULL;
            v = (v | (v >> 2)) & 0x0f0f0f0f0f0f0f0fULL;
            v = (v | (v >> 4)) & 0x00ff00ff00ff00ffULL;
            v = (v | (v >> 8)) & 0x0000ffff0000ffffULL;
            v = (v | (v >> 16)) & 0x00000000ffffffffULL;
        } else {
            v &= 0x1249249249249249ULL;
            v = (v | (v >> 2)) & 0x10c30c30c30c30c3ULL;
            v = (v | (v >> 4)) & 0x100f00f00f00f00fULL;
            v = (v | (v >> 8)) & 0x001f0000ff0000ffULL;
            v = (v | (v >> 16)) & 0x001f00000000ffffULL;
            v = (v | (v >> 32)) & 0x00000000001fffffULL;
        }
        return v;
    }

    static constexpr Key encode(const BlockPosition<Dim>& b) {
        Key k = 0;
        for (int a = 0; a < Dim; ++a)
            k |= spread(static_cast<std::uint64_t>(static_cast<std::int64_t>(b[a]) + bias)) << a;
        return k;
    }

    static constexpr BlockPosition<Dim> decode(Key k) {
        BlockPosition<Dim> b{};
        for (int a = 0; a < Dim; ++a)
            b[a] = static_cast<std::int32_t>(static_cast<std::int64_t>(gather(k >> a)) - bias);
        return b;
    }
};

static_assert(Morton<2>::encode({1 - Morton<2>::bias, 2 - Morton<2>::bias}) == 9);
static_assert(Morton<3>::encode({1 - Morton<3>::bias, 2 - Morton<3>::bias, 4 - Morton<3>::bias}) == 273);
static_assert(Morton<2>::decode(Morton<2>::encode({-7, 12345}))[0] == -7);
static_assert(Morton<3>::decode(Morton<3>::encode({-7, 12345, 99}))[1] == 12345);

}  // namespace moraine
