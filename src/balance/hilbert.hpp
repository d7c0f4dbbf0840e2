#pragma once
// Hilbert order of blocks: positions that follow each other on the curve are neighbours in space.
//
// Skilling's transform of the axes (2004, AIP Conf. Proc. 707, 381), then the bits interleaved, first axis
// highest. Same range and bias as Morton. The cube of 2^k blocks that holds a domain is one piece of the
// curve, so a larger key range changes nothing but the orientation. Against Morton's order: no jumps, so fewer
// faces between ranks; the price is a sort, because the blocks come in Morton order.

#include <cstdint>

#include "core/data/morton.hpp"

namespace moraine {

template <int Dim>
struct Hilbert {
    static constexpr Key encode(const BlockPosition<Dim>& at) {
        std::array<std::uint64_t, Dim> x{};
        for (int a = 0; a < Dim; ++a)
            x[a] = static_cast<std::uint64_t>(static_cast<std::int64_t>(at[a]) + Morton<Dim>::bias);
        rotate(x);
        to_gray(x);
        Key key = 0;
        for (int a = 0; a < Dim; ++a) key |= Morton<Dim>::spread(x[a]) << (Dim - 1 - a);
        return key;
    }

  private:
    static constexpr std::uint64_t top = std::uint64_t(1) << (Morton<Dim>::bits - 1);

    /// From the largest cube to the smallest: turn it so that the curve enters and leaves as the standard one.
    static constexpr void rotate(std::array<std::uint64_t, Dim>& x) {
        for (std::uint64_t bit = top; bit > 1; bit >>= 1) {
            const std::uint64_t below = bit - 1;
            for (int a = 0; a < Dim; ++a) {
                if (x[a] & bit) {
                    x[0] ^= below;
                } else {
                    const std::uint64_t differ = (x[0] ^ x[a]) & below;
                    x[0] ^= differ;
                    x[a] ^= differ;
                }
            }
        }
    }

    static constexpr void to_gray(std::array<std::uint64_t, Dim>& x) {
        for (int a = 1; a < Dim; ++a) x[a] ^= x[a - 1];
        std::uint64_t flip = 0;
        for (std::uint64_t bit = top; bit > 1; bit >>= 1)
            if (x[Dim - 1] & bit) flip ^= bit - 1;
        for (int a = 0; a < Dim; ++a) x[a] ^= flip;
    }
};

}  // namespace moraine
