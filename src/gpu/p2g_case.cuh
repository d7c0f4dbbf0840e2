#pragma once
// What the compiler knows of one particle-to-grid kernel, and the weights of a slice.
//
// A slice is one layer of the stencil across the last axis: `lines` lines of `width` nodes. One thread sums one slice
// of one cell. A thread block has the 64 cells of one block in 3-D, of four in 2-D, times `width` slices.

#include "core/shape.hpp"
#include "gpu/view.hpp"

namespace moraine::gpu {

template <class R, int D, class S, bool A>
struct P2gCase {
    using Real = R;
    using Shape = S;
    static constexpr int dim = D;
    static constexpr bool affine = A;
    static constexpr int width = S::width;
    static constexpr int cells = 64;                        ///< of a thread block
    static constexpr int blocks = cells / Block<D>::cells;  ///< of a thread block
    static constexpr int threads = cells * width;
    static constexpr int lines = D == 3 ? width : 1;
    static constexpr int nodes = lines * width;  ///< of a slice
    static constexpr int side = tile_side(width);
    static constexpr int tile_nodes = power<D>(side);
    /// The middle node of three is summed as the whole line and loses the outer two at the end. Its weight is 1/2 or
    /// more, so that no rounding becomes a mass; and it saves a sixth of the instructions.
    static constexpr bool middle_is_rest = width == 3;
    static constexpr bool is_rest(int i) { return middle_is_rest && i == 1; }
};

/// Index of this thread in its block, read anew: what is derived from it need not stay in registers through the sums.
__device__ __forceinline__ int thread_now() {
    int t;
    asm volatile("mov.u32 %0, %%tid.x;" : "=r"(t));
    return t;
}

/// Weights of one axis, and what goes with the other axes' weights: slopes [1/cell] or levers.
template <class Case>
struct Axis {
    typename Case::Real w[Case::width];
    typename Case::Real d[Case::width];
};

/// Gimp (core/shape.hpp) by ramps, without a branch: half is l, quarter 1 / (4 l).
template <class Real>
__device__ __forceinline__ void gimp_weights(Real f, Real half, Real quarter, Real* w, Real* dw) {
    const Real d = f - Real(0.5), box = half + half;
    const Real up = min(max(half + d, Real(0)), box), down = min(max(half - d, Real(0)), box);
    w[0] = down * down * quarter + max(-d - half, Real(0));
    w[2] = up * up * quarter + max(d - half, Real(0));
    w[1] = Real(1) - w[0] - w[2];
    dw[0] = Real(-2) * down * quarter;
    dw[2] = Real(2) * up * quarter;
    dw[1] = -dw[0] - dw[2];
}

/// Weights and slopes of an axis; f: place in the cell.
template <class Case>
__device__ __forceinline__ Axis<Case> slopes_of(typename Case::Real f, typename Case::Real half,
                                                typename Case::Real quarter) {
    Axis<Case> a;
    if constexpr (Case::Shape::sized)
        gimp_weights(f, half, quarter, a.w, a.d);
    else
        Case::Shape::weights(f, half, a.w, a.d);
    return a;
}

/// The same weights with levers w (x_i - x_p) [cells], which sum to nothing as slopes do.
template <class Case>
__device__ __forceinline__ Axis<Case> levers_of(Axis<Case> a, typename Case::Real f) {
    using Real = typename Case::Real;
#pragma unroll
    for (int i = 0; i < Case::width; ++i) a.d[i] = a.w[i] * (Real(i) - Case::Shape::template reach<Real> - f);
    return a;
}

/// Entry k of an axis, k known at run time.
template <class Case>
__device__ __forceinline__ void pick(const Axis<Case>& a, int k, typename Case::Real& w, typename Case::Real& d) {
    w = a.w[0], d = a.d[0];
#pragma unroll
    for (int i = 1; i < Case::width; ++i)
        if (k == i) w = a.w[i], d = a.d[i];
}

}  // namespace moraine::gpu
