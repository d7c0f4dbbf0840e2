#include <doctest/doctest.h>

#include "core/nodes/nodes.hpp"
#include "core/sample.hpp"
#include "every_case.hpp"

using namespace moraine;
using moraine::test::Node;
using moraine::test::Sample;

namespace {

template <class C>
constexpr double tolerance = sizeof(typename C::Real) == 8 ? 1e-12 : 2e-5;

struct Settings {
    double dt = 0.01;
    double damping = 0;
    double cutoff = 0;
    NodeTask task = NodeTask::solve;
};

/// Particles to tiles, tiles to nodes; returns the impulse of walls and damping.
template <class Real, int Dim>
std::array<double, Dim> run_nodes(Sample<Real, Dim>& sample, const Settings& set, bool sum_first = true) {
    if (sum_first) sample.method.kernels.p2g(sample.call(), sample.method.cell);
    const auto chosen = sample.patch.node_blocks();
    const Quantum quantum = Quantum::for_largest(1e4);
    std::vector<ExactSum> impulse(chosen.size() * Dim);
    Vec<Real, Dim> gravity;
    for (int a = 0; a < Dim; ++a) gravity[a] = Real(3 - 5 * a);
    const SolveNodes<Real, Dim> kernel{
        sample.method.context.walls,
        sample.patch.table(),
        sample.patch.grid(),
        chosen.data(),
        sample.method.stencil.width,
        sample.method.stencil.origin,
        {set.task, static_cast<Real>(set.dt), gravity, static_cast<Real>(set.damping), static_cast<Real>(set.cutoff)},
        quantum,
        impulse.data()};
    Host::launch_teams(static_cast<std::int64_t>(chosen.size()), kernel);
    std::array<double, Dim> all{};
    for (std::size_t a = 0; a < Dim; ++a) {
        ExactSum sum;
        for (std::size_t c = 0; c < chosen.size(); ++c) sum.add(impulse[c * Dim + a]);
        all[a] = quantum.value(sum);
    }
    return all;
}

template <class Real, int Dim>
struct Solved {
    Vec<Real, Dim> velocity, change;
};

/// Velocity and change of every node that was solved.
template <class Real, int Dim>
std::map<Node<Dim>, Solved<Real, Dim>> solved_nodes(Sample<Real, Dim>& sample) {
    std::map<Node<Dim>, Solved<Real, Dim>> nodes;
    const TileView<Real> grid = sample.patch.grid();
    for (std::int32_t c : sample.patch.node_blocks()) {
        if (grid.node_of[c] < 0) continue;
        for (int n = 0; n < Block<Dim>::cells; ++n) {
            const Real* from = grid.nodes + (grid.node_of[c] * Block<Dim>::cells + n) * node_reals;
            Solved<Real, Dim> s;
            for (int a = 0; a < Dim; ++a) s.velocity[a] = from[a], s.change[a] = from[quad + a];
            nodes[node_at(sample, sample.patch.table().node_position[c], n, 4)] = s;
        }
    }
    return nodes;
}

/// v and v' of a node from its sums, by the equations of core/nodes/nodes.hpp.
template <class Real, int Dim>
void expected_velocities(const Sample<Real, Dim>& sample, const Settings& set, const test::PerAxis<int, Dim>& node,
                         const test::NodeSums<Dim>& sums, Vec<double, Dim>& start, Vec<double, Dim>& end) {
    for (int a = 0; a < Dim; ++a) {
        const auto i = static_cast<std::size_t>(a);
        start[a] = end[a] = 0;
        if (sums.mass <= set.cutoff) continue;
        const double pull = sums.force[i] / sums.mass + (3 - 5 * a);
        start[a] = sums.momentum[i] / sums.mass;
        end[a] = start[a] + set.dt * pull;
        if (end[a] != 0) end[a] -= set.damping * set.dt * std::fabs(pull) * (end[a] > 0 ? 1 : -1);
    }
    for (int a = 0; a < Dim; ++a) {
        const auto i = static_cast<std::size_t>(a);
        if (sample.domain.periodic[i]) continue;
        if (node[i] <= 0) end = zero_vec<double, Dim>();
        if (node[i] >= sample.domain.nodes[i]) end[a] = 0;
    }
}

template <class C, class F>
void each_method(const F& f) {
    using moraine::Shape;
    for (Shape shape : {Shape::linear, Shape::gimp, Shape::quadratic, Shape::cubic})
        for (bool periodic : {false, true}) {
            CAPTURE(int(shape));
            CAPTURE(periodic);
            const Scene scene = test::sample_scene(C::dim, shape, periodic);
            Sample<typename C::Real, C::dim> sample(scene, C::dim == 2 ? 400 : 900, 21);
            f(sample);
        }
}

}  // namespace

TEST_CASE_TEMPLATE("nodes move by their sums, gravity, damping and walls as a plain loop says", C, EVERY_CASE) {
    constexpr int dim = C::dim;
    each_method<C>([](auto& sample) {
        for (double damping : {0.0, 0.3}) {
            const Settings set{0.01, damping, 0.1, NodeTask::solve};
            run_nodes(sample, set);
            const auto found = solved_nodes(sample);
            double worst = 0;
            for (const auto& [node, sums] : reference_sums(sample)) {
                if (std::fabs(sums.mass - set.cutoff) < 1e-5) continue;
                Vec<double, dim> start, end;
                expected_velocities(sample, set, node, sums, start, end);
                REQUIRE(found.contains(node));
                const auto& got = found.at(node);
                // A speed is a ratio of sums: the lighter the node, the more of a rounding shows.
                const double scale = 10 + 500 * set.dt / std::max(sums.mass, set.cutoff);
                for (int a = 0; a < dim; ++a) {
                    test::widen(worst, std::fabs(double(got.velocity[a]) - end[a]) / scale);
                    test::widen(worst, std::fabs(double(got.change[a]) - (end[a] - start[a])) / scale);
                }
            }
            CHECK(worst <= tolerance<C>);
        }
    });
}

TEST_CASE_TEMPLATE("what walls and damping take from the momentum is their impulse, each node counted once", C,
                   EVERY_CASE) {
    constexpr int dim = C::dim;
    each_method<C>([](auto& sample) {
        for (double damping : {0.0, 0.3}) {
            const Settings set{0.01, damping, 1e-9, NodeTask::solve};
            const std::array<double, dim> impulse = run_nodes(sample, set);
            const auto found = solved_nodes(sample);
            std::array<double, dim> expected{};
            double mass = 0;
            for (const auto& [node, sums] : reference_sums(sample)) {
                mass += sums.mass;
                for (int a = 0; a < dim; ++a) {
                    const auto i = static_cast<std::size_t>(a);
                    const double free = sums.momentum[i] + set.dt * (sums.force[i] + sums.mass * (3 - 5 * a));
                    if (sums.mass > set.cutoff) expected[i] += sums.mass * double(found.at(node).velocity[a]) - free;
                }
            }
            for (std::size_t a = 0; a < dim; ++a)
                CHECK(std::fabs(impulse[a] - expected[a]) <= 10 * tolerance<C> * mass);
        }
    });
}

TEST_CASE("a node lighter than the cutoff stands still and gives nothing") {
    Sample<double, 2> sample(test::sample_scene(2, moraine::Shape::quadratic, false), 60, 22);
    run_nodes(sample, {0.01, 0, 0.5, NodeTask::solve});
    const auto found = solved_nodes(sample);
    int light = 0;
    for (const auto& [node, sums] : reference_sums(sample)) {
        if (sums.mass > 0.4999) continue;
        ++light;
        for (int a = 0; a < 2; ++a) {
            REQUIRE(found.at(node).velocity[a] == 0);
            REQUIRE(found.at(node).change[a] == 0);
        }
    }
    CHECK(light > 3);
}

TEST_CASE_TEMPLATE("the velocity task keeps the velocity of the round before and adds no force", Real, float, double) {
    Sample<Real, 2> sample(test::sample_scene(2, moraine::Shape::quadratic, false), 400, 23);
    run_nodes(sample, {0.01, 0.2, 0.1, NodeTask::solve});
    const auto before = solved_nodes(sample);
    const std::array<double, 2> impulse = run_nodes(sample, {0.01, 0.2, 0.1, NodeTask::velocity}, false);
    CHECK(impulse[0] == 0);
    CHECK(impulse[1] == 0);
    const auto after = solved_nodes(sample);
    const auto sums = reference_sums(sample);
    for (const auto& [node, s] : before) {
        const bool inside = node[0] > 0 && node[1] > 0 && node[0] < 8 && node[1] < 10;
        for (int a = 0; a < 2; ++a) {
            REQUIRE(after.at(node).change[a] == s.velocity[a]);
            if (inside && sums.contains(node) && sums.at(node).mass > 0.2)
                REQUIRE(double(after.at(node).velocity[a]) ==
                        doctest::Approx(sums.at(node).momentum[static_cast<std::size_t>(a)] / sums.at(node).mass)
                            .epsilon(1e-4));
        }
    }
}

TEST_CASE("a lattice of equal particles at rest falls freely") {
    Sample<double, 3> sample(test::sample_scene(3, moraine::Shape::cubic, true), 500, 24);
    const auto p = sample.patch.particles.view();
    for (std::uint32_t s = 0; s < 500; ++s) {
        p.velocity[s] = zero_vec<double, 3>();
        p.volume[s] = 0;
    }
    run_nodes(sample, {0.25, 0, 1e-9, NodeTask::solve});
    for (const auto& [node, s] : solved_nodes(sample)) {
        if (s.velocity[0] == 0 || node[1] <= 0 || node[2] <= 0 || node[1] >= 10 || node[2] >= 7) continue;
        for (int a = 0; a < 3; ++a) REQUIRE(s.velocity[a] == doctest::Approx(0.25 * (3 - 5 * a)).epsilon(1e-12));
    }
}
