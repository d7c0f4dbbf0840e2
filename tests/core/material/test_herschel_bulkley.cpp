#include "core/material/drive.hpp"
#include "core/material/herschel_bulkley.hpp"

using namespace moraine;
using namespace moraine::testing;

namespace {
constexpr double young = 250e3, poisson = 0.45, G = young / (2 * (1 + poisson));

template <class C, class Law>
double steady_shear_stress(const Law& law, double rate) {
    auto state = virgin_state<C>();
    strain_path<C>(law, state, plane_strain<C>(0, 0, 1e-3), 1e-3 / rate, 4000);
    return double(state.stress[3]);
}
}  // namespace

TEST_CASE_TEMPLATE("steady simple shear carries tau = yield + K rate^n", C, EVERY_CASE) {
    for (double n : {0.2, 0.35, 0.5, 1.0, 1.7, 3.0})
        for (double yield : {0.0, 500.0})
            for (double rate : {0.01, 1.0, 30.0}) {
                CAPTURE(n);
                CAPTURE(yield);
                CAPTURE(rate);
                const double K = n > 1 ? 2 : 150;
                const auto law = make_law<HerschelBulkley<typename C::Real>>({{"young", young},
                                                                              {"poisson", poisson},
                                                                              {"consistency", K},
                                                                              {"yield_stress", yield},
                                                                              {"exponent", n}});
                const double tau = yield + K * std::pow(rate, n);
                if (tau > 0.5 * G) continue;  // beyond what 4 of shear brings to a steady state
                CHECK(steady_shear_stress<C>(law, rate) == near(tau, C::tolerance, 0.1 * yield));
            }
}

TEST_CASE_TEMPLATE("bingham and newtonian are names of the same law", C, EVERY_CASE) {
    using Real = typename C::Real;
    const auto stress = [](const auto& law) -> double {
        if constexpr (std::is_same_v<std::decay_t<decltype(law)>, HerschelBulkley<Real>>)
            return steady_shear_stress<C>(law, 2);
        return 0;
    };
    const auto bingham =
        values_of("bingham", {{"young", young}, {"poisson", poisson}, {"viscosity", 50}, {"yield_stress", 500}});
    const auto newtonian = values_of("newtonian", {{"young", young}, {"poisson", poisson}, {"viscosity", 50}});
    CHECK(with_law<Real>("bingham", bingham.data(), stress) == near(600, C::tolerance));
    CHECK(with_law<Real>("newtonian", newtonian.data(), stress) == near(100, C::tolerance));
}

TEST_CASE_TEMPLATE("held in place, an overstress relaxes to the yield stress and no further", C, EVERY_CASE) {
    for (double n : {0.5, 1.0, 2.0}) {
        CAPTURE(n);
        const auto law = make_law<HerschelBulkley<typename C::Real>>(
            {{"young", young}, {"poisson", poisson}, {"consistency", 50}, {"yield_stress", 500}, {"exponent", n}});
        auto state = virgin_state<C>();
        strain_path<C>(law, state, plane_strain<C>(0, 0, 1200 / G), 1e-9, 1);
        double before = double(state.stress[3]);
        CHECK(before > 600);
        for (int i = 0; i < 20; ++i) {
            strain_path<C>(law, state, plane_strain<C>(0, 0, 0), 1e-4, 20);
            CHECK(double(state.stress[3]) <= before);
            before = double(state.stress[3]);
        }
        CHECK(before >= 500 * (1 - C::tolerance));
        if (n >= 1) CHECK(before == near(500, C::tolerance));  // n < 1: algebraic in time
    }
}

TEST_CASE("Bingham relaxation is exponential with time K / G, first order in dt") {
    using C = Case<double, 2>;
    const auto law = make_law<HerschelBulkley<double>>(
        {{"young", young}, {"poisson", poisson}, {"consistency", 50}, {"yield_stress", 500}});
    double error[2];
    for (int level = 0; level < 2; ++level) {
        auto state = virgin_state<C>();
        state.stress[3] = 900;
        const int steps = 1000 << level;
        strain_path<C>(law, state, plane_strain<C>(0, 0, 0), 50 / G / steps, steps);
        error[level] = std::fabs(state.stress[3] - (500 + 400 * std::exp(-1.0)));
    }
    CHECK(error[0] <= 0.1);
    CHECK(error[0] / error[1] == near(2, 0.01));
}

TEST_CASE_TEMPLATE("below the yield stress nothing creeps, to the bit", C, EVERY_CASE) {
    const auto law = make_law<HerschelBulkley<typename C::Real>>(
        {{"young", young}, {"poisson", poisson}, {"consistency", 50}, {"yield_stress", 500}, {"exponent", 0.4}});
    auto state = virgin_state<C>();
    strain_path<C>(law, state, plane_strain<C>(0, 0, 499 / G), 1e-4, 1);
    const auto held = state.stress[3];
    CHECK(double(held) == near(499, C::tolerance));
    strain_path<C>(law, state, plane_strain<C>(0, 0, 0), 1, 1000);
    CHECK(state.stress[3] == held);
    strain_path<C>(law, state, plane_strain<C>(0, 0, -499 / G), 1e-4, 1);
    CHECK(std::fabs(double(state.stress[3])) <= 1e-4);
}

TEST_CASE_TEMPLATE("a step solves its own equation, for any exponent, rate and step", C, EVERY_CASE) {
    using Real = typename C::Real;
    for (double n : {0.1, 0.35, 0.9, 1.0, 1.3, 5.0})
        for (double K : {0.0, 1e-3, 1.0, 1e3, 1e6})
            for (double over : {1e-3, 1.0, 1e4})
                for (double dt : {1e-7, 1e-4, 1e-1}) {
                    CAPTURE(n);
                    CAPTURE(K);
                    CAPTURE(over);
                    CAPTURE(dt);
                    const auto law = make_law<HerschelBulkley<Real>>({{"young", young},
                                                                      {"poisson", poisson},
                                                                      {"consistency", K},
                                                                      {"yield_stress", 0},
                                                                      {"exponent", n}});
                    const double share = double(law.viscous_share(Real(over), Real(dt)));
                    CHECK(share >= 0);
                    CHECK(share <= 1);
                    // q = K ((A - q) / (G dt))^n, on the side that keeps its digits
                    const double q = share * over;
                    if (share < 0.5)
                        CHECK(q == near(K * std::pow((over - q) / (G * dt), n), 50 * C::tolerance, over));
                    else
                        CHECK(over - q == near(G * dt * std::pow(q / K, 1 / n), 50 * C::tolerance, over));
                }
}
