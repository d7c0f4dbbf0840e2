#include "core/material/drive.hpp"
#include "core/material/undrained_strength.hpp"

using namespace moraine;
using namespace moraine::testing;

// The seed problem's law on one particle, in simple shear at a constant rate. Both surfaces give the
// same answer there.

namespace {
constexpr double su = 500, young = 500 * su, poisson = 0.495, G = young / (2 * (1 + poisson));
constexpr double gd = 0.3, xi95 = 10, sensitivity = 4;

double softened(double rate, double xi) {
    return rate * su * (1 / sensitivity + (1 - 1 / sensitivity) * std::exp(-3 * xi / xi95));
}

/// tau = s_u(xi), xi = gamma - tau / G: the plastic part of a monotonic shear gamma.
double exact_stress(double rate, double gamma) {
    double tau = softened(rate, gamma);
    for (int i = 0; i < 200; ++i) tau = softened(rate, gamma - tau / G);
    return tau;
}

template <class Law, class C>
void shear_to_remoulded(std::initializer_list<std::pair<const char*, double>> given, double rate) {
    const Law law(values_of(Law::name, given).data());
    auto state = virgin_state<C>();
    const double target = sizeof(typename C::Real) == 8 ? 1e-10 : 1e-5;
    const double step = 0.02;
    for (int n = 1; n <= 51; ++n) {
        strain_path<C>(law, state, plane_strain<C>(0, 0, step), step / gd, 50);
        const double gamma = n * 50 * step;
        CAPTURE(gamma);
        CHECK(double(state.stress[3]) == doctest::Approx(exact_stress(rate, gamma)).epsilon(target).scale(0));
    }
    CHECK(double(state.history[0]) >= 5 * xi95);
}
}  // namespace

TEST_CASE_TEMPLATE("simple shear to 5 xi95 follows the strength with a logarithmic rate effect", C, EVERY_CASE) {
    using Real = typename C::Real;
    const double rate = 1 + 0.1 * std::log10(gd / 3e-6);
    const std::initializer_list<std::pair<const char*, double>> given = {
        {"young", young},         {"poisson", poisson},        {"su", su}, {"rate_log", 0.1}, {"xi95", xi95},
        {"rate_reference", 3e-6}, {"sensitivity", sensitivity}};
    shear_to_remoulded<VonMises<Real>, C>(given, rate);
    shear_to_remoulded<Tresca<Real>, C>(given, rate);
}

TEST_CASE_TEMPLATE("simple shear to 5 xi95 follows the strength with a power rate effect", C, EVERY_CASE) {
    using Real = typename C::Real;
    const double rate = 1 + 0.7 * std::pow(gd / 0.05, 0.35);
    const std::initializer_list<std::pair<const char*, double>> given = {{"young", young},
                                                                         {"poisson", poisson},
                                                                         {"su", su},
                                                                         {"rate_power", 0.7},
                                                                         {"xi95", xi95},
                                                                         {"rate_reference", 0.05},
                                                                         {"sensitivity", sensitivity},
                                                                         {"rate_exponent", 0.35}};
    shear_to_remoulded<VonMises<Real>, C>(given, rate);
    shear_to_remoulded<Tresca<Real>, C>(given, rate);
}

TEST_CASE_TEMPLATE("with spin the stress stays on the softening surface as well", C, EVERY_CASE) {
    using Real = typename C::Real;
    const double target = sizeof(Real) == 8 ? 1e-10 : 1e-5;
    const double rate = 1 + 0.1 * std::log10(gd / 3e-6), step = 0.01;
    Mat<Real, C::dim> grad = zero_mat<Real, C::dim>();
    grad(0, 1) = Real(step);
    const auto values = values_of("tresca", {{"young", young},
                                             {"poisson", poisson},
                                             {"su", su},
                                             {"rate_log", 0.1},
                                             {"rate_reference", 3e-6},
                                             {"sensitivity", sensitivity},
                                             {"xi95", 1}});
    const auto check = [&](const auto& law) {
        auto state = virgin_state<C>();
        gradient_path<C>(law, state, grad, step / gd, 100);
        const double xi = double(state.history[0]);
        CHECK(xi == near(1, 0.01));
        const double strength = rate * su * (1 / sensitivity + (1 - 1 / sensitivity) * std::exp(-3 * xi));
        CHECK(shear_stress_measure(state) == doctest::Approx(strength).epsilon(target).scale(0));
    };
    check(VonMises<Real>(values.data()));
    check(Tresca<Real>(values.data()));
}

TEST_CASE("below the reference rate the logarithmic law adds nothing") {
    const UndrainedStrength<double> s(
        values_of("tresca", {{"su", su}, {"rate_log", 0.1}, {"rate_reference", 1}}).data());
    CHECK(s.rate_factor(0) == 1);
    CHECK(s.rate_factor(0.5) == 1);
    CHECK(s.rate_factor(100) == near(1.2, 1e-14));
}

TEST_CASE("a return lands on the surface, also where softening is steeper than the elastic line") {
    for (double steepness : {0.1, 0.999, 1.0, 1.001, 30.0, 1e4}) {
        const double brittle = 3 * (1 - 1 / sensitivity) * su / (G * steepness);  // xi95
        const UndrainedStrength<double> s(
            values_of("tresca", {{"su", su}, {"sensitivity", sensitivity}, {"xi95", brittle}}).data());
        for (double over : {1e-12, 1e-6, 1e-3, 0.1, 10.0}) {
            CAPTURE(steepness);
            CAPTURE(over);
            double xi = 0;
            const double trial = su * (1 + over);
            const double tau = s.returned(trial, G, 1, xi);
            CHECK(tau == near(s.at(1, xi), 1e-14));
            CHECK(tau <= su);
            // At steepness 1 the elastic line touches the surface: the root is double and half the digits go.
            CHECK(std::fabs(trial - G * xi - tau) <= (steepness == 1.0 ? 1e-7 : 1e-9) * su);
        }
    }
}

TEST_CASE("two rate effects at once, or one without its reference, are refused") {
    const auto problem = [](std::initializer_list<std::pair<const char*, double>> given) {
        return find_law("von-mises")->problem(values_of("von-mises", given).data());
    };
    CHECK(problem({{"su", 1}}) == nullptr);
    CHECK(problem({{"rate_log", 0.1}, {"rate_reference", 3e-6}}) == nullptr);
    CHECK(std::string(problem({{"rate_log", 0.1}})).starts_with("rate_reference is missing"));
    CHECK(std::string(problem({{"rate_log", 0.1}, {"rate_power", 1}, {"rate_reference", 1}})).find("rate_power") !=
          std::string::npos);
}
