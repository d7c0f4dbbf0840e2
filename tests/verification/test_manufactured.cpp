// E3: the manufactured displacement converges at second order, periodic and between walls, in 1-D and 2-D.
#include "verification/drive.hpp"
#include "verification/exact_manufactured.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

constexpr double cfl = 0.2;

struct Error {
    double displacement = 0;  ///< rms over A, largest over one period
    double stress = 0;        ///< rms at that time over E A pi
};

/// Square or (one moving axis) a strip: over [0, 2] periodic, or over [0, 1] between walls.
Scene square(const Manufactured& exact, int cells_per_wave, const Choice& choice, bool periodic) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 2.0 / cells_per_wave;
    const double side = periodic ? 2 : 1;
    scene.max = {side, exact.axes == 2 ? side : 4 * scene.cell, 0};
    choose(scene, choice);
    for (std::size_t a = 0; a < 2; ++a) {
        if (periodic || static_cast<int>(a) >= exact.axes)
            make_periodic(scene, a);
        else
            scene.walls[a][0].kind = scene.walls[a][1].kind = WallKind::free_slip;
    }
    const double modulus = exact.lambda() + 2 * exact.mu();
    scene.dt = cfl * scene.cell / std::sqrt(modulus / exact.density);
    scene.materials.push_back(
        material("neo-hookean", exact.density, {{"young", exact.young}, {"poisson", exact.poisson}}));
    BodySpec body;
    body.max = scene.max;
    if (exact.axes == 1) body.particles_per_cell[1] = 1;
    scene.bodies.push_back(body);
    return scene;
}

void start(Run<>& run, const Manufactured& exact, double dt) {
    run.start_with([&](const auto& p, std::uint32_t s, const auto& X) {
        for (int a = 0; a < 2; ++a) {
            const double x = X[static_cast<std::size_t>(a)];
            p.velocity[s][a] = exact.velocity(a, x, -dt / 2);
            if (p.affine) p.affine[s](a, a) = exact.stretch_rate(a, x, -dt / 2);
        }
    });
}

Error deviation(Run<>& run, const Manufactured& exact, const Scene& scene) {
    const double t = run.time();
    Error e;
    double count = run.sum([](const auto&...) { return 1; });
    e.displacement = run.sum([&](const auto&, std::uint32_t, const auto& X, const auto& x) {
        double square = 0;
        for (std::size_t a = 0; a < 2; ++a) {
            const double error = x[a] - X[a] - exact.displacement(static_cast<int>(a), X[a], t);
            square += std::pow(std::remainder(error, scene.max[a]), 2);
        }
        return square;
    });
    e.stress = run.sum([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
        double square = 0;
        for (int a = 0; a < exact.axes; ++a) square += std::pow(p.stress[s](a, a) - exact.stress(a, X, t), 2);
        return square;
    });
    e.displacement = std::sqrt(e.displacement / count) / exact.amplitude;
    e.stress = std::sqrt(e.stress / count) / (exact.young * exact.amplitude * pi);
    return e;
}

Error manufacture(const Manufactured& exact, int cells_per_wave, const Choice& choice, bool periodic) {
    const Scene scene = square(exact, cells_per_wave, choice, periodic);
    Run<> run(scene, [&](const auto& X, double t) {
        return Vec<double, 2>{{exact.body_force(0, X, t), exact.body_force(1, X, t)}};
    });
    start(run, exact, scene.dt);
    Error worst;
    const auto steps = static_cast<int>(std::lround(exact.period() / scene.dt));
    for (int part = 1; part <= 16; ++part) {
        run.steps(steps * part / 16 - steps * (part - 1) / 16);
        const Error now = deviation(run, exact, scene);
        worst.displacement = std::max(worst.displacement, now.displacement);
        worst.stress = std::max(worst.stress, now.stress);
    }
    return worst;
}

/// Runs `cells` per wavelength one after another, prints all, returns the order over the last two rungs.
struct Orders {
    double displacement, stress;
    Error finest;
};

Orders converge(double amplitude, int axes, bool periodic, const Choice& choice, const std::vector<int>& cells) {
    const Manufactured exact{.amplitude = amplitude, .poisson = axes == 1 ? 0 : 0.3, .axes = axes};
    Orders last{};
    std::string line;
    for (int n : cells) {
        const Error e = manufacture(exact, n, choice, periodic);
        last = {order(last.finest.displacement, e.displacement), order(last.finest.stress, e.stress), e};
        line += fmt::format("; {}: u {:.2e}, stress {:.2e}", n, e.displacement, e.stress);
    }
    say(fmt::format("E3 A = {}, {}-D {}, {}{}; p {:.2f}, {:.2f}", amplitude, axes, periodic ? "periodic" : "walls",
                    choice.name, line, last.displacement, last.stress));
    return last;
}

constexpr double small = 1e-4;  ///< no particle changes its cell
constexpr double large = 0.05;  ///< they do from 16 cells on

}  // namespace

TEST_CASE("E3: at small amplitude the displacement converges at the GATE of order 1.9 in 1-D") {
    for (const Choice& choice : {quadratic_flip_usl, quadratic_apic_usl, quadratic_apic_musl, gimp_flip_usl,
                                 contiguous_tpic_usl, cubic_apic_usl})
        for (bool periodic : {true, false}) {
            const Orders r = converge(small, 1, periodic, choice, {32, 64});
            CHECK(r.displacement >= 1.9);
            CHECK(r.finest.displacement <= 0.015);
        }
}

TEST_CASE("E3: splines converge in stress at the same order, GIMP at first order") {
    for (const Choice& choice : {quadratic_flip_usl, quadratic_apic_usl, cubic_apic_usl})
        for (bool periodic : {true, false}) CHECK(converge(small, 1, periodic, choice, {32, 64}).stress >= 1.9);
    CHECK(converge(small, 1, true, gimp_flip_usl, {32, 64}).stress >= 0.9);
}

TEST_CASE("E3: at small amplitude the displacement converges at the GATE of order 1.9 in 2-D") {
    for (const Choice& choice : {quadratic_flip_usl, quadratic_apic_usl, gimp_flip_usl})
        for (bool periodic : {true, false}) CHECK(converge(small, 2, periodic, choice, {16, 32}).displacement >= 1.9);
    const Orders fine = converge(small, 2, true, quadratic_apic_usl, {32, 64});
    CHECK(fine.displacement >= 1.9);  // fine enough to see 2 % of the body force
    CHECK(fine.finest.displacement <= 8e-3);
}

TEST_CASE("E3: with cell crossing the displacement converges at the GATE of order 1.5 up to 64 cells") {
    for (const Choice& choice : {quadratic_flip_usl, quadratic_apic_usl, gimp_flip_usl, contiguous_tpic_usl})
        for (bool periodic : {true, false}) CHECK(converge(large, 1, periodic, choice, {32, 64}).displacement >= 1.5);
    CHECK(converge(large, 2, true, quadratic_apic_usl, {32, 64}).displacement >= 1.5);
    CHECK(converge(large, 2, false, quadratic_flip_usl, {32, 64}).displacement >= 1.5);
}

TEST_CASE("E3: with cell crossing contiguous GIMP converges at second order in stress too") {
    CHECK(converge(large, 1, true, contiguous_tpic_usl, {32, 64}).stress >= 1.8);
    CHECK(converge(large, 2, false, contiguous_tpic_usl, {32, 64}).stress >= 1.8);
}

TEST_CASE("E3: long ladders" * doctest::skip(!long_tests())) {
    for (double amplitude : {small, large})
        for (const Choice& choice : {quadratic_flip_usl, quadratic_apic_usl, gimp_flip_usl, contiguous_flip_usl,
                                     contiguous_tpic_usl, cubic_flip_usl, cubic_apic_usl})
            converge(amplitude, 1, true, choice, {16, 32, 64, 128, 256, 512});
}
