#pragma once
// Several particles side by side: a formula written for one Real computes a register full of them.
//
// Each lane is an ordinary IEEE operation, so the bits are those of the scalar formula.

#include <utility>

#include "core/data/processor.hpp"
#include "core/data/vec.hpp"

namespace moraine {

template <class Real>
struct Lanes {
    static constexpr int bytes = register_bytes < 32 ? 32 : register_bytes;
    static constexpr int count = bytes / int(sizeof(Real));
    typedef Real Register __attribute__((vector_size(bytes)));
    Register v;

    Lanes() = default;
    MORAINE_HD explicit Lanes(Register r) : v(r) {}
    MORAINE_HD explicit Lanes(double all) : v(Register{} + static_cast<Real>(all)) {}
    /// value(lane) of each.
    template <class F>
    static MORAINE_HD Lanes each(const F& value) {
        return [&]<int... K>(std::integer_sequence<int, K...>) MORAINE_INLINE {
            return Lanes(Register{value(K)...});
        }
        (std::make_integer_sequence<int, count>{});
    }
    MORAINE_HD Real operator[](int i) const { return v[i]; }
    MORAINE_HD Real& operator[](int i) { return reinterpret_cast<Real*>(&v)[i]; }
    MORAINE_HD Lanes& operator+=(Lanes b) { return v += b.v, *this; }

    friend MORAINE_HD Lanes operator+(Lanes a, Lanes b) { return Lanes(a.v + b.v); }
    friend MORAINE_HD Lanes operator-(Lanes a, Lanes b) { return Lanes(a.v - b.v); }
    friend MORAINE_HD Lanes operator-(Lanes a) { return Lanes(-a.v); }
    friend MORAINE_HD Lanes operator*(Lanes a, Lanes b) { return Lanes(a.v * b.v); }
    friend MORAINE_HD Lanes operator/(Lanes a, Lanes b) { return Lanes(a.v / b.v); }
};

}  // namespace moraine
