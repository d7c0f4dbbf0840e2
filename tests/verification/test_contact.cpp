// C1 to C7: an elastic block on a rigid plane. It rests with its weight on it, sticks below the angle of friction,
// slides on the exact path above it, is braked by no more than the strength of an undrained interface, and bounces.
#include "verification/contact_block.hpp"
#include "verification/drive.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

constexpr Triple along{1, 0, 0}, down{0, -1, 0};
constexpr double degree = pi / 180;

void rests(double lift) {
    Brick b;
    b.lift = lift;
    ContactRun block(block_scene(b, InterfaceLaw::coulomb));
    block.run.steps(12000);
    const double settled = block.moved(down), before = block.impulse(down), t = block.run.time();
    block.run.steps(10000);
    const double drift = (block.moved(down) - settled) / b.h;
    const double load = (block.impulse(down) - before) / (block.run.time() - t) / b.weight() - 1;
    say(fmt::format("C1 plane {} cells over a node: load {:.1e}, sunk {:.4f} h, drift {:.1e} h in 1e4 steps", lift,
                    load, settled / b.h, drift));
    CHECK(std::fabs(load) <= 1e-6);
    CHECK(std::fabs(settled / b.h) <= 0.05);
    CHECK(std::fabs(drift) <= 1e-6);
}

/// Error of the way along the plane after a time [s], over the way.
double slide_error(const Brick& b, double time, bool balanced = false) {
    Scene scene = block_scene(b, InterfaceLaw::coulomb);
    if (balanced) {
        scene.bodies[0].geostatic = true;
        scene.bodies[0].geostatic_surface = b.height;
        scene.bodies[0].geostatic_k0 = 0;
    }
    ContactRun block(scene);
    block.until(time);
    const double a = b.gravity * (std::sin(b.slope) - std::tan(15 * degree) * std::cos(b.slope));
    const double t = block.run.time();
    const double lead = 0.5 * a * t * block.run.sim.clock().dt;  // the velocity is given at t = 0
    const double error = (block.moved(turned(1, 0, b.tilt)) - lead) / (b.speed * t + 0.5 * a * t * t) - 1;
    const auto row = observe(block.run.sim, Comm(MPI_COMM_WORLD));
    for (double e : row.momentum_error) CHECK(std::fabs(e) <= 1e-12 * b.weight() * t);
    return error;
}

}  // namespace

TEST_CASE("C1: a resting block gives its weight to the plane, and does not creep") {
    rests(0);
    rests(0.5);
}

TEST_CASE("C2: a block slides on the exact path under Coulomb friction") {
    Brick b;
    b.slope = 24 * degree;
    b.speed = 0.1;
    const double error = slide_error(b, 0.5, true);
    say(fmt::format("C2 24 degrees, tan 15, 0.25 m: error {:.1e}", error));
    CHECK(std::fabs(error) <= 1e-4);
}

TEST_CASE("C2: below the angle of friction a block stays where it is") {
    Brick b;
    b.slope = 10 * degree;
    ContactRun block(block_scene(b, InterfaceLaw::coulomb));
    block.run.steps(3000);
    const double settled = block.moved(along);
    block.run.steps(20000);
    const double slip = (block.moved(along) - settled) / b.h;
    say(fmt::format("C2 10 degrees, tan 15: slip {:.1e} h in 2e4 steps", slip));
    CHECK(std::fabs(slip) <= 1e-4);
}

TEST_CASE("C4: an undrained interface takes its strength times the area, whatever presses on it") {
    for (double lift : {0.0, 0.25, 0.5})
        for (double gravity : {9.81, 50.0}) {
            Brick b;
            b.lift = lift;
            b.gravity = gravity;
            b.speed = 2;
            Scene scene = block_scene(b, InterfaceLaw::undrained);
            scene.min[0] = 0, scene.max[0] = 8 * b.h;  // all of a periodic strip: no edges
            scene.structures[0].alpha = 0.5;
            scene.structures[0].su = 200;
            ContactRun block(scene);
            block.until(0.1);
            const double before = block.impulse(along), t = block.run.time();
            block.until(0.3);
            const double force = (block.impulse(along) - before) / (block.run.time() - t) / (100 * b.width) - 1;
            say(fmt::format("C4 plane {} cells over a node, g = {}: force {:.1e} of alpha su A", lift, gravity, force));
            CHECK(std::fabs(force) <= 0.01);
        }
}

TEST_CASE("C5: an elastic bar bounces off with its speed after the time of a wave there and back") {
    Brick b;
    b.gravity = 0;
    b.height = 2;
    b.lift = -80;
    b.width = 0.1;
    Scene scene = block_scene(b, InterfaceLaw::smooth);
    scene.min = {0, -100 * b.h, 0}, scene.max = {b.width, 100 * b.h, 0};  // a strip, periodic across
    scene.materials[0] = material("linear-elastic", b.density, {{"young", 1e6}, {"poisson", 0.0}});
    const double c = std::sqrt(1e6 / b.density), speed = 0.01 * c;
    scene.bodies[0].velocity = {0, -speed, 0};
    ContactRun block(scene);
    const double whole = 2 * b.mass() * speed;
    double half = 0;
    while (block.impulse(down) < 0.5 * whole && block.run.time() < 0.1) {
        block.run.steps(1);
        half = block.run.time();
    }
    block.until(2 * (2 * b.height / c));
    const double impulse = block.impulse(down) / whole - 1, duration = 2 * half / (2 * b.height / c) - 1;
    say(fmt::format("C5 160 cells: impulse {:.1e} of 2 m v, duration {:.1e} of 2 L / c", impulse, duration));
    CHECK(std::fabs(impulse) <= 0.01);
    CHECK(std::fabs(duration) <= 0.02);
}

TEST_CASE("C7: at any angle to the grid a block slides as it does along it") {
    for (double tilt : {17.0, 45.0}) {
        Brick b;
        b.slope = 24 * degree;
        b.tilt = tilt * degree;
        b.speed = 0.1;
        const double error = slide_error(b, 0.5);
        say(fmt::format("C7 plane at {} degrees to the grid: way {:.1e}", tilt, error));
        CHECK(std::fabs(error) <= 0.01);
    }
}

TEST_CASE("a free structure on a block comes to rest, and the block bears its weight") {
    Brick b;
    Scene scene = block_scene(b, InterfaceLaw::rough);
    StructureSpec weight;
    weight.name = "weight";
    weight.shape = StructureShape::box;
    weight.min = {-0.02, b.height, 0};
    weight.max = {0.12, b.height + 0.03, 0};
    weight.motion.kind = StructureMotion::free;
    weight.motion.mass = 20;
    scene.structures.push_back(weight);
    scene.damping = 0.2;
    ContactRun block(scene);
    block.run.steps(45000);  // nothing at the contact damps it
    const double before = block.impulse(down), t = block.run.time();
    block.run.steps(2000);
    const double load = (block.impulse(down) - before) / (block.run.time() - t) / (b.weight() + 20 * b.gravity);
    const auto& state = block.run.sim.structures().state(1);
    say(fmt::format("free weight: load {:.6f} of both weights, speed {:.1e} m/s, sunk {:.3f} h", load,
                    state.velocity[1], -state.displacement[1] / b.h));
    CHECK(load == doctest::Approx(1).epsilon(1e-3));
    CHECK(std::fabs(state.velocity[1]) < 1e-6);
    CHECK(std::fabs(state.displacement[1]) < 0.05 * b.h);
}
