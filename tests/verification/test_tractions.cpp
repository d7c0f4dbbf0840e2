// Tractions against closed forms: a column, a block under pressure on all sides, a plate, and what came in.
#include "records/time_series.hpp"
#include "seeding/traction_place.hpp"
#include "verification/drive.hpp"
#include "verification/problem_column.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

// 1e-3 of its height, so that c does not change as it settles
constexpr Column stiff{.height = 8, .young = 8e6, .density = 1000, .gravity = 0};
constexpr double load = 8e3;

TractionSpec traction(const Scene& scene, const Triple& normal, double pressure, bool follows = false) {
    TractionSpec t;
    t.normal = normal, t.pressure = pressure, t.follows = follows;
    t.depth = 3 * scene.cell;
    t.spacing = line_spacing(scene, t);
    return t;
}

Scene loaded_column(int cells, const Choice& choice = quadratic_apic_usl) {
    Scene scene = column_scene(stiff, cells, choice, "linear-elastic", true);
    scene.course.tractions.push_back(traction(scene, {0, 1, 0}, load));
    return scene;
}

double settled(Run<>& run) {
    return run.sum([&](const auto&, std::uint32_t, const auto& X, const auto& x) {
        return (X[1] - x[1]) / static_cast<double>(run.particles());
    });
}

constexpr double period = 4 * 8 / 89.442719099991592;  // 4 l0 / c

/// A block in free space, of 8 x 4 m.
Scene block(const std::string& law, double young, double poisson) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 0.5;
    scene.max = {32, 32, 0};
    scene.end = 10;
    scene.cfl = 0.4;
    scene.materials.push_back(material(law, 1000, {{"young", young}, {"poisson", poisson}}));
    BodySpec body;
    body.min = {10, 10, 0}, body.max = {18, 14, 0};
    scene.bodies.push_back(body);
    return scene;
}

}  // namespace

TEST_CASE("a column bears its load in each particle, with each transfer") {
    for (const Choice& choice : {quadratic_apic_usl, quadratic_flip_usl, quadratic_apic_musl, cubic_flip_usl,
                                 contiguous_flip_usl, quadratic_fmpm2}) {
        Scene scene = loaded_column(16, choice);
        Run<> run(scene);
        while (run.time() < 12 * period) run.steps(50);
        const double worst = run.largest([&](const auto& p, std::uint32_t s, const auto&, const auto&) {
            return std::fabs(p.stress[s](1, 1) / load + 1);
        });
        const double mean = run.sum([&](const auto& p, std::uint32_t s, const auto&, const auto&) {
            return p.stress[s](1, 1) / load / static_cast<double>(run.particles());
        });
        const double settles = settled(run) / (0.5 * stiff.height * load / stiff.young);
        say(
            fmt::format("column under a pressure, {}: mean stress {:.6f}, worst particle off by {:.4f}, settles to "
                        "{:.5f}",
                        choice.name, mean, worst, settles));
        CHECK(mean == doctest::Approx(-1).epsilon(1e-3));
        CHECK(worst <= 0.02);
        CHECK(settles == doctest::Approx(1).epsilon(2e-3));
    }
}

TEST_CASE("a load at once makes twice the settlement, and one by a ramp of a period none that rings") {
    for (const double share : {0.0, 1.0}) {
        Scene scene = loaded_column(16);
        scene.damping = 0;
        if (share > 0) scene.course.tractions[0].factor = {{0, share * period}, {0, 1}};
        Run<> run(scene);
        double low = 1e9, high = -1e9;
        while (run.time() < share * period) run.steps(1);
        while (run.time() < (share + 1) * period) {
            run.steps(1);
            const double now = settled(run) / (0.5 * stiff.height * load / stiff.young);
            low = std::min(low, now), high = std::max(high, now);
        }
        say(fmt::format("column, load by a ramp of {} periods: {:.4f} to {:.4f} of the settlement of rest", share, low,
                        high));
        CHECK(low == doctest::Approx(share).epsilon(0.02));
        CHECK(high == doctest::Approx(2 - share).epsilon(0.02));
    }
}

TEST_CASE("a block under one pressure on all sides shrinks by p / (lambda + G) and stays where it is") {
    constexpr double young = 1e6, poisson = 0.25, p = 1e3;
    Scene scene = block("linear-elastic", young, poisson);
    scene.damping = 0.3;
    for (const Triple normal : {Triple{1, 0, 0}, Triple{-1, 0, 0}, Triple{0, 1, 0}, Triple{0, -1, 0}})
        scene.course.tractions.push_back(traction(scene, normal, p, true));
    Run<> run(scene);
    while (run.time() < 6) run.steps(50);
    const double lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), shear = young / (2 * (1 + poisson));
    const double exact = -p / (lame + shear);
    const double worst = run.largest(
        [&](const auto& v, std::uint32_t s, const auto&, const auto&) { return std::fabs(v.ln_J[s] / exact - 1); });
    const TimeSeriesRow<2> row = observe(run.sim, Comm(MPI_COMM_WORLD));
    const double momentum = std::hypot(row.totals.momentum[0], row.totals.momentum[1]);
    say(fmt::format("block under a pressure: ln J off by {:.4f} at most, momentum {:.2g} kg m/s", worst, momentum));
    CHECK(worst <= 0.03);
    CHECK(momentum <= 1e-9 * p * 8 * run.time());
}

TEST_CASE("momentum and energy that came in are in the budget") {
    for (const bool follows : {false, true}) {
        Scene scene = block("neo-hookean", 1e6, 0.3);
        scene.course.tractions.push_back(traction(scene, {1, 0, 0}, 2e3, follows));
        scene.course.tractions[0].shear = {0, 500, 0};
        scene.course.tractions[0].factor = {{0, 0.2, 0.4}, {0, 1, 0.5}};
        Run<> run(scene);
        while (run.time() < 1.0) run.steps(20);
        const TimeSeriesRow<2> row = observe(run.sim, Comm(MPI_COMM_WORLD));
        for (std::size_t a = 0; a < 2; ++a) {
            CHECK(std::fabs(row.momentum_error[a]) <= 1e-11 * std::fabs(row.loads->impulse[0]));
            CHECK(row.totals.momentum[a] == doctest::Approx(row.loads->impulse[a]).epsilon(1e-11));
        }
        const double integral = 0.1 + 0.15 + 0.5 * (run.time() - 0.4);
        if (!follows) CHECK(row.loads->impulse[0] == doctest::Approx(-2e3 * 4 * integral).epsilon(1e-3));
        if (!follows) CHECK(row.loads->impulse[1] == doctest::Approx(500 * 4 * integral).epsilon(1e-3));
        say(
            fmt::format("block that is pushed, {}: work {:.5g} J, kinetic {:.5g}, stored {:.5g}, dissipated {:.5g}, "
                        "unaccounted {:.5g}",
                        follows ? "follower" : "dead", row.loads->work, row.totals.kinetic, row.totals.strain,
                        row.dissipated, row.unaccounted));
        CHECK(std::fabs(row.unaccounted) <= 0.02 * row.loads->work);
    }
}

TEST_CASE("a plate under a dead load at its end bends as the elastica") {
    constexpr double young = 1e7, poisson = 0.0;  // plane strain: E / (1 - nu^2)
    constexpr double length = 20, height = 2;
    const double stiffness = young * height * height * height / 12;
    Scene scene = block("neo-hookean", young, poisson);
    scene.cell = 0.5;
    scene.min = {0, 0, 0}, scene.max = {24, 24, 0};
    scene.bodies[0].min = {0, 18, 0}, scene.bodies[0].max = {length, 18 + height, 0};
    scene.walls[0][0].kind = WallKind::no_slip;
    scene.transfer = Transfer::flip;
    scene.damping = 0.7;
    TractionSpec t = traction(scene, {1, 0, 0}, 0);
    t.shear = {0, -stiffness / (length * length) / height, 0};  // P L^2 / (E I) = 1
    scene.course.tractions = {t};
    Run<> run(scene);
    while (run.time() < 45) run.steps(100);
    double sinks = 0, comes = 0, count = 0;
    run.sum([&](const auto&, std::uint32_t, const auto& X, const auto& x) {
        if (X[0] > length - scene.cell) sinks += X[1] - x[1], comes += X[0] - x[0], ++count;
        return 0.0;
    });
    say(fmt::format(
        "plate, P L^2 / (E I) = 1: sinks by {:.4f} L (0.3017), comes in by {:.4f} L (0.0564), moves {:.2g} m/s",
        sinks / count / length, comes / count / length, totals_of(run.sim).speed.value));
    CHECK(sinks / count / length == doctest::Approx(0.3017).epsilon(0.03));
    CHECK(comes / count / length == doctest::Approx(0.0564).epsilon(0.08));
}
