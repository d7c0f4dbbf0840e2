#include <doctest/doctest.h>

#include "core/fluid/over_filling.hpp"
#include "core/sample.hpp"
#include "core/transfer/scene_walls.hpp"

using namespace moraine;
using moraine::test::NodeSums;
using moraine::test::Sample;

namespace {

/// Integral over x in (0, 4) of the weight of node `node`, with or without the fold of the ghost at -1 [cells].
template <class S>
double integral(int node, bool folded) {
    constexpr int steps = 40000;
    double sum = 0;
    for (int k = 0; k < steps; ++k) {
        const double x = 4 * (k + 0.5) / steps, reach = S::template reach<double>;
        const int base = static_cast<int>(std::floor(x - reach));
        double w[S::width], dw[S::width];
        S::weights(x - reach - base, 0.25, w, dw);
        if (folded && base < 0) fold_weights<S::width>(1, w, dw);
        if (node >= base && node < base + S::width) sum += w[node - base] * 4 / steps;
    }
    return sum;
}

Scene closed_scene(int dim, moraine::Shape shape, bool spline = true) {
    Scene scene = test::sample_scene(dim, shape, false);
    scene.boundary_spline = spline;
    return scene;
}

/// What the engine of the host does: tiles of volumes, then nodes.
template <class Real, int Dim>
NodeVolumes volumes_of(Sample<Real, Dim>& sample) {
    auto call = sample.call();
    call.particles.mass = call.particles.volume;
    sample.method.kernels.p2g(call, sample.method.cell);
    std::vector<NodeVolumes> volumes(sample.patch.node_blocks().size());
    const CountVolumes<Real, Dim> kernel{sample.method.capacity,
                                         sample.patch.table(),
                                         sample.patch.grid(),
                                         sample.method.stencil.width,
                                         sample.method.stencil.origin,
                                         std::pow(sample.scene.cell, -Dim),
                                         volumes.data()};
    Host::launch_teams(static_cast<std::int64_t>(volumes.size()), kernel);
    NodeVolumes sum;
    for (const NodeVolumes& v : volumes) sum.add(v);
    return sum;
}

}  // namespace

TEST_CASE("a node at a closed end holds the integral of its shape function over the domain") {
    using enum moraine::Shape;
    for (bool folded : {false, true}) {
        CAPTURE(folded);
        CHECK(end_capacity(quadratic, folded).on == doctest::Approx(integral<Quadratic>(0, folded)).epsilon(1e-6));
        CHECK(end_capacity(quadratic, folded).next == doctest::Approx(integral<Quadratic>(1, folded)).epsilon(1e-6));
        CHECK(end_capacity(cubic, folded).on == doctest::Approx(integral<Cubic>(0, folded)).epsilon(1e-6));
        CHECK(end_capacity(cubic, folded).next == doctest::Approx(integral<Cubic>(1, folded)).epsilon(1e-6));
    }
    CHECK(end_capacity(quadratic, true).on == doctest::Approx(13.0 / 24));
    CHECK(end_capacity(quadratic, true).next == doctest::Approx(23.0 / 24));
    CHECK(end_capacity(linear, false).on == doctest::Approx(integral<Linear>(0, false)).epsilon(1e-6));
    CHECK(end_capacity(linear, false).next == doctest::Approx(integral<Linear>(1, false)).epsilon(1e-6));
    CHECK(integral<Quadratic>(2, true) == doctest::Approx(1).epsilon(1e-6));  // and no others hold less
    CHECK(integral<Cubic>(2, true) == doctest::Approx(1).epsilon(1e-6));
}

TEST_CASE("boxes of GIMP that tile the domain give half a node to the wall, and whole ones to all others") {
    double sum[3] = {};
    for (double x = 0.25; x < 5; x += 0.5) {
        const int base = static_cast<int>(std::floor(x - 0.5));
        double w[3], dw[3];
        Gimp::weights(x - 0.5 - base, 0.25, w, dw);
        if (base < 0) fold_weights<3>(1, w, dw);
        for (int i = 0; i < 3; ++i)
            if (base + i >= 0 && base + i < 3) sum[base + i] += 0.5 * w[i];
    }
    CHECK(sum[0] == doctest::Approx(end_capacity(moraine::Shape::gimp, true).on));
    CHECK(sum[1] == doctest::Approx(end_capacity(moraine::Shape::gimp, true).next));
    CHECK(sum[2] == doctest::Approx(1));
}

TEST_CASE("capacities multiply in corners, and ends that are open or periodic have none of their own") {
    Scene scene = closed_scene(2, moraine::Shape::quadratic);
    scene.walls[1][1].kind = WallKind::open;
    const NodeCapacity<double, 2> c = node_capacity<double, 2>(scene, make_walls<double, 2>(scene));
    const auto of = [&](int i, int j) {
        const int node[2] = {i, j};
        return c.of(node);
    };
    CHECK(of(0, 0) == doctest::Approx(13.0 / 24 * 13 / 24));
    CHECK(of(1, 0) == doctest::Approx(23.0 / 24 * 13 / 24));
    CHECK(of(8, 5) == doctest::Approx(13.0 / 24));
    CHECK(of(7, 1) == doctest::Approx(23.0 / 24 * 23 / 24));
    CHECK(of(4, 10) == 1);
    CHECK(of(4, 9) == 1);
    CHECK(of(4, 5) == 1);
    scene.periodic[0] = true;
    scene.walls[0][0].kind = scene.walls[0][1].kind = WallKind::periodic;
    CHECK(node_capacity<double, 2>(scene, make_walls<double, 2>(scene)).along(0, 0) == 1);
}

TEST_CASE_TEMPLATE("over-filling is what a plain loop over particles and nodes gives", Real, float, double) {
    for (moraine::Shape shape : {moraine::Shape::linear, moraine::Shape::gimp, moraine::Shape::quadratic})
        for (Transfer transfer : {Transfer::flip, Transfer::apic}) {
            if (shape == moraine::Shape::linear && transfer == Transfer::apic) continue;
            CAPTURE(int(shape));
            Scene scene = closed_scene(3, shape);
            scene.transfer = transfer;
            Sample<Real, 3> sample(scene, 4000, 5);
            const NodeVolumes found = volumes_of(sample);
            const auto p = sample.patch.particles.view();
            double volume = 0;
            sample.each_particle([&](std::uint32_t s, const auto&) {
                volume += double(p.volume[s]);
                p.mass[s] = p.volume[s];
            });
            double above = 0;
            for (const auto& [node, sums] : reference_sums(sample)) {
                const double fits = double(sample.method.capacity.of(node.data())) * std::pow(scene.cell, 3);
                above += std::max(0.0, sums.mass - fits);
            }
            CHECK(above / volume > 0.02);
            CHECK(found.over_filling() == doctest::Approx(above / volume).epsilon(sizeof(Real) == 8 ? 1e-12 : 1e-5));
        }
}
