#include <doctest/doctest.h>

#include "blocks/contact_pairs.hpp"
#include "core/sample.hpp"
#include "core/structures/particle_depth.hpp"
#include "core/structures/structure_set.hpp"
#include "every_case.hpp"

using namespace moraine;
using moraine::test::Node;
using moraine::test::Sample;

namespace {

template <class C>
constexpr double tolerance = sizeof(typename C::Real) == 8 ? 1e-7 : 1e-5;  // the numbers are fixed-point

/// A slope and a ball.
void add_structures(Scene& scene) {
    StructureSpec slope, ball;
    slope.point = {2, 1.3, 0}, slope.normal = {0.2, 1, 0.1};
    ball.shape = StructureShape::sphere;
    ball.center = {2.2, 3.1, 1.4}, ball.radius = 0.6;
    scene.structures = {slope, ball};
}

/// The tiles of a sample, and what nodes read from them.
template <class Real, int Dim>
struct Gaps {
    Sample<Real, Dim>& sample;
    StructureSet<Dim> set;
    ContactPairs<Dim> pairs;
    std::vector<NodeGap> tiles;

    explicit Gaps(Sample<Real, Dim>& s) : sample(s), set(s.scene) {
        const ContactField<Dim> field = set.field();
        pairs.make(sample.patch.tables(), field, false);
        tiles.assign(pairs.tiles() * power<Dim>(tile_side(sample.method.stencil.width)), NodeGap{-7, 7});  // stale
        sample.method.kernels.gaps(sample.call(), {field, tiles.data(), pairs.interior().data(),
                                                   static_cast<std::int64_t>(pairs.interior().size())});
    }

    /// Calls f(node, structure, what the node is told).
    template <class F>
    void each_node(const F& f) const {
        const GapTiles gaps{pairs.structures(), pairs.tile_of().data(), tiles.data()};
        const BlockTable<Dim> table = sample.patch.table();
        for (int c = 0; c < table.node_blocks; ++c)
            for (int n = 0; n < Block<Dim>::cells; ++n)
                for (int k = 0; k < 2; ++k)
                    f(node_at(sample, table.node_position[c], n, 4), k,
                      gap_at_node(gaps, table, sample.patch.tile_of(), sample.method.stencil.width, c, n, k));
    }
};

/// What one node should be told: the gap lies between the least of those who surely reach it and of those who may.
struct Told {
    double surely = 1e9, at_most = 1e9, area = 0;
};

template <class Real, int Dim>
std::map<std::pair<Node<Dim>, int>, Told> reference(Sample<Real, Dim>& sample, const ContactField<Dim>& field) {
    std::map<std::pair<Node<Dim>, int>, Told> all;
    const auto p = sample.patch.particles.view();
    sample.each_particle([&](std::uint32_t s, const std::array<double, Dim>& cells) {
        Vec<double, Dim> x;
        for (int a = 0; a < Dim; ++a) x[a] = cells[static_cast<std::size_t>(a)] * 0.5;
        const double size = std::pow(double(p.volume[s]), 1.0 / Dim) / 0.5;
        std::map<Node<Dim>, double> weights;
        each_weight(sample, s, cells,
                    [&](const Node<Dim>& node, double w, const auto&, const auto&) { weights[node] += w; });
        for (int k = 0; k < 2; ++k) {
            const double d = surface(field.structure[k], field.corners, x).distance / 0.5;
            if (d >= 1.5) continue;
            const double lies = std::clamp((1.1 - d / size) / 0.2, 0.0, 1.0);
            for (const auto& [node, w] : weights) {
                Told& t = all[{node, k}];
                t.area += w * lies * std::pow(size, Dim - 1);
                if (w > 1e-6) t.surely = std::min(t.surely, d - size / 2);
                if (w > -1e-6) t.at_most = std::min(t.at_most, d - size / 2);
            }
        }
    });
    return all;
}

template <class C, class F>
void each_sample(const F& f) {
    using moraine::Shape;
    for (Shape shape : {Shape::linear, Shape::gimp, Shape::gimp_contiguous, Shape::quadratic, Shape::cubic})
        for (bool spline : {false, true}) {
            CAPTURE(int(shape));
            CAPTURE(spline);
            Scene scene = test::sample_scene(C::dim, shape, false);
            scene.boundary_spline = spline;
            add_structures(scene);
            Sample<typename C::Real, C::dim> sample(scene, C::dim == 2 ? 400 : 900, 17);
            f(sample);
        }
}

}  // namespace

TEST_CASE_TEMPLATE("a node is told the least gap of the particles that reach it, and the area of those that touch", C,
                   EVERY_CASE) {
    each_sample<C>([](auto& sample) {
        const Gaps<typename C::Real, C::dim> gaps(sample);
        const auto expected = reference(sample, gaps.set.field());
        double worst = 0;
        int heard = 0;
        gaps.each_node([&](const auto& node, int k, const NodeGap& found) {
            const auto at = expected.find({node, k});
            const Told t = at == expected.end() ? Told{} : at->second;
            if (found.is_none()) return test::widen(worst, t.surely < 1e8 ? 1 : 0);
            ++heard;
            test::widen(worst, found.cells() - t.surely);
            test::widen(worst, t.at_most - found.cells());
            test::widen(worst, std::fabs(found.faces() - t.area));
        });
        CHECK(worst <= 4 * tolerance<C>);
        CHECK(heard > 20);
    });
}

TEST_CASE_TEMPLATE("the areas of the nodes add up to that of the particles, beside walls too", C, EVERY_CASE) {
    each_sample<C>([](auto& sample) {
        if (!sample.scene.boundary_spline) return;
        const Gaps<typename C::Real, C::dim> gaps(sample);
        const auto p = sample.patch.particles.view();
        const ContactField<C::dim> field = gaps.set.field();
        double expected[2] = {}, found[2] = {};
        sample.each_particle([&](std::uint32_t s, const std::array<double, C::dim>& cells) {
            Vec<double, C::dim> x;
            for (int a = 0; a < C::dim; ++a) x[a] = cells[static_cast<std::size_t>(a)] * 0.5;
            const double size = std::pow(double(p.volume[s]), 1.0 / C::dim) / 0.5;
            for (int k = 0; k < 2; ++k) {
                const double d = surface(field.structure[k], field.corners, x).distance / 0.5;
                expected[k] += std::clamp((1.1 - d / size) / 0.2, 0.0, 1.0) * std::pow(size, C::dim - 1);
            }
        });
        std::map<std::pair<Node<C::dim>, int>, bool> seen;
        gaps.each_node([&](const auto& node, int k, const NodeGap& gap) {
            if (!std::exchange(seen[{node, k}], true)) found[k] += gap.faces();
        });
        for (int k = 0; k < 2; ++k) CHECK(found[k] == doctest::Approx(expected[k]).epsilon(1e-5));
    });
}

TEST_CASE_TEMPLATE(
    "who stands too deep in a structure is brought back along its normal, within its cell and the domain", C,
    EVERY_CASE) {
    using Real = typename C::Real;
    constexpr int dim = C::dim;
    Scene scene = test::sample_scene(dim, moraine::Shape::quadratic, false);
    add_structures(scene);
    StructureSpec beyond;  // pushes who stands in the last half cell out of the domain
    beyond.point = {4.2, 0, 0}, beyond.normal = {1, 0.2, 0};
    scene.structures.push_back(beyond);
    Sample<Real, dim> sample(scene, dim == 2 ? 400 : 900, 17);
    const Gaps<Real, dim> gaps(sample);
    const ContactField<dim> field = gaps.set.field();
    const ParticleView<Real, dim> p = sample.patch.particles.view();
    std::map<std::uint32_t, std::array<double, dim>> before;
    std::map<std::uint32_t, Vec<Coordinate<Real>, dim>> exactly;
    sample.each_particle([&](std::uint32_t s, const auto& cells) { before[s] = cells, exactly[s] = p.position[s]; });
    const std::vector<ContactPair>& pairs = gaps.pairs.interior();
    const LimitDepth<Real, dim> limit{
        p.position, sample.method.ends, sample.patch.table(),          sample.patch.list(),
        field,      pairs.data(),       static_cast<int>(pairs.size())};
    for (int k = 0; k < limit.count; ++k) limit(k);
    int wholly = 0, in_part = 0, at_end = 0;
    sample.each_particle([&](std::uint32_t s, const std::array<double, dim>& now) {
        std::array<double, dim> expected = before[s];
        bool within = true;
        for (int k = 0; k < 3; ++k) {
            Vec<double, dim> x;
            for (std::size_t a = 0; a < dim; ++a) x[int(a)] = expected[a] * 0.5;
            const Surface<dim> at = surface(field.structure[k], field.corners, x);
            const double depth = -at.distance / 0.5;
            if (!(depth > 0.1 && depth < 1)) continue;
            for (std::size_t a = 0; a < dim; ++a) {
                const double cell = std::floor(before[s][a] + 0.5) - 0.5,
                             to = expected[a] + (depth - 0.1) * at.normal[int(a)];
                const double lower = std::max(cell, 0.0), upper = std::min(cell + 1, double(sample.domain.nodes[a]));
                within = within && to > lower && to < upper;
                at_end += !(to >= 0 && to <= sample.domain.nodes[a]);
                expected[a] = std::clamp(to, lower, upper);
            }
            ++(within ? wholly : in_part);
        }
        for (std::size_t a = 0; a < dim; ++a) {
            CHECK(std::fabs(now[a] - expected[a]) <= 1e-8 + least_height<Real>);
            CHECK(cell_of<Real>(p.position[s][int(a)]) == cell_of<Real>(exactly[s][int(a)]));
            if (expected == before[s]) CHECK(p.position[s][int(a)] == exactly[s][int(a)]);
        }
    });
    CHECK(wholly > 10);
    CHECK(in_part > 3);
    CHECK(at_end > 0);
}
