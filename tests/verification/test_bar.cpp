// E1: a vibrating elastic bar keeps its frequency and its energy, at rest and adrift.
#include "core/courant.hpp"
#include "verification/drive.hpp"
#include "verification/problem_bar.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

Ringing ring(const Choice& choice, double periods, const Motion& motion, double cfl = 0.4) {
    const Bar bar{.speed = motion.speed};
    const Scene scene = bar_scene(bar, choice, motion, 64, cfl);
    Run<> run(scene);
    return ring(run, bar, periods, motion);
}

Ringing report(const Choice& choice, double periods, const Motion& motion, double cfl = 0.4) {
    const Ringing r = ring(choice, periods, motion, cfl);
    say(fmt::format("E1 {}, {}, {} periods: dfreq {:+.2e}, E/E0 {:.4f}", choice.name, motion.name, periods,
                    r.frequency_error, r.energy));
    return r;
}

struct Bounds {
    double dfreq, least, most;
};

void check(const Choice& choice, double periods, const Bounds& bounds, const Motion& motion, double cfl = 0.4) {
    const Ringing r = report(choice, periods, motion, cfl);
    CHECK(std::fabs(r.frequency_error) <= bounds.dfreq);
    CHECK(r.energy >= bounds.least);
    CHECK(r.energy <= bounds.most);
}

/// Energy, over that at the start, of stresses that alternate from particle to particle, their amplitude a wave of some
/// three cells, after some periods adrift at the program's step. No node feels them where the particles begin.
double alternating_stress(const Choice& choice, int periods) {
    const Bar bar;
    Scene scene = bar_scene(bar, choice, faint_adrift, 64, 1);
    scene.dt *= standard_courant(scene) / (1 + faint_adrift.drift / bar.wave_speed());
    Run<> run(scene);
    constexpr double amplitude = 1e-6;  // over E
    run.start_with([&](const auto& p, std::uint32_t s, const auto& X) {
        const double sign = std::lround(2 * X[0] / scene.cell - 0.5) % 2 == 0 ? 1 : -1;
        p.velocity[s][0] = faint_adrift.drift;
        p.stress[s][0] = sign * amplitude * bar.young * std::cos(21 * bar.wave_number() * X[0]);
    });
    const auto energy = [&] {
        return run.sum([&](const auto& p, std::uint32_t s, const auto&, const auto&) {
            const double u = p.velocity[s][0] - faint_adrift.drift;
            return 0.5 * p.mass[s] * u * u + 0.5 * p.volume[s] * p.stress[s][0] * p.stress[s][0] / bar.young;
        });
    };
    const double start = energy();
    run.steps(static_cast<int>(std::ceil(periods * bar.period() / scene.dt)));
    const double left = energy() / start;
    say(fmt::format("E1 {}, alternating stresses adrift, {} periods: E/E0 {:.2e}", choice.name, periods, left));
    return left;
}

}  // namespace

TEST_CASE("E1: APIC keeps frequency and energy over 100 periods, at rest and adrift, at the limit") {
    check(quadratic_apic_usl, 100, {.dfreq = 2.5e-3, .least = 0.9, .most = 1.02}, free_end);
    check(quadratic_apic_usl, 100, {.dfreq = 2.5e-3, .least = 0.9, .most = 1.02}, adrift);
}

TEST_CASE("E1: the paper's FLIP and USL keeps frequency and energy over 100 periods at the limit") {
    check(gimp_flip_usl, 100, {.dfreq = 2.5e-3, .least = 0.9, .most = 1.02}, free_end);
    check(contiguous_flip_usl, 100, {.dfreq = 2.5e-3, .least = 0.9, .most = 1.02}, adrift);
}

TEST_CASE("E1: FMPM(3) keeps frequency and energy over 100 periods at the goal, at rest and adrift") {
    for (const Motion& motion : {faint_free_end, faint_adrift})
        check(quadratic_fmpm3, 100, {.dfreq = 1e-4, .least = 0.99, .most = 1.01}, motion, 0.3);
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

TEST_CASE("E1: stresses that alternate grow adrift with AFLIP and USL, and fade with USF") {
    CHECK(alternating_stress(quadratic_aflip_usl, 40) > 30);
    CHECK(alternating_stress(quadratic_aflip_usf, 40) < 1e-3);
    CHECK(alternating_stress(cubic_aflip_usl, 40) < 3);
}

TEST_CASE("E1: all methods over 100 periods" * doctest::skip(!long_tests())) {
    for (const Choice& choice : {quadratic_flip_usl, quadratic_flip_musl, quadratic_apic_usl, quadratic_apic_usf,
                                 quadratic_apic_musl, quadratic_tpic_usl, cubic_flip_usl, cubic_apic_usl, gimp_flip_usl,
                                 gimp_tpic_usl, contiguous_flip_usl, contiguous_tpic_usl})
        for (const Motion& motion : {free_end, standing, adrift}) report(choice, 100, motion);
    for (const Choice& choice : {quadratic_apic_usl, contiguous_tpic_usl, gimp_flip_usl, quadratic_fmpm2,
                                 quadratic_fmpm3, quadratic_fmpm4, contiguous_fmpm2})
        for (const Motion& motion : {faint_free_end, faint_adrift}) report(choice, 100, motion, 0.3);
}
