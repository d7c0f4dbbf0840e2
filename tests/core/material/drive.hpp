#pragma once
// Drives one material point through a strain path, as a time step does.
//
// Cases name precision and dimension: TEST_CASE_TEMPLATE("...", C, EVERY_CASE) with C::Real, C::dim and
// C::tolerance, relative. Parameters are given by key, so that a table in another order than the
// constructor shows.

#include <doctest/doctest.h>

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "core/material/laws.hpp"

namespace moraine::testing {

template <class R, int D>
struct Case {
    using Real = R;
    static constexpr int dim = D;
    static constexpr double tolerance = sizeof(R) == 8 ? 1e-8 : 2e-5;
    using State = PointState<R, D>;
    using Strain = Sym<R, D>;
};

#define EVERY_CASE testing::Case<double, 2>, testing::Case<double, 3>, testing::Case<float, 2>, testing::Case<float, 3>

inline std::vector<double> values_of(const std::string& law,
                                     std::initializer_list<std::pair<const char*, double>> given) {
    const LawInfo* info = find_law(law);
    REQUIRE(info != nullptr);
    std::vector<double> values;
    for (const Parameter& p : info->parameters) values.push_back(p.standard);
    for (const auto& [key, value] : given) {
        std::size_t i = 0;
        while (i < values.size() && std::string(info->parameters[i].key) != key) ++i;
        REQUIRE(i < values.size());
        values[i] = value;
    }
    return values;
}

/// Law<Real> from values given by key.
template <class Law>
Law make_law(std::initializer_list<std::pair<const char*, double>> given) {
    return Law(values_of(Law::name, given).data());
}

template <class C>
typename C::State virgin_state() {
    typename C::State state{};
    state.left_stretch = undeformed_stretch<typename C::Real, C::dim>();
    return state;
}

/// Normal strains in x, y and engineering shear xy; in both dimensions de_zz = 0.
template <class C>
typename C::Strain plane_strain(double xx, double yy, double shear) {
    using Real = typename C::Real;
    typename C::Strain e = zero_sym<Real, C::dim>();
    e[0] = Real(xx), e[1] = Real(yy), e[3] = Real(shear / 2);
    return e;
}

/// `steps` equal steps of prescribed strain without spin, dt each.
template <class C, class Law>
void strain_path(const Law& law, typename C::State& state, const typename C::Strain& increment, double dt, int steps) {
    using Real = typename C::Real;
    StrainIncrement<Real, C::dim> step{};
    step.strain = increment;
    step.rotation = identity<Real, C::dim>();
    step.volumetric = increment.trace();
    step.stretch = Real(1) + increment.trace();
    step.dt = Real(dt);
    for (int i = 0; i < steps; ++i) {
        state.ln_J += step.volumetric;
        law.update(step, state);
    }
}

/// `steps` steps of the same displacement gradient with respect to the body at rest: F = I + k grad.
template <class C, class Law>
void gradient_path(const Law& law, typename C::State& state, const Mat<typename C::Real, C::dim>& grad, double dt,
                   int steps) {
    using Real = typename C::Real;
    Mat<Real, C::dim> f = identity<Real, C::dim>();
    for (int n = 0; n < steps; ++n) {
        const Mat<Real, C::dim> dL = grad * inverse(f);
        const StrainIncrement<Real, C::dim> step = strain_increment(dL, Real(dt));
        state.ln_J += step.volumetric;
        state.left_stretch = advanced(state.left_stretch, dL);
        law.update(step, state);
        for (int i = 0; i < C::dim; ++i)
            for (int j = 0; j < C::dim; ++j) f(i, j) += grad(i, j);
    }
}

template <class State>
double shear_stress_measure(const State& state) {
    return std::sqrt(double(invariants(state.stress).j2));
}

/// Approximate, relative to `scale` or the value when that is larger.
inline doctest::Approx near(double value, double tolerance, double scale = 1) {
    return doctest::Approx(value).epsilon(tolerance).scale(scale);
}

}  // namespace moraine::testing
