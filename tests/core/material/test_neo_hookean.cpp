#include <numbers>

#include "core/material/drive.hpp"
#include "core/material/neo_hookean.hpp"

using namespace moraine;
using namespace moraine::testing;

namespace {
constexpr double young = 1e6, poisson = 0.3;
constexpr double mu = young / (2 * (1 + poisson)), lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));

template <class C>
typename C::State stretched(double stretch) {
    const auto law = make_law<NeoHookean<typename C::Real>>({{"young", young}, {"poisson", poisson}});
    auto state = virgin_state<C>();
    Mat<typename C::Real, C::dim> grad = zero_mat<typename C::Real, C::dim>();
    constexpr int steps = 400;
    grad(0, 0) = typename C::Real((stretch - 1) / steps);
    gradient_path<C>(law, state, grad, 1e-3, steps);
    return state;
}
}  // namespace

TEST_CASE_TEMPLATE("uniaxial stretch follows sigma = (mu (b - 1) + lambda ln J) / J", C, EVERY_CASE) {
    for (double stretch : {0.6, 1.5}) {
        CAPTURE(stretch);
        const auto state = stretched<C>(stretch);
        CHECK(double(state.left_stretch[0]) == near(stretch * stretch - 1, C::tolerance));
        CHECK(double(state.left_stretch[2]) == 0);
        const double volumetric = lambda * std::log(stretch);
        CHECK(double(state.stress[0]) ==
              near((mu * (stretch * stretch - 1) + volumetric) / stretch, 10 * C::tolerance));
        CHECK(double(state.stress[1]) == near(volumetric / stretch, 10 * C::tolerance));
        CHECK(double(state.stress[2]) == near(volumetric / stretch, 10 * C::tolerance));
    }
}

TEST_CASE_TEMPLATE("simple shear by 2 gives tau = mu gamma and sigma_xx = mu gamma^2", C, EVERY_CASE) {
    using Real = typename C::Real;
    const auto law = make_law<NeoHookean<Real>>({{"young", young}, {"poisson", poisson}});
    auto state = virgin_state<C>();
    Mat<Real, C::dim> grad = zero_mat<Real, C::dim>();
    grad(0, 1) = Real(2.0 / 64);
    gradient_path<C>(law, state, grad, 1e-3, 64);
    CHECK(double(state.stress[3]) == near(2 * mu, C::tolerance));
    CHECK(double(state.stress[0]) == near(4 * mu, C::tolerance));
    CHECK(std::fabs(double(state.stress[1])) <= C::tolerance * mu);

    const double largest = 3 + 2 * std::sqrt(2.0);  // eigenvalue of b
    const double exact = lambda + mu + mu * largest;
    CHECK(double(law.wave_modulus(state)) >= exact);
    CHECK(double(law.wave_modulus(state)) <= 1.25 * exact);
}

TEST_CASE("the stress is the slope of the stored energy") {
    using C = Case<double, 3>;
    const auto law = make_law<NeoHookean<double>>({{"young", young}, {"poisson", poisson}});
    const auto energy = [&](double stretch) { return law.strain_energy(stretched<C>(stretch)) * stretch; };
    const double d = 1e-4;
    CHECK((energy(1.3 + d) - energy(1.3 - d)) / (2 * d) == near(stretched<C>(1.3).stress[0], 1e-6));
    CHECK(law.strain_energy(virgin_state<C>()) == 0);
    CHECK(law.wave_modulus(virgin_state<C>()) == near(lambda + 2 * mu, 1e-14));
}

TEST_CASE("b returns to I after a turn and a closed stretch") {
    Sym<double, 3> b = undeformed_stretch<double, 3>();
    Mat<double, 3> there = {{{0.1, 0.2, 0}, {-0.3, 0.05, 0.1}, {0, 0.4, -0.2}}};
    Mat<double, 3> whole = identity<double, 3>();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) whole(i, j) += there(i, j);
    Mat<double, 3> back = inverse(whole);
    for (int i = 0; i < 3; ++i) back(i, i) -= 1;
    b = advanced(advanced(b, there), back);
    for (int k = 0; k < 6; ++k) CHECK(std::fabs(b[k]) <= 1e-14);
}

TEST_CASE_TEMPLATE("small strains keep their digits over many steps", C, EVERY_CASE) {
    using Real = typename C::Real;
    const auto law = make_law<NeoHookean<Real>>({{"young", young}, {"poisson", 0.0}});
    auto state = virgin_state<C>();
    const double most = 3e-4;
    double stretch = 1, worst = 0;
    for (int n = 1; n <= 800; ++n) {
        const double next = 1 + most * std::sin(2 * std::numbers::pi * n / 800);
        Mat<Real, C::dim> dL = zero_mat<Real, C::dim>();
        dL(0, 0) = Real(next / stretch - 1);
        stretch = next;
        const StrainIncrement<Real, C::dim> step = strain_increment(dL, Real(1e-3));
        state.ln_J += step.volumetric;
        state.left_stretch = advanced(state.left_stretch, dL);
        law.update(step, state);
        const double exact = 0.5 * young * (stretch * stretch - 1) / stretch;
        worst = std::max(worst, std::fabs(double(state.stress[0]) - exact));
    }
    CHECK(worst <= 1e-5 * young * most);  // of b kept as it is single would leave 3 %
}
