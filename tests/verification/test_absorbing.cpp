// Ends that absorb: what of the energy of plane waves comes back, and ground that rests on them.
#include "verification/drive.hpp"
#include "verification/wave_box.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

constexpr Choice quadratic_tpic{"quadratic TPIC USL", Shape::quadratic, Transfer::tpic, StressUpdate::usl};
constexpr Choice linear_flip{"linear FLIP USL", Shape::linear, Transfer::flip, StressUpdate::usl};

/// Ground at rest on ends that absorb below and beside it.
Scene resting(Precision precision) {
    Scene scene = wave_box({}, quadratic_apic_usl, 20);
    scene.precision = precision;
    scene.periodic[0] = false;
    for (WallSpec& wall : scene.walls[0]) wall.kind = WallKind::law, wall.absorbs = true;
    scene.walls[1][1] = {};
    scene.gravity[1] = -9.81;
    scene.max[0] = 8 * scene.cell;
    scene.bodies[0].max = {scene.max[0], 16 * scene.cell, 0};
    scene.bodies[0].geostatic = true;
    scene.bodies[0].geostatic_surface = 16 * scene.cell;
    scene.bodies[0].geostatic_k0 = 1.0 / 3;
    return scene;
}

/// Largest way of a particle in 10 s over a cell.
template <class Real>
double drift(const Scene& scene) {
    Run<Real> run(scene);
    while (run.time() < 10) run.steps(100);
    return run.largest([&](const auto&, std::uint32_t, const auto& X, const auto& x) {
        return std::hypot(x[0] - X[0], x[1] - X[1]) / scene.cell;
    });
}

}  // namespace

TEST_CASE("at most 1 % of the energy of waves comes back at normal incidence, and 0.1 % with quadratic FLIP") {
    for (const Choice& choice : {quadratic_flip_usl, quadratic_apic_usl, quadratic_tpic, quadratic_aflip_usl,
                                 quadratic_fmpm2, cubic_flip_usl, gimp_flip_usl, linear_flip})
        for (const bool shear : {false, true}) {
            const double left = energy_left<double>({.shear = shear}, choice);
            say(fmt::format("{}, {} at 10 cells a wave: {:.2e} of the energy comes back", choice.name,
                            shear ? "S" : "P", left));
            CHECK(left <= (std::string(choice.name) == quadratic_flip_usl.name ? 1e-3 : 1e-2));
        }
    CHECK(energy_left<float>({}, quadratic_flip_usl) <= 1e-3);
}

TEST_CASE("at most 5 % of the energy of waves comes back at 45 degrees") {
    for (const double poisson : {0.25, 0.45})
        for (const bool shear : {false, true}) {
            const double left = energy_left<double>({16, 16, shear, poisson}, quadratic_flip_usl, 96);
            say(fmt::format("{} at 45 degrees, nu {}: {:.4f} of the energy comes back", shear ? "S" : "P", poisson,
                            left));
            CHECK(left <= 0.05);
        }
}

TEST_CASE("ground rests on ends that absorb for 10 s") {
    const double moved = drift<double>(resting(Precision::double_)), single = drift<float>(resting(Precision::single_));
    say(fmt::format("ground on absorbing ends moves by {:.2e} cells in 10 s, {:.2e} in single precision", moved,
                    single));
    CHECK(moved <= 1e-3);
    CHECK(single <= 1e-2);
}

TEST_CASE("soil that comes to an end later meets a smooth wall there") {
    Scene scene = wave_box({}, quadratic_flip_usl, 16);
    scene.bodies[0].min[1] = 4 * scene.cell, scene.bodies[0].max[1] = 8 * scene.cell;
    scene.bodies[0].velocity = {0.5, -1, 0};
    Run<> run(scene);
    while (run.time() < 8 * scene.cell) run.steps(10);
    const Totals<2> all = totals_of(run.sim);
    CHECK(all.momentum[1] / all.mass == doctest::Approx(1).epsilon(0.1));  // it bounces
    CHECK(all.momentum[0] / all.mass == doctest::Approx(0.5).epsilon(1e-6));
}
