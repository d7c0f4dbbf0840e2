#pragma once
// Tractions on a flat part of a body's surface, without a surface: by the divergence theorem along the lines of soil
// that began under it (M: its normal then, outward; a virtual stress as in Liang, Given and Soga 2023, in the places of
// the start).
//
//   int w_i t dA0 = int M . Grad0 (chi w_i t) dV0 = sum_p V0 t_p (q_p w_ip + chi_p (F_p M) . grad w_ip)
//   chi(d) = 1 at the surface, 0 from D on: 3 s^2 - 2 s^3, s = 1 - d / D;   q = -d chi / d d
//   dead      t = -p M + S                                             per area of the start
//   follower  t = -p c + |c| s,   c = det F F^-T M,  s = |S| F S / |F S|     per area of now
//
// chi and q are means over a particle's own length of a line, so that those of a lattice add up to 1 and the force is
// the area times t, whatever the cells and however the soil moves: gradients of weights cancel. Lines of soil are
// independent, so what is loaded ends sharply. Soil that has been mixed has no lines: from |F - I|^2 = 1 on chi fades,
// which leaves the force as it is and spreads it over D; an area counts at most 4 times that of the start.
// Why not forces on the particles of the surface: stresses under it were wrong by half of p (docs/adr/0015).

#include <cmath>

#include "core/particles/particle_load.hpp"

namespace moraine {

template <class Real, int Dim>
struct Traction {
    Vec<Real, Dim> normal;    ///< M
    Vec<Real, Dim> shear;     ///< S [Pa]
    Real pressure;            ///< p [Pa]
    Real depth;               ///< D [m]
    Real spacing;             ///< of particles along M [m]
    Real inverse_density;     ///< of the body at the start [m3/kg]
    int density_scalar = -1;  ///< of the law, where each particle has its own; -1: it has none
    bool follows;
};

/// chi and q of a particle.
template <class Real>
struct LineShare {
    Real chi, q;  ///< [-], [1/m]
};

template <class Real>
MORAINE_HD LineShare<Real> line_share(Real depth, Real spacing, Real load_place) {
    const auto cut = [](Real s) { return s < Real(0) ? Real(0) : s > Real(1) ? Real(1) : s; };
    const auto chi = [&](Real s) { return cut(s) * cut(s) * (Real(3) - Real(2) * cut(s)); };
    const auto sum = [&](Real s) {  // integral of chi
        const Real c = cut(s);
        return c * c * c * (Real(1) - Real(0.5) * c) + (s - c > Real(0) ? s - c : Real(0));
    };
    const Real lower = (load_place - spacing) / depth, upper = load_place / depth;  // s of its ends
    return {(sum(upper) - sum(lower)) * depth / spacing, (chi(upper) - chi(lower)) / spacing};
}

/// det F F^-T.
template <class Real>
MORAINE_HD Mat<Real, 2> cofactors(const Mat<Real, 2>& f) {
    return {{{f(1, 1), -f(1, 0)}, {-f(0, 1), f(0, 0)}}};
}
template <class Real>
MORAINE_HD Mat<Real, 3> cofactors(const Mat<Real, 3>& f) {
    Mat<Real, 3> c;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const int k = (i + 1) % 3, l = (i + 2) % 3, m = (j + 1) % 3, n = (j + 2) % 3;
            c(i, j) = f(k, m) * f(l, n) - f(k, n) * f(l, m);
        }
    return c;
}

template <class Real, int Dim>
MORAINE_HD Vec<Real, Dim> times(const Mat<Real, Dim>& m, const Vec<Real, Dim>& v) {
    Vec<Real, Dim> out = zero_vec<Real, Dim>();
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) out[i] += m(i, j) * v[j];
    return out;
}

template <class Real, int Dim>
MORAINE_HD Real length_of(const Vec<Real, Dim>& v) {
    using std::sqrt;
    Real square = Real(0);
    for (int a = 0; a < Dim; ++a) square += v[a] * v[a];
    return sqrt(square);
}

/// t, where the soil has F [Pa].
template <class Real, int Dim>
MORAINE_HD Vec<Real, Dim> traction_of(const Traction<Real, Dim>& t, const Mat<Real, Dim>& F) {
    constexpr Real most = Real(4);
    Vec<Real, Dim> area = t.normal, along = t.shear;
    Real stretch = Real(1);
    if (t.follows) {
        area = times(cofactors(F), t.normal);
        const Real size = length_of(area), kept = size > most ? most / size : Real(1);
        along = times(F, t.shear);
        const Real shear = length_of(along);
        stretch = shear > Real(0) ? size * kept * length_of(t.shear) / shear : Real(0);
        for (int a = 0; a < Dim; ++a) area[a] *= kept;
    }
    Vec<Real, Dim> out;
    for (int a = 0; a < Dim; ++a) out[a] = stretch * along[a] - t.pressure * area[a];
    return out;
}

/// Adds what a traction gives to a particle. factor: of the step; place: its load_place; F: F - I; inverse_density: of
/// the particle at the start [m3/kg].
template <class Real, int Dim>
MORAINE_HD void add_load(const Traction<Real, Dim>& t, Real factor, Real place, Mat<Real, Dim> F, Real mass,
                         Real inverse_density, ParticleLoad<Real, Dim>& to) {
    Real change = Real(0);
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) change += F(i, j) * F(i, j);
    for (int i = 0; i < Dim; ++i) F(i, i) += Real(1);
    const LineShare<Real> share = line_share(t.depth, t.spacing, place);
    const Real volume = factor * mass * inverse_density;
    const Vec<Real, Dim> traction = traction_of(t, F), line = times(F, t.normal);
    const Real chi = volume * (change > Real(1) ? share.chi / change : share.chi);
    for (int a = 0; a < Dim; ++a) {
        to.force[a] += volume * share.q * traction[a];
        for (int b = 0; b < Dim; ++b) to.couple(a, b) += chi * traction[a] * line[b];
    }
}

}  // namespace moraine
