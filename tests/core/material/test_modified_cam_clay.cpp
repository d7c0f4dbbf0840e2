#include <random>

#include "core/material/drive.hpp"
#include "core/material/modified_cam_clay.hpp"

using namespace moraine;
using namespace moraine::testing;

namespace {
constexpr double lambda = 0.2, kappa = 0.04, M = 1.05, nu = 0.25, e_1 = 2.0;

template <class Real>
ModifiedCamClay<Real> clay(double floor = 1.0) {
    return make_law<ModifiedCamClay<Real>>({{"compression_index", lambda},
                                            {"swelling_index", kappa},
                                            {"critical_state_ratio", M},
                                            {"poisson", nu},
                                            {"reference_void_ratio", e_1},
                                            {"pressure_floor", floor}});
}

template <class C>
typename C::State consolidated(const ModifiedCamClay<typename C::Real>& law, double p, double ratio = 1) {
    auto state = virgin_state<C>();
    for (int k = 0; k < 3; ++k) state.stress[k] = typename C::Real(-p);
    REQUIRE(law.begin({ratio}, state) == nullptr);
    return state;
}

template <class State>
double pressure(const State& state) {
    return -double(state.stress.trace()) / 3;
}

/// q = sigma_r - sigma_a of a triaxial test whose axis is y.
template <class State>
double deviator(const State& state) {
    return double(state.stress[0]) - double(state.stress[1]);
}

template <class State>
double yield_function(const State& state) {
    const double p = pressure(state), j2 = double(invariants(state.stress).j2), p_c = double(state.history[0]);
    return (3 * j2 / (M * M) + p * (p - p_c)) / (p_c * p_c);
}

/// Shear strain along the drained path q = 3 (p - p0) from p0 on the virgin line, elastic and plastic, by Simpson's
/// rule of the two rates: d(p_c) is exact, and so is v.
double drained_shear_strain(double p0, double p_end) {
    const double v0 = 1 + e_1 - lambda * std::log(p0 / 1000);
    const auto v_at = [&](double p, double p_c) {
        return v0 - kappa * std::log(p / p0) - (lambda - kappa) * std::log(p_c / p0);
    };
    const auto rate = [&](double p) {
        const double eta = 3 * (p - p0) / p, p_c = p * (1 + eta * eta / (M * M));
        const double deta = 3 * p0 / (p * p), dp_c = p_c / p + p * 2 * eta * deta / (M * M), v = v_at(p, p_c);
        const double G = 1.5 * (1 - 2 * nu) / (1 + nu) * v * p / kappa;
        return 3 / (3 * G) + (lambda - kappa) / v * dp_c / p_c * 2 * eta / (M * M - eta * eta);
    };
    const int n = 20000;
    double sum = rate(p0) + rate(p_end);
    for (int i = 1; i < n; ++i) sum += (i % 2 ? 4 : 2) * rate(p0 + i * (p_end - p0) / n);
    return sum * (p_end - p0) / n / 3;
}

/// An axial increment whose radial one keeps the radial stress: Newton's method with the last slope.
template <class C>
void drained_step(const ModifiedCamClay<typename C::Real>& law, typename C::State& state, double axial,
                  double& radial) {
    const double wanted = state.stress[0];
    const auto error_at = [&](double r, typename C::State& end) {
        end = state;
        typename C::Strain de = zero_sym<typename C::Real, C::dim>();
        de[0] = de[2] = r, de[1] = axial;
        strain_path<C>(law, end, de, 1e-3, 1);
        return end.stress[0] - wanted;
    };
    typename C::State end;
    for (int n = 0; n < 50; ++n) {
        const double h = 1e-7 * std::fabs(axial), error = error_at(radial, end);
        if (std::fabs(error) < 1e-13 * std::fabs(wanted)) break;
        typename C::State other;
        radial -= error * h / (error_at(radial + h, other) - error);
    }
    error_at(radial, end);
    state = end;
}
}  // namespace

TEST_CASE_TEMPLATE("isotropic compression follows lambda, unloading kappa", C, EVERY_CASE) {
    const auto law = clay<typename C::Real>();
    auto state = consolidated<C>(law, 1e5);
    const double e_0 = double(state.history[1]), tolerance = sizeof(typename C::Real) == 8 ? 1e-6 : 2e-3;
    CHECK(e_0 == near(e_1 - lambda * std::log(100.0), C::tolerance));
    const auto squeeze = [&](double volumetric) {
        typename C::Strain de = zero_sym<typename C::Real, C::dim>();
        for (int k = 0; k < 3; ++k) de[k] = typename C::Real(volumetric / 3e4);
        strain_path<C>(law, state, de, 1e-3, 10000);
    };
    squeeze(-0.1);
    const double e = (1 + e_0) * std::exp(-0.1) - 1, p = 1e5 * std::exp((e_0 - e) / lambda);
    CHECK(double(state.history[1]) == near(e, tolerance));
    CHECK(pressure(state) == near(p, tolerance));
    CHECK(double(state.history[0]) == near(p, tolerance));
    squeeze(0.02);
    CHECK(double(state.history[0]) == near(p, tolerance));
    CHECK(pressure(state) == near(p * std::exp(-(1 + e) * std::expm1(0.02) / kappa), tolerance));
    CHECK(double(state.history[2]) == near(0, tolerance));
}

TEST_CASE("drained triaxial compression is that of the closed form to 1e-6 in 1e4 increments") {
    using C = Case<double, 3>;
    const auto law = clay<double>();
    const double p0 = 1e5, axial = -0.15;
    const int steps = 10000;
    auto state = consolidated<C>(law, p0);
    const double v0 = 1 + state.history[1];
    double radial = 0, strain_radial = 0;
    for (int n = 0; n < steps; ++n) {
        drained_step<C>(law, state, axial / steps, radial);
        strain_radial += radial;
    }
    const double p = pressure(state), q = deviator(state), p_c = p * (1 + q * q / (M * M * p * p));
    CHECK(q == near(3 * (p - p0), 1e-9));
    CHECK(q / p > 0.7 * M);  // far along
    CHECK(double(state.history[0]) == near(p_c, 1e-9));
    const double v = v0 - kappa * std::log(p / p0) - (lambda - kappa) * std::log(p_c / p0);
    CHECK(1 + state.history[1] == near(v, 1e-6));
    CHECK(axial + 2 * strain_radial == near(std::log(v / v0), 1e-6));
    CHECK(-2.0 / 3 * (axial - strain_radial) == near(drained_shear_strain(p0, p), 1e-6));
}

TEST_CASE_TEMPLATE("undrained, p and q stay on the path of constant volume up to the critical state", C, EVERY_CASE) {
    const auto law = clay<typename C::Real>();
    for (double ratio : {1.0, 1.5, 4.0}) {
        CAPTURE(ratio);
        auto state = consolidated<C>(law, 1e5, ratio);
        const double p_c0 = double(state.history[0]), p_0 = 1e5,
                     tolerance = sizeof(typename C::Real) == 8 ? 1e-4 : 5e-3;
        double worst = 0;
        for (int n = 0; n < 10000; ++n) {
            strain_path<C>(law, state, plane_strain<C>(5e-5, -5e-5, 0), 1e-3, 1);
            const double p = pressure(state), p_c = double(state.history[0]);
            // kappa ln p + (lambda - kappa) ln p_c is kept; on the surface p_c = p (1 + eta^2 / M^2)
            worst = std::max(worst, std::fabs(kappa * std::log(p / p_0) + (lambda - kappa) * std::log(p_c / p_c0)));
            CHECK(yield_function(state) < tolerance);
        }
        CHECK(worst < tolerance * kappa);
        const double p = pressure(state), q = std::sqrt(3 * double(invariants(state.stress).j2));
        CHECK(q / p == near(M, 20 * tolerance));
        CHECK(p == near(p_0 * std::pow(p_c0 / p_0 / 2, (lambda - kappa) / lambda), 20 * tolerance));
    }
}

TEST_CASE("of second order: half the increment, a quarter of the error") {
    using C = Case<double, 3>;
    const auto law = clay<double>();
    const auto end_of = [&](int steps) {
        auto state = consolidated<C>(law, 1e5);
        strain_path<C>(law, state, plane_strain<C>(-0.04 / steps, -0.08 / steps, 0.1 / steps), 1e-3, steps);
        return state;
    };
    const auto exact = end_of(40000);
    const auto error_of = [&](int steps) {
        const auto state = end_of(steps);
        double sum = 0;
        for (int k = 0; k < 6; ++k) sum += std::fabs(state.stress[k] - exact.stress[k]);
        return sum / pressure(exact);
    };
    const double coarse = error_of(200), fine = error_of(400);
    CHECK(coarse < 1e-4);
    CHECK(coarse / fine > 3.5);
    CHECK(coarse / fine < 4.6);
}

TEST_CASE_TEMPLATE("any increment ends on or inside the surface, with numbers", C, EVERY_CASE) {
    using Real = typename C::Real;
    const auto law = clay<Real>(1000);
    std::mt19937_64 random(7);
    const auto unit = [&] { return std::ldexp(double(random() >> 11), -52) - 1; };
    double worst = 0;
    for (int path = 0; path < 300; ++path) {
        auto state = consolidated<C>(law, 1e3 * std::pow(10, 1.5 + 1.5 * unit()), 3 + 2 * unit());
        const double size = std::pow(10, -3 + 2 * unit());
        typename C::Strain way = plane_strain<C>(0, 0, 0);
        for (int n = 0; n < 200; ++n) {
            if (n % 20 == 0)
                for (int k = 0; k < C::Strain::size; ++k) way[k] = Real(k == 2 && C::dim == 2 ? 0 : size * unit());
            strain_path<C>(law, state, way, 1e-3, 1);
            REQUIRE(state.history[0] > 0);
            REQUIRE(law.wave_modulus(state) > 0);
            const double surface = std::max(1000.0, double(state.history[0])), p = pressure(state);
            const double q2 = 3 * double(invariants(state.stress).j2);
            const double beyond = (q2 / (M * M) + p * (p - surface)) / (surface * surface);
            worst = std::max(worst, beyond);
        }
    }
    CHECK(worst < (sizeof(Real) == 8 ? 1e-9 : 1e-4));
}

TEST_CASE("soil that was pulled apart must close again before it bears") {
    using C = Case<double, 3>;
    const auto law = clay<double>(1000);
    auto state = consolidated<C>(law, 1e4);
    typename C::Strain way = zero_sym<double, 3>();
    for (int k = 0; k < 3; ++k) way[k] = 1e-4;
    strain_path<C>(law, state, way, 1e-3, 2000);
    CHECK(pressure(state) == near(0, 1e-6));
    for (int k = 0; k < 3; ++k) way[k] = -1e-4;
    strain_path<C>(law, state, way, 1e-3, 1000);  // by its void ratio it would bear 117 Pa: less than the floor
    CHECK(pressure(state) == near(1000, 1e-6));
    strain_path<C>(law, state, way, 1e-3, 1000);
    CHECK(pressure(state) == near(1e4, 0.02));
}

TEST_CASE("a body begins on the line of its over-consolidation, or says why it cannot") {
    const auto law = clay<double>();
    auto state = consolidated<Case<double, 3>>(law, 5e4, 2);
    CHECK(state.history[0] == near(1e5, 1e-14));
    CHECK(state.history[1] == near(e_1 - lambda * std::log(100.0) + kappa * std::log(2.0), 1e-14));
    state.stress[1] = -1e9;
    CHECK(std::string(law.begin({1}, state)).find("void ratio") != std::string::npos);
    CHECK(std::string(
              law.problem(values_of("modified-cam-clay", {{"compression_index", 0.1}, {"swelling_index", 0.1}}).data()))
              .find("swelling_index") == 0);
}
