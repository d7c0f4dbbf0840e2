#pragma once
// The largest stable step dt c / h, between a stable and an unstable one.

#include <algorithm>
#include <cmath>

namespace moraine {

inline constexpr double least_courant = 0.02, most_courant = 4;  ///< dt c / h
inline constexpr double sharp = 1.02;                            ///< ratio of the ends of the last bracket

/// stable(dt c / h) says so. Stable steps below are looked at again, since an instability may have an upper end.
template <class Stable>
double largest_stable(const Stable& stable, double guess) {
    double low = guess, high = guess;
    if (stable(guess))
        while (high < most_courant && stable(high = std::min(most_courant, low * 1.25))) low = high;
    else
        while (low > least_courant && !stable(low = std::max(least_courant, high / 1.25))) high = low;
    if (low >= most_courant || high <= least_courant) return low;
    while (high / low > sharp) {
        const double middle = std::sqrt(low * high);
        (stable(middle) ? low : high) = middle;
    }
    for (double share : {0.85, 0.6, 0.35})
        if (!stable(share * low)) return largest_stable(stable, share * low);
    return low;
}

}  // namespace moraine
