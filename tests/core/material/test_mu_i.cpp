#include "core/material/drive.hpp"
#include "core/material/drucker_prager.hpp"
#include "core/material/mu_i.hpp"

using namespace moraine;
using namespace moraine::testing;

namespace {
constexpr double young = 2e6, poisson = 0.3, G = young / (2 * (1 + poisson)), K = young / (3 * (1 - 2 * poisson));
constexpr double mu_s = 0.38, mu_2 = 0.64, I0 = 0.279, grain = 2500;

template <class Real>
MuI<Real> beads(double diameter) {
    return make_law<MuI<Real>>({{"young", young},
                                {"poisson", poisson},
                                {"static_friction", mu_s},
                                {"limit_friction", mu_2},
                                {"inertial_number", I0},
                                {"grain_diameter", diameter},
                                {"grain_density", grain}});
}

template <class C>
typename C::State confined(double pressure) {
    auto state = virgin_state<C>();
    for (int k = 0; k < 3; ++k) state.stress[k] = typename C::Real(-pressure);
    return state;
}

double friction_at(double rate, double diameter, double pressure) {
    const double I = rate * diameter * std::sqrt(grain / pressure);
    return mu_s + (mu_2 - mu_s) * I / (I0 + I);
}
}  // namespace

TEST_CASE_TEMPLATE("steady simple shear bears mu(I) times the pressure, at any rate", C, EVERY_CASE) {
    using Real = typename C::Real;
    for (double diameter : {0.0, 1e-3, 0.02})
        for (double rate : {1e-3, 1.0, 30.0, 3000.0})
            for (double dt : {1e-6, 1e-4}) {
                CAPTURE(diameter);
                CAPTURE(rate);
                CAPTURE(dt);
                const double p = 4000;
                const auto law = beads<Real>(diameter);
                auto state = confined<C>(p);
                // To the yield stress in one step, then at the rate: the elastic lag decays in mu' p / (G rate).
                strain_path<C>(law, state, plane_strain<C>(0, 0, mu_s * p / G), dt, 1);
                const int steps = int(std::min(4e5, 2e3 + 0.5 / (rate * dt)));
                strain_path<C>(law, state, plane_strain<C>(0, 0, rate * dt), dt, steps);
                const double mu = friction_at(rate, diameter, p);
                CHECK(shear_stress_measure(state) == near(mu * p, 10 * C::tolerance));
                CHECK(double(state.stress[2]) == near(-p, 10 * C::tolerance));
            }
}

TEST_CASE_TEMPLATE("a step solves its own equation, for any rate, pressure and step", C, EVERY_CASE) {
    using Real = typename C::Real;
    for (double diameter : {0.0, 1e-5, 1e-3, 0.1})
        for (double p : {1e-12, 1e-3, 10.0, 1e5})
            for (double over : {1e-6, 1.0, 1e3, 1e7})
                for (double dt : {1e-8, 1e-5, 1e-2}) {
                    CAPTURE(diameter);
                    CAPTURE(p);
                    CAPTURE(over);
                    CAPTURE(dt);
                    const auto law = beads<Real>(diameter);
                    const double tau = mu_s * p * (1 + over);
                    const double found = double(law.shear_stress(Real(tau), Real(p), Real(dt)));
                    CHECK(found >= mu_s * p * (1 - C::tolerance));
                    CHECK(found <= mu_2 * p * (1 + C::tolerance));
                    // tau = mu(I) p with the plastic rate (trial - tau) / (G dt)
                    const double mu = friction_at(std::max(0.0, tau - found) / (G * dt), diameter, p);
                    CHECK(found == near(mu * p, 10 * C::tolerance, 0));
                }
}

TEST_CASE_TEMPLATE("below mu_s p it is elastic, and nothing creeps, to the bit", C, EVERY_CASE) {
    const auto law = beads<typename C::Real>(1e-3);
    auto state = confined<C>(1e4);
    strain_path<C>(law, state, plane_strain<C>(0, 0, 0.99 * mu_s * 1e4 / G), 1e-4, 1);
    const auto held = state.stress;
    CHECK(double(held[3]) == near(0.99 * mu_s * 1e4, C::tolerance));
    strain_path<C>(law, state, plane_strain<C>(0, 0, 0), 1, 1000);
    for (int k = 0; k < 4; ++k) CHECK(state.stress[k] == held[k]);
    CHECK(double(state.history[0]) == 0);
}

TEST_CASE("stress above yield relaxes to mu_s p and never passes it") {
    using C = Case<double, 2>;
    const auto law = beads<double>(1e-3);
    auto state = confined<C>(2000);
    strain_path<C>(law, state, plane_strain<C>(0, 0, 5000 / G), 1e-6, 1);
    double before = state.stress[3];
    CHECK(before > 1.2 * mu_s * 2000);
    for (int n = 0; n < 200; ++n) {
        strain_path<C>(law, state, plane_strain<C>(0, 0, 0), 1e-4, 1);
        CHECK(state.stress[3] <= before);
        before = state.stress[3];
    }
    CHECK(before == near(mu_s * 2000, 1e-12));
}

TEST_CASE_TEMPLATE("pulled apart it bears nothing", C, EVERY_CASE) {
    const auto law = beads<typename C::Real>(1e-3);
    auto state = confined<C>(100);
    strain_path<C>(law, state, plane_strain<C>(3e-3, 2.5e-3, 1e-4), 1e-4, 5);
    for (int k = 0; k < 4; ++k) CHECK(double(state.stress[k]) == 0);
    CHECK(double(law.strain_energy(state)) == 0);
    CHECK(double(state.history[1]) == near(5 * 5.5e-3 - 100 / K, C::tolerance));
}

TEST_CASE("without rate effect it is Drucker-Prager's, with the sine of the friction angle") {
    using C = Case<double, 3>;
    const auto law = beads<double>(0);
    const auto other = make_law<DruckerPrager<double>>(
        {{"young", young}, {"poisson", poisson}, {"friction_angle", std::asin(mu_s) * 180 / std::acos(-1.0)}});
    auto state = confined<C>(500), same = state;
    for (int n = 0; n < 400; ++n) {  // in and out of compression, with shear that turns
        const double e = 4e-4 * std::sin(0.05 * n), g = 1e-3 * std::cos(0.031 * n);
        strain_path<C>(law, state, plane_strain<C>(-e, -0.5 * e, g), 1e-4, 1);
        strain_path<C>(other, same, plane_strain<C>(-e, -0.5 * e, g), 1e-4, 1);
        for (int k = 0; k < 6; ++k) CHECK(state.stress[k] == near(same.stress[k], 1e-10, 500));
        for (int k = 0; k < 2; ++k) CHECK(state.history[k] == near(same.history[k], 1e-10));
        CHECK(state.ln_J == near(same.ln_J, 1e-12));
    }
    CHECK(state.history[0] > 0.1);
}

TEST_CASE("friction that falls with the rate is refused") {
    const auto problem = [](double slow, double fast) {
        return find_law("mu-i")->problem(
            values_of("mu-i", {{"static_friction", slow}, {"limit_friction", fast}}).data());
    };
    CHECK(problem(0.38, 0.64) == nullptr);
    CHECK(problem(0.38, 0.38) == nullptr);
    CHECK(problem(0.64, 0.38) != nullptr);
}
