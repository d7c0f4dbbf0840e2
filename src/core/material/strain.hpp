#pragma once
// The strain increment of one step, objective: Hughes and Winget (1980), doi 10.1002/nme.1620151210.
//
//   dL = dt grad v  (with respect to the positions at the start of the step; I + dL maps them on)
//   H  = dL (I + dL/2)^-1                       gradient at mid-step
//   w  = skew H,  Q(w) = (I - w/2)^-1 (I + w/2)  turns from the start to the end of the step
//   de = Q(w/2) sym H Q(w/2)ᵀ                    seen in the axes of the end of the step
//
// A rigid rotation gives de = 0 and Q = the rotation, to rounding, whatever its angle below 180 deg.
// A material turns its stress by Q and adds its response to de (Jaumann rate). Without the half turn
// of de simple shear is of first order: error 8e-4 G instead of 2e-7 G at dgamma = 1e-3, gamma = 4.
// Q has a closed form (Cayley transform of a skew tensor): no second inverse, orthogonal to rounding.
// H = 2 tanh(ln(I + dL) / 2), hence d ln J = tr H + tr H^3 / 12 + O(dL^5).

#include "core/data/vec.hpp"

namespace moraine {

template <class Real, int Dim>
struct StrainIncrement {
    Sym<Real, Dim> strain;    ///< de, in the axes of the end of the step        [-]
    Sym<Real, Dim> middle;    ///< sym H, in mid-step axes: (sigma_n + sigma_n+1) / 2 : middle is work  [-]
    Mat<Real, Dim> rotation;  ///< Q                                             [-]
    Mat<Real, Dim> gradient;  ///< dL                                            [-]
    Real volumetric;          ///< the increment of ln J, to fifth order         [-]
    Real stretch;             ///< det(I + dL); not positive: the step is wrong  [-]
    Real dt;                  ///< [s]
};

/// Q(fraction w), w = skew H: in the plane a turn by 2 atan(fraction w_yx / 2).
template <class Real>
MORAINE_HD Mat<Real, 2> cayley_rotation(const Mat<Real, 2>& H, Real fraction) {
    const Real r = Real(0.25) * fraction * (H(1, 0) - H(0, 1));
    const Real f = Real(2) / (Real(1) + r * r);
    const Real c = Real(1) - f * r * r;
    return {{{c, -f * r}, {f * r, c}}};
}

/// In space, with r the axial vector of fraction w / 2: Q = I + 2 (R + R R) / (1 + r.r), R R = r rT - r.r I.
template <class Real>
MORAINE_HD Mat<Real, 3> cayley_rotation(const Mat<Real, 3>& H, Real fraction) {
    const Real quarter = Real(0.25) * fraction;
    const Real x = quarter * (H(2, 1) - H(1, 2));
    const Real y = quarter * (H(0, 2) - H(2, 0));
    const Real z = quarter * (H(1, 0) - H(0, 1));
    const Real f = Real(2) / (Real(1) + (x * x + y * y + z * z));
    const Real fx = f * x, fy = f * y, fz = f * z;
    const Real xx = fx * x, yy = fy * y, zz = fz * z, xy = fx * y, yz = fy * z, zx = fz * x;
    return {{{Real(1) - (yy + zz), xy - fz, zx + fy},
             {xy + fz, Real(1) - (zz + xx), yz - fx},
             {zx - fy, yz + fx, Real(1) - (xx + yy)}}};
}

/// tr H^3 from the invariants of H.
template <class Real>
MORAINE_HD Real trace_of_cube(const Mat<Real, 2>& H) {
    const Real t = H(0, 0) + H(1, 1);
    return t * (t * t - Real(3) * determinant(H));
}

template <class Real>
MORAINE_HD Real trace_of_cube(const Mat<Real, 3>& H) {
    const Real t = H(0, 0) + H(1, 1) + H(2, 2);
    const Real second = (H(0, 0) * H(1, 1) - H(0, 1) * H(1, 0)) + (H(1, 1) * H(2, 2) - H(1, 2) * H(2, 1)) +
                        (H(2, 2) * H(0, 0) - H(2, 0) * H(0, 2));
    return t * (t * t - Real(3) * second) + Real(3) * determinant(H);
}

template <class Real, int Dim>
MORAINE_HD StrainIncrement<Real, Dim> strain_increment(const Mat<Real, Dim>& dL, Real dt) {
    const Real half = Real(0.5);
    Mat<Real, Dim> mid = identity<Real, Dim>();
    Mat<Real, Dim> whole = identity<Real, Dim>();
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) mid(i, j) += half * dL(i, j), whole(i, j) += dL(i, j);
    const Mat<Real, Dim> H = dL * inverse(mid);

    StrainIncrement<Real, Dim> s;
    s.middle = zero_sym<Real, Dim>();
    for (int i = 0; i < Dim; ++i)
        for (int j = i; j < Dim; ++j) s.middle[Sym<Real, Dim>::index(i, j)] = half * (H(i, j) + H(j, i));
    s.strain = rotated(s.middle, cayley_rotation(H, half));
    s.rotation = cayley_rotation(H, Real(1));
    s.gradient = dL;
    s.volumetric = s.middle.trace() + trace_of_cube(H) * Real(1.0 / 12.0);
    s.stretch = determinant(whole);
    s.dt = dt;
    return s;
}

}  // namespace moraine
