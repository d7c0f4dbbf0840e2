// Gravity by a table of time: what a ramp leaves of the first mode of a column, and impulses to rounding.
#include "records/time_series.hpp"
#include "verification/drive.hpp"
#include "verification/problem_column.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

// 1e-3 of its height, so that c does not change as it settles
constexpr Column stiff{.height = 8, .young = 8e6, .density = 1000, .gravity = 1};

struct Ringing {
    double top;     ///< half of the range of the mean height after the ramp, over the settlement of rest
    double settle;  ///< its middle over the settlement of rest
    double stress;  ///< of the mean over two periods, sum V0 |sigma - exact| / (rho0 g l0 sum V0)
};

/// Without damping, from t_r on for two periods 4 l0 / c; the ramp takes `share` of one.
Ringing ring(const Column& column, double share, int cells) {
    Scene scene = column_scene(column, cells, quadratic_apic_usl, "linear-elastic", true);
    scene.damping = 0;
    const double period = 4 * column.height / column.wave_speed();
    scene.course.gravity = {{0, share * period}, {0, 1}};
    Run<> run(scene);
    const double volume = scene.max[0] * column.height;
    const double rest = run.sum([&](const auto&, std::uint32_t, const auto& X, const auto&) {
        return (X[1] - column.place(X[1])) / static_cast<double>(run.particles());
    });
    double low = 1e9, high = -1e9;
    std::vector<double> stress(run.particles());
    int samples = 0;
    while (run.time() < share * period) run.steps(1);
    while (run.time() < (share + 2) * period) {
        run.steps(1);
        const double settled = run.sum([&](const auto& p, std::uint32_t s, const auto& X, const auto& x) {
            stress[p.id[s]] += p.stress[s](1, 1);
            return (X[1] - x[1]) / static_cast<double>(run.particles());
        });
        low = std::min(low, settled), high = std::max(high, settled);
        ++samples;
    }
    const double error = run.sum([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
        return 0.5 * scene.cell * scene.cell * std::fabs(stress[p.id[s]] / samples - column.stress(X[1]));
    });
    return {0.5 * (high - low) / rest, 0.5 * (high + low) / rest, error / (column.base_pressure() * volume)};
}

/// Of the first mode after a ramp: |sin x| / x, x = pi t_r / T.
double overshoot(double share) {
    return std::fabs(std::sin(pi * share)) / (pi * share);
}

/// A block that falls in free space; nothing but gravity acts.
Scene falling(double dt) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 0.5;
    scene.max = {8, 8, 0};
    scene.dt = dt;
    scene.end = 10;
    scene.gravity = {0.3, -2, 0};
    scene.course.gravity = {{0.013, 0.2, 0.31, 0.5}, {0, 1, -0.5, 0.25}};
    scene.materials.push_back(material("neo-hookean", 1000, {{"young", 1e4}, {"poisson", 0.3}}));
    BodySpec body;
    body.min = {3, 5, 0}, body.max = {5, 7, 0};
    scene.bodies.push_back(body);
    return scene;
}

}  // namespace

TEST_CASE("a ramp of one period leaves a column at rest, and others ring by sin(x) / x") {
    for (const double share : {1.0, 0.5, 1.5}) {
        const Ringing r = ring(stiff, share, 16);
        say(
            fmt::format("gravity by a ramp of {} periods: rings by {:.4f} (first mode {:.4f}), settles to {:.4f}, mean "
                        "stress off by {:.4f}",
                        share, r.top, overshoot(share), r.settle, r.stress));
        CHECK(r.settle == doctest::Approx(1).epsilon(0.01));
        CHECK(r.stress <= 0.01);
        if (share == 1) CHECK(r.top <= 0.01);
        if (share != 1) CHECK(r.top == doctest::Approx(overshoot(share)).epsilon(0.1));
    }
}

TEST_CASE(
    "a falling block has the impulse of its table to rounding, whatever the steps, and energy by its step alone") {
    for (const double dt : {0.01, 0.0037, 0.05}) {
        const Scene scene = falling(dt);
        Run<> run(scene);
        run.steps(static_cast<std::int64_t>(0.7 / dt));
        const Comm comm(MPI_COMM_WORLD);
        const TimeSeriesRow<2> row = observe(run.sim, comm);
        const double integral = 0.5 * 0.187 + 0.5 * 0.11 * 0.5 - 0.5 * 0.19 * 0.25 + 0.25 * (run.time() - 0.5);
        for (std::size_t a = 0; a < 2; ++a) {
            CHECK(row.totals.momentum[a] / row.totals.mass ==
                  doctest::Approx(scene.gravity[a] * integral).epsilon(1e-12));
            CHECK(row.gravity_impulse[a] == doctest::Approx(row.totals.momentum[a]).epsilon(1e-12));
        }
        // a step gives m g v dt + m g^2 dt^2 / 2 and lowers by m g (v + g dt) dt: half of m g^2 dt^2 is its error
        double error = 0;
        for (int k = 0; k < run.sim.clock().step; ++k) {
            const double g = scene.course.gravity.mean(k * dt, (k + 1) * dt) * std::hypot(0.3, 2.0);
            error += 0.5 * row.totals.mass * g * g * dt * dt;
        }
        CHECK(row.gravity_work != 0);
        CHECK(row.unaccounted == doctest::Approx(error).epsilon(1e-6));
    }
}
