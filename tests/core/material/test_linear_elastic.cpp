#include "core/material/drive.hpp"
#include "core/material/linear_elastic.hpp"

using namespace moraine;
using namespace moraine::testing;

namespace {
constexpr double young = 1e6, poisson = 0.3;
constexpr double G = young / (2 * (1 + poisson)), K = young / (3 * (1 - 2 * poisson));
constexpr double M = K + 4 * G / 3, lambda = K - 2 * G / 3;
}  // namespace

TEST_CASE_TEMPLATE("uniaxial strain gives M e along and lambda e across", C, EVERY_CASE) {
    const auto law = make_law<LinearElastic<typename C::Real>>({{"young", young}, {"poisson", poisson}});
    auto state = virgin_state<C>();
    strain_path<C>(law, state, plane_strain<C>(-1e-4, 0, 0), 1e-3, 50);
    CHECK(double(state.stress[0]) == near(-5e-3 * M, C::tolerance));
    CHECK(double(state.stress[1]) == near(-5e-3 * lambda, C::tolerance));
    CHECK(double(state.stress[2]) == near(-5e-3 * lambda, C::tolerance));
    CHECK(double(state.stress[3]) == 0);
    CHECK(double(law.strain_energy(state)) == near(0.5 * M * 5e-3 * 5e-3, C::tolerance));
    CHECK(double(law.wave_modulus(state)) == near(M, C::tolerance));
}

TEST_CASE_TEMPLATE("simple shear gives tau = G gamma and no mean stress", C, EVERY_CASE) {
    const auto law = make_law<LinearElastic<typename C::Real>>({{"young", young}, {"poisson", poisson}});
    auto state = virgin_state<C>();
    strain_path<C>(law, state, plane_strain<C>(0, 0, 1e-4), 1e-3, 50);
    CHECK(double(state.stress[3]) == near(5e-3 * G, C::tolerance));
    CHECK(double(state.stress.trace()) == 0);
    CHECK(double(law.strain_energy(state)) == near(0.5 * G * 5e-3 * 5e-3, C::tolerance));
}
