#include "core/material/drive.hpp"
#include "core/material/drucker_prager.hpp"

using namespace moraine;
using namespace moraine::testing;

namespace {
constexpr double young = 2e6, poisson = 0.3, G = young / (2 * (1 + poisson)), K = young / (3 * (1 - 2 * poisson));
const double degree = std::acos(-1.0) / 180;

template <class Real>
DruckerPrager<Real> sand(double phi, double psi, double cohesion, double matching) {
    return make_law<DruckerPrager<Real>>({{"young", young},
                                          {"poisson", poisson},
                                          {"friction_angle", phi},
                                          {"dilation_angle", psi},
                                          {"cohesion", cohesion},
                                          {"matching", matching}});
}

template <class C>
typename C::State confined(double pressure) {
    auto state = virgin_state<C>();
    for (int k = 0; k < 3; ++k) state.stress[k] = typename C::Real(-pressure);
    return state;
}
}  // namespace

TEST_CASE_TEMPLATE("triaxial compression fails at Mohr-Coulomb's axial stress with matching 1", C,
                   testing::Case<double, 3>, testing::Case<float, 3>) {
    using Real = typename C::Real;
    const double p0 = 1e4, c = 300, phi = 30 * degree;
    const auto law = sand<Real>(30, 0, c, 1);
    auto state = confined<C>(p0);
    // Drained: elastic at constant cell pressure (lateral strain -nu), then isochoric flow at constant stress.
    const double q = (2 * p0 * std::sin(phi) + 2 * c * std::cos(phi)) / (1 - std::sin(phi));
    Sym<Real, 3> e = zero_sym<Real, 3>();
    e[0] = Real(-q / young / 100), e[1] = e[2] = Real(poisson * q / young / 100);
    strain_path<C>(law, state, e, 1, 99);
    CHECK(double(state.history[0]) == 0);
    CHECK(double(state.stress[1] - state.stress[0]) == near(0.99 * q, C::tolerance));
    strain_path<C>(law, state, e, 1, 1);
    e[0] = Real(-1e-3), e[1] = e[2] = Real(5e-4);
    strain_path<C>(law, state, e, 1, 100);
    CHECK(double(state.stress[1] - state.stress[0]) == near(q, 10 * C::tolerance));
    CHECK(double(state.stress[1]) == near(-p0, 10 * C::tolerance));
    CHECK(double(state.history[0]) == near(0.1 * std::sqrt(3.0), C::tolerance));  // 2 sqrt(J2(e))
}

TEST_CASE_TEMPLATE("plane strain fails where Mohr-Coulomb does, for any dilation angle, with matching 0", C,
                   EVERY_CASE) {
    using Real = typename C::Real;
    for (double psi : {0.0, 15.0, 35.0}) {
        CAPTURE(psi);
        const double c = 700, phi = 35 * degree, gamma = 2e-4, swell = gamma * std::sin(psi * degree);
        const auto law = sand<Real>(35, psi, c, 0);
        auto state = confined<C>(1e4);
        // Flow at the dilation angle: the pressure settles, and with it the stress.
        strain_path<C>(law, state, plane_strain<C>((swell + gamma) / 2, (swell - gamma) / 2, 0), 1, 2000);
        const double radius = double(state.stress[0] - state.stress[1]) / 2;
        const double centre = double(state.stress[0] + state.stress[1]) / 2;
        CHECK(radius == near(-centre * std::sin(phi) + c * std::cos(phi), 10 * C::tolerance));
        if (psi == 0) CHECK(centre == near(-1e4, 10 * C::tolerance));
        CHECK(double(state.history[0]) > 0.3);
    }
}

TEST_CASE_TEMPLATE("a state in the cone is elastic", C, EVERY_CASE) {
    const auto law = sand<typename C::Real>(30, 10, 0, 0);
    auto state = confined<C>(1e4);
    const double gamma = 0.99 * 1e4 * 0.5 / G;
    strain_path<C>(law, state, plane_strain<C>(0, 0, 0.9 * gamma), 1, 1);
    CHECK(double(state.stress[3]) == near(0.9 * G * gamma, C::tolerance));
    CHECK(double(state.history[0]) == 0);
}

TEST_CASE_TEMPLATE("pulled apart it goes to the apex, and carries nothing there without cohesion", C, EVERY_CASE) {
    using Real = typename C::Real;
    for (double psi : {0.0, 20.0})
        for (double c : {0.0, 400.0}) {
            CAPTURE(psi);
            CAPTURE(c);
            const double apex = c / std::tan(30 * degree);
            const auto law = sand<Real>(30, psi, c, 0);
            auto state = confined<C>(100);
            strain_path<C>(law, state, plane_strain<C>(3e-3, 2.5e-3, 1e-4), 1, 5);
            for (int k = 0; k < 3; ++k) CHECK(double(state.stress[k]) == near(apex, C::tolerance));
            CHECK(double(state.stress[3]) == 0);
            CHECK(double(law.strain_energy(state)) == near(apex * apex / (2 * K), 10 * C::tolerance));
        }
}

TEST_CASE_TEMPLATE("the associated return is closest in energy, dg = f / (G + K eta^2)", C, EVERY_CASE) {
    using Real = typename C::Real;
    const double phi = 30 * degree, eta = 3 * std::tan(phi) / std::sqrt(9 + 12 * std::tan(phi) * std::tan(phi));
    const auto law = sand<Real>(30, 30, 0, 0);
    CHECK(double(law.friction) == near(eta, C::tolerance));
    CHECK(double(law.dilation) == near(eta, C::tolerance));
    auto state = confined<C>(1e4);
    const double gamma = 0.02;
    strain_path<C>(law, state, plane_strain<C>(0, 0, gamma), 1, 1);
    const double dg = (G * gamma - eta * 1e4) / (G + K * eta * eta);
    CHECK(double(state.history[0]) == near(dg, C::tolerance, 0));
    CHECK(double(state.stress[3]) == near(G * (gamma - dg), C::tolerance));
    CHECK(double(state.stress[2]) == near(-1e4 - K * eta * dg, C::tolerance));
}

TEST_CASE("impossible pairs of parameters are refused") {
    const auto problem = [](std::initializer_list<std::pair<const char*, double>> given) {
        return find_law("drucker-prager")->problem(values_of("drucker-prager", given).data());
    };
    CHECK(problem({{"friction_angle", 30}, {"dilation_angle", 5}}) == nullptr);
    CHECK(problem({{"friction_angle", 30}, {"dilation_angle", 31}}) != nullptr);
    CHECK(problem({{"friction_angle", 0}}) != nullptr);
    CHECK(problem({{"friction_angle", 0}, {"cohesion", 10}}) == nullptr);
    CHECK(problem({{"friction_angle", 30}, {"matching", 0.5}}) != nullptr);
}
