#pragma once
// How each particle-to-grid kernel is launched.

#include "gpu/kernels/p2g/p2g.hpp"
#include "gpu/kernels/p2g/p2g_plan.cuh"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

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
