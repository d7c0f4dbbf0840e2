#pragma once
// Four reals that move together: one vector register on the host, four registers on a device.
//
// The compilers here do not reliably vectorise loops of four, nor keep an array of four in a register
// when its elements are written one by one (each write is then stored and read back, which stalls), and
// -ffp-contract=off forbids them to fuse. So the host type is a vector, made whole by of(), and the fused
// multiply-add is written once, by the instruction where the target has them. Each lane is an ordinary IEEE
// operation: the bits do not depend on which branch was compiled.

#include <cmath>
#include <cstring>

#include "core/data/block.hpp"
#include "core/data/vec.hpp"

#if defined(__GNUC__) && !defined(__CUDACC__)
#define MORAINE_QUAD_VECTOR 1
#endif
// By the compiler's own names: the header of intrinsics is two megabytes in every object.
#if defined(MORAINE_QUAD_VECTOR) && defined(__FMA__)
#if __has_builtin(__builtin_ia32_vfmaddpd256) && __has_builtin(__builtin_ia32_vfmaddps)
#define MORAINE_QUAD_INTRINSICS 1
#endif
#endif

namespace moraine {

template <class Real>
struct alignas(quad * sizeof(Real)) Quad {
#if defined(MORAINE_QUAD_VECTOR)
    typedef Real Register __attribute__((vector_size(quad * sizeof(Real))));
#else
    typedef Real Register[quad];
#endif
    Register e;

    MORAINE_HD Real& operator[](int i) {
        return reinterpret_cast<Real*>(&e)[i];
    }
    MORAINE_HD Real operator[](int i) const {
        return e[i];
    }

    static MORAINE_HD Quad of(Real a, Real b, Real c, Real d) {
        return Quad{{a, b, c, d}};
    }
    static MORAINE_HD Quad all(Real v) {
        return of(v, v, v, v);
    }
    static MORAINE_HD Quad zero() {
        return all(Real(0));
    }

    /// s (v, 0), and (first, s v, 0): the components of a vector in the lanes from 0 or from 1 on.
    template <int Dim>
    static MORAINE_HD Quad scaled(Real s, const Vec<Real, Dim>& v) {
        return of(s * v[0], s * v[1], Dim == 3 ? s * v[Dim - 1] : Real(0), Real(0));
    }
    template <int Dim>
    static MORAINE_HD Quad scaled_after(Real first, Real s, const Vec<Real, Dim>& v) {
        return of(first, s * v[0], s * v[1], Dim == 3 ? s * v[Dim - 1] : Real(0));
    }

    static MORAINE_HD Quad load(const Real* from) {
        Quad q;
        std::memcpy(&q.e, from, sizeof(q.e));
        return q;
    }
    MORAINE_HD void store(Real* to) const {
        std::memcpy(to, &e, sizeof(e));
    }
};

/// s a + b, lane by lane, rounded once.
template <class Real>
MORAINE_HD Quad<Real> fma(Real s, const Quad<Real>& a, const Quad<Real>& b) {
#if defined(MORAINE_QUAD_INTRINSICS)
    if constexpr (sizeof(Real) == 8)
        return {__builtin_ia32_vfmaddpd256(Quad<Real>::all(s).e, a.e, b.e)};
    else
        return {__builtin_ia32_vfmaddps(Quad<Real>::all(s).e, a.e, b.e)};
#else
    using std::fma;
    return Quad<Real>::of(fma(s, a[0], b[0]), fma(s, a[1], b[1]), fma(s, a[2], b[2]), fma(s, a[3], b[3]));
#endif
}

template <class Real>
MORAINE_HD Quad<Real> operator*(Real s, const Quad<Real>& a) {
    return Quad<Real>::of(s * a[0], s * a[1], s * a[2], s * a[3]);
}

template <class Real>
MORAINE_HD Quad<Real> operator+(const Quad<Real>& a, const Quad<Real>& b) {
    return Quad<Real>::of(a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]);
}

}  // namespace moraine
