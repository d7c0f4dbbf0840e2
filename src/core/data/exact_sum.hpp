#pragma once
// Sums that do not depend on their order: 128-bit fixed point.
//
// Every reported global sum (momentum, energies, wall impulses, lost mass) adds doubles that are
// equal on any number of ranks, rounded to a common quantum; integers then add in any order. The
// quantum is 2^-97 of the scene's mass scale, so single terms keep their full 53 bits down to 1e-13
// of it, and 2^30 times the scale fits.

#include <cmath>
#include <cstdint>

#include "core/data/vec.hpp"

namespace moraine {

struct ExactSum {
    std::int64_t high = 0;  ///< two's complement, 128 bits in all
    std::uint64_t low = 0;

    MORAINE_HD void add(const ExactSum& other) {
        const std::uint64_t sum = low + other.low;
        high += other.high + (sum < low ? 1 : 0);
        low = sum;
    }
    MORAINE_HD void negate() {
        low = ~low + 1;
        high = ~high + (low == 0 ? 1 : 0);
    }
};

/// The quantum of a run's sums: powers of two, so scaling is exact.
struct Quantum {
    double scale = 1;  ///< quanta per unit

    /// For sums whose terms are of the order of `largest` units, at most 2^30 of them.
    static Quantum for_largest(double largest) {
        const int exponent = largest > 0 ? std::ilogb(largest) + 1 : 0;
        return {std::ldexp(1.0, 97 - exponent)};
    }

    /// Not a number, or more than fits: nothing (the run's faults tell of it).
    MORAINE_HD ExactSum of(double value) const {
        using std::floor;
        using std::rint;
        const double two64 = 18446744073709551616.0;
        const double quanta = rint(value * scale);
        if (!(quanta < two64 * two64 / 4 && quanta > -two64 * two64 / 4)) return {};
        // By magnitude: two64 - 1 is no double, so a low word must not be the complement of a small number.
        const double size = quanta < 0 ? -quanta : quanta;
        const double high = floor(size / two64);
        ExactSum s;
        s.high = static_cast<std::int64_t>(high);
        s.low = static_cast<std::uint64_t>(size - high * two64);
        if (quanta < 0) s.negate();
        return s;
    }

    double value(ExactSum s) const {
        const double two64 = 18446744073709551616.0;
        const double sign = s.high < 0 ? -1 : 1;
        if (s.high < 0) s.negate();
        return sign * (static_cast<double>(s.high) * two64 + static_cast<double>(s.low)) / scale;
    }
};

/// to[i] += sum by several threads at once: the low word tells the carry. Nobody may read `to` meanwhile.
template <int N>
inline void add_shared(ExactSum (&to)[N], const Quantum& quantum, const double (&values)[N]) {
    for (int i = 0; i < N; ++i) {
        const ExactSum sum = quantum.of(values[i]);
        if (sum.low == 0 && sum.high == 0) continue;
        const std::uint64_t old = __atomic_fetch_add(&to[i].low, sum.low, __ATOMIC_RELAXED);
        const std::int64_t high = sum.high + (old + sum.low < old ? 1 : 0);
        if (high != 0) __atomic_fetch_add(&to[i].high, high, __ATOMIC_RELAXED);
    }
}

}  // namespace moraine
