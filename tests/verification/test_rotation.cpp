// E7: a free square turns for 20 s and keeps its angular momentum, to rounding with APIC, and its energy.
#include "verification/drive.hpp"
#include "verification/exact_rotation.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

constexpr double young = 1e6;  ///< [Pa]

/// [s]; several ranks share few cores in the tests, and need only show that they say the same.
double duration() {
    int ranks = 1;
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    return ranks == 1 ? 20 : 1;
}

struct Turning {
    double momentum = 0;   ///< largest |L / L0 - 1| at 20 times
    double particles = 0;  ///< the same without the affine part, over the first
    double loss = 0;       ///< 1 - E / E0 at the end, kinetic (affine part included) and elastic
    double stress = 0;     ///< largest component at the end over E
};

Scene spin_scene(const Spin& spin, const Choice& choice, double cell) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = cell;
    scene.max = {14, 14, 0};
    choose(scene, choice);
    scene.cfl = 0.4;
    scene.materials.push_back(material("linear-elastic", spin.density, {{"young", young}, {"poisson", 0.3}}));
    BodySpec body;
    body.min = {1, 1, 0};
    body.max = {1 + spin.side, 1 + spin.side, 0};
    scene.bodies.push_back(body);
    return scene;
}

void turn(Run<>& run, const Spin& spin) {
    const double centre = 1 + spin.side / 2;
    run.start_with([&](const auto& p, std::uint32_t s, const auto& X) {
        p.velocity[s][0] = spin.drift - spin.rate * (X[1] - centre);
        p.velocity[s][1] = spin.drift + spin.rate * (X[0] - centre);
        if (p.affine) p.affine[s](0, 1) = -spin.rate, p.affine[s](1, 0) = spin.rate;
    });
}

/// Angular momentum about the domain's corner: of the particles, and with the affine part.
std::array<double, 2> angular_momentum(Run<>& run, double D) {
    const double particles = run.sum([&](const auto& p, std::uint32_t s, const auto&, const auto& x) {
        return p.mass[s] * (x[0] * p.velocity[s][1] - x[1] * p.velocity[s][0]);
    });
    const double affine = run.sum([&](const auto& p, std::uint32_t s, const auto&, const auto&) {
        return p.affine ? p.mass[s] * D * (p.affine[s](1, 0) - p.affine[s](0, 1)) : 0;
    });
    return {particles, particles + affine};
}

double energy(Run<>& run, double D) {
    const auto totals = run.sim.totals();
    return totals.kinetic + totals.strain + run.sum([&](const auto& p, std::uint32_t s, const auto&, const auto&) {
        double square = 0;
        for (int a = 0; p.affine && a < 2; ++a)
            for (int b = 0; b < 2; ++b) square += p.affine[s](a, b) * p.affine[s](a, b);
        return 0.5 * p.mass[s] * D * square;
    });
}

Turning rotate(const Choice& choice, double cell) {
    const Spin spin;
    const Scene scene = spin_scene(spin, choice, cell);
    const double D = scene.cell * scene.cell / (choice.shape == Shape::cubic ? 3 : 4);
    Run<> run(scene);
    turn(run, spin);
    const auto start = angular_momentum(run, D);
    const double start_energy = energy(run, D);
    Turning r;
    for (int part = 1; part <= 20; ++part) {
        while (run.time() < duration() * part / 20) run.steps(20);
        const auto now = angular_momentum(run, D);
        r.particles = std::max(r.particles, std::fabs(now[0] / start[0] - 1));
        r.momentum = std::max(r.momentum, std::fabs(now[1] / start[1] - 1));
    }
    r.loss = 1 - energy(run, D) / start_energy;
    r.stress = run.largest([&](const auto& p, std::uint32_t s, const auto&, const auto&) {
        double most = 0;
        for (int k = 0; k < 4; ++k) most = std::max(most, std::fabs(p.stress[s][k]) / young);
        return most;
    });
    return r;
}

Turning report(const Choice& choice, double cell = 0.1) {
    const Turning r = rotate(choice, cell);
    say(fmt::format("E7 {}: dL {:.1e} (particles alone {:.1e}), dE {:+.2e}, stress {:.1e} E", choice.name, r.momentum,
                    r.particles, r.loss, r.stress));
    return r;
}

}  // namespace

TEST_CASE("E7: APIC keeps angular momentum to rounding and loses less than 1e-4 of the energy in 20 s") {
    for (const Choice& choice : {quadratic_apic_usl, quadratic_apic_musl}) {
        const Turning r = report(choice);
        CHECK(r.momentum <= 1e-12);
        CHECK(r.loss >= 0);
        CHECK(r.loss <= 1e-4);
        CHECK(r.stress <= 5e-4);  // rho w^2 a^2 / 4 = 3.9e-4 E
    }
}

TEST_CASE("E7: TPIC keeps angular momentum and energy to 1e-4") {
    const Turning r = report(quadratic_tpic_usl);
    CHECK(r.momentum <= 1e-4);
    CHECK(std::fabs(r.loss) <= 1e-4);
}

TEST_CASE("E7: the other methods, which promise nothing" * doctest::skip(!long_tests())) {
    for (const Choice& choice : {quadratic_flip_usl, gimp_flip_usl, gimp_tpic_usl, quadratic_apic_usf, cubic_apic_usl})
        report(choice);
    say("with half the cell:");
    for (const Choice& choice : {quadratic_apic_usl, quadratic_flip_usl}) report(choice, 0.05);
}
