#pragma once
// Which of a law's properties are each particle's own, and where they are: scalars in the order of Law::over_depth,
// those alone that the scene gives (over_depth.hpp).

#include "core/data/vec.hpp"

namespace moraine {

/// Bits set below bit k.
MORAINE_HD constexpr int bits_below(int mask, int k) {
    int count = 0;
    for (int i = 0; i < k; ++i) count += mask >> i & 1;
    return count;
}

template <class Real>
struct OwnProperties {
    int mask;           ///< bit k: property k of Law::over_depth
    const Real* value;  ///< those that are, one after the other

    MORAINE_HD bool has(int k) const { return (mask >> k & 1) != 0; }
    MORAINE_HD Real operator[](int k) const { return value[bits_below(mask, k)]; }
};

}  // namespace moraine
