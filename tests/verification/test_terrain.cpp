// Ground from heights: an incline is the plane that it is, a block on a parabola goes where a point mass goes, what
// rests on rough ground stays, and a slab under Voellmy's law comes to its speed.
#include "core/structures/ground.hpp"
#include "verification/contact_block.hpp"
#include "verification/drive.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

constexpr double degree = pi / 180;
constexpr Triple along{1, 0, 0};

/// A profile of f under the domain and beyond it in place of the first structure.
template <class F>
void lay_ground(Scene& scene, double spacing, const F& f) {
    auto ground = std::make_shared<Ground>();
    ground->spacing = spacing;
    ground->first[0] = scene.min[0] - 4 * spacing;
    ground->count[0] = std::lround((scene.max[0] - scene.min[0]) / spacing) + 9;
    for (std::int64_t i = 0; i < ground->count[0]; ++i)
        ground->height.push_back(f(ground->first[0] + spacing * double(i)));
    ground->fit();
    scene.structures[0].shape = StructureShape::ground;
    scene.structures[0].ground = ground;
}

double path_on_incline(bool as_ground, bool with_raster = false) {
    Brick b;
    b.slope = 24 * degree;
    b.tilt = -b.slope;
    b.speed = 0.1;
    Scene scene = block_scene(b, InterfaceLaw::coulomb);
    if (as_ground) lay_ground(scene, 20 * b.h, [&](double x) { return -std::tan(b.slope) * x; });
    if (with_raster) {
        auto ground = std::make_shared<Ground>(*scene.structures[0].ground);
        ground->friction.assign(ground->height.size(), scene.structures[0].friction);
        scene.structures[0].ground = ground;
        scene.structures[0].friction = 0;
    }
    ContactRun block(scene);
    block.until(0.5);
    return block.moved(turned(1, 0, b.tilt));
}

/// Where a point mass from x stops: g sin - mu (g cos + v^2 / R) along z = C (1 - x / f)^2, level from f on.
double stop_of_point(double x, double height, double foot, double mu, double g) {
    double v = 0;
    const double dt = 1e-3;
    const auto rates = [&](double at, double speed) {
        const double u = std::max(0.0, 1 - at / foot);
        const double slope = 2 * height / foot * u, bend = u > 0 ? 2 * height / (foot * foot) : 0;
        const double sec = std::sqrt(1 + slope * slope);
        return std::array{speed / sec, g * slope / sec - mu * (g / sec + speed * speed * bend / (sec * sec * sec))};
    };
    do {
        const auto k1 = rates(x, v);
        const auto k2 = rates(x + dt * k1[0], v + dt * k1[1]);
        x += dt / 2 * (k1[0] + k2[0]), v += dt / 2 * (k1[1] + k2[1]);
    } while (v > 0);
    return x;
}

}  // namespace

TEST_CASE("an incline as heights is the plane: paths agree to 2e-4") {
    const double plane = path_on_incline(false), ground = path_on_incline(true);
    say(fmt::format("T1 incline of 24 degrees: {:.6f} m on the plane, {:.1e} of it less on heights", plane,
                    1 - ground / plane));
    CHECK(std::fabs(ground / plane - 1) <= 2e-4);
}

TEST_CASE("friction by a raster of one value is that value") {
    CHECK(path_on_incline(true, true) == doctest::Approx(path_on_incline(true)).epsilon(1e-12));
}

TEST_CASE("a particle more than a cell under the ground ends the run with its place") {
    Brick b;
    b.lift = -3;
    Scene scene = block_scene(b, InterfaceLaw::coulomb);
    scene.periodic = {};
    lay_ground(scene, 20 * b.h, [](double) { return 0.0; });
    ContactRun block(scene);
    std::string said;
    try {
        block.until(0.5);
    } catch (const PhysicsError& e) {
        said = e.what();
    }
    CAPTURE(said);
    CHECK(said.find("particle 0 at (0.003125, -0.034375) m is more than a cell under the ground") != std::string::npos);
}

TEST_CASE("a block on a parabola stops where the point mass does") {
    const double height = 1000, foot = 2250, h = 1.25, x0 = 100;
    const auto z = [&](double x) { return x < foot ? height * (1 - x / foot) * (1 - x / foot) : 0.0; };
    Scene scene = block_scene({.h = h, .tilt = 1}, InterfaceLaw::coulomb);
    scene.min = {0, -100, 0}, scene.max = {2400, 1100, 0};
    scene.gravity = {0, -9.81, 0};
    scene.materials[0] = material("linear-elastic", 1000, {{"young", 2e6}, {"poisson", 0.3}});
    scene.structures[0].friction = 0.4;
    lay_ground(scene, 5, z);
    const double slope = 2 * height / foot * (1 - x0 / foot), sec = std::sqrt(1 + slope * slope);
    scene.bodies[0].velocity = {};
    scene.bodies[0].points.clear();
    for (const auto& [a, u] :
         {std::pair(-10.0, 0.03), std::pair(10.0, 0.03), std::pair(10.0, 2.53), std::pair(-10.0, 2.53)})
        scene.bodies[0].points.push_back({x0 + (a + u * slope) / sec, z(x0) + (u - a * slope) / sec});
    ContactRun block(scene);
    block.until(90);
    // What the middle of the block, 1.28 m over the ground, goes in plan besides what its base goes.
    const double exact = stop_of_point(x0, height, foot, 0.4, 9.81),
                 stop_slope = 2 * height / foot * (1 - exact / foot);
    const double lean = 1.28 * (stop_slope / std::sqrt(1 + stop_slope * stop_slope) - slope / sec);
    const double n = block.run.sum([](const auto&, std::uint32_t, const auto&, const auto&) { return 1.0; });
    const double moved =
        block.run.sum([](const auto&, std::uint32_t, const auto& X, const auto& x) { return x[0] - X[0]; }) / n;
    const double error = moved / (exact - x0 + lean) - 1;
    say(fmt::format("T2 parabola: {:.1f} m in plan, error {:.1e}", exact - x0, error));
    CHECK(std::fabs(error) <= 1e-3);
}

TEST_CASE("a slab under Voellmy's law has the speed of the exact solution") {
    for (int cells : {2, 4, 8}) {
        Brick b;
        b.slope = 24 * degree;
        b.width = 16 * b.h;
        b.height = cells * b.h;
        const double mu = 0.1, xi = 500;
        const double drive = std::sin(b.slope) - mu * std::cos(b.slope), steady = std::sqrt(xi * b.height * drive);
        b.speed = 0.8 * steady;
        Scene scene = block_scene(b, InterfaceLaw::voellmy);
        scene.min[0] = 0, scene.max[0] = b.width;
        StructureSpec& bed = scene.structures[0];
        bed.friction = mu, bed.xi = xi, bed.density = b.density;
        ContactRun slab(scene);
        slab.until(0.5);
        const double speed = slab.run.sum([](const auto& p, std::uint32_t s, const auto&, const auto&) {
            return double(p.mass[s]) * double(p.velocity[s][0]);
        }) / (b.density * b.height * b.width);
        const double exact = steady * std::tanh(b.gravity * drive / steady * slab.run.time() + std::atanh(0.8));
        say(fmt::format("T7 Voellmy, {} cells: {:.4f} m/s, exact {:.4f}", cells, speed, exact));
        CHECK(speed == doctest::Approx(exact).epsilon(0.01));
    }
}

TEST_CASE("a slab on rough ground stays where it is") {
    Brick b;
    Scene scene = block_scene(b, InterfaceLaw::coulomb);
    scene.gravity = turned(b.gravity * std::sin(8 * degree), -b.gravity * std::cos(8 * degree), 0);
    lay_ground(scene, 2 * b.h, [&](double x) { return -0.1 * b.h * (1 + std::sin(2 * pi * x / (10 * b.h))); });
    ContactRun slab(scene);
    slab.run.steps(4000);
    const double settled = slab.moved(along);
    slab.run.steps(10000);
    const double creep = (slab.moved(along) - settled) / b.h;
    say(fmt::format("T6 slab on rough ground, 8 degrees, tan 15: {:.1e} h in 1e4 steps", creep));
    CHECK(std::fabs(creep) <= 1e-4);
}
