// Ground whose fall is turned against the grid by 0, 10 and 45 degrees: a slab on an incline and one on a parabola go
// where a point mass goes, and a lake on rough ground stays where it is.
#include <cmath>

#include "core/structures/ground.hpp"
#include "simulation/diagnostics.hpp"
#include "verification/drive.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

constexpr double degree = pi / 180, gravity = 9.81;

/// A slab that begins at s0 on ground z(s), s along the fall, which is turned by `angle` in plan.
struct Slab {
    double h, spacing;             ///< cells of the grid and of the heights [m]
    double s0, along, across, up;  ///< place of its middle and its sizes [m]
    double last;                   ///< s up to which the domain reaches [m]
    double friction, speed;        ///< mu; at the start, along the fall [m/s]
    double young, angle;
};

template <class F>
Scene slab_scene(const Slab& b, const F& z, double slope_at_start) {
    Scene scene;
    scene.transfer = Transfer::flip;
    scene.dimensions = 3;
    scene.cell = b.h;
    scene.gravity = {0, 0, -gravity};
    const double c = std::cos(b.angle), s = std::sin(b.angle), spare = b.along + b.across + 8 * b.h;
    const double low = std::min(z(b.s0 - spare), z(b.last)), high = z(b.s0 - spare);
    scene.min = {-spare, -spare, low - 8 * b.h};
    const double reach[3] = {c * b.last + spare, s * b.last + spare, high + 4 * b.up + 8 * b.h};
    for (std::size_t a = 0; a < 3; ++a) scene.max[a] = scene.min[a] + b.h * std::ceil((reach[a] - scene.min[a]) / b.h);
    for (auto& axis : scene.walls)
        for (WallSpec& wall : axis) wall.kind = WallKind::open;
    scene.materials.push_back(material("linear-elastic", 1000, {{"young", b.young}, {"poisson", 0.3}}));
    auto ground = std::make_shared<Ground>();
    ground->spacing = b.spacing;
    for (std::size_t a = 0; a < 2; ++a) {
        ground->first[a] = scene.min[a] - 4 * b.spacing;
        ground->count[a] = std::lround((scene.max[a] - scene.min[a]) / b.spacing) + 9;
    }
    for (std::int64_t j = 0; j < ground->count[1]; ++j)
        for (std::int64_t i = 0; i < ground->count[0]; ++i)
            ground->height.push_back(
                z(c * (ground->first[0] + b.spacing * double(i)) + s * (ground->first[1] + b.spacing * double(j))));
    ground->fit();
    StructureSpec bed;
    bed.name = "terrain", bed.shape = StructureShape::ground, bed.ground = ground;
    bed.law = InterfaceLaw::coulomb, bed.friction = b.friction;
    scene.structures.push_back(bed);
    BodySpec body;
    body.shape = BodyShape::layer, body.ground = ground, body.thickness = b.up;
    const double cosine = 1 / std::sqrt(1 + slope_at_start * slope_at_start);
    for (const auto& [u, v] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)}) {
        const double from = b.s0 + 0.5 * u * b.along * cosine, beside = 0.5 * v * b.across;
        body.points.push_back({c * from - s * beside, s * from + c * beside});
    }
    body.velocity = {b.speed * cosine * c, b.speed * cosine * s, -b.speed * cosine * slope_at_start};
    scene.bodies.push_back(body);
    return scene;
}

/// Mean way in plan along the fall of all particles until the first step that ends at t or later, which is t then.
double way_of(const Scene& scene, double angle, double& t) {
    const Comm comm(MPI_COMM_SELF);
    Simulation<double, 3> sim(scene, comm);
    sim.seed();
    const auto place = [&] {
        double sum = 0;
        each_particle(sim, [&](std::uint32_t, const std::array<double, 3>& x) {
            sum += std::cos(angle) * x[0] + std::sin(angle) * x[1];
        });
        return sum / static_cast<double>(sim.engine().census().particles);
    };
    const double start = place();
    const std::int64_t particles = sim.engine().census().particles;
    while (sim.clock().time < t) sim.step(), sim.balance();
    sim.conclude();
    t = sim.clock().time;
    CHECK(sim.engine().census().particles == particles);
    return place() - start;
}

/// Where a mass whose middle goes d over z = C (1 - s / f)^2, level from f on, stops if it begins over s:
/// dv/dt = g sin - mu (g cos + v^2 / (R - d)), and its base goes R / (R - d) times as fast as its middle.
double stop_of_mass(double s, double d, double height, double foot, double mu) {
    double v = 0;
    const double dt = 1e-3;
    const auto rates = [&](double at, double speed) {
        const double u = std::max(0.0, 1 - at / foot);
        const double slope = 2 * height / foot * u, bend = u > 0 ? 2 * height / (foot * foot) : 0;
        const double sec = std::sqrt(1 + slope * slope), curvature = bend / (sec * sec * sec);
        const double base = 1 / (1 - d * curvature);
        return std::array{base * speed / sec,
                          gravity * slope / sec - mu * (gravity / sec + speed * speed * curvature * base)};
    };
    do {
        const auto k1 = rates(s, v);
        const auto k2 = rates(s + dt * k1[0], v + dt * k1[1]);
        s += dt / 2 * (k1[0] + k2[0]), v += dt / 2 * (k1[1] + k2[1]);
    } while (v > 0);
    return s;
}

}  // namespace

TEST_CASE("a slab on an incline turned against the grid goes as far as a point mass, within 0.1 %") {
    const double slope = std::tan(24 * degree), mu = std::tan(15 * degree), v = 0.1;
    const double pull = gravity * (std::sin(24 * degree) - mu * std::cos(24 * degree));
    for (double turn : {0.0, 10.0, 45.0}) {
        double t = 0.5;
        const Slab b{.h = 0.025,
                     .spacing = 0.2,
                     .s0 = 0,
                     .along = 0.2,
                     .across = 0.1,
                     .up = 0.1,
                     .last = 0.7,
                     .friction = mu,
                     .speed = v,
                     .young = 1e6,
                     .angle = turn * degree};
        const Scene scene = slab_scene(
            b, [&](double s) { return -slope * s; }, slope);
        const double way = way_of(scene, b.angle, t);
        const double exact = (v * t + 0.5 * pull * t * t) * std::cos(24 * degree);
        say(fmt::format("T1 incline of 24 degrees turned by {}: {:.6f} m, error {:.1e}", turn, way, way / exact - 1));
        CHECK(way == doctest::Approx(exact).epsilon(1e-3));
    }
}

TEST_CASE("a slab on a parabola turned against the grid stops where a point mass does, within 0.1 %") {
    const double height = 1000, foot = 2250, mu = 0.4, s0 = 100;
    const double exact = stop_of_mass(s0, 1.25, height, foot, mu);
    const auto sine = [&](double s) {
        const double slope = 2 * height / foot * (1 - s / foot);
        return slope / std::sqrt(1 + slope * slope);
    };
    for (double turn : {0.0, 10.0, 45.0}) {
        const Slab b{.h = 1.25,
                     .spacing = 5,
                     .s0 = s0,
                     .along = 20,
                     .across = 5,
                     .up = 2.5,
                     .last = 2200,
                     .friction = mu,
                     .speed = 0,
                     .young = 2e6,
                     .angle = turn * degree};
        const Scene scene = slab_scene(
            b, [&](double s) { return s < foot ? height * (1 - s / foot) * (1 - s / foot) : 0.0; },
            2 * height / foot * (1 - s0 / foot));
        double end = 90;
        const double way = way_of(scene, b.angle, end);
        const double lean = 0.5 * b.up * (sine(exact) - sine(s0));  // of its middle, which stands over its base
        const double error = way / (exact - s0 + lean) - 1;
        say(fmt::format("T2 parabola turned by {}: {:.1f} m in plan, error {:.1e}", turn, way, error));
        CHECK(std::fabs(error) <= 1e-3);
    }
}

TEST_CASE("a lake on rough ground stays where it is") {
    const double h = 0.1, level = 1;
    Scene scene;
    scene.transfer = Transfer::apic;
    scene.dimensions = 2;
    scene.cell = h;
    scene.min = {0, -0.5, 0}, scene.max = {4, 2, 0};
    scene.gravity = {0, -gravity, 0};
    scene.materials.push_back(material("newtonian", 1000, {{"young", 1e6}, {"poisson", 0.49}, {"viscosity", 10}}));
    const auto z = [&](double x) {
        return 0.1 + 0.4 * (x - 2) * (x - 2) + 0.05 * std::sin(9 * x) + 0.03 * std::sin(23 * x + 1);
    };
    auto ground = std::make_shared<Ground>();
    ground->spacing = 0.05, ground->first[0] = -0.2, ground->count = {89, 1};
    for (int i = 0; i < 89; ++i) ground->height.push_back(z(-0.2 + 0.05 * i));
    ground->fit();
    StructureSpec bed;
    bed.name = "terrain", bed.shape = StructureShape::ground, bed.ground = ground, bed.law = InterfaceLaw::smooth;
    bed.clear = true;
    scene.structures.push_back(bed);
    BodySpec lake;
    lake.min = {0, -0.1, 0}, lake.max = {4, level, 0};  // what is in the ground is left out
    lake.geostatic = true, lake.geostatic_surface = level;
    scene.bodies.push_back(lake);
    const Comm comm(MPI_COMM_SELF);
    Simulation<double, 2> sim(scene, comm);
    sim.seed();
    const auto state = [&](double& middle, double& mean_speed) {
        sim.conclude();
        const Totals<2> t = totals_of(sim);
        middle = t.centre[0] / t.mass, mean_speed = std::sqrt(2 * t.kinetic / t.mass);
    };
    double before = 0, after = 0, speed = 0;
    const auto until = [&](double time) {
        while (sim.clock().time < time) sim.step(), sim.balance();
    };
    until(10);
    state(before, speed);
    until(20);
    state(after, speed);
    say(fmt::format("T6 lake on rough ground: its middle moves {:.1e} h in 10 s, mean speed {:.1e} m/s",
                    (after - before) / h, speed));
    CHECK(std::fabs(after - before) <= 1e-3 * h);
    CHECK(speed <= 2e-3);
}
