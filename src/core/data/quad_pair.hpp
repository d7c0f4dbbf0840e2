#pragma once
// The two quads of a node in one register, where there is one that holds them: single precision on AVX2, double on
// AVX-512. Elsewhere they are two quads. What is done to one of them leaves the other as it is, whatever it holds: a
// weight of zero would not (-0 + 0 is 0, and zero times infinity is no number).

#include "core/data/processor.hpp"
#include "core/data/quad_group.hpp"

namespace moraine {

template <class Real, bool InOne = 2 * quad* int(sizeof(Real)) <= register_bytes>
struct QuadPair {
    using Factors = Together<Real, 1>;  ///< of what numbers a pair is multiplied with
    using Number = typename Factors::Number;
    Quad<Real> first, second;

    static MORAINE_HD QuadPair of(const Quad<Real>& first, const Quad<Real>& second) { return {first, second}; }
    static MORAINE_HD QuadPair load(const Real* from) {
        return {Quad<Real>::load(from), Quad<Real>::load(from + quad)};
    }
    MORAINE_HD void store(Real* to) const { first.store(to), second.store(to + quad); }

    /// (s first, t second).
    MORAINE_HD QuadPair times(Number s, Number t) const { return {s * first, t * second}; }
    /// this + b; and for the first quad only.
    MORAINE_HD QuadPair plus(const QuadPair& b) const { return {first + b.first, second + b.second}; }
    MORAINE_HD QuadPair first_plus(const QuadPair& b) const { return {first + b.first, second}; }
    /// this + s a, rounded once; and for one quad only.
    MORAINE_HD QuadPair plus(Number s, const QuadPair& a) const {
        return {fma(s, a.first, first), fma(s, a.second, second)};
    }
    MORAINE_HD QuadPair first_plus(Number s, const QuadPair& a) const { return {fma(s, a.first, first), second}; }
    MORAINE_HD QuadPair second_plus(Number s, const QuadPair& a) const { return {first, fma(s, a.second, second)}; }
};

#if defined(MORAINE_QUAD_INTRINSICS) && defined(__AVX2__)
template <class Real>
struct QuadPair<Real, true> {
    using Factors = Together<Real, 2>;
    using Number = QuadGroup<Real, 2>;
    Number e;

    static MORAINE_HD QuadPair of(const Quad<Real>& first, const Quad<Real>& second) {
#if defined(__AVX512F__)
        if constexpr (sizeof(Real) == 8)
            return {Number(_mm512_maskz_insertf64x4(0xff, _mm512_castpd256_pd512(first.e), second.e, 1))};
        else
#endif
            return {Number(_mm256_set_m128(second.e, first.e))};
    }
    static MORAINE_HD QuadPair load(const Real* from) {
        QuadPair p;
        std::memcpy(&p.e.e, from, sizeof(p.e.e));
        return p;
    }
    MORAINE_HD void store(Real* to) const {
        std::memcpy(to, &e.e, sizeof(e.e));
    }

    MORAINE_HD QuadPair times(const Number& s, const Number& t) const {
        return {chosen(s, t) * e};
    }
    MORAINE_HD QuadPair plus(const QuadPair& b) const {
        return {e + b.e};
    }
    MORAINE_HD QuadPair first_plus(const QuadPair& b) const {
        return {chosen(e + b.e, e)};
    }
    MORAINE_HD QuadPair plus(const Number& s, const QuadPair& a) const {
        return {fma(s, a.e, e)};
    }
    MORAINE_HD QuadPair first_plus(const Number& s, const QuadPair& a) const {
        return {chosen(fma(s, a.e, e), e)};
    }
    MORAINE_HD QuadPair second_plus(const Number& s, const QuadPair& a) const {
        return {chosen(e, fma(s, a.e, e))};
    }

  private:
    /// The first quad of one, the second of the other.
    static MORAINE_HD Number chosen(const Number& first, const Number& second) {
#if defined(__AVX512F__)
        if constexpr (sizeof(Real) == 8)
            return Number(_mm512_mask_blend_pd(0xf0, first.e, second.e));
        else
#endif
            return Number(_mm256_blend_ps(first.e, second.e, 0xf0));
    }
};
#endif

}  // namespace moraine
