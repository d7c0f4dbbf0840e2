#pragma once
// Which plan each particle-to-grid kernel runs by.

#include "gpu/kernels/p2g/p2g.cuh"

namespace moraine::gpu {

/// How a kernel is laid out: passes over the particles, rounds in shared memory, thread blocks per multiprocessor.
struct P2gPlan {
    int passes, stages, resident;
};

/// The fastest of those measured on an H200 that spill no register. What counts most is thread blocks per
/// multiprocessor; two passes pay where the sums of one would leave registers for too few.
template <class Case>
constexpr P2gPlan p2g_plan() {
    constexpr bool single = sizeof(typename Case::Real) == 4, flat = Case::dim == 2;
    constexpr bool many = Case::affine || Case::mean;                                            // sums in one pass
    constexpr bool halved = !flat && single && Case::width == 3 && many && !Case::Shape::sized;  // two passes
    constexpr bool heavy = (many && !halved) || (Case::Shape::sized && !single);
    constexpr int resident[2][2][3][2] = {
        // width 2, 3, 4: light and heavy
        {{{8, 8}, {7, 5}, {5, 4}}, {{6, 6}, {5, 3}, {3, 2}}},               // 2-D: single, double
        {{{8, 8}, {halved ? 4 : 3, 2}, {2, 2}}, {{5, 3}, {3, 2}, {1, 1}}},  // 3-D
    };
    const bool two = halved || (!flat && (Case::width == 4 || (Case::width == 3 && !single)));
    const bool deep = !flat && (single ? Case::width == 3 && !many : Case::width == 4);
    // Where the mean is a register too many.
    const bool tight =
        Case::affine && Case::mean && (single ? Case::width == (flat ? 4 : 2) : flat && Case::width == 3);
    return {two ? 2 : 1, deep ? 3 : 2,
            resident[Case::dim - 2][single ? 0 : 1][Case::width - 2][heavy ? 1 : 0] - (tight ? 1 : 0)};
}

}  // namespace moraine::gpu
