// Grains that fly apart and come together again, under both granular laws.
#include "core/material/drive.hpp"
#include "core/material/drucker_prager.hpp"
#include "core/material/mu_i.hpp"
#include "core/particles/stress.hpp"

using namespace moraine;
using namespace moraine::testing;

namespace {
constexpr double young = 2e6, poisson = 0.3, K = young / (3 * (1 - 2 * poisson));

template <class Real>
DruckerPrager<Real> sand(double psi, double cohesion) {
    return make_law<DruckerPrager<Real>>({{"young", young},
                                          {"poisson", poisson},
                                          {"friction_angle", 30},
                                          {"dilation_angle", psi},
                                          {"cohesion", cohesion}});
}

template <class Real>
MuI<Real> beads() {
    return make_law<MuI<Real>>({{"young", young},
                                {"poisson", poisson},
                                {"static_friction", 0.38},
                                {"limit_friction", 0.64},
                                {"grain_diameter", 1e-3},
                                {"grain_density", 2500}});
}

template <class State>
double largest_stress(const State& state) {
    double largest = 0;
    for (int k = 0; k < std::decay_t<decltype(state.stress)>::size; ++k)
        largest = std::max(largest, std::fabs(double(state.stress[k])));
    return largest;
}

template <class C, class Law>
void opens_and_closes(const Law& law, bool dilates) {
    auto state = virgin_state<C>();
    // 50 steps apart by 0.015 each and sheared, 49 back: no stress at any time, and ln J of the grains stays.
    for (int n = 0; n < 99; ++n) {
        const double sign = n < 50 ? 1 : -1;
        strain_path<C>(law, state, plane_strain<C>(0.01 * sign, 0.005 * sign, 0.003), 1e-3, 1);
        CHECK(largest_stress(state) == 0);
        CHECK(std::fabs(double(state.ln_J)) <= 75 * C::tolerance);
    }
    CHECK(double(state.history[1]) == near(0.015, 75 * C::tolerance));
    // What is left of the gap closes, and only what comes after that bears stress.
    strain_path<C>(law, state, plane_strain<C>(-0.0101, -0.0051, 0), 1e-3, 1);
    CHECK(double(state.history[1]) == 0);
    const double pressure = -double(invariants(state.stress).mean);
    if (dilates)
        CHECK(pressure > 2e-4 * K);
    else
        CHECK(pressure == near(2e-4 * K, 10 * C::tolerance, K));
    CHECK(double(state.ln_J) == near(-2e-4, 75 * C::tolerance));
}
}  // namespace

TEST_CASE_TEMPLATE("grains that flew apart bear nothing until the gap has closed", C, EVERY_CASE) {
    using Real = typename C::Real;
    opens_and_closes<C>(sand<Real>(0, 0), false);
    opens_and_closes<C>(sand<Real>(20, 0), true);
    opens_and_closes<C>(beads<Real>(), false);
}

TEST_CASE_TEMPLATE("compressed, pulled apart and back, the stress is that of the start", C, EVERY_CASE) {
    using Real = typename C::Real;
    const auto cycle = [](const auto& law) {
        auto state = virgin_state<C>();
        for (int k = 0; k < 3; ++k) state.stress[k] = Real(-1000);
        const auto apart = plane_strain<C>(4e-3, 4e-3, 0);
        const auto back = plane_strain<C>(-4e-3, -4e-3, 0);
        strain_path<C>(law, state, apart, 1e-3, 100);
        CHECK(double(state.history[1]) == near(0.8 - 1000 / K, 100 * C::tolerance));
        CHECK(double(state.ln_J) == near(1000 / K, 100 * C::tolerance));
        strain_path<C>(law, state, back, 1e-3, 100);
        CHECK(double(invariants(state.stress).mean) == near(-1000, 100 * C::tolerance, K));
        CHECK(double(state.ln_J) == near(0, 100 * C::tolerance));
        CHECK(double(state.history[1]) == 0);
    };
    cycle(sand<Real>(0, 0));
    cycle(beads<Real>());
}

TEST_CASE("the volume and the wave speed of grains that fly apart are those of the grains") {
    using C = Case<double, 3>;
    const auto law = beads<double>();
    auto state = virgin_state<C>();
    Mat<double, 3> apart = zero_mat<double, 3>();
    for (int a = 0; a < 3; ++a) apart(a, a) = 0.05;
    const StrainIncrement<double, 3> step = strain_increment(apart, 1e-3);
    const Vec<double, 3> rest{};
    for (int n = 0; n < 40; ++n) {
        const PointStep<double> told = advance_point(law, step, state, 3.0, rest, 1.0 / 1500);
        CHECK(told.volume == near(3.0 / 1500, 1e-3));
        CHECK(told.signal == near(std::sqrt(law.wave_modulus(state) / 1500), 1e-3));
        CHECK(told.work == 0);
    }
    CHECK(state.history[1] == near(120 * std::log(1.05), 1e-3));
}

TEST_CASE("cohesive soil that has torn gives its tension back before the gap closes, and then bears pressure") {
    using C = Case<double, 3>;
    const double cohesion = 500, apex = cohesion / std::tan(std::acos(-1.0) / 6);
    const auto law = sand<double>(0, cohesion);
    auto state = virgin_state<C>();
    strain_path<C>(law, state, plane_strain<C>(0.01, 0.01, 0), 1e-3, 5);
    const double gap = 0.1 - apex / K;
    CHECK(state.history[1] == near(gap, 1e-10));
    CHECK(state.ln_J == near(apex / K, 1e-10));
    strain_path<C>(law, state, plane_strain<C>(-apex / K / 4, -apex / K / 4, 0), 1e-3, 1);
    CHECK(invariants(state.stress).mean == near(apex / 2, 1e-8));
    CHECK(state.history[1] == near(gap, 1e-10));
    strain_path<C>(law, state, plane_strain<C>(-0.02, -0.02, 0), 1e-3, 1);
    CHECK(invariants(state.stress).mean == near(0, 1e-8));
    CHECK(state.history[1] == near(gap - 0.04 + apex / 2 / K, 1e-10));
    strain_path<C>(law, state, plane_strain<C>(-0.04, -0.04, 0), 1e-3, 1);
    CHECK(state.history[1] == 0);
    CHECK(invariants(state.stress).mean == near(-K * 0.02 - apex / 2, 1e-8));
}

TEST_CASE("grains that are apart do not dilate: sheared in their gap they build up no pressure") {
    using C = Case<double, 2>;
    const auto law = sand<double>(25, 0);
    auto state = virgin_state<C>();
    strain_path<C>(law, state, plane_strain<C>(0.01, 0, 0), 1e-3, 1);
    strain_path<C>(law, state, plane_strain<C>(0, 0, 0.05), 1e-3, 20);
    CHECK(largest_stress(state) == 0);
    CHECK(state.history[1] == near(0.01, 1e-12));
    strain_path<C>(law, state, plane_strain<C>(-0.01, 0, 0), 1e-3, 1);
    strain_path<C>(law, state, plane_strain<C>(0, 0, 0.05), 1e-3, 1);
    CHECK(invariants(state.stress).mean < 0);
}
