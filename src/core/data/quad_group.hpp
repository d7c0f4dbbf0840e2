#pragma once
// The quads of several particles side by side in one register: what the gather of a cell computes with.
//
// Particles of a cell read the same nodes, so a node is spread to all of them (a load does that), and each has its
// weight in lanes of its own. Every lane does what it would do for one particle alone, in the same order, so the bits
// do not depend on how many go together. An operator for every number of a shape's formulas, so that these are written
// once. Host only: on a device each particle has a thread.

#include "core/data/quad.hpp"

#if defined(MORAINE_QUAD_INTRINSICS)
#include <immintrin.h>
#endif

namespace moraine {

template <class Real, int Count>
struct QuadGroup;

#if defined(MORAINE_QUAD_VECTOR)
template <class Real, int Count>
struct QuadGroup {
    static constexpr int bytes = Count * quad * int(sizeof(Real));
    typedef Real Register __attribute__((vector_size(bytes)));
    Register e;

    QuadGroup() = default;
    MORAINE_HD constexpr explicit QuadGroup(const Register& r) : e(r) {}
    /// One number for all.
    MORAINE_HD constexpr explicit QuadGroup(double all) : e(static_cast<Real>(all) * (Register{} + Real(1))) {}

    /// A quad of memory for all: a load that spreads it, which compilers make of no shuffle.
    static MORAINE_HD QuadGroup spread(const Quad<Real>& q) {
        if constexpr (Count == 1) return QuadGroup(q.e);
#if defined(__AVX512F__)
        if constexpr (bytes == 64 && sizeof(Real) == 8)
            return QuadGroup(Register(_mm512_maskz_broadcast_f64x4(0xff, q.e)));
        if constexpr (bytes == 64 && sizeof(Real) == 4)
            return QuadGroup(Register(_mm512_maskz_broadcast_f32x4(0xffff, q.e)));
#endif
#if defined(__AVX2__)
        if constexpr (bytes == 32 && sizeof(Real) == 4)
            return QuadGroup(Register(_mm256_broadcast_ps(reinterpret_cast<const __m128*>(&q))));
#endif
        QuadGroup g;
        for (int i = 0; i < Count * quad; ++i) g.e[i] = q.e[i % quad];
        return g;
    }
    /// value(particle): a number of each.
    template <class F>
    static MORAINE_HD QuadGroup each(const F& value) {
        const Real a = value(0);
        if constexpr (Count == 1) return QuadGroup(Register{a, a, a, a});
        const Real b = value(Count > 1 ? 1 : 0);
        if constexpr (Count == 2) return QuadGroup(Register{a, a, a, a, b, b, b, b});
        if constexpr (Count == 4) {
            const Real c = value(2), d = value(3);
            return QuadGroup(Register{a, a, a, a, b, b, b, b, c, c, c, c, d, d, d, d});
        }
    }

    /// What a particle has of it.
    MORAINE_HD Quad<Real> of(int particle) const {
        return Quad<Real>::load(reinterpret_cast<const Real*>(&e) + particle * quad);
    }

    MORAINE_HD QuadGroup& operator*=(const QuadGroup& b) {
        return e *= b.e, *this;
    }
    MORAINE_HD QuadGroup& operator+=(const QuadGroup& b) {
        return e += b.e, *this;
    }
    MORAINE_HD QuadGroup& operator-=(const QuadGroup& b) {
        return e -= b.e, *this;
    }
    friend MORAINE_HD QuadGroup operator+(const QuadGroup& a, const QuadGroup& b) {
        return QuadGroup(a.e + b.e);
    }
    friend MORAINE_HD QuadGroup operator-(const QuadGroup& a, const QuadGroup& b) {
        return QuadGroup(a.e - b.e);
    }
    friend MORAINE_HD QuadGroup operator-(const QuadGroup& a) {
        return QuadGroup(-a.e);
    }
    friend MORAINE_HD QuadGroup operator*(const QuadGroup& a, const QuadGroup& b) {
        return QuadGroup(a.e * b.e);
    }
    friend MORAINE_HD QuadGroup operator/(const QuadGroup& a, const QuadGroup& b) {
        return QuadGroup(a.e / b.e);
    }
};

/// s a + b, lane by lane, rounded once.
template <class Real, int Count>
MORAINE_HD QuadGroup<Real, Count> fma(const QuadGroup<Real, Count>& s, const QuadGroup<Real, Count>& a,
                                      const QuadGroup<Real, Count>& b) {
    using Group = QuadGroup<Real, Count>;
#if defined(__AVX512F__)
    if constexpr (Group::bytes == 64 && sizeof(Real) == 8) return Group(_mm512_fmadd_pd(s.e, a.e, b.e));
    if constexpr (Group::bytes == 64 && sizeof(Real) == 4) return Group(_mm512_fmadd_ps(s.e, a.e, b.e));
#endif
#if defined(MORAINE_QUAD_INTRINSICS)
    if constexpr (Group::bytes == 32 && sizeof(Real) == 8) return Group(_mm256_fmadd_pd(s.e, a.e, b.e));
    if constexpr (Group::bytes == 32 && sizeof(Real) == 4) return Group(_mm256_fmadd_ps(s.e, a.e, b.e));
    if constexpr (Group::bytes == 16) return Group(_mm_fmadd_ps(s.e, a.e, b.e));
#endif
    Group r;
    for (int i = 0; i < Count * quad; ++i) r.e[i] = std::fma(s.e[i], a.e[i], b.e[i]);
    return r;
}
#endif

/// Numbers and quads of Count particles that go together: of one, those of quad.hpp.
template <class Real, int Count>
struct Together {
    static constexpr int count = Count;
    using Scalar = Real;
    using Number = QuadGroup<Real, Count>;
    using Quads = QuadGroup<Real, Count>;

    static MORAINE_HD Quads spread(const Quad<Real>& q) { return Quads::spread(q); }
    template <class F>
    static MORAINE_HD Number each(const F& value) {
        return Number::each(value);
    }
    static MORAINE_HD Real number_of(const Number& n, int particle) { return n.of(particle)[0]; }
};

template <class Real>
struct Together<Real, 1> {
    static constexpr int count = 1;
    using Scalar = Real;
    using Number = Real;
    using Quads = Quad<Real>;

    static MORAINE_HD const Quads& spread(const Quads& q) { return q; }
    template <class F>
    static MORAINE_HD Number each(const F& value) {
        return value(0);
    }
    static MORAINE_HD Number number_of(Number n, int) { return n; }
};

}  // namespace moraine
