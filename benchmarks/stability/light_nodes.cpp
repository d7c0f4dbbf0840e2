// S2-edge and S3: nodes that hardly any mass sees. The outermost particles stand `overlap` inside the support of a
// node.
//
// S2-edge is one step of a particle alone, or of a droplet of 2 x 2, that bears a pressure: its velocity may change by
// no more than the forces on all of its nodes give it. S3 is a slab of 4 x 4 cells whose corner particle alone sees the
// light nodes: one step at each overlap, and 2000 steps adrift. There is no traction in the program; what acts on the
// surface is the pressure inside. The program drops nodes below 1e-18 of the lightest particle: a corner node of the
// quadratic shape from 1e-5 h on, all light ones from 1e-9 h on. h, c and rho are 1.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/courant.hpp"
#include "core/data/error.hpp"
#include "method_name.hpp"
#include "records/time_series.hpp"
#include "stability/cases.hpp"
#include "verification/problem_cloud.hpp"

namespace moraine {

namespace {

using namespace verification;

constexpr double pressure = 1e-3;  ///< at the start [rho c^2]
constexpr double gentle = 0.3;     ///< dt c / h of S2-edge, where a particle alone is stable with wide shapes
constexpr double drift = 0.05;     ///< [c]
constexpr int long_run = 2000;
constexpr double energy_goal = 1.25;  ///< velocities are half a step off: what is there swings
/// Sum of |h dN_i| over the nodes of an axis is at most 2: no particle is given more than this by its own stress,
/// per axis [c^2/h].
constexpr double bound = 2 * pressure;

constexpr Choice choices[] = {
    {"linear FLIP USL", Shape::linear, Transfer::flip, StressUpdate::usl},
    gimp_flip_usl,
    quadratic_flip_usl,
    quadratic_flip_musl,
    quadratic_apic_usl,
    cubic_flip_usl,
};

/// How far from a node its weight ends [cells]; two particles per cell and axis.
double radius_of(Shape shape) {
    switch (shape) {
        case Shape::linear:
            return 1;
        case Shape::cubic:
            return 2;
        case Shape::quadratic:
            return 1.5;
        default:
            return 1.25;
    }
}

/// per_axis particles along both axes, half a cell apart, the first ones `overlap` inside the support of nodes at 4.
Scene scene_of(const Choice& choice, int per_axis, double overlap, double dt) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 1;
    scene.dt = dt;
    scene.limits_light_nodes = false;  // what a node's weight does by itself
    choose(scene, choice);
    scene.materials.push_back(material("linear-elastic", 1, {{"young", 0.742857142857142857}, {"poisson", 0.3}}));
    BodySpec body;
    for (std::size_t a = 0; a < 2; ++a) {
        scene.max[a] = 16;
        make_periodic(scene, a);
        body.min[a] = 4 + radius_of(choice.shape) - overlap - 0.25;
        body.max[a] = body.min[a] + 0.5 * per_axis;
    }
    scene.bodies.push_back(body);
    return scene;
}

struct Outcome {
    double velocity = 0;  ///< largest off the drift [c]
    double pressure = 0;  ///< largest magnitude over that at the start
    double energy = 0;    ///< largest stored and kinetic, off the drift, over that at the start
    double momentum = 0;  ///< largest change over M c
};

/// Stored and kinetic energy off the drift [J] and the error of momentum [kg m/s].
struct Budget {
    double energy = 0;
    std::array<double, 2> error{};
};

Budget budget(Run<double, 2>& run, const Comm& comm, double speed) {
    const TimeSeriesRow<2> row = observe(run.sim, comm);
    const double kinetic = run.sum([&](const auto& p, std::uint32_t s, const auto&, const auto&) {
        return 0.5 * p.mass[s] * (std::pow(p.velocity[s][0] - speed, 2) + std::pow(p.velocity[s][1] - speed, 2));
    });
    return {row.totals.strain + kinetic, row.momentum_error};
}

void look(Run<double, 2>& run, const Comm& comm, double speed, const Budget& start, Outcome& most) {
    const double mass = run.sum([](const auto& p, std::uint32_t s, const auto&, const auto&) { return p.mass[s]; });
    const Budget now = budget(run, comm, speed);
    for (std::size_t a = 0; a < 2; ++a)
        most.momentum = std::max(most.momentum, std::fabs(now.error[a] - start.error[a]) / mass);
    most.energy = std::max(most.energy, now.energy / start.energy);
    most.velocity = std::max(most.velocity, run.largest([&](const auto& p, std::uint32_t s, const auto&, const auto&) {
        return std::max(std::fabs(p.velocity[s][0] - speed), std::fabs(p.velocity[s][1] - speed));
    }));
    most.pressure = std::max(most.pressure, run.largest([](const auto& p, std::uint32_t s, const auto&, const auto&) {
        return std::fabs(p.stress[s].trace()) / (3 * pressure);
    }));
}

Outcome follow(const Scene& scene, double speed, int steps, int every) {
    const Comm comm(MPI_COMM_WORLD);
    Run<double, 2> run(scene);
    run.start_with([&](const auto& p, std::uint32_t s, const auto&) {
        for (int a = 0; a < 2; ++a) p.velocity[s][a] = speed;
        for (int a = 0; a < 3; ++a) p.stress[s][a] = -pressure;
    });
    const Budget start = budget(run, comm, speed);
    Outcome most;
    for (int done = 0; done < steps; done += every) {
        run.steps(every);
        look(run, comm, speed, start, most);
    }
    return most;
}

Finding edge(const Choice& choice, int per_axis) {
    Finding finding{std::string(choice.name) + (per_axis == 1 ? ", alone" : ", droplet"), {}, true, ""};
    double velocity = 0;
    for (double overlap : {1e-3, 1e-6, 1e-9}) {
        const Outcome one = follow(scene_of(choice, per_axis, overlap, gentle), 0, 1, 1);
        velocity = std::max(velocity, one.velocity / (bound * gentle));
        finding.numbers.emplace_back(fmt::format("pressure at {:.0e} h", overlap), one.pressure);
        if (!(one.pressure <= 1)) finding.pass = false, finding.why = "the pressure grows in one step";
    }
    finding.numbers.emplace_back("velocity over its bound", velocity);
    if (!(velocity <= 1)) finding.pass = false, finding.why = "the velocity changes by more than the forces";
    return finding;
}

Finding slab(const Choice& choice) {
    Finding finding{choice.name, {}, true, ""};
    const auto fails = [&](const std::string& why) {
        finding.pass = false;
        finding.why += (finding.why.empty() ? "" : "; ") + why;
    };
    double momentum = 0;
    for (double overlap : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12}) {
        const Outcome one = follow(scene_of(choice, 8, overlap, 0.1), 0, 1, 1);
        momentum = std::max(momentum, one.momentum);
        finding.numbers.emplace_back(fmt::format("a at {:.0e} h", overlap), one.velocity / (bound * 0.1));
        if (!(one.velocity <= bound * 0.1)) fails(fmt::format("acceleration at {:.0e} h", overlap));
    }
    Scene adrift = scene_of(choice, 8, 1e-6, 0);
    adrift.dt = standard_courant(adrift) / (1 + std::sqrt(2.0) * drift);
    Outcome end;
    try {
        end = follow(adrift, drift, long_run, 20);
        if (!(end.energy <= energy_goal)) fails("energy grows adrift");
        momentum = std::max(momentum, end.momentum);
    } catch (const PhysicsError& e) {
        fails(e.what());
        end = {NAN, NAN, NAN, NAN};
    }
    finding.numbers.emplace_back("dt c / h adrift", adrift.dt);
    finding.numbers.emplace_back("pressure adrift", end.pressure);
    finding.numbers.emplace_back("energy adrift", end.energy);
    finding.numbers.emplace_back("momentum error", momentum);
    if (!(momentum <= 1e-12)) fails("momentum");
    return finding;
}

}  // namespace

void find_edges(const Wanted& wanted, const Report& report) {
    for (int per_axis : {1, 2})
        for (const Choice& choice : choices)
            if (wanted.names(choice.name)) report(edge(choice, per_axis));
}

void drift_slab(const Wanted& wanted, const Report& report) {
    for (const Choice& choice : choices)
        if (wanted.names(choice.name)) report(slab(choice));
}

}  // namespace moraine
