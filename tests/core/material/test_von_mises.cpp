#include "core/material/drive.hpp"
#include "core/material/von_mises.hpp"

using namespace moraine;
using namespace moraine::testing;

namespace {
constexpr double su = 500, young = 500 * su, poisson = 0.49;
constexpr double G = young / (2 * (1 + poisson)), K = young / (3 * (1 - 2 * poisson));

template <class C>
VonMises<typename C::Real> clay() {
    return make_law<VonMises<typename C::Real>>({{"young", young}, {"poisson", poisson}, {"su", su}});
}
}  // namespace

TEST_CASE_TEMPLATE("simple shear is elastic to tau = su and stays there", C, EVERY_CASE) {
    const auto law = clay<C>();
    auto state = virgin_state<C>();
    const double yield = su / G;
    strain_path<C>(law, state, plane_strain<C>(0, 0, yield / 100), 1, 99);
    CHECK(double(state.stress[3]) == near(0.99 * su, C::tolerance));
    CHECK(double(state.history[0]) == 0);
    strain_path<C>(law, state, plane_strain<C>(0, 0, yield / 100), 1, 401);
    CHECK(double(state.stress[3]) == near(su, C::tolerance));
    CHECK(double(state.history[0]) == near(4 * yield, C::tolerance, 0));
    CHECK(double(law.strain_energy(state)) == near(su * su / (2 * G), C::tolerance, 0));
    strain_path<C>(law, state, plane_strain<C>(0, 0, -yield / 100), 1, 50);
    CHECK(double(state.stress[3]) == near(0.5 * su, C::tolerance));
    CHECK(double(state.history[0]) == near(4 * yield, C::tolerance, 0));
}

TEST_CASE_TEMPLATE("uniaxial strain yields at a stress difference of sqrt(3) su, the mean stays elastic", C,
                   EVERY_CASE) {
    const auto law = clay<C>();
    auto state = virgin_state<C>();
    strain_path<C>(law, state, plane_strain<C>(-1e-4, 0, 0), 1, 300);
    CHECK(double(state.stress[1] - state.stress[0]) == near(std::sqrt(3.0) * su, 20 * C::tolerance));
    CHECK(double(state.stress[2]) == near(double(state.stress[1]), C::tolerance));
    CHECK(double(state.stress.trace()) / 3 == near(-0.03 * K, C::tolerance));
}

TEST_CASE_TEMPLATE("shear flow with spin stays on the surface at tau = su to second order in su / G", C, EVERY_CASE) {
    using Real = typename C::Real;
    const auto law = clay<C>();
    auto state = virgin_state<C>();
    Mat<Real, C::dim> grad = zero_mat<Real, C::dim>();
    grad(0, 1) = Real(1e-3);
    gradient_path<C>(law, state, grad, 1, 2000);
    CHECK(shear_stress_measure(state) == near(su, C::tolerance));
    CHECK(double(state.stress[3]) == near(su, su * su / (G * G)));
}
