// S4: velocities that alternate from particle to particle, which no node sees, on top of a drift.
//
// With two particles per cell and axis the pattern has the wavelength h, where the transform of every B-spline is zero:
// all nodes sum to nothing wherever the lattice stands. h, c and rho are 1.

#include <algorithm>
#include <cmath>

#include "core/courant.hpp"
#include "core/data/error.hpp"
#include "method_name.hpp"
#include "stability/cases.hpp"
#include "verification/problem_cloud.hpp"

namespace moraine {

namespace {

using namespace verification;

constexpr Cloud adrift{"2-D adrift", 2, false, false, 0.05};
constexpr double amplitude = 1e-3;  ///< of the alternating velocity, along both axes [c]
constexpr int early = 100, late = 10000;
constexpr double goal = 1e-3;       ///< of the energy, after `early` steps
constexpr double bulk_goal = 1e-4;  ///< loss of the drift's energy

struct Energies {
    double null = 0;   ///< kinetic, less that of the mean velocity [J]
    double drift = 0;  ///< of the mean velocity [J]
};

Energies energies(Run<double, 2>& run) {
    const double mass = run.sum([](const auto& p, std::uint32_t s, const auto&, const auto&) { return p.mass[s]; });
    double mean[2];
    for (int a = 0; a < 2; ++a)
        mean[a] = run.sum([a](const auto& p, std::uint32_t s, const auto&, const auto&) {
            return p.mass[s] * p.velocity[s][a];
        }) / mass;
    const double null = run.sum([&](const auto& p, std::uint32_t s, const auto&, const auto&) {
        return 0.5 * p.mass[s] * (std::pow(p.velocity[s][0] - mean[0], 2) + std::pow(p.velocity[s][1] - mean[1], 2));
    });
    return {null, 0.5 * mass * (mean[0] * mean[0] + mean[1] * mean[1])};
}

void start_alternating(Run<double, 2>& run) {
    const Vec<double, 2> drift = drift_of<2>(adrift);
    run.start_with([&](const auto& p, std::uint32_t s, const auto& X) {
        const int parity = static_cast<int>(std::floor(2 * X[0])) + static_cast<int>(std::floor(2 * X[1]));
        for (int a = 0; a < 2; ++a) p.velocity[s][a] = drift[a] + (parity % 2 == 0 ? amplitude : -amplitude);
    });
}

struct Kind {
    Transfer transfer;
    double flip;
    bool has_goal;
};

Finding follow(Shape shape, const Kind& kind) {
    const std::string name = method_name(shape, kind.transfer, StressUpdate::usl) +
                             (kind.transfer == Transfer::flip && kind.flip < 1 ? ", 0.99 of FLIP" : "");
    const Choice choice{name.c_str(), shape, kind.transfer, StressUpdate::usl};
    Scene scene = cloud_scene(adrift, choice, 0);
    scene.flip = kind.flip;
    scene.dt = standard_courant(scene) / (kind.transfer == Transfer::fmpm ? std::sqrt(2.0) : 1);
    Run<double, 2> run(scene);
    start_alternating(run);
    const Energies start = energies(run);
    Energies soon, end{NAN, NAN};
    std::string why;
    run.steps(early);
    soon = energies(run);
    try {
        run.steps(late - early);
        end = energies(run);
    } catch (const PhysicsError& e) {
        why = e.what();
    }
    const double loss = std::fabs(1 - soon.drift / start.drift);
    const bool met = soon.null <= goal * start.null && loss <= bulk_goal;
    if (kind.has_goal && !met) why = "too much is left, or the drift loses energy";
    return {name,
            {{"dt c / h", scene.dt},
             {"left after 100 steps", soon.null / start.null},
             {"left after 10 000", end.null / start.null},
             {"loss of the drift's energy", loss}},
            kind.has_goal ? std::optional(met) : std::nullopt,
            why};
}

}  // namespace

void follow_null_mode(const Wanted& wanted, const Report& report) {
    constexpr Kind kinds[] = {{Transfer::flip, 1, false}, {Transfer::flip, 0.99, false}, {Transfer::pic, 0, true},
                              {Transfer::apic, 1, true},  {Transfer::tpic, 1, true},     {Transfer::fmpm, 1, true}};
    for (Shape shape : {Shape::quadratic, Shape::cubic})
        for (const Kind& kind : kinds)
            if (wanted.names(method_name(shape, kind.transfer, StressUpdate::usl))) report(follow(shape, kind));
}

}  // namespace moraine
