// Shaking against closed forms: a layer on rigid and on compliant rock, and Newmark's block.
#include "core/gravity.hpp"
#include "verification/drive.hpp"
#include "verification/wave_box.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

constexpr int cells = 16;  // of the layer

/// a sin(w t), by rows of a 64th of a period.
TimeTable sine(double amplitude, double frequency, double end) {
    TimeTable table;
    const double step = 1 / (64 * frequency);
    for (int k = 0; k * step < end + step; ++k) {
        table.times.push_back(k * step);
        table.values.push_back(amplitude * std::sin(2 * pi * k / 64));
    }
    return table;
}

/// A layer on rock with `ratio` of its impedance, 0: rigid; kH = share pi; it is shaken for some periods.
Scene layer(double ratio, double share, int periods) {
    Scene scene = wave_box({}, quadratic_aflip_usl, cells + 4);
    scene.walls[1][1] = {};
    scene.bodies[0].max[1] = cells * scene.cell;
    const double c = speed_of({.shear = true}), frequency = share * c / (2 * cells * scene.cell);
    ShakingSpec& shaking = scene.course.shaking;
    shaking.table = sine(1e-3, frequency, periods / frequency);
    shaking.direction = {1, 0, 0};
    scene.end = periods / frequency;
    if (ratio == 0) {
        scene.walls[1][0] = {}, scene.walls[1][0].kind = WallKind::no_slip;
        return scene;
    }
    shaking.motion = BaseMotion::outcrop;
    MaterialSpec rock = scene.materials[0];
    rock.name = "rock";
    rock.density = soil_density, rock.parameters[0] = soil_young / (ratio * ratio);
    scene.walls[1][0].material = "rock";
    scene.materials.push_back(rock);
    return scene;
}

/// Of the velocity of the surface over that of rock where it crops out, in the last four periods.
double amplification(const Scene& scene, double frequency) {
    Run<> run(scene);
    const double w = 2 * pi * frequency, from = scene.end - 4 / frequency;
    const double top = (cells - 0.5) * scene.cell;
    double sine = 0, cosine = 0;
    while (run.time() < scene.end) {
        const double before = run.time();
        run.steps(1);
        if (before < from) continue;
        double v = 0, count = 0;
        v = run.sum([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
            return X[1] > top ? double(p.velocity[s][0]) : 0;
        });
        count = run.sum([&](const auto&, std::uint32_t, const auto& X, const auto&) { return X[1] > top ? 1 : 0; });
        v = v / count + base_velocity(scene.course.shaking, 0, run.time());
        const double dt = run.time() - before, t = run.time();
        sine += 2 * v * std::sin(w * t) * dt * frequency / 4;
        cosine += 2 * v * std::cos(w * t) * dt * frequency / 4;
    }
    // v of the outcrop: (a / w) (1 - cos w t)
    return std::hypot(sine, cosine) / (1e-3 / w);
}

}  // namespace

TEST_CASE("a layer on compliant rock answers by its transfer function within 2 %, down to 32 cells a wave") {
    const double ratio = 0.25;
    for (const double share : {0.25, 0.5, 0.75, 1.0, 1.5, 2.5}) {
        const Scene scene = layer(ratio, share, 24);
        const double frequency = share * speed_of({.shear = true}) / (2 * cells * scene.cell);
        const double k = share * pi, found = amplification(scene, frequency);
        const double exact = std::cos(k / (4 * cells)) / std::hypot(std::cos(k), ratio * std::sin(k));  // of its place
        say(fmt::format("layer on rock, impedances 0.25, kH {} pi, {:.3g} cells a wave: {:.4f}, exact {:.4f}", share,
                        2 * cells / share, found, exact));
        if (share <= 1) CHECK(found == doctest::Approx(exact).epsilon(0.02));
    }
}

TEST_CASE("a layer on a rigid base that sets off swings to a H^2 / c^2 and back within 2 %") {
    Scene scene = layer(0, 1, 24);
    const double height = cells * scene.cell, c = speed_of({.shear = true}), a = 0.01;
    scene.course.shaking.table = {{0}, {a}};
    scene.end = 4 * height / c;
    Run<> run(scene);
    const auto top = [&] {
        return run.largest([&](const auto&, std::uint32_t, const auto& X, const auto& x) {
            return X[1] > height - 0.5 * scene.cell ? std::remainder(X[0] - x[0], scene.max[0]) : -1;
        });
    };
    const double most = a * height * height / (c * c);
    while (run.time() < 0.5 * scene.end) run.steps(1);
    const double half = top() / most;
    while (run.time() < scene.end) run.steps(1);
    say(fmt::format("layer on a rigid base: {:.4f} of a H^2 / c^2 after half a period, {:.4f} after one", half,
                    top() / most));
    CHECK(half == doctest::Approx(1).epsilon(0.02));
    CHECK(std::fabs(top() / most) <= 0.02);
}

TEST_CASE("a block slides on a base that shakes as Newmark's within 2 %") {
    const double g = 9.81, push = 0.3 * g, holds = 0.1 * g, time = 0.5;
    Scene scene = wave_box({}, quadratic_flip_usl, 8);
    scene.periodic[0] = false;
    scene.walls = {};
    scene.walls[1][0].kind = WallKind::friction;
    scene.walls[1][0].friction = holds / g;
    scene.gravity[1] = -g;
    scene.max[0] = 16 * scene.cell;
    scene.bodies[0].min = {10 * scene.cell, 0, 0};
    scene.bodies[0].max = {14 * scene.cell, 2 * scene.cell, 0};
    scene.bodies[0].geostatic = true, scene.bodies[0].geostatic_surface = 2 * scene.cell;
    scene.course.shaking.table = {{0, time, time + 1e-6}, {push, push, 0}};
    scene.course.shaking.direction = {1, 0, 0};
    scene.end = 2;
    Run<> run(scene);
    while (run.time() < scene.end) run.steps(20);
    const double count = static_cast<double>(run.particles());
    const double slip = run.sum([&](const auto&, std::uint32_t, const auto& X, const auto& x) { return X[0] - x[0]; });
    const double exact = (push - holds) * time * time * push / (2 * holds);
    say(fmt::format("Newmark's block slips {:.4f} m, exact {:.4f} m", slip / count, exact));
    CHECK(slip / count == doctest::Approx(exact).epsilon(0.02));
}
