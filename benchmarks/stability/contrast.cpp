// S8: a pulse in a strip meets a block of other stiffness or density, bonded to its own (nodes have one velocity).
//
// With the impedances Z = rho c of the two, of a pulse of velocity v and stress -Z1 v
//
//   R = (Z1 - Z2) / (Z1 + Z2) of the velocity, and so of the first block's momentum, comes back; R^2 of the energy
//   2 Z2 / (Z1 + Z2) of the stress and 2 Z1 / (Z1 + Z2) of the velocity are at the interface
//
// Stress is that of the first block and velocity that of the second, of the particles beside the interface and of those
// two cells further away.
//
// The pulse is cos^2, `width` cells from end to end. The second block is so long that nothing comes back from its far
// end in time, up to `longest` cells: beyond that nothing is compared. h, c and rho of the first block are 1.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/courant.hpp"
#include "core/data/error.hpp"
#include "method_name.hpp"
#include "stability/cases.hpp"
#include "verification/run.hpp"

namespace moraine {

namespace {

using namespace verification;

constexpr double width = 32;        ///< of the pulse [cells]
constexpr double first = 96;        ///< length of the block that it starts in [cells]
constexpr double away = 32;         ///< of its middle from the interface, at the start and when it is back [cells]
constexpr double longest = 900;     ///< of the other block [cells]
constexpr double shortest = 200;    ///< and where c2 is above 100 c1, which takes as many steps more [cells]
constexpr double amplitude = 1e-6;  ///< [c]
constexpr double goal = 0.02;
constexpr double off[] = {0.25, 2.25};  ///< from the interface: beside it, and two cells further [cells]
constexpr double margin = 4;            ///< of the domain [cells]

/// The second block over the first.
struct Contrast {
    double stiffness, density;
    double speed() const { return std::sqrt(stiffness / density); }
    double impedance() const { return std::sqrt(stiffness * density); }
    double wanted() const { return std::max(24.0, 0.55 * (away + width / 2) * speed()); }  ///< length [cells]
    bool has_goal() const { return wanted() <= longest && std::max({stiffness, density, 1 / density}) < 1001; }
};

Scene scene_of(const Choice& choice, const Contrast& contrast) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 1;
    choose(scene, choice);
    scene.dt = standard_courant(scene) / std::max(1.0, contrast.speed());
    const double second = std::ceil(contrast.speed() > 100 ? shortest : std::min(longest, contrast.wanted()));
    scene.max = {std::ceil((2 * margin + first + second) / 4) * 4, 4, 0};
    make_periodic(scene, 1);
    const double start[] = {margin, margin + first}, end[] = {margin + first, margin + first + second};
    const double young[] = {1, contrast.stiffness}, density[] = {1, contrast.density};
    for (int k = 0; k < 2; ++k) {
        scene.materials.push_back(material("linear-elastic", density[k], {{"young", young[k]}, {"poisson", 0}}));
        BodySpec body;
        body.material = k;
        body.min = {start[k], 0, 0}, body.max = {end[k], 4, 0};
        body.particles_per_cell = {2, 1, 1};
        scene.bodies.push_back(body);
    }
    return scene;
}

struct Found {
    double momentum = 0, energy = 0;    ///< of the first block
    double kinetic = 0, strain = 0;     ///< energy of both
    double whole = 0;                   ///< that of a leap-frog: velocities are half a step older than stresses
    double stress[2]{}, velocity[2]{};  ///< of the particles beside the interface and `off` from it
};

Found look(Simulation<double, 2>& sim, const Contrast& contrast) {
    Found now;
    const double face = margin + first;
    const ParticleView<double, 2> p = sim.patch().particles.view();
    each_particle(sim, [&](std::uint32_t s, const std::array<double, 2>& x) {
        const double young = p.body[s] == 0 ? 1 : contrast.stiffness;
        const double kinetic = 0.5 * p.mass[s] * p.velocity[s][0] * p.velocity[s][0];
        const double strain = 0.5 * p.volume[s] * p.stress[s][0] * p.stress[s][0] / young;
        now.kinetic += kinetic, now.strain += strain;
        if (p.body[s] == 0) now.momentum += p.mass[s] * p.velocity[s][0], now.energy += kinetic + strain;
        for (int k = 0; k < 2; ++k) {
            if (std::fabs(std::fabs(x[0] - face) - off[k]) > 0.2) continue;
            double& most = p.body[s] == 0 ? now.stress[k] : now.velocity[k];
            most = std::max(most, std::fabs(p.body[s] == 0 ? p.stress[s][0] : p.velocity[s][0]));
        }
    });
    return now;
}

void start_pulse(Simulation<double, 2>& sim) {
    sim.seed();
    const ParticleView<double, 2> p = sim.patch().particles.view();
    each_particle(sim, [&](std::uint32_t s, const std::array<double, 2>& x) {
        const double at = x[0] - (margin + first - away);
        const double v = std::fabs(at) < width / 2 ? amplitude * std::pow(std::cos(pi * at / width), 2) : 0;
        p.velocity[s][0] = v;
        p.stress[s][0] = -v;
    });
    sim.refresh_signal();
}

/// What is at the end, and the most that was at the interface and of the whole. Throws PhysicsError.
std::pair<Found, Found> follow(Simulation<double, 2>& sim, const Contrast& contrast) {
    Found end, most;
    const double dt = sim.scene().dt;
    const auto steps = static_cast<int>(2 * away / dt);
    const int every = std::max(1, static_cast<int>(0.5 / dt));
    for (int done = 0; done < steps; done += every) {
        Found before;
        for (int k = 0; k < every; ++k) {
            if (k + 1 == every) before = look(sim, contrast);
            sim.step(), sim.balance(), sim.conclude();
        }
        end = look(sim, contrast);
        most.whole = std::max(most.whole, end.kinetic + 0.5 * (before.strain + end.strain));
        for (int k = 0; k < 2; ++k) {
            most.stress[k] = std::max(most.stress[k], end.stress[k]);
            most.velocity[k] = std::max(most.velocity[k], end.velocity[k]);
        }
    }
    return {end, most};
}

/// Of the pulse and what comes back of it, R_stress of it, at `distance` before the interface, over the pulse's.
double largest_stress(double R_stress, double distance) {
    const auto pulse = [](double x) { return std::fabs(x) < width / 2 ? std::pow(std::cos(pi * x / width), 2) : 0; };
    double most = 0;
    for (double t = -width; t <= width; t += 0.01)
        most = std::max(most, std::fabs(pulse(t + distance) + R_stress * pulse(t - distance)));
    return most;
}

Finding judge(const std::string& name, const Contrast& contrast, const Found& start, const Found& end,
              const Found& most) {
    const double Z = contrast.impedance(), R = (1 - Z) / (1 + Z);
    const double back = end.momentum / start.momentum;
    const double whole = most.whole / (start.kinetic + start.strain);
    const bool stable = std::isfinite(back) && whole <= 1.01;
    Finding finding{
        name, {{"R", R}, {"momentum back", back}, {"energy back less R^2", end.energy / start.energy - R * R}}, {}, ""};
    double worst[2];
    for (int k = 0; k < 2; ++k) {
        const double stress = most.stress[k] / amplitude / largest_stress(-R, off[k]);
        const double velocity = most.velocity[k] / amplitude * (1 + Z) / 2;
        worst[k] = std::max({std::fabs(back - R), std::fabs(stress - 1), std::fabs(velocity - 1)});
        const char* where = k == 0 ? " beside" : " 2.25 h off";
        finding.numbers.emplace_back(std::string("stress") + where, stress);
        finding.numbers.emplace_back(std::string("velocity") + where, velocity);
    }
    finding.numbers.emplace_back("largest energy", whole);
    const bool met = std::max(worst[0], worst[1]) <= goal;
    finding.pass = stable && (met || !contrast.has_goal());
    finding.why = !stable                ? "energy grows"
                  : !contrast.has_goal() ? "stable; no goal"
                  : met                  ? ""
                        : fmt::format("off by {:.2g} beside the interface, by {:.2g} 2.25 h off", worst[0], worst[1]);
    return finding;
}

Finding meet(const Choice& choice, const Contrast& contrast) {
    const std::string name =
        fmt::format("{}, stiffness {:g}, density {:g}", choice.name, contrast.stiffness, contrast.density);
    const Scene scene = scene_of(choice, contrast);
    const Comm comm(MPI_COMM_WORLD);
    Simulation<double, 2> sim(scene, comm);
    start_pulse(sim);
    const Found start = look(sim, contrast);
    try {
        const auto [end, most] = follow(sim, contrast);
        return judge(name, contrast, start, end, most);
    } catch (const PhysicsError& e) {
        return {name, {}, false, e.what()};
    }
}

}  // namespace

void meet_contrasts(const Wanted& wanted, const Report& report) {
    constexpr Contrast contrasts[] = {{1, 1},  {10, 1},  {100, 1}, {1e3, 1},  {1e6, 1},
                                      {1, 10}, {1, 1e3}, {1, 1e5}, {1, 1e-3}, {1, 1e-5}};
    for (const Choice& choice : {quadratic_flip_usl, quadratic_apic_usl, gimp_flip_usl, cubic_flip_usl})
        for (const Contrast& contrast : contrasts) {
            const bool slow = contrast.speed() > 40 && choice.shape != Shape::quadratic;
            if (!slow && wanted.names(choice.name)) report(meet(choice, contrast));
        }
}

}  // namespace moraine
