#pragma once
// Several particles side by side: a formula written for one Real computes a register full of them.
//
// Each lane is an ordinary IEEE operation, so the bits are those of the scalar formula.

#include "core/vec.hpp"

namespace moraine {

template <class Real>
struct Lanes {
    static constexpr int count = 32 / sizeof(Real);
    typedef Real Register __attribute__((vector_size(32)));
    Register v;

    Lanes() = default;
    MORAINE_HD explicit Lanes(Register r) : v(r) {}
    MORAINE_HD explicit Lanes(double all) : v(Register{} + static_cast<Real>(all)) {}
    MORAINE_HD Real& operator[](int i) { return reinterpret_cast<Real*>(&v)[i]; }
    MORAINE_HD Lanes& operator+=(Lanes b) { return v += b.v, *this; }

    friend MORAINE_HD Lanes operator+(Lanes a, Lanes b) { return Lanes(a.v + b.v); }
    friend MORAINE_HD Lanes operator-(Lanes a, Lanes b) { return Lanes(a.v - b.v); }
    friend MORAINE_HD Lanes operator-(Lanes a) { return Lanes(-a.v); }
    friend MORAINE_HD Lanes operator*(Lanes a, Lanes b) { return Lanes(a.v * b.v); }
    friend MORAINE_HD Lanes operator/(Lanes a, Lanes b) { return Lanes(a.v / b.v); }
};

}  // namespace moraine
