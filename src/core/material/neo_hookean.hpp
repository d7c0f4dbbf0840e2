#pragma once
// Compressible neo-Hookean solid.
//
//   tau = mu (b - I) + lambda ln(J) I,   sigma = tau / J,   b = F Fᵀ
//   psi = mu (tr b - 3) / 2 - mu ln J + lambda (ln J)^2 / 2       per undeformed volume
//   acoustic tensor of direction n: J A(n) = (lambda + mu - lambda ln J) n nᵀ + mu (n.b n) I
//
// The wave modulus uses the current stretch (a sheared solid is several times stiffer along its
// extension), with the largest row sum of |b| as a bound on its largest eigenvalue: no eigenvalues.

#include <cmath>

#include "core/material/hypoelastic.hpp"
#include "core/material/left_stretch.hpp"

namespace moraine {

template <class Real>
struct NeoHookean {
    static constexpr const char* name = "neo-hookean";
    static constexpr int history = 0;
    static constexpr bool uses_left_stretch = true;
    static constexpr DeviceBlocks device_blocks{.affine = 4};
    static constexpr Parameter parameters[] = {young_parameter, poisson_parameter};
    static constexpr int over_depth[] = {0};
    static const char* problem(const double*) { return nullptr; }

    Real lambda;  ///< first Lamé parameter [Pa]
    Real mu;      ///< shear modulus        [Pa]

    explicit NeoHookean(const double* values) {
        const Hypoelastic<double> elastic(values[0], values[1]);
        lambda = Real(elastic.lambda);
        mu = Real(elastic.shear);
    }

    /// The same of its own moduli (over_depth.hpp).
    MORAINE_HD NeoHookean of(const OwnProperties<Real>& own) const {
        NeoHookean law = *this;
        if (own.has(0)) law.lambda *= own[0], law.mu *= own[0];
        return law;
    }

    template <int Dim>
    MORAINE_HD void update(const StrainIncrement<Real, Dim>&, PointState<Real, Dim>& state) const {
        using std::exp;
        const Real per_volume = exp(-state.ln_J);
        const Real volumetric = lambda * state.ln_J;
        for (int k = 0; k < 3; ++k) state.stress[k] = (mu * state.left_stretch[k] + volumetric) * per_volume;
        for (int k = 3; k < Sym<Real, Dim>::size; ++k) state.stress[k] = mu * state.left_stretch[k] * per_volume;
    }

    template <int Dim>
    MORAINE_HD Real wave_modulus(const PointState<Real, Dim>& state) const {
        using std::exp;
        using std::fabs;
        const Sym<Real, Dim>& b = state.left_stretch;  // less I
        Real largest = Real(1) + b[2];
        for (int i = 0; i < Dim; ++i) {
            Real row = Real(0);
            for (int j = 0; j < Dim; ++j) row += fabs(b(i, j) + Real(i == j));
            if (row > largest) largest = row;
        }
        const Real along = lambda + mu - lambda * state.ln_J;
        return ((along > Real(0) ? along : Real(0)) + mu * largest) * exp(-state.ln_J);
    }

    template <int Dim>
    MORAINE_HD Real strain_energy(const PointState<Real, Dim>& state) const {
        using std::exp;
        const Real first = state.left_stretch[0] + state.left_stretch[1] + state.left_stretch[2];
        const Real ln_J = state.ln_J;
        const Real psi = mu * (Real(0.5) * first - ln_J) + Real(0.5) * lambda * ln_J * ln_J;
        return psi * exp(-ln_J);
    }
};

}  // namespace moraine
