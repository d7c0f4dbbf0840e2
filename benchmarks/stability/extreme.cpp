// S12: inputs that nobody should give. Expected: a bounded result with a closed budget, or a clear error.
//
// In 2-D, at the default step unless a case says its own; h, c and rho are 1.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/courant.hpp"
#include "core/data/error.hpp"
#include "records/time_series.hpp"
#include "stability/cases.hpp"
#include "verification/run.hpp"

namespace moraine {

namespace {

using namespace verification;

constexpr double young = 0.742857142857142857;  ///< c = 1 with Poisson's ratio 0.3

/// How a case is to end.
enum class End { bounded, refused, either };

struct Extreme {
    const char* name;
    Scene (*scene)(const Choice& choice);
    int steps;
    End end;
    double later = 1;  ///< the step after half of them, over that before
};

Scene block(const Choice& choice, const std::string& law, double side, const std::map<std::string, double>& more = {}) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 1;
    scene.end = 1e6;
    choose(scene, choice);
    scene.cfl = standard_courant(scene);
    scene.max = {16, 16, 0};
    for (auto& walls : {&scene.walls[0], &scene.walls[1]})
        for (WallSpec& wall : *walls) wall.kind = WallKind::free_slip;
    std::map<std::string, double> values{{"young", young}, {"poisson", 0.3}};
    values.insert(more.begin(), more.end());
    scene.materials.push_back(material(law, 1, values));
    BodySpec body;
    body.min = {4, 0, 0}, body.max = {4 + side, side, 0};
    scene.bodies.push_back(body);
    return scene;
}

Scene heavy(const Choice& choice) {
    Scene scene = block(choice, "neo-hookean", 4);
    scene.gravity = {0, -0.25, 0};
    return scene;
}

Scene impact(const Choice& choice) {
    Scene scene = block(choice, "neo-hookean", 4);
    scene.bodies[0].min[1] = 4, scene.bodies[0].max[1] = 8;
    scene.bodies[0].velocity = {0, -1.5, 0};
    return scene;
}

Scene elastic_impact(const Choice& choice) {
    Scene scene = impact(choice);
    scene.materials[0] = block(choice, "linear-elastic", 4).materials[0];
    return scene;
}

Scene jump(const Choice& choice) {
    Scene scene = block(choice, "linear-elastic", 4);
    scene.bodies[0].wave = {{0.001, 0, 0}, 0, 0, 8};
    scene.dt = scene.cfl / 1.01;
    return scene;
}

Scene leaving(const Choice& choice, WallKind kind) {
    Scene scene = block(choice, "linear-elastic", 4);
    scene.walls[0][1].kind = kind;
    scene.bodies[0].velocity = {0.3, 0, 0};
    return scene;
}

Scene crowd(const Choice& choice) {
    Scene scene = block(choice, "linear-elastic", 1);
    scene.bodies[0].particles_per_cell = {316, 316, 1};
    scene.gravity = {0, -1e-3, 0};
    return scene;
}

Scene weak(const Choice& choice) {
    Scene scene = block(choice, "tresca", 4, {{"su", 1e-300}});
    scene.gravity = {0, -1e-3, 0};
    return scene;
}

Scene vacuum(const Choice& choice) {
    Scene scene = block(choice, "linear-elastic", 4);
    scene.gravity = {0, -1e-3, 0};
    scene.materials.push_back(material("linear-elastic", 1e-12, {{"young", 1e-12 * young}, {"poisson", 0.3}}));
    BodySpec air = scene.bodies[0];
    air.material = 1;
    air.min[0] = 8, air.max[0] = 12;
    scene.bodies.push_back(air);
    return scene;
}

Scene gate(const Choice& choice) {
    Scene scene = block(choice, "bingham", 8, {{"viscosity", 0.0045}, {"yield_stress", 6e-5}});
    scene.max[0] = 48;
    scene.bodies[0].min[0] = 0, scene.bodies[0].max[0] = 8;
    scene.gravity = {0, -1.7e-3, 0};
    scene.bodies[0].geostatic = true, scene.bodies[0].geostatic_surface = 8;
    scene.walls[1][0].kind = WallKind::no_slip;
    return scene;
}

constexpr Extreme extremes[] = {
    {"gravity of 1000 times what a soil has (g H = c^2)", heavy, 1000, End::either},
    {"impact at Mach 1.5, neo-hookean", impact, 500, End::either},
    {"impact at Mach 1.5, linear-elastic", elastic_impact, 500, End::either},
    {"the step falls to a tenth at once", jump, 2000, End::bounded, 0.1},
    {"all leave through an open wall", [](const Choice& c) { return leaving(c, WallKind::open); }, 200, End::bounded},
    {"particles leave where there is no wall", [](const Choice& c) { return leaving(c, WallKind::none); }, 200,
     End::refused},
    {"1e5 particles in one cell", crowd, 50, End::bounded},
    {"no strength (su = 1e-300)", weak, 1000, End::bounded},
    {"a neighbour of density 1e-12", vacuum, 1000, End::bounded},
    {"a gate that is gone at once", gate, 1000, End::bounded},
};

/// How a case ended.
struct Outcome {
    std::string error;  ///< the program's words; empty: it ran to the end
    int steps = 0;
    TimeSeriesRow<2> last;
    double speed = 0;       ///< largest [c]
    double momentum = NAN;  ///< error over M c
    bool closed() const { return error.empty() && std::isfinite(speed) && momentum <= 1e-10; }
};

Outcome follow(Scene scene, const Extreme& extreme, int steps) {
    const Comm comm(MPI_COMM_WORLD);
    Outcome out;
    try {
        Simulation<double, 2> sim(scene, comm);
        sim.seed();
        for (; out.steps < steps; ++out.steps) {
            if (out.steps == steps / 2) scene.dt *= extreme.later;
            sim.step();
            sim.balance();
            sim.conclude();
            if (out.steps % 10 != 9) continue;
            out.last = observe(sim, comm);
            out.speed = std::max(out.speed, out.last.totals.speed.value);
        }
        const auto& error = out.last.momentum_error;
        out.momentum = std::max(std::fabs(error[0]), std::fabs(error[1])) / sim.clock().start_mass;
    } catch (const PhysicsError& e) {
        out.error = e.what();
    }
    return out;
}

Finding push(const Extreme& extreme, const Choice& choice) {
    const Scene scene = extreme.scene(choice);
    const Outcome out = follow(scene, extreme, extreme.steps);
    const bool there = out.error.empty() && out.last.particles > 0;
    Finding finding{fmt::format("{}: {}", extreme.name, choice.name),
                    {{"steps", out.steps},
                     {"largest speed", out.speed},
                     {"least J", there ? out.last.totals.min_J : NAN},
                     {"largest J", there ? out.last.totals.max_J : NAN},
                     {"left", static_cast<double>(out.last.lost_particles)},
                     {"momentum error", out.momentum}},
                    out.error.empty() ? extreme.end != End::refused && out.closed() : extreme.end != End::bounded,
                    out.error};
    if (!*finding.pass) {
        Scene half = scene;
        half.cfl *= 0.5, half.dt *= 0.5;
        const bool stands = follow(half, extreme, 2 * extreme.steps).closed();
        finding.why += stands ? " Stands at half the step." : " Nor at half the step.";
    }
    return finding;
}

}  // namespace

void push_extremes(const Wanted& wanted, const Report& report) {
    for (const Extreme& extreme : extremes)
        for (const Choice& choice : {quadratic_flip_usl, quadratic_apic_musl, cubic_apic_usl})
            if (wanted.names(choice.name)) report(push(extreme, choice));
}

}  // namespace moraine
