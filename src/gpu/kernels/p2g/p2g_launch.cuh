#pragma once
// Which plan each particle-to-grid kernel runs by, and its launch.

#include "gpu/kernels/p2g/p2g.cuh"
#include "gpu/kernels/p2g/p2g.hpp"
#include "gpu/memory/array.hpp"

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

template <class Case>
struct P2gLaunch {
    using Real = typename Case::Real;
    static constexpr P2gPlan plan = p2g_plan<Case>();
    static constexpr int bytes = shared_bytes<Case, plan.passes, plan.stages>();
    static constexpr auto kernel = particles_to_grid<Case, plan.passes, plan.stages, plan.resident>;

    static void run(const View<Real, Case::dim>& view, const Chosen& chosen, int grid_blocks,
                    typename Case::Scale scale, cudaStream_t stream) {
        kernel<<<grid_blocks, Case::threads, bytes, stream>>>(view, chosen, scale);
        check(cudaGetLastError(), "Launching particle to grid");
    }
    static auto ready() {
        check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, bytes),
              "Asking for the shared memory of particle to grid");
        return run;
    }
};

template <class Real, int Dim, class S, bool Mean>
auto ready_p2g(bool affine) {
    return affine ? P2gLaunch<P2gCase<Real, Dim, S, true, Mean>>::ready()
                  : P2gLaunch<P2gCase<Real, Dim, S, false, Mean>>::ready();
}

template <class Real, int Dim, bool Mean>
auto choose_launch(Shape shape, bool affine) {
    switch (shape) {
        case Shape::linear:
            return ready_p2g<Real, Dim, Linear, Mean>(affine);
        case Shape::quadratic:
            return ready_p2g<Real, Dim, Quadratic, Mean>(affine);
        case Shape::cubic:
            return ready_p2g<Real, Dim, Cubic, Mean>(affine);
        default:
            return ready_p2g<Real, Dim, Gimp, Mean>(affine);
    }
}

template <class Real, int Dim>
P2g<Real, Dim> choose_p2g(Shape shape, bool affine) {
    return choose_launch<Real, Dim, false>(shape, affine);
}

template <class Real, int Dim>
P2gMean<Real, Dim> choose_p2g_mean(Shape shape, bool affine) {
    return choose_launch<Real, Dim, true>(shape, affine);
}

}  // namespace moraine::gpu
