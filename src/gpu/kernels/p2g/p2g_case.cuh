#pragma once
// What the compiler knows of one particle-to-grid kernel, and the weights of a slice.
//
// A slice is one layer of the stencil across the last axis: `lines` lines of `width` nodes. One thread sums one slice
// of one cell. A thread block has the 64 cells of one block in 3-D, of four in 2-D, times `width` slices.

#include <cmath>
#include <type_traits>

#include "core/grid/shape.hpp"
#include "gpu/kernels/p2g/p2g_scale.hpp"
#include "gpu/kernels/view.hpp"

namespace moraine::gpu {

/// Mean: the nodes' s_i is summed besides, for fluids that want it (core/transfer/p2g.hpp).
template <class R, int D, class S, bool A, bool Mean = false>
struct P2gCase {
    using Real = R;
    using Scale = std::conditional_t<Mean, MeanScale<R>, R>;
    using Shape = S;
    static constexpr int dim = D;
    static constexpr bool affine = A;
    static constexpr bool mean = Mean;
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
    /// Ghosts behind walls are folded particle by particle, not in tiles (folded_slopes()).
    static constexpr bool folds_weights = affine && width > 2;
};

template <class Real>
__device__ __forceinline__ Real cell_size(Real cell) {
    return cell;
}
template <class Real>
__device__ __forceinline__ Real cell_size(const MeanScale<Real>& scale) {
    return scale.cell;
}

/// Index of this thread in its block, read anew: what is derived from it need not stay in registers through the sums.
__device__ __forceinline__ unsigned thread_now() {
    unsigned t;
    asm volatile("mov.u32 %0, %%tid.x;" : "=r"(t));
    return t;
}

/// Weights and slopes [1/cell] of one axis.
template <class Case>
struct Axis {
    typename Case::Real w[Case::width];
    typename Case::Real d[Case::width];
};

/// Gimp (core/grid/shape.hpp) around d = f - 1/2, the distance from the middle node: a box of half-size l, with
/// quarter = 1 / (4 l), reaches both outer nodes where |d| < l, else the one on its side. Every thread of a cell makes
/// these weights anew; those of core/grid/shape.hpp divide, and have four branches per node: 1908 instructions instead
/// of 1312 and 48 bytes of stack instead of none (3-D, single, FLIP, sm_90; with C 2014 instead of 1450).
template <class Real>
__device__ __forceinline__ void gimp_weights(Real f, Real half, Real quarter, Real* w, Real* dw) {
    const Real d = f - Real(0.5), up = half + d, down = half - d, u = up * quarter, v = down * quarter;
    const bool both = std::fabs(d) < half;
    const bool above = d > Real(0);
    w[0] = both ? down * v : (above ? Real(0) : -d);
    w[2] = both ? up * u : (above ? d : Real(0));
    w[1] = Real(1) - w[0] - w[2];
    dw[0] = both ? -(v + v) : (above ? Real(0) : Real(-1));
    dw[2] = both ? u + u : (above ? Real(1) : Real(0));
    dw[1] = -dw[0] - dw[2];
}

/// f: place in the cell.
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

/// Weights and slopes; Folded: where ghosts behind walls are folded (core/grid/walls.hpp), for momentum with C, which a
/// ghost must not be given first. ghosts: 3 bits per axis. Without C tiles are folded, and nothing is done here.
template <class Case, bool Folded>
__device__ __forceinline__ Axis<Case> folded_slopes(int axis, unsigned ghosts, typename Case::Real f,
                                                    typename Case::Real half, typename Case::Real quarter) {
    Axis<Case> a = slopes_of<Case>(f, half, quarter);
    if constexpr (Folded) {
        const unsigned mine = ghosts >> (3 * axis) & 7;
        if (mine) fold_weights<Case::width>(mine, a.w, a.d);
    }
    return a;
}

/// Weight and slope of slice k on its axis; k is known at run time.
template <class Case, bool Folded>
struct SliceWeight {
    using Real = typename Case::Real;
    int k;

    __device__ explicit SliceWeight(int slice) : k(slice) {}
    __device__ void get(unsigned ghosts, Real f, Real half, Real quarter, Real& w, Real& d) const {
        const Axis<Case> a = folded_slopes<Case, Folded>(Case::dim - 1, ghosts, f, half, quarter);
        w = a.w[0], d = a.d[0];
#pragma unroll
        for (int i = 1; i < Case::width; ++i)
            if (k == i) w = a.w[i], d = a.d[i];
    }
    /// x_i - x_p [cells].
    __device__ Real distance(Real f) const {
        return Real(k) - Case::Shape::template reach<Real> - f;
    }
};

/// Quadratic: all three weights are a t^2 + e with t = f - c. Saves 7 of 158 instructions per particle; only these
/// cases have registers for three numbers more.
template <int D, bool Affine>
struct SliceWeight<P2gCase<float, D, Quadratic, Affine>, false> {
    using R = float;
    R a, c, e;

    __device__ explicit SliceWeight(int k)
        : a(k == 1 ? R(-1) : R(0.5)), c(R(1) - R(0.5) * R(k)), e(k == 1 ? R(0.75) : R(0)) {}
    __device__ R distance(R f) const { return R(1.5) - R(2) * c - f; }
    __device__ void get(unsigned, R f, R, R, R& w, R& d) const {
        const R t = f - c;
        w = a * t * t + e;
        d = (a + a) * t;
    }
};

}  // namespace moraine::gpu
