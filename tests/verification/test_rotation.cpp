// E7: a free square turns for 20 s and keeps its angular momentum, to rounding with APIC, and its energy.
#include "verification/drive.hpp"
#include "verification/problem_rotation.hpp"

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

Turning rotate(const Choice& choice, double cell) {
    const Spin spin;
    const Scene scene = spin_scene(spin, choice, cell, young);
    const double D = affine_moment(scene);
    Run<> run(scene);
    turn(run, spin);
    const auto start = angular_momentum(run, D);
    const double start_energy = spin_energy(run, D);
    Turning r;
    for (int part = 1; part <= 20; ++part) {
        while (run.time() < duration() * part / 20) run.steps(20);
        const auto now = angular_momentum(run, D);
        r.particles = std::max(r.particles, std::fabs(now[0] / start[0] - 1));
        r.momentum = std::max(r.momentum, std::fabs(now[1] / start[1] - 1));
    }
    r.loss = 1 - spin_energy(run, D) / start_energy;
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
