// Water in the ground against closed forms: consolidation, waves, the undrained limit, and still water.
#include <complex>

#include "records/time_series.hpp"
#include "verification/drive.hpp"
#include "verification/wet_column.hpp"

using namespace moraine;
using namespace moraine::verification;
using namespace moraine::verification::wet;

namespace {

/// The wave of free vibration of a column on a fixed base, by its rate and frequency [1/s]: a root of
/// (rho s^2 + c (M + Q)) (rho_w / n s^2 + gamma_w / k s + c Q) = (rho_w s^2 + c Q)^2, c = (pi / 2 H)^2.
std::complex<double> vibration(double conductivity) {
    const double c = std::pow(pi / 2 / height, 2), rho_w = 1000, drag = rho_w * conductivity_gravity / conductivity;
    std::complex<double> s(-1, std::sqrt(c * (M + Q) / density));
    for (int k = 0; k < 50; ++k) {
        const auto soil = density * s * s + c * (M + Q), flow = rho_w / porosity * s * s + drag * s + c * Q;
        const auto both = rho_w * s * s + c * Q;
        const auto slope = 2 * density * s * flow + soil * (2 * rho_w / porosity * s + drag) - 4 * rho_w * s * both;
        s -= (soil * flow - both * both) / slope;
    }
    return s;
}

struct Oscillation {
    double rate, frequency;  ///< [1/s]
};

/// Of what begins as A e^(rate t) sin(frequency t) about a slow drift, from its zeros and the extremes between them.
Oscillation oscillation(Run<>& run, double until) {
    std::vector<double> zeros, extremes;
    double before = 0, time = 0, most = 0;
    while (run.time() < until) {
        run.steps(1);
        const double now = settlement(run);
        if (before * now < 0) {
            zeros.push_back(time + (run.time() - time) * before / (before - now));
            extremes.push_back(most);
            most = 0;
        }
        before = now, time = run.time(), most = std::max(most, std::fabs(now));
    }
    const std::size_t halves = (zeros.size() - 1) / 2 * 2;  // the drift of what consolidates moves every other zero
    const double frequency = pi * static_cast<double>(halves) / (zeros[halves] - zeros[0]);
    const double first = extremes[1] + extremes[2], last = extremes[halves - 1] + extremes[halves];
    return {std::log(last / first) * frequency / pi / static_cast<double>(halves - 2), frequency};
}

/// The column on a rough bed of this slope.
Scene slope_of(double slope, double conductivity) {
    Scene scene = column(10, conductivity);
    scene.gravity = {9.81 * std::sin(slope), -9.81 * std::cos(slope), 0};
    scene.walls[1][0].kind = WallKind::no_slip;
    return scene;
}

}  // namespace

TEST_CASE("a column consolidates as by Terzaghi") {
    constexpr double load = 1e4, k = 3e-4, ramp = 0.03;
    const double c_v = k / (1000 * conductivity_gravity * (1 / M + 1 / Q)), p0 = load * Q / (M + Q);
    Scene scene = column(10, k);
    press(scene, load, ramp);
    Run<> run(scene);
    for (const double T : {0.1, 0.2, 0.5}) {
        while (run.time() < T / c_v + ramp / 2) run.steps(20);
        const double now = c_v * (run.time() - ramp / 2);
        const double U = 1 - series(now, [](double a) { return 2 / (a * a); });
        const double base = series(now, [](double a) { return 2 / a * std::sin(a); });
        const double settled = (settlement(run) - load / (M + Q)) / (load / M - load / (M + Q));
        const double pressed = mean(run, [&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
            return X[1] < 0.5 * scene.cell ? p.pore_pressure[s] / p0 * 20 : 0;
        });
        say(fmt::format("consolidation, 10 cells, T = {:.3f}: U {:.4f} for {:.4f}, base {:.4f} for {:.4f}", now,
                        settled, U, pressed, base));
        CHECK(settled == doctest::Approx(U).epsilon(0.01));
        CHECK(std::fabs(pressed - base) <= 0.01);
    }
}

TEST_CASE("waves of saturated soil have their speed, and drag takes what Darcy's law takes") {
    for (const double k : {1e-9, 1e-3}) {
        const std::complex<double> exact = vibration(k);
        Scene scene = column(20, k);
        scene.bodies[0].wave = {{0, 1e-3, 0}, 1, 0, 4 * height};
        Run<> run(scene);
        const Oscillation found = oscillation(run, 0.03);
        say(fmt::format("vibration, k = {:.0e}: {:.2f} 1/s for {:.2f}, rate {:.3f} for {:.3f}", k, found.frequency,
                        exact.imag(), found.rate, exact.real()));
        CHECK(found.frequency == doctest::Approx(exact.imag()).epsilon(5e-3));
        if (k > 1e-6) CHECK(found.rate == doctest::Approx(exact.real()).epsilon(0.05));
        if (k > 1e-6) continue;
        CHECK(std::fabs(found.rate) < 0.5);  // no more than the transfer takes
        const double apart = run.largest([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
            return X[1] < 0.9 ? std::fabs(p.pore_pressure[s] + Q * p.ln_J[s]) : 0;
        });
        CHECK(apart <= 0.1 * Q * 1.3e-6);  // undrained: the water follows the volume
    }
}

TEST_CASE("pressures of alternating sign fall, though they push no node") {
    double left[2];
    for (const double k : {1e-4, 1e-12}) {
        Scene scene = column(20, k);
        scene.walls[1][1].kind = WallKind::free_slip;
        scene.max[1] = height;
        Run<> run(scene);
        run.start_with([&](const auto& p, std::uint32_t s, const auto& X) {
            p.pore_pressure[s] = std::lround(X[1] / scene.cell) % 2 == 0 ? 1e3 : -1e3;
        });
        while (run.time() < 0.02) run.steps(50);
        left[k < 1e-9] = mean(run, [&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
            return p.pore_pressure[s] * (std::lround(X[1] / scene.cell) % 2 == 0 ? 1e-3 : -1e-3);
        });
    }
    say(fmt::format("checkerboard after 20 ms: {:.4f} of it, undrained {:.4f}", left[0], left[1]));
    CHECK(left[0] <= 0.05);
    CHECK(left[1] >= 0.99);
}

TEST_CASE("water seeps down a slope as fast as Darcy's law says, and its ground stays") {
    constexpr double slope = 20 * pi / 180, g = 9.81, k = 1e-3;
    const Scene scene = slope_of(slope, k);
    Run<> run(scene);
    run.start_with([&](const auto& p, std::uint32_t s, const auto& X) { seep(slope, k, p, s, X); });
    while (run.time() < 0.2) run.steps(50);
    const double flux =
        mean(run, [](const auto& p, std::uint32_t s, const auto&, const auto&) { return p.darcy_velocity[s][0]; });
    const double base = mean(run, [&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
        return X[1] < 0.5 * scene.cell ? 20 * p.pore_pressure[s] : 0;
    });
    const double moved =
        run.largest([](const auto&, std::uint32_t, const auto& X, const auto& x) { return std::fabs(x[1] - X[1]); });
    say(fmt::format("seepage: w {:.5f} k sin(beta), base {:.4f}, moved {:.1e} h", flux / (k * std::sin(slope)),
                    base / (1000 * g * std::cos(slope) * 0.975), moved / scene.cell));
    CHECK(flux == doctest::Approx(k * std::sin(slope)).epsilon(0.01));
    CHECK(base == doctest::Approx(1000 * g * std::cos(slope) * 0.975).epsilon(0.03));
    CHECK(moved <= 1e-3 * scene.cell);
}

TEST_CASE("saturated ground slides on a wall as its effective stress says") {
    constexpr double g = 9.81, friction = 0.5, over = 0.3 * pi / 180;
    const double critical = std::atan(friction * (density - 1000) / density);  // FS = (gamma' / gamma) mu / tan(beta)
    for (const double k : {1e-3, 1e-6})
        for (const double slope : {critical - over, critical + over}) {
            Scene scene = column(10, k);
            scene.gravity = {g * std::sin(slope), -g * std::cos(slope), 0};
            scene.walls[1][0].kind = WallKind::friction, scene.walls[1][0].friction = friction;
            Run<> run(scene);
            run.start_with([&](const auto& p, std::uint32_t s, const auto& X) { seep(slope, k, p, s, X); });
            while (run.time() < 0.3) run.steps(50);
            const double speed =
                mean(run, [](const auto& p, std::uint32_t s, const auto&, const auto&) { return p.velocity[s][0]; });
            const double falls =
                std::max(0.0, g * (std::sin(slope) - std::cos(slope) * std::tan(critical)) * run.time());
            const double off = (speed - falls) / (g * run.time()) * 180 / pi;
            say(
                fmt::format("seepage on a wall with friction, k = {:.0e}, {:+.1f} degrees: {:.2e} m/s for {:.2e}, that "
                            "is {:+.3f} degrees",
                            k, (slope - critical) * 180 / pi, speed, falls, off));
            CHECK(std::fabs(off) <= (slope < critical ? 0.001 : 0.2));
        }
}

TEST_CASE("what drag takes of a column that consolidates is what Darcy's law takes, and no energy is left over") {
    constexpr double load = 1e4, k = 3e-4, ramp = 0.03;
    const double c_v = k / (1000 * conductivity_gravity * (1 / M + 1 / Q)), p0 = load * Q / (M + Q);
    const auto lost = [&](double T) { return series(2 * T, [](double a) { return 1 / (a * a); }); };
    Scene scene = column(10, k);
    scene.output.energy_budget = true;
    press(scene, load, ramp);
    Run<> run(scene);
    const Comm comm(MPI_COMM_WORLD);
    std::vector<TimeSeriesRow<2>> rows;
    std::vector<double> T;
    for (const double until : {0.1, 0.5}) {
        while (run.time() < until / c_v + ramp / 2) run.steps(20);
        rows.push_back(observe(run.sim, comm));
        T.push_back(c_v * (run.time() - ramp / 2));
    }
    const double drag = rows[1].water->drag - rows[0].water->drag;
    // gamma_w / k w^2 of the series, over the column and the time
    const double darcy = p0 * p0 * (1 / M + 1 / Q) * height * scene.max[0] * (lost(T[0]) - lost(T[1]));
    const EnergyBudget& took = *rows[1].energy;
    const double known = took.transfer + took.shift + took.wall + took.contact + took.damping + took.lost;
    say(
        fmt::format("consolidation: drag takes {:.5g} J for {:.5g}, of {:.5g} J of the load; unaccounted {:.2g}, "
                    "known {:.2g}, momentum error {:.1e}",
                    drag, darcy, rows[1].loads->work, rows[1].unaccounted, known, rows[1].momentum_error[1]));
    CHECK(std::fabs(drag / darcy - 1) <= 0.01);
    CHECK(std::fabs(rows[1].unaccounted) <= 0.02 * rows[1].loads->work);
    CHECK(std::fabs(rows[1].unaccounted - known) <= 0.01 * rows[1].loads->work);
    CHECK(std::fabs(rows[1].momentum_error[1]) <= 1e-11 * std::fabs(rows[1].loads->impulse[1]));
}

TEST_CASE("what drag takes of seepage is what the weight of the water gives") {
    constexpr double slope = 20 * pi / 180, k = 1e-3;
    const Scene scene = slope_of(slope, k);
    Run<> run(scene);
    run.start_with([&](const auto& p, std::uint32_t s, const auto& X) { seep(slope, k, p, s, X); });
    const Comm comm(MPI_COMM_WORLD);
    while (run.time() < 0.1) run.steps(50);  // what the start was off by
    const TimeSeriesRow<2> start = observe(run.sim, comm);
    while (run.time() < 0.2) run.steps(50);
    const TimeSeriesRow<2> end = observe(run.sim, comm);
    const double darcy = 1000 * conductivity_gravity * k * std::pow(std::sin(slope), 2) * height * scene.max[0] *
                         (end.time - start.time);
    const double drag = (end.water->drag - start.water->drag) / darcy;
    const double weight = (end.water->weight - start.water->weight) / darcy;
    say(fmt::format("seepage: drag {:.5f}, weight {:.5f} of Darcy's; unaccounted {:.1e} of it, momentum error {:.1e}",
                    drag, weight, (end.unaccounted - start.unaccounted) / darcy, end.momentum_error[0]));
    CHECK(std::fabs(drag - 1) <= 0.01);
    CHECK(std::fabs(weight - 1) <= 0.01);
    CHECK(std::fabs(end.momentum_error[0]) <= 1e-11 * std::fabs(end.gravity_impulse[0]));
}
