// What a transfer takes of a velocity that varies over a few cells: a shear wave v_x = V sin(k y) of a fluid without
// viscosity stands for ever. It is a loss per step, c (k h)^4 of the amplitude, so a viscosity c k^2 h^4 / dt.
#include "verification/drive.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

/// So many cells over a wave, all sides periodic; waves of pressure at 75 m/s, which a shear wave has none of.
Scene wave_scene(int cells, const Choice& choice, double cfl) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 0.1;
    scene.max = {4 * scene.cell, cells * scene.cell, 0};
    scene.cfl = cfl;
    choose(scene, choice);
    for (std::size_t a = 0; a < 2; ++a) make_periodic(scene, a);
    scene.materials.push_back(material("newtonian", 1500, {{"young", 2.5e5}, {"poisson", 0.495}, {"viscosity", 0}}));
    BodySpec body;
    body.max = scene.max;
    body.wave = {.velocity = {0.01, 0, 0}, .axis = 1, .wavelength = scene.max[1]};
    scene.bodies.push_back(body);
    return scene;
}

/// Of the amplitude, in a step, over (k h)^4. The first steps fill the affine field and are not counted.
double loss(int cells, const Choice& choice, double cfl = 0.4) {
    Run<> run(wave_scene(cells, choice, cfl));
    const auto energy = [&] {
        return run.sum([](const auto& p, std::uint32_t s, const auto&, const auto&) {
            return p.velocity[s][0] * p.velocity[s][0];
        });
    };
    run.steps(20);
    const double before = energy();
    constexpr int steps = 100;
    run.steps(steps);
    const double lost = 0.5 * std::log(before / energy()) / steps / std::pow(2 * pi / cells, 4);
    say(fmt::format("shear wave of {} cells, {}, CFL {}: loses {:.4f} (k h)^4 a step", cells, choice.name, cfl, lost));
    return lost;
}

/// Share by which two losses differ. (doctest's Approx takes a share of 1 + the value, which is none of a small one.)
double apart(double a, double b) {
    return std::fabs(a / b - 1);
}

}  // namespace

TEST_CASE("APIC takes 0.024 (k h)^4 of a shear wave in a step, however short the step is") {
    for (const int cells : {12, 24, 48}) CHECK(apart(loss(cells, quadratic_apic_usl), 0.024) < 0.05);
    CHECK(apart(loss(24, quadratic_apic_usl, 0.05), loss(24, quadratic_apic_usl)) < 1e-3);
}

TEST_CASE("of a shear wave AFLIP takes a twentieth of what APIC does, FLIP nothing, and cubic APIC twice as much") {
    const double apic = loss(24, quadratic_apic_usl);
    CHECK(apart(loss(24, quadratic_aflip_usl), apic / 20) < 0.05);
    CHECK(std::fabs(loss(24, quadratic_flip_usl)) < 1e-6 * apic);
    CHECK(apart(loss(24, cubic_apic_usl), 2 * apic) < 0.05);
    CHECK(apart(loss(24, quadratic_tpic_usl), 4 * apic / 3) < 0.02);
}
