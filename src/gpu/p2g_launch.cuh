#pragma once
// Which plan each particle-to-grid kernel runs by, and its launch.

#include "gpu/array.hpp"
#include "gpu/p2g.cuh"
#include "gpu/p2g.hpp"

namespace moraine::gpu {

/// How a kernel is laid out: passes over the particles, rounds in shared memory, thread blocks per multiprocessor.
struct P2gPlan {
    int passes, stages, resident;
};

/// Measured (benchmarks/gpu_lab has the method); none of them spills registers.
template <class Case>
constexpr P2gPlan p2g_plan() {
    constexpr bool single = sizeof(typename Case::Real) == 4;
    if (Case::dim == 2) return {1, 3, Case::width == 4 ? 2 : 4};
    if (Case::width == 2) return {1, 3, single ? 6 : 3};
    if (Case::width == 4) return {2, 2, single ? 2 : 1};
    if (!single) return {2, 2, 2};
    return Case::affine ? P2gPlan{1, 3, 2} : P2gPlan{1, 3, 3};
}

template <class Case>
struct P2gLaunch {
    using Real = typename Case::Real;
    static constexpr P2gPlan plan = p2g_plan<Case>();
    static constexpr int bytes = shared_bytes<Case, plan.passes, plan.stages>();
    static constexpr auto kernel = particles_to_grid<Case, plan.passes, plan.stages, plan.resident>;

    static void run(const View<Real, Case::dim>& view, const Chosen& chosen, int grid_blocks, Real cell,
                    cudaStream_t stream) {
        kernel<<<grid_blocks, Case::threads, bytes, stream>>>(view, chosen, cell);
        check(cudaGetLastError(), "Launching particle to grid");
    }
    static P2g<Real, Case::dim> ready() {
        check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, bytes),
              "Asking for the shared memory of particle to grid");
        return run;
    }
};

template <class Real, int Dim, class S>
P2g<Real, Dim> ready_p2g(bool affine) {
    return affine ? P2gLaunch<P2gCase<Real, Dim, S, true>>::ready() : P2gLaunch<P2gCase<Real, Dim, S, false>>::ready();
}

template <class Real, int Dim>
P2g<Real, Dim> choose_p2g(Shape shape, bool affine) {
    switch (shape) {
        case Shape::linear:
            return ready_p2g<Real, Dim, Linear>(affine);
        case Shape::quadratic:
            return ready_p2g<Real, Dim, Quadratic>(affine);
        case Shape::cubic:
            return ready_p2g<Real, Dim, Cubic>(affine);
        default:
            return ready_p2g<Real, Dim, Gimp>(affine);
    }
}

}  // namespace moraine::gpu
