// Saturated soil against closed forms and against soil of total stress: cavitation, the undrained limit, slopes with
// seepage, consolidation under its own weight at large strain, pressures at rest.
#include "verification/drive.hpp"
#include "verification/pressure_noise.hpp"
#include "verification/wet_column.hpp"

using namespace moraine;
using namespace moraine::verification;
using namespace moraine::verification::wet;

namespace {

/// Poisson's ratio and Young's modulus of soil whose water stays: K' + Q, and G.
MaterialSpec undrained_clay(double E, double nu, double storage) {
    const double K = E / (3 * (1 - 2 * nu)) + storage, G = E / (2 * (1 + nu));
    MaterialSpec m = material("linear-elastic", density,
                              {{"young", 9 * K * G / (3 * K + G)}, {"poisson", (3 * K - 2 * G) / (2 * (3 * K + G))}});
    m.volumetric = Volumetric::grid;
    return m;
}

/// A block of 8 cells that stands free and settles under its weight: how far its crest has gone down and its side out.
std::array<double, 2> spread(const MaterialSpec& soil, bool wet) {
    Scene scene = column(8, 1e-12);
    scene.max = {2.5 * height, 1.5 * height, 0};
    scene.periodic[0] = false;
    for (WallSpec& wall : scene.walls[0]) wall.kind = WallKind::open;
    scene.walls[1][0].kind = WallKind::no_slip;
    scene.gravity = {0, -9.81, 0};
    scene.water.on = wet;
    scene.materials = {soil};
    scene.bodies[0].min = {0.75 * height, 0, 0}, scene.bodies[0].max = {1.75 * height, height, 0};
    Run<> run(scene);
    const auto moved = [&](std::size_t a) {
        return run.largest([&](const auto&, std::uint32_t, const auto& X, const auto& x) {
            return a == 0 ? x[0] - X[0] : X[1] - x[1];
        });
    };
    constexpr double until = 0.06;  // between steps: what moves faster and faster is there at the same time
    while (run.time() < until - 5e-4) run.steps(1);
    std::array<double, 2> gone{moved(0), moved(1)};
    const double before = run.time();
    while (run.time() < until) run.steps(1);
    const double share = (until - before) / (run.time() - before);
    for (std::size_t a = 0; a < 2; ++a) gone[a] += share * (moved(a) - gone[a]);
    return gone;
}

/// Settlement of soil that consolidates under its own weight, in stretches: d(lambda)/dT = d/dZ (lambda_Z / lambda^2 -
/// N / lambda), lambda = 1 at the drained top and lambda_Z = N lambda at the closed base (Gibson et al. 1967, with
/// sigma' = M ln J and a constant k). T: by k M / (gamma_w H^2).
double gibson(double N, double T) {
    constexpr int cells = 100;
    const double h = 1.0 / cells, dt = 0.2 * h * h;
    std::vector<double> stretch(cells, 1), flux(cells + 1, 0);
    for (double t = 0; t < T; t += dt) {
        for (int k = 1; k <= cells; ++k) {
            const double below = stretch[static_cast<std::size_t>(k - 1)];
            const double above = k < cells ? stretch[static_cast<std::size_t>(k)] : 1;
            const double face = k < cells ? 0.5 * (below + above) : 1, width = k < cells ? h : 0.5 * h;
            flux[static_cast<std::size_t>(k)] = ((above - below) / width / face - N) / face;
        }
        for (std::size_t k = 0; k < cells; ++k) stretch[k] += dt / h * (flux[k + 1] - flux[k]);
    }
    double sum = 0;
    for (const double s : stretch) sum += (1 - s) * h;
    return sum;
}

}  // namespace

TEST_CASE("water bears no more tension than it can before it cavitates") {
    constexpr double pull = 2.5e5, limit = 1e5, table = 3;
    for (const bool submerged : {false, true})
        for (const double cavitation : {limit, 1e9}) {
            Scene scene = column(10, 1e-9);
            scene.water.cavitation = cavitation;
            if (submerged) scene.gravity = {0, -9.81, 0}, scene.water.submerged = true, scene.water.table = table;
            press(scene, -pull, 0.05);
            Run<> run(scene);
            double most = 0;
            while (run.time() < 0.1) {
                run.steps(5);
                most = std::max(most, run.largest([&](const auto& p, std::uint32_t s, const auto&, const auto& x) {
                    return -p.pore_pressure[s] - (submerged ? 9810 * (table - x[1]) : 0);
                }));
            }
            say(fmt::format("cavitation at {:.0e} Pa{}: tension {:.5g} Pa", cavitation, submerged ? " under water" : "",
                            most));
            if (cavitation == limit) CHECK(std::fabs(most / limit - 1) <= 1e-3);
            if (cavitation > limit) CHECK(most >= 2 * limit);  // nothing else holds it
        }
}

TEST_CASE("soil whose water has no time to flow is clay of total stress") {
    constexpr double E = 1e6, nu = 0.3;
    MaterialSpec soil = material("linear-elastic", density, {{"young", E}, {"poisson", nu}});
    soil.porosity = porosity, soil.conductivity = 1e-12;
    soil.volumetric = Volumetric::grid;
    const auto wet = spread(soil, true), dry = spread(undrained_clay(E, nu, Q), false);
    say(fmt::format("block of undrained clay: crest {:.5f} m for {:.5f}, side {:.5f} m for {:.5f}", wet[1], dry[1],
                    wet[0], dry[0]));
    CHECK(std::fabs(wet[1] / dry[1] - 1) <= 0.01);
    CHECK(std::fabs(wet[0] / dry[0] - 1) <= 0.015);
}

TEST_CASE("a slope with seepage fails where its effective stress says") {
    constexpr double g = 9.81, k = 1e-3, phi = 32 * pi / 180, over = 0.3 * pi / 180;
    // simple shear without dilation: sin(phi) of the normal stress
    const double critical = std::atan(std::sin(phi) * (density - 1000) / density);
    for (const double slope : {critical - over, critical + over}) {
        Scene scene = column(10, k);
        scene.gravity = {g * std::sin(slope), -g * std::cos(slope), 0};
        scene.walls[1][0].kind = WallKind::no_slip;
        MaterialSpec sand =
            material("drucker-prager", density, {{"young", young}, {"poisson", poisson}, {"friction_angle", 32.0}});
        sand.porosity = porosity, sand.conductivity = k, sand.volumetric = Volumetric::grid;
        scene.materials = {sand};
        Run<> run(scene);
        run.start_with([&](const auto& p, std::uint32_t s, const auto& X) { seep(slope, k, p, s, X); });
        while (run.time() < 0.3) run.steps(50);
        const double speed =
            mean(run, [](const auto& p, std::uint32_t s, const auto&, const auto&) { return p.velocity[s][0]; });
        const double falls = std::max(0.0, g * (std::sin(slope) - std::cos(slope) * std::tan(critical)) * run.time());
        const double off = (speed - falls) / (g * run.time()) * 180 / pi;
        say(fmt::format("slope with seepage, {:+.1f} degrees: {:.2e} m/s for {:.2e}, that is {:+.3f} degrees",
                        (slope - critical) * 180 / pi, speed, falls, off));
        CHECK(std::fabs(off) <= (slope < critical ? 0.03 : 0.2));
    }
}

TEST_CASE_TEMPLATE("soft soil consolidates under its own weight", Real, double, float) {
    constexpr double N = 0.5, g = 9.81, k = 0.05, T = 0.2;
    const double soft = (density - 1000) * g * height / N;  // M
    Scene scene = column(10, k);
    scene.gravity = {0, -g, 0};
    scene.water.bulk = 2e6;
    scene.water.table = height;
    scene.materials[0] =
        material("linear-elastic", density, {{"young", soft * (1 + 0.2) * (1 - 0.4) / 0.8}, {"poisson", 0.2}});
    scene.materials[0].porosity = porosity, scene.materials[0].conductivity = k;
    scene.materials[0].volumetric = Volumetric::grid;
    Run<Real> run(scene);
    run.start_with([&](const auto& p, std::uint32_t s, const auto& X) {
        p.pore_pressure[s] = static_cast<Real>(density * g * (height - X[1]));
    });
    const double c_v = k * soft / (1000 * conductivity_gravity);
    while (run.time() < T / c_v) run.steps(50);
    const double exact = gibson(N, c_v * run.time());
    say(fmt::format("self-weight, N = {}, T = {:.3f}: settlement {:.5f} of the height for {:.5f}", N, c_v * run.time(),
                    settlement(run), exact));
    CHECK(std::fabs(settlement(run) / exact - 1) <= 0.02);
}

TEST_CASE_TEMPLATE("pressures of a bed at rest stay smooth at any conductivity", Real, double, float) {
    constexpr double g = 9.81;
    for (const double k : {1e-9, 1e-6, 1e-3}) {
        Scene scene = column(8, k);
        scene.periodic[0] = false;
        for (WallSpec& wall : scene.walls[0]) wall.kind = WallKind::free_slip;
        scene.max[0] = height;
        scene.gravity = {0, -g, 0};
        scene.water.table = height;
        scene.walls[1][0].kind = WallKind::no_slip;
        BodySpec& bed = scene.bodies[0];
        bed.max = {height, height, 0};
        bed.geostatic = true, bed.geostatic_surface = height, bed.geostatic_k0 = 0.45;
        Run<Real> run(scene);
        while (run.time() < 0.3) run.steps(50);
        const double off = std::sqrt(mean(run, [&](const auto& p, std::uint32_t s, const auto&, const auto& x) {
            return std::pow(p.pore_pressure[s] / (1000 * g * height) - (height - x[1]), 2);
        }));
        const double noise = checkerboard(run.sim);
        say(fmt::format("bed at rest, k = {:.0e}: pressures off by {:.5f} of the base's, noise {:.5f}", k, off, noise));
        CHECK(noise <= 0.01);
        CHECK(off <= 0.02);  // cells at the surface are half full
    }
}
