#pragma once
// The strain increment of one step, objective: Hughes and Winget (1980), doi 10.1002/nme.1620151210.
//
//   dL = dt grad v  (with respect to the positions at the start of the step; I + dL maps them on)
//   H  = dL (I + dL/2)^-1                       gradient at mid-step
//   de = sym H,  w = skew H,  Q = (I - w/2)^-1 (I + w/2)
//
// A rigid rotation gives de = 0 and Q = the rotation, to rounding, whatever its angle below 180 deg.
// tr H = d ln J to third order. A material turns its stress by Q and adds its response to de
// (Jaumann rate).

#include "core/vec.hpp"

namespace moraine {

template <class Real, int Dim>
struct StrainIncrement {
    Sym<Real, Dim> strain;    ///< de                                            [-]
    Mat<Real, Dim> rotation;  ///< Q                                             [-]
    Mat<Real, Dim> gradient;  ///< dL                                            [-]
    Real volumetric;          ///< tr H, the increment of ln J                   [-]
    Real stretch;             ///< det(I + dL); not positive: the step is wrong  [-]
    Real dt;                  ///< [s]
};

template <class Real, int Dim>
MORAINE_HD StrainIncrement<Real, Dim> strain_increment(const Mat<Real, Dim>& dL, Real dt) {
    const Real half = Real(0.5);
    Mat<Real, Dim> mid = identity<Real, Dim>();
    Mat<Real, Dim> whole = identity<Real, Dim>();
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) mid(i, j) += half * dL(i, j), whole(i, j) += dL(i, j);
    const Mat<Real, Dim> H = dL * inverse(mid);

    StrainIncrement<Real, Dim> s;
    s.strain = zero_sym<Real, Dim>();
    s.volumetric = Real(0);
    Mat<Real, Dim> plus = identity<Real, Dim>();
    Mat<Real, Dim> minus = identity<Real, Dim>();
    for (int i = 0; i < Dim; ++i) {
        s.volumetric += H(i, i);
        for (int j = 0; j < Dim; ++j) {
            const Real w = Real(0.25) * (H(i, j) - H(j, i));  // half the spin of the step
            plus(i, j) += w;
            minus(i, j) -= w;
            if (j >= i) s.strain[Sym<Real, Dim>::index(i, j)] = half * (H(i, j) + H(j, i));
        }
    }
    s.rotation = inverse(minus) * plus;
    s.gradient = dL;
    s.stretch = determinant(whole);
    s.dt = dt;
    return s;
}

}  // namespace moraine
