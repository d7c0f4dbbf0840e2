#include <doctest/doctest.h>

#include "core/data/hash.hpp"
#include "core/fluid/particle_shifting.hpp"
#include "core/sample.hpp"
#include "core/structures/structure_set.hpp"

using namespace moraine;
using moraine::test::Node;
using moraine::test::Sample;

namespace {

constexpr double shifting = 0.02;  // n gamma c h [m2/s], with dt = 1 s

/// Gives the nodes volumes and no velocity, and moves the particles of body 1 by their shift alone.
template <class Real, int Dim, class Filling>
void shift_all(Sample<Real, Dim>& sample, const Filling& filling, const ContactField<Dim>& contact = {}) {
    const TileView<Real> grid = sample.patch.grid();
    for (std::int32_t c : sample.patch.node_blocks()) {
        if (grid.node_of[c] < 0) continue;
        for (int n = 0; n < Block<Dim>::cells; ++n) {
            Real* to = grid.nodes + (grid.node_of[c] * Block<Dim>::cells + n) * node_reals;
            std::fill_n(to, node_reals, Real(0));
            const Node<Dim> node = node_at(sample, sample.patch.table().node_position[c], n, 4);
            to[quad - 1] = Real(500);  // kg
            to[2 * quad - 1] = static_cast<Real>(filling(node) * std::pow(sample.scene.cell, Dim) / 500);
        }
    }
    const FluidTerms<Real> fluid[] = {{}, {Real(0), Real(1e-6), Real(shifting)}};
    const Shifting<Real, Dim> rules{
        sample.method.capacity, static_cast<Real>(std::pow(sample.scene.cell, -Dim)), sample.method.ends, contact, {}};
    GatherCall<Real, Dim> gather{
        {nullptr, 0, nullptr}, sample.method.ends, sample.round(gather_motion, 1), sample.notes()};
    gather.terms.template get<ShiftingTerm<Real, Dim>>() = {fluid, &rules, nullptr};
    sample.method.kernels.g2p(sample.call(), gather);
}

/// Where the particles are [cells], those that changed their block too: by list entry.
template <class Real, int Dim>
std::map<std::uint32_t, std::array<double, Dim>> places(Sample<Real, Dim>& sample, bool moved) {
    std::map<std::uint32_t, std::array<double, Dim>> x;
    const ListView<Dim> list = sample.patch.list();
    for (int b = 0; b < sample.patch.own(); ++b)
        for (std::uint32_t k = list.first[b]; k < list.first[b + 1]; ++k)
            for (int a = 0; a < Dim; ++a) {
                int block = sample.patch.table().position[b][a];
                if (moved) block += Block<Dim>::offset(move_code(sample.patch.moves()[k]), a);
                const auto& u = sample.patch.particles.view().position[list.slot[k]][a];
                x[list.slot[k]][static_cast<std::size_t>(a)] =
                    local_of<Real>(block, u) - sample.method.stencil.offset();
            }
    return x;
}

/// A number in [0, 2) for each node: over-filled and not.
double filling_at(const Node<2>& node) {
    std::uint64_t h = mix(7);
    for (int i : node) h = mix(h ^ static_cast<std::uint64_t>(i + 100));
    return std::ldexp(static_cast<double>(h >> 11), -52);
}

/// e_i by a plain reading: what is above capacity, and on beds what is missing under nodes that are full.
template <class Capacity>
double plain_excess(const Scene& scene, const DomainBlocks<2>& domain, const Capacity& capacity, const Node<2>& node) {
    const double e = filling_at(node) / double(capacity.of(node.data())) - 1;
    bool bed = false, full = true;
    for (std::size_t a = 0; a < 2; ++a) {
        const double g = scene.gravity[a];
        if (scene.periodic[a] || g == 0 || node[a] != (g < 0 ? 0 : domain.nodes[a])) continue;
        Node<2> above = node;
        above[a] += g < 0 ? 1 : -1;
        bed = true;
        full = full && filling_at(above) > 0.9 * double(capacity.of(above.data()));
    }
    return bed && full && e < -0.05 ? e : std::max(0.0, e);
}

}  // namespace

TEST_CASE("a node's excess is its volume above its capacity, and nothing below") {
    CHECK(node_excess(1.5, 1.0) == doctest::Approx(0.5));
    CHECK(node_excess(1.5, 0.5) == doctest::Approx(2));
    CHECK(node_excess(0.95, 1.0) == 0);
    CHECK(node_excess(std::nan(""), 1.0) == 0);
}

TEST_CASE("beside a surface a node's capacity is what is open of it, and next to nothing does not count") {
    CHECK(excess_beside({0.2, 0.5}, 0.75) == doctest::Approx(0.5));
    CHECK(excess_beside({0.2, 0.5}, 0.45) == 0);
    CHECK(excess_beside({-0.9, 0.05}, 0.75) == 0);
    const SpaceNode near{1.4, 1}, far{1.6, 1};
    CHECK(limits_node(&near));
    CHECK_FALSE(limits_node(&far));
    CHECK_FALSE(limits_node(nullptr));
}

TEST_CASE("what goes into a surface nearer than a quarter of a cell is taken from a shift") {
    const Vec<double, 2> up = {{-0.6, 0.8}};
    const auto kept = [&](double distance, const Vec<double, 2>& by) {
        Vec<double, 2> shift = by;
        keep_from_surface(distance, up, shift);
        return shift;
    };
    const Vec<double, 2> into = {{0.0, -0.05}}, out = {{0.0, 0.05}};
    CHECK(dot(kept(0.2, into), up) == doctest::Approx(0));
    CHECK(kept(0.2, into)[0] == doctest::Approx(-0.024));
    CHECK(kept(0.3, into)[1] == -0.05);
    CHECK(kept(0.2, out)[1] == 0.05);
}

TEST_CASE("a shift goes down the gradient, and at most a twentieth of a cell") {
    Vec<double, 2> gradient = {{3, -4}};
    const Vec<double, 2> shift = shift_by(0.001, 0.5, 0.1, gradient);
    CHECK(shift[0] == doctest::Approx(-0.0015));
    CHECK(shift[1] == doctest::Approx(0.002));
    const Vec<double, 2> longest = shift_by(1.0, 0.5, 0.1, gradient);
    CHECK(std::hypot(longest[0], longest[1]) == doctest::Approx(0.005));
    CHECK(longest[1] / longest[0] == doctest::Approx(-4.0 / 3));
}

TEST_CASE("one step in five shifts, by its number") {
    int shifts = 0;
    for (std::int64_t step = 0; step < 20; ++step) shifts += shifts_in(step);
    CHECK(shifts == 4);
    CHECK(shifts_in(4));
    CHECK(!shifts_in(0));
}

TEST_CASE_TEMPLATE("particles of the fluid are shifted by what a plain loop over nodes says", Real, float, double) {
    using moraine::Shape;
    for (Shape shape : {Shape::linear, Shape::gimp, Shape::quadratic, Shape::cubic})
        for (Transfer transfer : {Transfer::flip, Transfer::apic})
            for (bool periodic : {false, true}) {
                if (shape == Shape::linear && transfer == Transfer::apic) continue;
                CAPTURE(int(shape));
                Scene scene = test::sample_scene(2, shape, periodic);
                scene.transfer = transfer;
                scene.gravity = {transfer == Transfer::flip ? 0.0 : 2.0, -9.81, 0};
                Sample<Real, 2> sample(scene, 900, 3);
                const auto before = places(sample, false);
                std::map<std::uint32_t, Vec<double, 2>> expected;
                const auto p = sample.patch.particles.view();
                for (const auto& [s, x] : before) {
                    Vec<double, 2> slope = {{0, 0}};
                    each_weight(sample, s, x, [&](const Node<2>& node, double, const auto& dw, const auto&) {
                        const double e = plain_excess(scene, sample.domain, sample.method.capacity, node);
                        for (int a = 0; a < 2; ++a) slope[a] += e * dw[static_cast<std::size_t>(a)] / scene.cell;
                    });
                    expected[s] = shift_by(shifting, 1.0, scene.cell, slope);
                    for (int a = 0; a < 2; ++a) {
                        const auto i = static_cast<std::size_t>(a);
                        const double n = sample.domain.nodes[i], to = expected[s][a] < 0 ? x[i] : n - x[i];
                        if (p.body[s] == 0 || (!scene.periodic[i] && to < kept_from_ends)) expected[s][a] = 0;
                    }
                }
                shift_all(sample, filling_at);
                double worst = 0, most = 0;
                for (const auto& [s, x] : places(sample, true))
                    for (int a = 0; a < 2; ++a) {
                        const auto i = static_cast<std::size_t>(a);
                        const double found = (x[i] - before.at(s)[i]) * scene.cell;
                        test::widen(worst, std::fabs(found - expected[s][a]));
                        test::widen(most, std::fabs(found));
                    }
                CHECK(most > 0.01);
                CHECK(worst <= (sizeof(Real) == 8 ? 1e-12 : 1e-6));
            }
}

TEST_CASE("nothing is shifted beside a structure, by whatever way it is reached") {
    Scene scene = test::sample_scene(2, moraine::Shape::quadratic, false);
    StructureSpec disk;
    disk.shape = StructureShape::sphere;
    disk.center = {2, 2.5, 0};
    disk.radius = 0.6;
    scene.structures.push_back(disk);
    const StructureSet<2> structures(scene);
    Sample<double, 2> sample(scene, 900, 3);
    const auto before = places(sample, false);
    shift_all(sample, filling_at, structures.field());
    const auto p = sample.patch.particles.view();
    int near = 0, far = 0;
    for (const auto& [s, x] : places(sample, true)) {
        if (p.body[s] == 0) continue;
        const auto& from = before.at(s);
        const double gap = std::hypot(from[0] - 4, from[1] - 5) - 1.2;  // [cells]
        const bool moved = x != from;
        if (gap < 1.5) near += moved;
        if (gap > 4) far += moved;
    }
    CHECK(near == 0);
    CHECK(far > 50);
}

TEST_CASE_TEMPLATE("in steps that shift nodes hold the volume of their particles, over mass", Real, float, double) {
    for (moraine::Shape shape : {moraine::Shape::gimp, moraine::Shape::quadratic, moraine::Shape::cubic})
        for (Transfer transfer : {Transfer::flip, Transfer::apic}) {
            Scene scene = test::sample_scene(3, shape, true);
            scene.transfer = transfer;
            Sample<Real, 3> sample(scene, 900, 3);
            auto call = sample.call();
            call.mean = NodeMean::volume;
            sample.method.kernels.p2g(call, sample.method.cell);
            const auto chosen = sample.patch.node_blocks();
            std::vector<ExactSum> impulse(chosen.size() * 3);
            const SolveNodes<Real, 3> kernel{sample.method.context.walls,
                                             sample.patch.table(),
                                             sample.patch.grid(),
                                             chosen.data(),
                                             sample.method.stencil.width,
                                             sample.method.stencil.origin,
                                             {NodeTask::solve, Real(1), {}, Real(0), Real(0)},
                                             Quantum::for_largest(1e4),
                                             impulse.data()};
            Host::launch_teams(static_cast<std::int64_t>(chosen.size()), kernel);
            std::map<Node<3>, double> volume;
            const auto p = sample.patch.particles.view();
            sample.each_particle([&](std::uint32_t s, const std::array<double, 3>& x) {
                each_weight(sample, s, x, [&](const Node<3>& node, double w, const auto&, const auto&) {
                    volume[node] += w * double(p.volume[s]);
                });
            });
            double worst = 0;
            const TileView<Real> grid = sample.patch.grid();
            for (std::int32_t c : chosen)
                for (int n = 0; grid.node_of[c] >= 0 && n < Block<3>::cells; ++n) {
                    const Real* q = grid.nodes + (grid.node_of[c] * Block<3>::cells + n) * node_reals;
                    const double found = double(q[quad - 1]) * double(q[2 * quad - 1]);
                    const Node<3> node = node_at(sample, sample.patch.table().node_position[c], n, 4);
                    test::widen(worst, std::fabs(found - volume[node]));
                }
            CHECK(worst <= (sizeof(Real) == 8 ? 1e-14 : 1e-6));
        }
}
