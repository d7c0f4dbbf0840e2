#pragma once
// Four reals that move together: one vector register on the host, four registers on a device.
//
// The compilers here do not reliably vectorise loops of four, and -ffp-contract=off forbids them to
// fuse, so the fused multiply-add is written once, by intrinsics where the target has them. Each
// lane is an ordinary IEEE fma: the bits do not depend on which branch was compiled.

#include <cmath>
#include <cstring>

#include "core/block.hpp"
#include "core/vec.hpp"

#if defined(__FMA__) && !defined(__CUDA_ARCH__)
#include <immintrin.h>
#define MORAINE_QUAD_INTRINSICS 1
#endif

namespace moraine {

template <class Real>
struct alignas(quad * sizeof(Real)) Quad {
    Real e[quad];

    MORAINE_HD Real& operator[](int i) { return e[i]; }
    MORAINE_HD const Real& operator[](int i) const { return e[i]; }

    static MORAINE_HD Quad zero() { return all(Real(0)); }
    static MORAINE_HD Quad all(Real v) { return {{v, v, v, v}}; }
    static MORAINE_HD Quad load(const Real* from) { return {{from[0], from[1], from[2], from[3]}}; }
    MORAINE_HD void store(Real* to) const {
        for (int i = 0; i < quad; ++i) to[i] = e[i];
    }
};

/// s a + b, lane by lane, rounded once.
template <class Real>
MORAINE_HD Quad<Real> fma(Real s, const Quad<Real>& a, const Quad<Real>& b) {
    Quad<Real> r;
#if defined(MORAINE_QUAD_INTRINSICS)
    if constexpr (sizeof(Real) == 8) {
        _mm256_store_pd(r.e, _mm256_fmadd_pd(_mm256_set1_pd(s), _mm256_load_pd(a.e), _mm256_load_pd(b.e)));
    } else {
        _mm_store_ps(r.e, _mm_fmadd_ps(_mm_set1_ps(s), _mm_load_ps(a.e), _mm_load_ps(b.e)));
    }
#else
    using std::fma;
    for (int i = 0; i < quad; ++i) r.e[i] = fma(s, a.e[i], b.e[i]);
#endif
    return r;
}

template <class Real>
MORAINE_HD Quad<Real> operator*(Real s, const Quad<Real>& a) {
    return {{s * a.e[0], s * a.e[1], s * a.e[2], s * a.e[3]}};
}

template <class Real>
MORAINE_HD Quad<Real> operator+(const Quad<Real>& a, const Quad<Real>& b) {
    return {{a.e[0] + b.e[0], a.e[1] + b.e[1], a.e[2] + b.e[2], a.e[3] + b.e[3]}};
}

}  // namespace moraine
