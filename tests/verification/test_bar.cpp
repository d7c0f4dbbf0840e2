// E1: a vibrating elastic bar keeps its frequency and its energy, at rest and adrift.
#include "verification/drive.hpp"
#include "verification/exact_bar.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

constexpr double cells_per_wave = 64;
constexpr double cfl = 0.4;

/// Frequency and energy of the mode over whole periods, against the exact ones.
struct Ringing {
    double frequency_error;  ///< w / w_exact - 1
    double energy;           ///< E / E0, mean over the last period
};

Scene bar_scene(const Bar& bar, const Choice& choice, bool periodic, double drift) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 4 * bar.length / cells_per_wave;
    const double length = periodic ? 4 * bar.length : bar.length;
    scene.max = {periodic ? length : 1.25 * length, 4 * scene.cell, 0};
    choose(scene, choice);
    make_periodic(scene, 1);
    if (periodic) make_periodic(scene, 0);
    if (!periodic) scene.walls[0][0].kind = WallKind::free_slip;
    scene.dt = cfl * scene.cell / bar.wave_speed();
    scene.materials.push_back(material("linear-elastic", bar.density, {{"young", bar.young}, {"poisson", 0}}));
    BodySpec body;
    body.max = {length, scene.max[1], 0};
    body.particles_per_cell = {2, 1, 1};
    body.velocity[0] = drift;
    scene.bodies.push_back(body);
    return scene;
}

Ringing ring(const Choice& choice, double periods, bool periodic, double drift) {
    const Bar bar;
    const Scene scene = bar_scene(bar, choice, periodic, drift);
    Run<> run(scene);
    run.start_with([&](const auto& p, std::uint32_t s, const auto& X) {
        p.velocity[s][0] = drift + bar.velocity(X[0], -scene.dt / 2);
        if (p.affine)  // the gradient of that velocity
            p.affine[s](0, 0) = bar.speed * bar.wave_number() * std::cos(bar.wave_number() * X[0]);
    });
    const double steps_per_period = bar.period() / scene.dt;
    const auto last = static_cast<std::int64_t>(std::lround(periods * steps_per_period));
    double before = 1, crossings = 0, first_crossing = 0, last_crossing = 0, energy = 0;
    for (std::int64_t step = 1; step <= last; ++step) {
        run.steps(1);
        const double amplitude = run.sum([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
            return p.mass[s] * (p.velocity[s][0] - drift) * bar.shape(X[0]);
        });
        const double t = (static_cast<double>(step) - 0.5) * scene.dt;
        if ((before < 0) != (amplitude < 0)) {
            last_crossing = t - scene.dt * amplitude / (amplitude - before);
            if (crossings++ == 0) first_crossing = last_crossing;
        }
        before = amplitude;
        if (static_cast<double>(last - step) >= steps_per_period - 0.5) continue;
        const auto totals = run.sim.totals();
        energy += totals.kinetic + totals.strain - drift * totals.momentum[0] + 0.5 * drift * drift * totals.mass;
    }
    const double frequency = pi * (crossings - 1) / (last_crossing - first_crossing);
    const double volume = (periodic ? 4 : 1) * bar.length * scene.max[1];
    return {frequency / bar.frequency() - 1, energy / std::round(steps_per_period) / bar.energy(volume)};
}

void check(const Choice& choice, double periods, bool periodic, double drift, double frequency_bound,
           double least_energy, double most_energy) {
    const Ringing r = ring(choice, periods, periodic, drift);
    MESSAGE(fmt::format("E1 {} {}, drift {}, {} periods: dfreq {:+.2e}, E/E0 {:.4f}", choice.name,
                        periodic ? "periodic" : "fixed-free", drift, periods, r.frequency_error, r.energy));
    CHECK(std::fabs(r.frequency_error) <= frequency_bound);
    CHECK(r.energy >= least_energy);
    CHECK(r.energy <= most_energy);
}

}  // namespace

TEST_CASE("explore") {
    const double n = 100;
    for (const Choice& c : {quadratic_flip_usl, quadratic_flip_musl, quadratic_apic_usl, quadratic_apic_usf, quadratic_apic_musl, quadratic_tpic_usl, cubic_flip_usl, cubic_apic_usf,
                            gimp_flip_usl, gimp_tpic_usl, contiguous_flip_usl, contiguous_tpic_usl}) {
        auto t0 = std::chrono::steady_clock::now();
        check(c, n, false, 0, 2.5e-3, 0.9, 1.02);
        check(c, n, true, 0, 2.5e-3, 0.9, 1.02);
        check(c, n, true, 0.5, 2.5e-3, 0.9, 1.02);
        MESSAGE(std::chrono::duration<double>(std::chrono::steady_clock::now() - t0).count());
    }
}
