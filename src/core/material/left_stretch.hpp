#pragma once
// The left Cauchy-Green tensor b = F Fᵀ, advanced without F, and kept as b - I:
//
//   b - I <- (I + dL) (b - I) (I + dL)ᵀ + dL + dLᵀ + dL dLᵀ
//
// Symmetric by construction and 4 or 6 numbers instead of 4 or 9. In plane strain b_zz stays 1. Kept as b, strains of
// 1e-4 would have four digits in single, and each step would round there: E3 at A = 1e-4 was off by 0.8 % of A.

#include "core/data/vec.hpp"

namespace moraine {

template <class Real, int Dim>
MORAINE_HD Sym<Real, Dim> undeformed_stretch() {
    return zero_sym<Real, Dim>();
}

template <class Real, int Dim>
MORAINE_HD Sym<Real, Dim> advanced(const Sym<Real, Dim>& b, const Mat<Real, Dim>& dL) {
    Mat<Real, Dim> f = dL;
    for (int i = 0; i < Dim; ++i) f(i, i) += Real(1);
    Sym<Real, Dim> next = rotated(b, f);
    for (int i = 0; i < Dim; ++i)
        for (int j = i; j < Dim; ++j) {
            Real square = Real(0);
            for (int k = 0; k < Dim; ++k) square += dL(i, k) * dL(j, k);
            next[Sym<Real, Dim>::index(i, j)] += (dL(i, j) + dL(j, i)) + square;
        }
    return next;
}

}  // namespace moraine
