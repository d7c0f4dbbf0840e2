// Properties over depth against closed forms: stresses under layers of their own densities, the settlement of a column
// that gets stiffer, a slope that slips in a seam of low friction, a step by the fastest of its layers.
#include "seeding/property_profile.hpp"
#include "simulation/rest_watch.hpp"
#include "verification/drive.hpp"
#include "verification/problem_column.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

constexpr double height = 8, poisson = 0.3, k0 = poisson / (1 - poisson);

ProfileSpec line(double surface, double gradient) {
    ProfileSpec p;
    p.surface = surface, p.gradient = gradient;
    return p;
}

ProfileSpec layers(std::vector<double> depth, std::vector<double> value) {
    ProfileSpec p;
    p.depth = std::move(depth), p.value = std::move(value);
    return p;
}

/// A periodic strip under gravity 10 m/s2.
Scene strip(const MaterialSpec& soil, int cells = 16) {
    const Column column{.height = height, .young = 1e7, .density = 1000, .gravity = 10};
    Scene scene = column_scene(column, cells, quadratic_apic_usl, "linear-elastic", true);
    scene.materials = {soil};
    scene.damping = 0;
    scene.end = 1e3;
    return scene;
}

MaterialSpec elastic(double young, double density) {
    return material("linear-elastic", density, {{"young", young}, {"poisson", poisson}});
}

constexpr std::size_t young = 0, density = 2;  // properties of linear-elastic

/// Over the pressure at the base, the largest difference of a stress component from what is above, per 10 m/s2.
double stress_error(Run<>& run, const std::function<double(double depth)>& mass) {
    return run.largest([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
        const double exact = -10 * mass(height - X[1]);
        const double across = std::fabs(p.stress[s](0, 0) - k0 * exact);
        return std::max(std::fabs(p.stress[s](1, 1) - exact), across) / (10 * mass(height));
    });
}

}  // namespace

TEST_CASE("layers of their own densities begin under the exact weight above, and stay") {
    MaterialSpec soil = elastic(1e7, 1400);
    set_profile(soil, density, layers({2, 2 + 1e-9, 5, 5 + 1e-9}, {1400, 1800, 1800, 2200}));
    Scene scene = strip(soil);
    scene.bodies[0].geostatic = true;
    scene.bodies[0].geostatic_surface = height;
    scene.bodies[0].geostatic_k0 = k0;
    Run run(scene);
    const auto mass = [](double depth) {
        return 1400 * std::min(depth, 2.0) + 1800 * std::clamp(depth - 2, 0.0, 3.0) + 2200 * std::max(depth - 5, 0.0);
    };
    const double all = run.sum([](const auto& p, std::uint32_t s, const auto&, const auto&) { return p.mass[s]; });
    CHECK(all == doctest::Approx(mass(height) * scene.max[0]).epsilon(1e-12));
    CHECK(stress_error(run, mass) < 1e-9);
    while (run.time() < 4 * height / std::sqrt(1.35e7 / 1400)) run.steps(1);
    const double moved =
        run.largest([](const auto&, std::uint32_t, const auto& X, const auto& x) { return std::fabs(x[1] - X[1]); });
    MESSAGE("moved " << moved / scene.cell << " h, stress " << stress_error(run, mass));
    CHECK(moved < 1e-3 * scene.cell);
    CHECK(stress_error(run, mass) < 0.02);
}

TEST_CASE("a column that gets stiffer with depth settles by the exact integral, whatever its law") {
    constexpr double surface = 1e6, gradient = 1e6, rho = 1000, g = 0.1;
    const double ratio = (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson));
    const double exact =
        rho * g / (ratio * gradient) * (height - surface / gradient * std::log(1 + gradient * height / surface));
    for (const char* law : {"linear-elastic", "neo-hookean", "tresca"}) {
        CAPTURE(std::string(law));
        MaterialSpec soil = material(law, rho, {{"young", 1}, {"poisson", poisson}, {"su", 1e9}});
        set_profile(soil, young, line(surface, gradient));
        soil.parameters[young] = surface + gradient * height;
        Scene scene = strip(soil);
        scene.gravity[1] = -g;
        scene.damping = 0.7;
        scene.rest.displacement = 1e-6;
        scene.rest.mass = 1;
        Run run(scene);
        const Comm comm(MPI_COMM_WORLD);
        RestWatch<2> watch(scene, comm);
        watch.look(run.sim);
        while (!watch.is_at_rest()) {
            run.sim.step();
            watch.look(run.sim);
        }
        run.sim.conclude();
        const double top = height - 0.25 * scene.cell;  // the highest row
        const double settled = run.largest([&](const auto&, std::uint32_t, const auto& X, const auto& x) {
            return X[1] > top - 1e-9 ? X[1] - x[1] : 0.0;
        });
        MESSAGE(std::string(law) << ": settled " << settled / exact << " of the exact integral");
        CHECK(settled == doctest::Approx(exact).epsilon(0.01));
    }
}

TEST_CASE("a slope slips in its seam of low friction, and what lies on it goes with its acceleration") {
    constexpr double beta = 20 * pi / 180, phi = 10 * pi / 180;
    MaterialSpec soil =
        material("drucker-prager", 1600, {{"young", 1e7}, {"poisson", 0.45}, {"friction_angle", 30}, {"cohesion", 0}});
    set_profile(soil, 2, layers({4, 4 + 1e-9, 5, 5 + 1e-9}, {30, 10, 10, 30}));
    Scene scene = strip(soil, 32);  // 4 cells in the seam
    choose(scene, quadratic_flip_usl);
    scene.walls[1][0].kind = WallKind::no_slip;
    scene.gravity = {10 * std::sin(beta), -10 * std::cos(beta), 0};
    scene.bodies[0].geostatic = true;
    scene.bodies[0].geostatic_surface = height;
    scene.bodies[0].geostatic_k0 = 0.8;
    Run run(scene);
    const auto speed = [&] {
        double mass = 0, momentum = 0;
        mass = run.sum([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
            return X[1] > height - 4 ? p.mass[s] : 0.0;
        });
        momentum = run.sum([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
            return X[1] > height - 4 ? p.mass[s] * p.velocity[s][0] : 0.0;
        });
        return momentum / mass;
    };
    while (run.time() < 0.5) run.steps(1);
    const double before = speed(), from = run.time();
    while (run.time() < 1) run.steps(1);
    const double found = (speed() - before) / (run.time() - from);
    const double exact = 10 * (std::sin(beta) - std::cos(beta) * std::sin(phi));  // shear without dilation
    const auto plastic = [&](double low, double high) {
        return run.largest([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
            return X[1] > low && X[1] < high ? p.history[0][s] : 0.0;
        });
    };
    MESSAGE("acceleration " << found / exact << ", plastic above " << plastic(4.5, 8) << ", seam " << plastic(3, 4)
                            << ", below " << plastic(0, 2.5));
    CHECK(found == doctest::Approx(exact).epsilon(0.02));
    CHECK(plastic(3, 4) > 0.5);
    CHECK(plastic(4.5, 8) < 0.01);
    CHECK(plastic(0, 2.5) < 0.01);
}

TEST_CASE("the step is that of the fastest layer") {
    const auto step = [](const ProfileSpec& of_young, const ProfileSpec& of_density) {
        MaterialSpec soil = elastic(1e6, 1000);
        set_profile(soil, young, of_young);
        set_profile(soil, density, of_density);
        Run run(strip(soil));
        run.steps(1);
        return run.time();
    };
    const double one = step(line(1e6, 0), line(1000, 0));
    CHECK(step(layers({4, 4.1}, {1e6, 4e6}), line(1000, 0)) == doctest::Approx(0.5 * one).epsilon(1e-9));
    CHECK(step(line(1e6, 0), layers({4, 4.1}, {250, 1000})) == doctest::Approx(0.5 * one).epsilon(1e-9));
}
