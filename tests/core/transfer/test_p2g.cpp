#include <doctest/doctest.h>

#include "core/sample.hpp"
#include "core/transfer/p2g.hpp"
#include "every_case.hpp"

using namespace moraine;
using moraine::test::Node;
using moraine::test::NodeSums;
using moraine::test::Sample;

namespace {

/// Runs the kernel and adds all tiles up, in double.
template <class Real, int Dim>
std::map<Node<Dim>, NodeSums<Dim>> kernel_sums(Sample<Real, Dim>& sample) {
    const TileView<Real> grid = sample.patch.grid();
    const int side = tile_side(sample.method.stencil.width);
    const int reals = power<Dim>(side) * node_reals;
    for (std::int64_t k = 0; k < sample.patch.tiles_in_use() * reals; ++k) grid.tiles[k] = Real(1e30);  // stale
    sample.method.kernels.p2g(sample.call(), sample.method.cell);
    std::map<Node<Dim>, NodeSums<Dim>> nodes;
    for (int b = 0; b < sample.patch.own(); ++b) {
        if (grid.tile_of[b] < 0) continue;
        const Real* tile = grid.tiles + grid.tile_of[b] * reals;
        for (int n = 0; n < power<Dim>(side); ++n) {
            const Real* from = tile + n * node_reals;
            NodeSums<Dim>& sums = nodes[node_at(sample, sample.patch.table().position[b], n, side)];
            sums.mass += double(from[0]);
            for (int a = 0; a < Dim; ++a) {
                sums.momentum[static_cast<std::size_t>(a)] += double(from[1 + a]);
                sums.force[static_cast<std::size_t>(a)] += double(from[quad + a]);
            }
            for (int q = 1 + Dim; q < quad; ++q) REQUIRE(from[q] == 0);
            for (int q = Dim; q < quad; ++q) REQUIRE(from[quad + q] == 0);
        }
    }
    return nodes;
}

template <class C, class F>
void each_method(const F& f) {
    using moraine::Shape;
    for (Shape shape : {Shape::linear, Shape::gimp, Shape::gimp_contiguous, Shape::quadratic, Shape::cubic})
        for (Transfer transfer : {Transfer::flip, Transfer::apic})
            for (auto [periodic, spline] : {std::pair{false, true}, {true, true}, {false, false}}) {
                CAPTURE(int(shape));
                CAPTURE(int(transfer));
                CAPTURE(periodic);
                CAPTURE(spline);
                Scene scene = test::sample_scene(C::dim, shape, periodic);
                scene.transfer = transfer;
                scene.boundary_spline = spline;
                Sample<typename C::Real, C::dim> sample(scene, C::dim == 2 ? 400 : 900, 11);
                f(sample);
            }
}

}  // namespace

TEST_CASE_TEMPLATE("tiles add up to the sums over particles that a plain loop gives", C, EVERY_CASE) {
    constexpr int dim = C::dim;
    each_method<C>([](auto& sample) {
        const auto expected = reference_sums(sample);
        auto found = kernel_sums(sample);
        double mass = 0, momentum = 0, force = 0;
        for (const auto& [node, n] : expected) {
            test::widen(mass, n.mass);
            for (std::size_t a = 0; a < dim; ++a) {
                test::widen(momentum, std::fabs(n.momentum[a]));
                test::widen(force, std::fabs(n.force[a]));
            }
        }
        double worst = 0;
        for (const auto& [node, n] : expected) {
            const NodeSums<dim> f = found[node];
            test::widen(worst, std::fabs(f.mass - n.mass) / mass);
            for (std::size_t a = 0; a < dim; ++a) {
                test::widen(worst, std::fabs(f.momentum[a] - n.momentum[a]) / momentum);
                test::widen(worst, std::fabs(f.force[a] - n.force[a]) / force);
            }
            found.erase(node);
        }
        CHECK(worst <= C::tolerance);
        double stray = 0;
        for (const auto& [node, f] : found) test::widen(stray, std::fabs(f.mass));
        CHECK(stray <= C::tolerance * mass);
    });
}

TEST_CASE_TEMPLATE("the nodes hold all mass and momentum of the particles, and internal forces add up to nothing", C,
                   EVERY_CASE) {
    constexpr int dim = C::dim;
    each_method<C>([](auto& sample) {
        double mass = 0, size = 0;
        std::array<double, dim> momentum{};
        const auto p = sample.patch.particles.view();
        sample.each_particle([&](std::uint32_t s, const auto&) {
            mass += double(p.mass[s]);
            for (int a = 0; a < dim; ++a)
                momentum[static_cast<std::size_t>(a)] += double(p.mass[s]) * double(p.velocity[s][a]);
        });
        NodeSums<dim> all;
        for (const auto& [node, n] : kernel_sums(sample)) {
            all.mass += n.mass;
            for (std::size_t a = 0; a < dim; ++a) {
                all.momentum[a] += n.momentum[a];
                all.force[a] += n.force[a];
                size += std::fabs(n.force[a]);
            }
        }
        CHECK(std::fabs(all.mass - mass) <= C::tolerance * mass);
        for (std::size_t a = 0; a < dim; ++a) {
            CHECK(std::fabs(all.momentum[a] - momentum[a]) <= C::tolerance * 2 * mass);
            CHECK(std::fabs(all.force[a]) <= C::tolerance * size);
        }
    });
}

TEST_CASE("a manufactured acceleration pulls nodes by the mass they hold") {
    Sample<double, 2> sample(test::sample_scene(2, moraine::Shape::quadratic, false), 300, 12);
    sample.patch.particles = Particles<Host, double, 2>({false, false, false, 0, true});
    sample.patch.particles.resize(300);
    // The columns are new: give them values, and places that suit the lists.
    const auto p = sample.patch.particles.view();
    const ListView<2> list = sample.patch.list();
    for (int b = 0; b < sample.patch.own(); ++b)
        for (int c = 0; c < Block<2>::cells; ++c)
            for (std::uint32_t k = list.cell_first[b * 17 + c]; k < list.cell_first[b * 17 + c + 1]; ++k) {
                const std::uint32_t s = list.slot[list.first[b] + k];
                for (int a = 0; a < 2; ++a) {
                    p.position[s][a] = cell_coordinate<2>(c, a) * one_cell<double> + one_cell<double> / 2;
                    p.velocity[s][a] = 0;
                    p.body_force[s][a] = a + 1.5;
                }
                p.mass[s] = 1 + s % 3;
                p.volume[s] = 0;
                p.body[s] = 0;
                p.stress[s] = zero_sym<double, 2>();
            }
    for (const auto& [node, n] : kernel_sums(sample)) {
        REQUIRE(n.force[0] == doctest::Approx(1.5 * n.mass).epsilon(1e-12));
        REQUIRE(n.force[1] == doctest::Approx(2.5 * n.mass).epsilon(1e-12));
    }
}
