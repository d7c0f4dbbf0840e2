// S15: an elastic block rests on a rigid plane for a million steps, without damping.
//
// Let go at t = 0 it bounces; what is left of that after the first tenth of the steps is looked at, at a thousand
// moments of the rest: kinetic energy over m g times its height, and how far the block has gone on average.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/courant.hpp"
#include "stability/cases.hpp"
#include "verification/contact_block.hpp"

namespace moraine {

namespace {

using namespace verification;

constexpr int steps = 1000000, settled = steps / 10, between = 900;
constexpr double energy_goal = 1e-8;
constexpr double drift_goal = 1e-6;  ///< [h per 1e4 steps], that of C1
constexpr double sunk_goal = 0.05;   ///< [h], that of C1

struct Rest {
    double energy = 0;  ///< largest kinetic energy over m g height
    double last = 0;    ///< the same at the end
    double sunk = 0;    ///< at the end [h]
    double drift = 0;   ///< since it had settled [h per 1e4 steps]
    double load = 0;    ///< on the plane since, over the weight, less 1
};

Rest rest(const Brick& b, const Scene& scene) {
    constexpr Triple down{0, -1, 0};
    ContactRun block(scene);
    block.run.steps(settled);
    const double before = block.moved(down), impulse = block.impulse(down), t = block.run.time();
    Rest rest;
    for (int done = settled; done < steps; done += between) {
        block.run.steps(between);
        rest.last = block.run.sum([](const auto& p, std::uint32_t s, const auto&, const auto&) {
            return 0.5 * p.mass[s] * (p.velocity[s][0] * p.velocity[s][0] + p.velocity[s][1] * p.velocity[s][1]);
        }) / (b.weight() * b.height);
        rest.energy = std::max(rest.energy, rest.last);
    }
    rest.sunk = block.moved(down) / b.h;
    rest.drift = (block.moved(down) - before) / b.h / ((steps - settled) / 1e4);
    rest.load = (block.impulse(down) - impulse) / (block.run.time() - t) / b.weight() - 1;
    return rest;
}

Finding chatter(const Choice& choice, double lift) {
    Brick b;
    b.lift = lift;
    Scene scene = block_scene(b, InterfaceLaw::coulomb);
    choose(scene, choice);
    scene.cfl = standard_courant(scene);
    Finding finding{fmt::format("{}, plane {} h over a node", choice.name, lift), {}, false, ""};
    attempt(finding, [&] {
        const Rest r = rest(b, scene);
        finding.numbers = {{"largest kinetic energy / m g height", r.energy},
                           {"at the end", r.last},
                           {"sunk [h]", r.sunk},
                           {"drift [h per 1e4 steps]", r.drift},
                           {"load over the weight, less 1", r.load}};
        if (!(r.energy <= energy_goal)) finding.why += fmt::format("it keeps bouncing by {:.1e}; ", r.energy);
        if (!(std::fabs(r.drift) <= drift_goal)) finding.why += fmt::format("it drifts by {:.1e} h; ", r.drift);
        if (!(std::fabs(r.sunk) <= sunk_goal)) finding.why += "it sinks; ";
        finding.pass = finding.why.empty();
    });
    return finding;
}

}  // namespace

void rest_on_plane(const Wanted& wanted, const Report& report) {
    for (const Choice& choice : {quadratic_flip_usl, quadratic_apic_usl, gimp_flip_usl})
        for (double lift : {0.0, 0.5})
            if (wanted.names(choice.name)) report(chatter(choice, lift));
}

}  // namespace moraine
