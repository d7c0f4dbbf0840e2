#pragma once
// A product that a device does not contract with the sum behind it: where host and device must agree to the bit, and
// the formula is a double's. The host's compiler contracts nothing (-ffp-contract=off).

#include "core/data/vec.hpp"

namespace moraine {

/// a b, rounded.
MORAINE_HD double rounded_product(double a, double b) {
#if defined(__CUDA_ARCH__)
    return __dmul_rn(a, b);
#else
    return a * b;
#endif
}

}  // namespace moraine
