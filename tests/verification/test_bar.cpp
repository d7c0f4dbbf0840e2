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

struct Motion {
    const char* name;
    bool periodic;
    double drift;  ///< [m/s]
};
constexpr Motion free_end{"fixed-free", false, 0};
constexpr Motion standing{"periodic", true, 0};
constexpr Motion adrift{"periodic, drift at Mach 0.05", true, 0.5};

Scene bar_scene(const Bar& bar, const Choice& choice, const Motion& motion) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 4 * bar.length / cells_per_wave;
    const bool periodic = motion.periodic;
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
    body.velocity[0] = motion.drift;
    scene.bodies.push_back(body);
    return scene;
}

Ringing ring(const Choice& choice, double periods, const Motion& motion) {
    const Bar bar;
    const double drift = motion.drift;
    const Scene scene = bar_scene(bar, choice, motion);
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
    const double volume = (motion.periodic ? 4 : 1) * bar.length * scene.max[1];
    return {frequency / bar.frequency() - 1, energy / std::round(steps_per_period) / bar.energy(volume)};
}

Ringing report(const Choice& choice, double periods, const Motion& motion) {
    const Ringing r = ring(choice, periods, motion);
    say(fmt::format("E1 {}, {}, {} periods: dfreq {:+.2e}, E/E0 {:.4f}", choice.name, motion.name, periods,
                    r.frequency_error, r.energy));
    return r;
}

struct Bounds {
    double dfreq, least, most;
};

void check(const Choice& choice, double periods, const Bounds& bounds, const Motion& motion) {
    const Ringing r = report(choice, periods, motion);
    CHECK(std::fabs(r.frequency_error) <= bounds.dfreq);
    CHECK(r.energy >= bounds.least);
    CHECK(r.energy <= bounds.most);
}

}  // namespace

TEST_CASE("E1: APIC keeps frequency and energy over 100 periods, at rest and adrift, at the GATE") {
    check(quadratic_apic_usl, 100, {.dfreq = 2.5e-3, .least = 0.9, .most = 1.02}, free_end);
    check(quadratic_apic_usl, 100, {.dfreq = 2.5e-3, .least = 0.9, .most = 1.02}, adrift);
}

TEST_CASE("E1: the paper's FLIP and USL keeps frequency and energy over 100 periods at the GATE") {
    check(gimp_flip_usl, 100, {.dfreq = 2.5e-3, .least = 0.9, .most = 1.02}, free_end);
    check(contiguous_flip_usl, 100, {.dfreq = 2.5e-3, .least = 0.9, .most = 1.02}, adrift);
}

TEST_CASE("E1: every other method keeps frequency and energy over 10 periods within its own bounds") {
    const Bounds common{.dfreq = 4e-3, .least = 0.98, .most = 1.005};
    for (const Choice& choice : {quadratic_flip_usl, quadratic_tpic_usl, quadratic_apic_usf, quadratic_apic_musl,
                                 cubic_flip_usl, cubic_apic_usl, gimp_tpic_usl, contiguous_tpic_usl})
        for (const Motion& motion : {free_end, adrift}) check(choice, 10, common, motion);
    check(quadratic_flip_musl, 10, common, free_end);
}

TEST_CASE("E1: FLIP with MUSL gains energy once the bar drifts, so USL is the default of FLIP") {
    const Ringing r = report(quadratic_flip_musl, 100, adrift);
    CHECK(r.energy > 2);
}

TEST_CASE("E1: all methods over 100 periods" * doctest::skip(!long_tests())) {
    for (const Choice& choice : {quadratic_flip_usl, quadratic_flip_musl, quadratic_apic_usl, quadratic_apic_usf,
                                 quadratic_apic_musl, quadratic_tpic_usl, cubic_flip_usl, cubic_apic_usl, gimp_flip_usl,
                                 gimp_tpic_usl, contiguous_flip_usl, contiguous_tpic_usl})
        for (const Motion& motion : {free_end, standing, adrift}) report(choice, 100, motion);
}
