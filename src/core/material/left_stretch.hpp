#pragma once
// The left Cauchy-Green tensor b = F Fᵀ, advanced without F:
//
//   b <- (I + dL) b (I + dL)ᵀ
//
// Symmetric by construction and 4 or 6 numbers instead of 4 or 9. In plane strain b_zz stays 1.

#include "core/vec.hpp"

namespace moraine {

template <class Real, int Dim>
MORAINE_HD Sym<Real, Dim> undeformed_stretch() {
    Sym<Real, Dim> b = zero_sym<Real, Dim>();
    for (int k = 0; k < 3; ++k) b[k] = Real(1);
    return b;
}

template <class Real, int Dim>
MORAINE_HD Sym<Real, Dim> advanced(const Sym<Real, Dim>& b, const Mat<Real, Dim>& dL) {
    Mat<Real, Dim> f = dL;
    for (int i = 0; i < Dim; ++i) f(i, i) += Real(1);
    return rotated(b, f);
}

}  // namespace moraine
