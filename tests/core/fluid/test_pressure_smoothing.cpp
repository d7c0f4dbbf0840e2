#include <doctest/doctest.h>

#include "core/fluid/pressure_smoothing.hpp"
#include "core/sample.hpp"

using namespace moraine;
using moraine::test::Node;
using moraine::test::Sample;

namespace {

/// A step from sums to particles, in which body 1 is a fluid of bulk modulus 1 / compliance.
template <class Real, int Dim>
void step(Sample<Real, Dim>& sample, double share, double compliance) {
    auto call = sample.call();
    call.mean = NodeMean::stress;
    sample.method.kernels.p2g(call, sample.method.cell);
    const auto chosen = sample.patch.node_blocks();
    std::vector<ExactSum> impulse(chosen.size() * Dim);
    const SolveNodes<Real, Dim> kernel{sample.method.context.walls,
                                       sample.patch.table(),
                                       sample.patch.grid(),
                                       chosen.data(),
                                       sample.method.stencil.width,
                                       sample.method.stencil.origin,
                                       {NodeTask::solve, Real(1), {}, Real(0), Real(0)},
                                       Quantum::for_largest(1e4),
                                       impulse.data()};
    Host::launch_teams(static_cast<std::int64_t>(chosen.size()), kernel);
    const FluidTerms<Real> fluid[] = {{}, {Real(share), Real(compliance), Real(0)}};
    GatherCall<Real, Dim> gather{
        {nullptr, 0, nullptr}, sample.method.ends, sample.round(gather_gradient, 1), sample.notes()};
    gather.terms.template get<SmoothingTerm<Real>>().fluid = fluid;
    sample.method.kernels.g2p(sample.call(), gather);
}

}  // namespace

TEST_CASE("the share is k c dt / h, and at most a half") {
    CHECK(smoothing_share(0.25, 0.5) == 0.125);
    CHECK(smoothing_share(3.0, 0.5) == 0.5);
    CHECK(smoothing_share(0.0, 0.5) == 0);
}

TEST_CASE("pressure and ln J go to the grid's together, and the deviator stays") {
    struct {
        Sym<double, 3> sigma = {{-5, -3, -1, 7, 8, 9}};
        double ratio = 0.25;
        double& stress(int k) { return sigma[k]; }
        double& ln_J() { return ratio; }
    } particle;
    smooth_pressure({0.5, 0.125, 0}, 0.5, -11.0, particle);  // mean -3: a quarter of the way to -11
    CHECK(particle.sigma.trace() == doctest::Approx(-15));
    CHECK(particle.ratio == doctest::Approx(0.25 - 2 * 0.125));
    CHECK(particle.sigma[0] - particle.sigma[1] == doctest::Approx(-2));
    CHECK(particle.sigma[3] == 7);
    smooth_pressure({0.0, 0.125, 0}, 0.5, -11.0, particle);  // another body
    CHECK(particle.sigma.trace() == doctest::Approx(-15));
}

TEST_CASE_TEMPLATE("particles of the fluid take a share of the nodes' mean pressure, as a plain loop says", Real, float,
                   double) {
    const double tolerance = sizeof(Real) == 8 ? 1e-10 : 0.01;
    using moraine::Shape;
    for (Shape shape : {Shape::linear, Shape::gimp_contiguous, Shape::quadratic, Shape::cubic})
        for (Transfer transfer : {Transfer::flip, Transfer::apic})
            for (bool periodic : {false, true}) {
                if (shape == Shape::linear && transfer == Transfer::apic) continue;
                CAPTURE(int(shape));
                CAPTURE(int(transfer));
                Scene scene = test::sample_scene(2, shape, periodic);
                scene.transfer = transfer;
                Sample<Real, 2> sample(scene, 900, 3);
                const auto p = sample.patch.particles.view();
                std::map<Node<2>, std::array<double, 2>> nodes;  // m, s
                std::map<std::uint32_t, double> before, gathered;
                sample.each_particle([&](std::uint32_t s, const std::array<double, 2>& x) {
                    before[s] = double(p.stress[s].trace()) / 3;
                    each_weight(sample, s, x, [&](const Node<2>& node, double w, const auto&, const auto&) {
                        nodes[node][0] += w * double(p.mass[s]);
                        nodes[node][1] += w * double(p.mass[s]) * before[s];
                    });
                });
                sample.each_particle([&](std::uint32_t s, const std::array<double, 2>& x) {
                    each_weight(sample, s, x, [&](const Node<2>& node, double w, const auto&, const auto&) {
                        if (nodes[node][0] > 0) gathered[s] += w * nodes[node][1] / nodes[node][0];
                    });
                });
                step(sample, 0.25, 1e-3);
                double off = 0, lost = 0;
                for (const auto& [s, wanted] : gathered) {
                    const double change = p.body[s] == 1 ? 0.25 * (wanted - before[s]) : 0;
                    test::widen(off, std::fabs(double(p.stress[s].trace()) / 3 - before[s] - change));
                    test::widen(off, std::fabs(double(p.ln_J[s]) - 1e-3 * change));
                    lost += double(p.mass[s]) * (wanted - before[s]);
                }
                CHECK(off <= tolerance);
                CHECK(std::fabs(lost) <= 1e3 * tolerance);  // sum m P is kept where all bodies take it
            }
}
