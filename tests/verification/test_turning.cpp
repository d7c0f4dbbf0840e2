// Structures that turn: what the soil loses of momentum and of angular momentum they get, to rounding, in every step
// and in all of a run, at nodes and on surfaces.
#include "verification/drive.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

/// A block of rubber flies into a free structure off its middle, without gravity and far from walls.
template <int Dim>
Scene collision(StructureShape shape, InterfaceLaw law, Bed bed) {
    Scene scene;
    scene.dimensions = Dim;
    scene.transfer = Transfer::apic;
    scene.bed = bed;
    scene.limits_light_nodes = false;
    scene.cell = 0.1;
    scene.min = {-2, -2, -2};
    scene.max = {2, 2, 2};
    scene.materials.push_back(material("linear-elastic", 1000, {{"young", 1e5}, {"poisson", 0.3}}));
    BodySpec body;
    body.velocity = {0.3, -1, 0.2};
    body.min = {-0.33, 0.21, -0.2};
    body.max = {0.17, 0.61, 0.2};
    scene.bodies.push_back(body);
    StructureSpec s;
    s.name = "boulder";
    s.shape = shape;
    s.min = {-0.3, -0.2, -0.25};
    s.max = {0.5, 0.2, 0.3};
    s.center = {0.1, -0.1, 0.05};
    s.radius = 0.3;
    s.points = {{-0.4, -0.2}, {0.6, -0.3}, {0.4, 0.2}, {-0.3, 0.18}};
    s.law = law;
    s.friction = 0.4;
    s.motion.kind = StructureMotion::free;
    s.motion.turns = true;
    s.motion.mass = Dim == 2 ? 150 : 60;
    s.motion.angular_velocity = Dim == 2 ? std::vector<double>{1.5} : std::vector<double>{1.5, 0.4, -0.7};
    scene.structures.push_back(s);
    return scene;
}

/// Momentum and angular momentum about the origin.
template <int Dim>
struct Momenta {
    Vec<double, Dim> linear = zero_vec<double, Dim>();
    Vec<double, moments<Dim>> angular = zero_vec<double, moments<Dim>>();
};

/// Of all particles, with that of their affine fields: C turns what lies sqrt(D) off, D = h^2 / 4.
template <int Dim>
Momenta<Dim> of_soil(Run<double, Dim>& run, double h) {
    Momenta<Dim> all;
    const auto velocity = [](const auto& p, std::uint32_t s) {
        Vec<double, Dim> v;
        for (int a = 0; a < Dim; ++a) v[a] = p.velocity[s][a];
        return v;
    };
    for (int a = 0; a < Dim; ++a)
        all.linear[a] = run.sum(
            [&](const auto& p, std::uint32_t s, const auto&, const auto&) { return p.mass[s] * velocity(p, s)[a]; });
    for (int a = 0; a < moments<Dim>; ++a)
        all.angular[a] = run.sum([&](const auto& p, std::uint32_t s, const auto&, const auto& x) {
            Vec<double, Dim> at;
            for (int b = 0; b < Dim; ++b) at[b] = x[static_cast<std::size_t>(b)];
            const int i = Dim == 2 ? 0 : (a + 1) % 3, j = Dim == 2 ? 1 : (a + 2) % 3;
            const double own = h * h / 4 * (p.affine[s](j, i) - p.affine[s](i, j));
            return p.mass[s] * (moment_of(at, velocity(p, s))[a] + own);
        });
    return all;
}

/// What the structure has felt since the start, about its centre as it was then.
template <int Dim>
Momenta<Dim> felt(Run<double, Dim>& run) {
    const StructureSums<Dim> all = run.sim.comm().exact_sum(run.sim.structures().state(0).felt);
    Momenta<Dim> m;
    for (int a = 0; a < Dim; ++a) m.linear[a] = run.sim.quantum().value(all.sum[a]);
    for (int a = 0; a < moments<Dim>; ++a) m.angular[a] = run.sim.quantum().value(all.sum[Dim + a]);
    return m;
}

template <int Dim>
void exchange(StructureShape shape, InterfaceLaw law, Bed bed) {
    const Scene scene = collision<Dim>(shape, law, bed);
    Run<double, Dim> run(scene);
    const Vec<double, Dim> centre = centre_of_mass<Dim>(scene.structures[0]);
    const Momenta<Dim> start = of_soil(run, scene.cell);
    Momenta<Dim> before = start, last = felt(run), lost;
    const StructureState<Dim>& state = run.sim.structures().state(0);
    const Vec<double, moments<Dim>> spin = state.carried_spin;
    double linear = 0, angular = 0, size = 0, turned = 0;
    for (int k = 0; k < 150; ++k) {
        const Vec<double, Dim> at = centre - (-1.0) * state.displacement;  // where contact acts in this step
        run.steps(1);
        const Momenta<Dim> soil = of_soil(run, scene.cell), now = felt(run);
        const Vec<double, Dim> impulse = now.linear - last.linear;
        const Vec<double, moments<Dim>> moment = moment_of(at, impulse) - (-1.0) * (now.angular - last.angular);
        linear = std::fmax(linear, magnitude(soil.linear - before.linear - (-1.0) * impulse));
        angular = std::fmax(angular, magnitude(soil.angular - before.angular - (-1.0) * moment));
        size = std::fmax(size, magnitude(soil.angular));
        lost.linear = lost.linear - (-1.0) * impulse;
        lost.angular = lost.angular - (-1.0) * moment;
        before = soil, last = now;
    }
    run.steps(1);  // it feels the last impulse now
    const double gained = scene.structures[0].motion.mass * magnitude(state.carried);
    turned = magnitude(state.carried_spin - spin - last.angular);
    say(fmt::format(
        "turning {}-D, {}: momentum {:.1e}, angular {:.1e} of a step, over theirs; given {:.3g} N s, {:.3g} N m s", Dim,
        bed == Bed::surface ? "surface" : "nodes", linear / magnitude(start.linear), angular / size,
        magnitude(lost.linear), magnitude(last.angular)));
    CHECK(magnitude(lost.linear) > 0.1 * magnitude(start.linear));
    CHECK(linear < 1e-13 * magnitude(start.linear));
    CHECK(angular < 1e-13 * size);
    CHECK(std::fabs(gained - magnitude(lost.linear)) < 1e-12 * gained);
    CHECK(turned < 1e-12 * size);
}

}  // namespace

TEST_CASE("momentum and angular momentum go from the soil into a structure that turns, to rounding") {
    for (const Bed bed : {Bed::nodes, Bed::surface}) {
        exchange<2>(StructureShape::box, InterfaceLaw::coulomb, bed);
        exchange<2>(StructureShape::polygon, InterfaceLaw::rough, bed);
        exchange<3>(StructureShape::box, InterfaceLaw::coulomb, bed);
    }
}
