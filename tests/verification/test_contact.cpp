// C1 and C2: an elastic block on a rigid plane. It rests with its weight on it, sticks below the angle of friction, and
// slides on the exact path of Coulomb friction above it.
#include "core/structure_set.hpp"
#include "history.hpp"
#include "verification/drive.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

constexpr double h = 0.0125;  ///< [m]
constexpr double density = 1000, height = 0.05, length = 0.1, gravity = 9.81;

/// A block on a plane `lift` cells over a node, under gravity turned by `degrees`.
Scene block_scene(double degrees, double lift, InterfaceLaw law) {
    Scene scene;
    scene.dimensions = 2;
    scene.min = {0, -0.1, 0};
    scene.max = {1.0, 0.2, 0};
    scene.cell = h;
    make_periodic(scene, 0);
    scene.gravity = {gravity * std::sin(degrees * pi / 180), -gravity * std::cos(degrees * pi / 180), 0};
    scene.materials.push_back(material("linear-elastic", density, {{"young", 1e6}, {"poisson", 0.3}}));
    BodySpec body;
    body.min = {0.2, lift * h, 0};
    body.max = {0.2 + length, lift * h + height, 0};
    scene.bodies.push_back(body);
    StructureSpec plane;
    plane.name = "plane";
    plane.normal = {0, 1, 0};
    plane.point = {0, lift * h, 0};
    plane.law = law;
    plane.friction = std::tan(15 * pi / 180);
    scene.structures.push_back(plane);
    return scene;
}

struct Contact {
    explicit Contact(const Scene& scene) : scene_(scene), run(scene_) {}

    /// Mean displacement along an axis [m].
    double moved(std::size_t a) {
        const double n = run.sum([](const auto&, std::uint32_t, const auto&, const auto&) { return 1.0; });
        return run.sum([&](const auto&, std::uint32_t, const auto& X, const auto& x) {
            return std::remainder(x[a] - X[a], scene_.max[a] - scene_.min[a]);
        }) / n;
    }

    /// Impulse that the structure felt so far [N s].
    double impulse(int a) {
        std::vector<StructureSums<2>> felt;
        for (const StructureState<2>& s : run.sim.structures().states()) felt.push_back(s.felt);
        return run.sim.quantum().value(run.sim.sum_of(felt)[0].sum[a]);
    }

  private:
    Scene scene_;

  public:
    Run<> run;
};

void rests(double lift) {
    Contact block(block_scene(0, lift, InterfaceLaw::coulomb));
    block.run.steps(12000);
    const double settled = block.moved(1), before = block.impulse(1), t = block.run.time();
    block.run.steps(10000);
    const double drift = (block.moved(1) - settled) / h;
    const double weight = density * height * length * gravity;
    const double load = (block.impulse(1) - before) / (block.run.time() - t) / -weight - 1;
    say(fmt::format("C1 plane {} cells over a node: load {:.1e}, sunk {:.4f} h, drift {:.1e} h in 1e4 steps", lift,
                    load, -settled / h, drift));
    CHECK(std::fabs(load) <= 1e-6);
    CHECK(std::fabs(settled / h) <= 0.05);
    CHECK(std::fabs(drift) <= 1e-6);
}

}  // namespace

TEST_CASE("C1: a resting block gives its weight to the plane, and does not creep") {
    rests(0);
    rests(0.5);
}

TEST_CASE("C2: a block slides on the exact path under Coulomb friction") {
    Scene scene = block_scene(24, 0, InterfaceLaw::coulomb);
    scene.bodies[0].velocity = {0.1, 0, 0};
    scene.bodies[0].geostatic = true;
    scene.bodies[0].geostatic_surface = height;
    scene.bodies[0].geostatic_k0 = 0;
    Contact block(scene);
    const double angle = 24 * pi / 180;
    const double a = gravity * (std::sin(angle) - std::tan(15 * pi / 180) * std::cos(angle));
    double t = 0, path = 0;
    while (t < 0.5) {
        block.run.steps(500);
        t = block.run.time();
    }
    path = 0.1 * t + 0.5 * a * t * t;
    const double lead = 0.5 * a * t * block.run.sim.clock().dt;  // the velocity is given at t = 0
    const double error = (block.moved(0) - lead) / path - 1;
    say(fmt::format("C2 24 degrees, tan 15: {:.3f} m in {:.2f} s, error {:.1e}", path, t, error));
    CHECK(std::fabs(error) <= 1e-4);
    const auto row = observe(block.run.sim, Comm(MPI_COMM_WORLD));
    const double scale = density * height * length * gravity * t;
    for (double e : row.momentum_error) CHECK(std::fabs(e) <= 1e-12 * scale);
    CHECK(block.impulse(0) / block.impulse(1) == doctest::Approx(-std::tan(15 * pi / 180)).epsilon(1e-3));
}

TEST_CASE("C2: below the angle of friction a block stays where it is") {
    Contact block(block_scene(10, 0, InterfaceLaw::coulomb));
    block.run.steps(3000);
    const double settled = block.moved(0);
    block.run.steps(20000);
    const double slip = (block.moved(0) - settled) / h;
    say(fmt::format("C2 10 degrees, tan 15: slip {:.1e} h in 2e4 steps", slip));
    CHECK(std::fabs(slip) <= 1e-4);
}

TEST_CASE("a free structure on a block comes to rest, and the block bears its weight") {
    Scene scene = block_scene(0, 0, InterfaceLaw::rough);
    StructureSpec weight;
    weight.name = "weight";
    weight.shape = StructureShape::box;
    weight.min = {0.18, height, 0};
    weight.max = {0.32, height + 0.03, 0};
    weight.motion.kind = StructureMotion::free;
    weight.motion.mass = 20;
    scene.structures.push_back(weight);
    scene.damping = 0.2;
    Contact block(scene);
    block.run.steps(20000);
    const double before = block.impulse(1), t = block.run.time();
    block.run.steps(2000);
    const double load = (block.impulse(1) - before) / (block.run.time() - t);
    const auto& state = block.run.sim.structures().state(1);
    say(fmt::format("free weight: load {:.6f} of both weights, speed {:.1e} m/s, sunk {:.3f} h",
                    load / (-(density * height * length + 20) * gravity), state.velocity[1],
                    -state.displacement[1] / h));
    CHECK(load == doctest::Approx(-(density * height * length + 20) * gravity).epsilon(1e-2));
    CHECK(std::fabs(state.velocity[1]) < 1e-3);
    CHECK(std::fabs(state.displacement[1]) < 0.3 * h);
}
