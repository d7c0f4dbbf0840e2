#pragma once
// Linear elasticity in rate form: a Hooke's law between the Jaumann rate of Cauchy stress and the rate
// of deformation (hypoelastic.hpp). Exact in simple shear: tau = G sin(gamma), an oscillation that
// belongs to the rate and not to the integration; for large elastic strain take neo-hookean.

#include "core/material/hypoelastic.hpp"

namespace moraine {

template <class Real>
struct LinearElastic {
    static constexpr const char* name = "linear-elastic";
    static constexpr int history = 0;
    static constexpr bool uses_left_stretch = false;
    static constexpr DeviceBlocks device_blocks{.affine = 4};
    static constexpr Parameter parameters[] = {young_parameter, poisson_parameter};
    static constexpr int over_depth[] = {0};
    static const char* problem(const double*) { return nullptr; }

    Hypoelastic<Real> elastic;

    explicit LinearElastic(const double* values) : elastic(values[0], values[1]) {}

    /// The same of its own moduli (over_depth.hpp).
    MORAINE_HD LinearElastic of(const OwnProperties<Real>& own) const {
        LinearElastic law = *this;
        if (own.has(0)) law.elastic = elastic.times(own[0]);
        return law;
    }

    template <int Dim>
    MORAINE_HD void update(const StrainIncrement<Real, Dim>& step, PointState<Real, Dim>& state) const {
        state.stress = elastic.trial(step, state.stress);
    }

    template <int Dim>
    MORAINE_HD void after_trial(const StrainIncrement<Real, Dim>&, PointState<Real, Dim>&) const {}

    template <int Dim>
    MORAINE_HD Real wave_modulus(const PointState<Real, Dim>&) const {
        return elastic.wave_modulus();
    }

    template <int Dim>
    MORAINE_HD Real strain_energy(const PointState<Real, Dim>& state) const {
        return elastic.energy(state.stress);
    }
};

}  // namespace moraine
