// S10: when particles lose sight of each other, and what shear without end does to the stress.
//
// Stretch: a bar flies apart with v = rate X and next to no stiffness, so that every particle keeps its velocity and
// ln J = ln lambda, lambda = 1 + rate t. Its inner particles are looked at between lambda and 1.1 lambda: what they saw
// of ln 1.1. Shear: a slab moves with v_x = rate y in plane strain; so soft that its free faces do not matter. Its
// stress is known: viscosity rate, or the strength. h and rho are 1.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "stability/cases.hpp"
#include "verification/run.hpp"

namespace moraine {

namespace {

using namespace verification;

constexpr double rate = 0.01;    ///< [1/s]
constexpr double drift = 0.037;  ///< of the bar: all pass all places between nodes [m/s]
constexpr double longest = 20, step = 1.1;
constexpr double bar = 16;                                      ///< length [cells]
constexpr double inner = 4;                                     ///< half the length that is looked at [cells]
constexpr double strength = 1e-8, viscosity = strength / rate;  ///< shear stress of both laws [Pa], [Pa s]

/// Nothing in a plane that is periodic both ways.
Scene empty_plane(const Choice& choice, double length, double height) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 1;
    scene.dt = 1;
    choose(scene, choice);
    scene.max = {length, height, 0};
    make_periodic(scene, 0);
    make_periodic(scene, 1);
    return scene;
}

Scene bar_of(const Choice& choice, int per_cell) {
    Scene scene = empty_plane(choice, 352, 4);
    scene.materials.push_back(material("linear-elastic", 1, {{"young", 1e-14}, {"poisson", 0}}));
    BodySpec body;
    body.min = {176 - bar / 2, 0, 0}, body.max = {176 + bar / 2, 4, 0};
    body.particles_per_cell = {per_cell, 1, 1};
    scene.bodies.push_back(body);
    return scene;
}

/// ln J of the inner particles: mean, least and largest.
struct Volumes {
    double mean = 0, least = 0, most = 0;
};

Volumes volumes(Run<double, 2>& run) {
    const auto within = [](const auto& X) { return std::fabs(X[0] - 176) < inner; };
    const double n = run.sum([&](const auto&, std::uint32_t, const auto& X, const auto&) { return within(X) ? 1 : 0; });
    const auto of = [&](double sign) {
        return run.largest([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
            return within(X) ? 100 + sign * p.ln_J[s] : 0;
        });
    };
    const double sum =
        run.sum([&](const auto& p, std::uint32_t s, const auto& X, const auto&) { return within(X) ? p.ln_J[s] : 0; });
    return {sum / n, 100 - of(-1), of(1) - 100};
}

Finding stretch(const Choice& choice, int per_cell) {
    Run<double, 2> run(bar_of(choice, per_cell));
    run.start_with([](const auto& p, std::uint32_t s, const auto& X) {
        p.velocity[s][0] = drift + rate * (X[0] - 176);
        if (p.affine) p.affine[s](0, 0) = rate;
    });
    double lambda = 1, before = 0, lost = longest, torn = longest;
    Finding finding{fmt::format("stretch: {}, {} per cell", choice.name, per_cell), {}, std::nullopt, ""};
    Volumes now;
    attempt(finding, [&] {
        while (lambda * step < longest) {
            const int steps = static_cast<int>(std::lround((lambda * step - 1) / rate - run.time()));
            run.steps(steps);
            const double next = 1 + rate * run.time();
            now = volumes(run);
            const double seen = (now.mean - before) / std::log(next / lambda);
            if (std::fabs(seen - 1) > 0.5) lost = std::min(lost, lambda);
            if (now.least < 0.5 * std::log(next) || now.most > 1.5 * std::log(next)) torn = std::min(torn, lambda);
            lambda = next, before = now.mean;
        }
    });
    finding.numbers = {{"one off by half from lambda", torn},   {"half of the growth from lambda", lost},
                       {"lambda at the end", lambda},           {"mean ln J / ln lambda", now.mean / std::log(lambda)},
                       {"least", now.least / std::log(lambda)}, {"most", now.most / std::log(lambda)}};
    return finding;
}

Scene slab_of(const Choice& choice, const char* law) {
    Scene scene = empty_plane(choice, 8, 16);
    scene.materials.push_back(
        material(law, 1, {{"young", 0.01}, {"poisson", 0.3}, {"viscosity", viscosity}, {"su", strength}}));
    BodySpec body;
    body.min = {0, 4, 0}, body.max = {8, 12, 0};
    scene.bodies.push_back(body);
    return scene;
}

Finding shear(const Choice& choice, const char* law) {
    Run<double, 2> run(slab_of(choice, law));
    run.start_with([](const auto& p, std::uint32_t s, const auto& X) {
        p.velocity[s][0] = drift + rate * (X[1] - 8);
        if (p.affine) p.affine[s](0, 1) = rate;
    });
    Finding finding{fmt::format("shear: {}, {}", choice.name, law), {}, std::nullopt, ""};
    const auto inside = [](const auto& X) { return std::fabs(X[1] - 8) < 2; };
    double stress = 0, volume = 0;
    attempt(finding, [&] {
        for (int gamma = 1; gamma <= 50; ++gamma) {
            run.steps(static_cast<int>(1 / rate));
            stress = run.largest([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
                return inside(X) ? std::fabs(p.stress[s](0, 1) / strength - 1) : 0;
            });
            volume = run.largest([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
                return inside(X) ? std::fabs(p.ln_J[s]) : 0;
            });
            if (gamma == 1 || gamma == 10 || gamma == 50) {
                finding.numbers.emplace_back(fmt::format("stress at gamma {}", gamma), stress);
                finding.numbers.emplace_back(fmt::format("ln J at gamma {}", gamma), volume);
            }
        }
    });
    return finding;
}

}  // namespace

void pull_apart(const Wanted& wanted, const Report& report) {
    const Choice choices[] = {
        {"linear FLIP USL", Shape::linear, Transfer::flip, StressUpdate::usl},
        gimp_flip_usl,
        contiguous_flip_usl,
        quadratic_flip_usl,
        quadratic_flip_musl,
        quadratic_apic_usl,
        quadratic_tpic_usl,
        cubic_flip_usl,
        cubic_apic_usl,
    };
    for (int per_cell : {2, 4})
        for (const Choice& choice : choices)
            if (wanted.names(choice.name)) report(stretch(choice, per_cell));
    for (const char* law : {"newtonian", "tresca"})
        for (const Choice& choice : choices)
            if (wanted.names(choice.name)) report(shear(choice, law));
}

}  // namespace moraine
