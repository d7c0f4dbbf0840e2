#pragma once
// Principal values of a symmetric tensor, and the means to change them along their directions:
//
//   S = sum_a value_a n_a n_aᵀ,     add(S, change): S += sum_a change_a n_a n_aᵀ
//
// In plane strain the plane's two in closed form (n nᵀ from the deviator, no angle) and zz. In 3-D
// cyclic Jacobi on the deviator: orthogonal directions to rounding, also for equal values, where the
// closed formula loses half of the digits. Not sorted.

#include <cmath>
#include <limits>

#include "core/data/vec.hpp"

namespace moraine {

template <class Real, int Dim>
struct Spectrum;

template <class Real>
struct Spectrum<Real, 2> {
    Real value[3];

    MORAINE_HD explicit Spectrum(const Sym<Real, 2>& s) {
        using std::sqrt;
        const Real centre = Real(0.5) * (s[0] + s[1]);
        const Real x = Real(0.5) * (s[0] - s[1]);
        const Real radius = sqrt(x * x + s[3] * s[3]);
        const Real r = radius > Real(0) ? Real(1) / radius : Real(0);
        cosine = x * r;
        sine = s[3] * r;
        value[0] = centre + radius;
        value[1] = centre - radius;
        value[2] = s[2];
    }

    MORAINE_HD void add(Sym<Real, 2>& s, const Real (&change)[3]) const {
        const Real centre = Real(0.5) * (change[0] + change[1]);
        const Real radius = Real(0.5) * (change[0] - change[1]);
        s[0] += centre + radius * cosine;
        s[1] += centre - radius * cosine;
        s[2] += change[2];
        s[3] += radius * sine;
    }

    Real cosine;  ///< of twice the angle of the first direction
    Real sine;
};

template <class Real>
struct Spectrum<Real, 3> {
    static constexpr int sweep_limit = 10;
    static constexpr Real tolerance = Real(0.25) * std::numeric_limits<Real>::epsilon();
    Real value[3];

    MORAINE_HD explicit Spectrum(const Sym<Real, 3>& s) {
        const Real mean = s.trace() * Real(1.0 / 3.0);
        Real a[3][3], n[3][3];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                a[i][j] = i == j ? s(i, j) - mean : s(i, j);
                n[i][j] = i == j ? Real(1) : Real(0);
            }
        for (int sweep = 0; sweep < sweep_limit; ++sweep) {
            const Real off = a[0][1] * a[0][1] + a[1][2] * a[1][2] + a[0][2] * a[0][2];
            const Real diagonal = a[0][0] * a[0][0] + a[1][1] * a[1][1] + a[2][2] * a[2][2];
            if (off <= tolerance * tolerance * diagonal) break;
            turn<0, 1>(a, n);
            turn<0, 2>(a, n);
            turn<1, 2>(a, n);
        }
        for (int k = 0; k < 3; ++k) {
            value[k] = mean + a[k][k];
            for (int i = 0; i < 3; ++i) direction[k][i] = n[i][k];
        }
    }

    MORAINE_HD void add(Sym<Real, 3>& s, const Real (&change)[3]) const {
        for (int i = 0; i < 3; ++i)
            for (int j = i; j < 3; ++j) {
                Real sum = Real(0);
                for (int k = 0; k < 3; ++k) sum += change[k] * direction[k][i] * direction[k][j];
                s[Sym<Real, 3>::index(i, j)] += sum;
            }
    }

    Real direction[3][3];  ///< unit vectors, row k for value k

  private:
    /// One Jacobi rotation: makes a[P][Q] zero.
    template <int P, int Q>
    static MORAINE_HD void turn(Real (&a)[3][3], Real (&n)[3][3]) {
        using std::fabs;
        using std::sqrt;
        constexpr int R = 3 - P - Q;
        if (a[P][Q] == Real(0)) return;
        // tan of the smaller angle, written so that nothing overflows: 2 a_pq / (d +- sqrt(d^2 + 4 a_pq^2))
        const Real d = a[Q][Q] - a[P][P];
        const Real twice = Real(2) * a[P][Q];
        const Real root = sqrt(d * d + twice * twice);
        const Real t = root > Real(0) ? twice / (d >= Real(0) ? d + root : d - root) : Real(0);
        const Real c = Real(1) / sqrt(Real(1) + t * t);
        const Real s = t * c;
        a[P][P] -= t * a[P][Q];
        a[Q][Q] += t * a[P][Q];
        a[P][Q] = a[Q][P] = Real(0);
        const Real rp = a[R][P], rq = a[R][Q];
        a[R][P] = a[P][R] = c * rp - s * rq;
        a[R][Q] = a[Q][R] = s * rp + c * rq;
        for (int i = 0; i < 3; ++i) {
            const Real x = n[i][P], y = n[i][Q];
            n[i][P] = c * x - s * y;
            n[i][Q] = s * x + c * y;
        }
    }
};

/// Largest, middle and smallest of three.
template <class Real>
struct Ordered {
    Real first, second, third;

    MORAINE_HD explicit Ordered(const Real (&v)[3]) {
        const Real high = v[0] > v[1] ? v[0] : v[1];
        const Real low = v[0] > v[1] ? v[1] : v[0];
        first = high > v[2] ? high : v[2];
        third = low < v[2] ? low : v[2];
        second = v[2] > high ? high : (v[2] < low ? low : v[2]);
    }
};

}  // namespace moraine
