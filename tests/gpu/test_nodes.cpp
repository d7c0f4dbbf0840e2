#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numeric>

#include "core/transfer/scene_walls.hpp"
#include "every_case.hpp"
#include "gpu/node_pair.hpp"
#include "gpu/stopwatch.hpp"

using namespace moraine;
using moraine::test::DeviceSample;
using moraine::test::Sample;

namespace {

template <class Real, int Dim>
NodeRound<Real, Dim> round_of(NodeTask task, double damping) {
    NodeRound<Real, Dim> round{task, Real(0.01), {}, Real(damping), Real(0.1)};
    for (int a = 0; a < Dim; ++a) round.gravity[a] = Real(3 - 5 * a);
    return round;
}

/// Every kind of wall on some face; friction where particles press against it and where they do not.
inline Scene scene_with_walls(int dim, moraine::Shape shape, bool periodic) {
    Scene scene = test::sample_scene(dim, shape, periodic);
    const WallSpec kinds[3][2] = {{{WallKind::friction, 0.4}, {WallKind::none, 0}},
                                  {{WallKind::friction, 0.2}, {WallKind::free_slip, 0}},
                                  {{WallKind::no_slip, 0}, {WallKind::open, 0}}};
    for (std::size_t a = periodic ? 1 : 0; a < static_cast<std::size_t>(dim); ++a)
        for (std::size_t s = 0; s < 2; ++s) scene.walls[a][s] = kinds[a][s];
    if (dim == 2) scene.walls[1][1] = {WallKind::no_slip, 0};
    return scene;
}

template <class C, class F>
void each_pair(const F& f) {
    using moraine::Shape;
    for (Shape shape : {Shape::linear, Shape::gimp, Shape::quadratic, Shape::cubic})
        for (bool periodic : {false, true})
            for (int particles : {C::dim == 2 ? 400 : 900, 12}) {
                CAPTURE(int(shape));
                CAPTURE(periodic);
                CAPTURE(particles);
                test::NodePair<typename C::Real, C::dim> pair(scene_with_walls(C::dim, shape, periodic), particles);
                f(pair);
            }
}

}  // namespace

TEST_CASE_TEMPLATE("the device marks node blocks with light nodes, and leaves the masses", C, EVERY_CASE) {
    each_pair<C>([](auto& pair) {
        pair.marking = true;
        const auto round = round_of<typename C::Real, C::dim>(NodeTask::solve, 0.0);
        for (double mass : {0.0, 0.37, 1.93, 1e9}) {
            CAPTURE(mass);
            pair.light_mass = static_cast<typename C::Real>(mass);
            pair.on_host(round);
            pair.on_device(round);
            CHECK(pair.difference() <= 10 * C::tolerance);
            CHECK(pair.marks_are_right());
        }
    });
}

TEST_CASE_TEMPLATE("the device moves nodes as the host does, for both tasks, with damping and walls of all kinds", C,
                   EVERY_CASE) {
    each_pair<C>([](auto& pair) {
        for (double damping : {0.0, 0.3})
            for (NodeTask task : {NodeTask::solve, NodeTask::velocity, NodeTask::again}) {
                CAPTURE(damping);
                const auto round = round_of<typename C::Real, C::dim>(task, damping);
                const auto expected = pair.on_host(round);
                const auto found = pair.on_device(round);
                CHECK(pair.difference() <= 10 * C::tolerance);
                for (std::size_t a = 0; a < C::dim; ++a) {
                    const double impulse = pair.quantum.value(expected[a]);
                    CHECK(std::fabs(pair.quantum.value(found[a]) - impulse) <= 10 * C::tolerance * 900);
                    if (!counts(task)) CHECK(impulse == 0);
                }
            }
    });
}

TEST_CASE_TEMPLATE("the device's nodes touch structures of every shape as the host's do, and feel the same", C,
                   EVERY_CASE) {
    each_pair<C>([](auto& pair) {
        Scene scene = pair.sample.scene;
        for (int shape = 0; shape < 6; ++shape) {
            if (C::dim == 2 && shape == int(StructureShape::cylinder)) continue;
            StructureSpec s;
            s.shape = static_cast<StructureShape>(shape);
            s.law = static_cast<InterfaceLaw>(shape % 4);
            s.friction = 0.3, s.alpha = 0.5, s.su = 1e4;
            // No node on an axis, an edge or a corner: there the normal is a matter of rounding.
            s.point = {0, 0.7, 0}, s.normal = {0.2, 1, 0.1};
            s.center = {1.03, 2.06, 1.44}, s.radius = 0.6;
            s.from = {2.53, 2.47, 1.02}, s.to = {2.96, 3.41, 1.93};
            s.min = {2.04, 0.46, 0.53}, s.max = {2.93, 1.47, 1.98};
            s.points = {{0.53, 3.02}, {1.47, 3.46}, {0.71, 4.43}};
            s.motion.kind = StructureMotion::velocity;
            // No two alike: at a node that follows one a like one is approached by a matter of rounding.
            s.motion.velocity = {0.1 + 0.03 * shape, 0.5 - 0.02 * shape, -0.2 + 0.05 * shape};
            scene.structures.push_back(s);
        }
        StructureSet<C::dim> structures(scene);
        structures.begin_step(0, 0.01, {}, {}, {});
        pair.find_gaps(structures);
        CHECK(pair.difference_of_gaps() <= (sizeof(typename C::Real) == 8 ? 2e-7 : 1e-5));
        const auto round = round_of<typename C::Real, C::dim>(NodeTask::solve, 0.3);
        pair.template on_host<true>(round, structures.field());
        pair.on_device(round, &structures);
        CHECK(pair.difference() <= 10 * C::tolerance);
        double most = 0;
        for (std::size_t k = 0; k < structures.size(); ++k)
            for (int q = 0; q < StructureSums<C::dim>::count; ++q) {
                const double felt = pair.quantum.value(pair.felt_on_host[k].sum[q]);
                most = std::max(most, std::fabs(felt));
                CHECK(std::fabs(pair.quantum.value(pair.felt_on_device[k].sum[q]) - felt) <= 1e4 * C::tolerance);
            }
        CHECK(most > 0);
        const auto [apart, moved] = pair.limit_depths(structures);
        CHECK(apart <= (sizeof(typename C::Real) == 8 ? 1e-14 : 1e-8));
        if (pair.sample.patch.particles.size() > 100) CHECK(moved > 5);
    });
}

TEST_CASE_TEMPLATE("impulses of a second run are the same to the bit", C, EVERY_CASE) {
    each_pair<C>([](auto& pair) {
        const auto round = round_of<typename C::Real, C::dim>(NodeTask::solve, 0.3);
        const auto first = pair.on_device(round), second = pair.on_device(round);
        for (std::size_t a = 0; a < C::dim; ++a) {
            CHECK(first[a].high == second[a].high);
            CHECK(first[a].low == second[a].low);
            CHECK((first[a].high != 0 || first[a].low != 0));
        }
    });
}

TEST_CASE_TEMPLATE("where blocks belong to others, nodes are counted by the owner of the first block that covers them",
                   C, EVERY_CASE) {
    each_pair<C>([](auto& pair) {
        const auto round = round_of<typename C::Real, C::dim>(NodeTask::solve, 0.3);
        const int all = pair.own;
        for (int own : {all / 3, all - 1}) {
            pair.own = own;
            const auto expected = pair.on_host(round);
            const auto found = pair.on_device(round);
            for (std::size_t a = 0; a < C::dim; ++a)
                CHECK(std::fabs(pair.quantum.value(found[a]) - pair.quantum.value(expected[a])) <=
                      10 * C::tolerance * 900);
        }
    });
}

namespace {

/// 32 x 32 x 32 blocks, periodic in x and y, walls below and above; tiles of any numbers.
template <class Real>
void time_nodes(double damping) {
    constexpr int dim = 3;
    Scene scene = test::sample_scene(dim, moraine::Shape::quadratic, true);
    scene.cell = 1, scene.max = {128, 128, 127}, scene.periodic = {true, true, false};
    for (auto& wall : scene.walls[1]) wall.kind = WallKind::periodic;
    const DomainBlocks<dim> domain(scene);
    const Stencil stencil = stencil_of(scene.shape);
    std::vector<OccupiedBlock> occupied;
    for (int i = 0; i < 32 * 32 * 32; ++i)
        occupied.push_back({Morton<dim>::encode({i % 32, i / 32 % 32, i / 1024}), 0});
    std::sort(occupied.begin(), occupied.end(), [](const auto& a, const auto& b) { return a.key < b.key; });
    const EpochTables<dim> e =
        make_epoch<dim>(make_topology<dim>(domain, occupied, [](const auto&) { return 0; }), domain, stencil, 0);
    std::vector<std::int32_t> numbers(e.node_key.size());
    std::iota(numbers.begin(), numbers.end(), 0);
    gpu::Array<std::int32_t> source, tile_of, node_of;
    gpu::Array<Vec<std::int32_t, dim>> node_position;
    gpu::Array<std::uint8_t> node_border;
    gpu::Array<Quad<Real>> tiles, nodes;
    gpu::Array<gpu::Account<dim>> accounts;
    source.assign(e.source), node_position.assign(e.node_position), node_border.assign(e.node_border);
    tile_of.assign(numbers.data(), e.own.size()), node_of.assign(numbers);
    std::vector<Quad<Real>> some(e.own.size() * 216 * 2);
    std::mt19937_64 random(3);
    for (Quad<Real>& q : some)
        q = Quad<Real>::of(Real(random() % 1000 + 1), Real(random() % 999), Real(random() % 999), Real(random() % 999));
    tiles.assign(some), nodes.resize(numbers.size() * 64 * 2);
    accounts.assign(std::vector<gpu::Account<dim>>(gpu::account_parts));
    gpu::View<Real, dim> view{};
    view.table.own = static_cast<int>(e.own.size()), view.table.node_blocks = static_cast<int>(e.node_key.size());
    view.table.source = source.data(), view.table.node_position = node_position.data();
    view.table.node_border = node_border.data();
    view.grid = {tile_of.data(), reinterpret_cast<Real*>(tiles.data()), node_of.data(),
                 reinterpret_cast<Real*>(nodes.data())};
    view.context.walls = make_walls<Real, dim>(scene);
    view.accounts = accounts.data();
    const auto round = round_of<Real, dim>(NodeTask::solve, damping);
    gpu::Nodes<Real, dim> nodes_kernel(gpu::device_kernel_key<Real, dim>(scene));
    const double ms = test::median_ms(
        20, [] {}, [&] { nodes_kernel.solve(view, stencil, round, Quantum::for_largest(1e9), {}, nullptr); });
    std::printf("nodes %s, damping %.1f: %zu blocks, %zu node blocks, %.4f ms\n",
                sizeof(Real) == 4 ? "single" : "double", damping, e.own.size(), numbers.size(), ms);
}

}  // namespace

TEST_CASE("timing of nodes, where MORAINE_TIMING asks for it") {
    if (!std::getenv("MORAINE_TIMING")) return;
    for (double damping : {0.0, 0.1}) time_nodes<float>(damping), time_nodes<double>(damping);
}
