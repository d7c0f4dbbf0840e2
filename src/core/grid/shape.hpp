#pragma once
// Shape functions of one axis, as tensor products, in units of the cell.
//
// f in [0, 1) is the particle's place in its binning cell; node i of the stencil lies at distance
// d_i = f + reach - i. Each shape gives the weights w_i and slopes dw_i = d w_i / d(x/h).
//
//   Linear      hat functions                                             Sulsky et al. 1994
//   Gimp        hat averaged over a box of half-size l <= 1/2             Bardenhagen and Kober 2004, eq. 30
//   Quadratic   B-spline of order 2                                       Steffen et al. 2008
//   Cubic       B-spline of order 3
//
// Gimp covers `gimp` (l fixed: the method paper's) and `gimp-contiguous` (l follows the stretch).

#include "core/data/scene_choices.hpp"
#include "core/data/vec.hpp"

namespace moraine {

struct Linear {
    static constexpr int width = 2;
    static constexpr int origin = 0;  ///< block 0 starts at node -origin
    static constexpr bool sized = false;
    template <class Real>
    static constexpr Real reach = Real(0);

    template <class Real>
    static MORAINE_HD void weights(Real f, Real /*half*/, Real* w, Real* dw) {
        w[0] = Real(1) - f;
        w[1] = f;
        dw[0] = Real(-1);
        dw[1] = Real(1);
    }
};

struct Quadratic {
    static constexpr int width = 3;
    static constexpr int origin = 1;
    static constexpr bool sized = false;
    template <class Real>
    static constexpr Real reach = Real(0.5);

    template <class Real>
    static MORAINE_HD void weights(Real f, Real /*half*/, Real* w, Real* dw) {
        const Real g = Real(1) - f;
        const Real c = f - Real(0.5);
        w[0] = Real(0.5) * g * g;
        w[1] = Real(0.75) - c * c;
        w[2] = Real(0.5) * f * f;
        dw[0] = -g;
        dw[1] = Real(-2) * c;
        dw[2] = f;
    }
};

struct Cubic {
    static constexpr int width = 4;
    static constexpr int origin = 1;
    static constexpr bool sized = false;
    template <class Real>
    static constexpr Real reach = Real(1);

    template <class Real>
    static MORAINE_HD void weights(Real f, Real /*half*/, Real* w, Real* dw) {
        const Real g = Real(1) - f;
        const Real sixth = Real(1) / Real(6);
        // Written as differences of the outer two, so that their sum and first moment are exact: a bias in
        // the last bit would drift the same way at every step.
        w[0] = sixth * g * g * g;
        w[3] = sixth * f * f * f;
        w[1] = (g - w[0]) + (w[3] - w[0]);
        w[2] = (f - w[3]) + (w[0] - w[3]);
        dw[0] = Real(-0.5) * g * g;
        dw[1] = f * (Real(1.5) * f - Real(2));
        dw[2] = g * (Real(2) - Real(1.5) * g);
        dw[3] = Real(0.5) * f * f;
    }
};

struct Gimp {
    static constexpr int width = 3;
    static constexpr int origin = 1;
    static constexpr bool sized = true;
    template <class Real>
    static constexpr Real reach = Real(0.5);

    /// half: of the particle's box, 0 < half <= 1/2 [cells].
    template <class Real>
    static MORAINE_HD void weights(Real f, Real half, Real* w, Real* dw) {
        for (int i = 0; i < width; ++i) {
            const Real d = f + Real(0.5) - Real(i);
            const Real r = d < Real(0) ? -d : d;
            const Real sign = d < Real(0) ? Real(-1) : Real(1);
            if (r < half) {
                w[i] = Real(1) - (d * d + half * half) / (Real(2) * half);
                dw[i] = -d / half;
            } else if (r < Real(1) - half) {
                w[i] = Real(1) - r;
                dw[i] = -sign;
            } else if (r < Real(1) + half) {
                const Real e = Real(1) + half - r;
                w[i] = e * e / (Real(4) * half);
                dw[i] = -sign * e / (Real(2) * half);
            } else {
                w[i] = Real(0);
                dw[i] = Real(0);
            }
        }
    }
};

/// What the tables of blocks need to know of a shape.
struct Stencil {
    int width;
    int origin;
    double reach;
    /// Binning coordinate of the domain's lower corner: x/h + offset() counts cells from block 0.
    double offset() const { return origin - reach; }
};

inline Stencil stencil_of(Shape shape) {
    switch (shape) {
        case Shape::linear:
            return {Linear::width, Linear::origin, 0};
        case Shape::cubic:
            return {Cubic::width, Cubic::origin, 1};
        default:
            return {Quadratic::width, Quadratic::origin, 0.5};
    }
}

}  // namespace moraine
