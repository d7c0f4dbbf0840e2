#include <doctest/doctest.h>

#include "core/sample.hpp"
#include "every_case.hpp"

using namespace moraine;
using moraine::test::Node;
using moraine::test::Sample;

// FMPM(k) against the same series written with a dense list of weights.

namespace {

constexpr double dt = 0.01, cutoff = 1e-9;

template <class C>
constexpr double tolerance = sizeof(typename C::Real) == 8 ? 1e-11 : 1e-4;

template <int Dim>
Vec<double, Dim> pull() {
    Vec<double, Dim> g;
    for (int a = 0; a < Dim; ++a) g[a] = 3 - 5 * a;
    return g;
}

/// The velocities that the scene's rounds give the particles; returns the walls' impulse.
template <class Real, int Dim>
std::array<double, Dim> play(Sample<Real, Dim>& sample) {
    const auto chosen = sample.patch.node_blocks();
    const Quantum quantum = Quantum::for_largest(1e4);
    Vec<Real, Dim> gravity;
    for (int a = 0; a < Dim; ++a) gravity[a] = static_cast<Real>(pull<Dim>()[a]);
    std::array<ExactSum, Dim> sum{};
    for (const Round& round : sample.method.rounds) {
        std::vector<ExactSum> impulse(chosen.size() * Dim);
        sample.method.kernels.p2g(sample.call(), sample.method.cell);
        const SolveNodes<Real, Dim> nodes{
            sample.method.context.walls,
            sample.patch.table(),
            sample.patch.grid(),
            chosen.data(),
            sample.method.stencil.width,
            sample.method.stencil.origin,
            {round.nodes, static_cast<Real>(dt), gravity, Real(0), static_cast<Real>(cutoff)},
            quantum,
            impulse.data()};
        Host::launch_teams(static_cast<std::int64_t>(chosen.size()), nodes);
        const GatherCall<Real, Dim> gather{{nullptr, 0, nullptr},
                                           sample.method.ends,
                                           sample.round(round.gather & gather_velocity, dt),
                                           sample.notes()};
        sample.method.kernels.g2p(sample.call(), gather);
        for (std::size_t k = 0; k < impulse.size(); ++k) sum[k % Dim].add(impulse[k]);
    }
    std::array<double, Dim> all{};
    for (std::size_t a = 0; a < Dim; ++a) all[a] = quantum.value(sum[a]);
    return all;
}

/// One particle's row of the matrix S.
template <int Dim>
using Weights = std::vector<std::pair<Node<Dim>, double>>;

template <class Real, int Dim>
class Series {
  public:
    explicit Series(Sample<Real, Dim>& sample) : sample_(sample), nodes_(reference_sums(sample)) {
        sample.each_particle([&](std::uint32_t s, const std::array<double, Dim>& x) {
            each_weight(sample, s, x, [&](const Node<Dim>& node, double w, const auto&, const auto&) {
                row_[s].push_back({node, w});
            });
        });
    }

    /// Velocities of the particles after `order` terms.
    std::map<std::uint32_t, Vec<double, Dim>> velocities(int order) {
        std::map<Node<Dim>, Vec<double, Dim>> term, sum;
        for (const auto& [node, n] : nodes_) {
            Vec<double, Dim> v = zero_vec<double, Dim>();
            for (int a = 0; a < Dim && n.mass > cutoff; ++a) {
                const auto i = static_cast<std::size_t>(a);
                v[a] = (n.momentum[i] + dt * n.force[i]) / n.mass + dt * pull<Dim>()[a];
            }
            term[node] = sum[node] = constrained(node, v);
        }
        for (int l = 1; l < order; ++l) {
            std::map<Node<Dim>, Vec<double, Dim>> momentum;
            for (const auto& [s, u] : gathered(term))
                for (const auto& [node, w] : row_.at(s))
                    for (int a = 0; a < Dim; ++a)
                        momentum[node][a] += w * double(sample_.patch.particles.view().mass[s]) * u[a];
            for (auto& [node, total] : sum) {
                const double m = nodes_.at(node).mass;
                Vec<double, Dim> next = total;
                for (int a = 0; a < Dim && m > cutoff; ++a) next[a] += term[node][a] - momentum[node][a] / m;
                next = constrained(node, next);
                for (int a = 0; a < Dim; ++a) term[node][a] = next[a] - total[a];
                total = next;
            }
        }
        return gathered(sum);
    }

  private:
    std::map<std::uint32_t, Vec<double, Dim>> gathered(const std::map<Node<Dim>, Vec<double, Dim>>& values) const {
        std::map<std::uint32_t, Vec<double, Dim>> all;
        for (const auto& [s, row] : row_) {
            Vec<double, Dim>& u = all[s] = zero_vec<double, Dim>();
            for (const auto& [node, w] : row)
                for (int a = 0; a < Dim; ++a) u[a] += w * values.at(node)[a];
        }
        return all;
    }

    /// No-slip below, free slip above.
    Vec<double, Dim> constrained(const test::PerAxis<int, Dim>& node, Vec<double, Dim> v) const {
        for (int a = 0; a < Dim; ++a) {
            const auto i = static_cast<std::size_t>(a);
            if (sample_.domain.periodic[i]) continue;
            if (node[i] <= 0) v = zero_vec<double, Dim>();
            if (node[i] >= sample_.domain.nodes[i]) v[a] = 0;
        }
        return v;
    }

    Sample<Real, Dim>& sample_;
    std::map<Node<Dim>, test::NodeSums<Dim>> nodes_;
    std::map<std::uint32_t, Weights<Dim>> row_;
};

template <class Real, int Dim>
std::array<double, Dim> momentum_of(Sample<Real, Dim>& sample, double& mass) {
    std::array<double, Dim> sum{};
    mass = 0;
    const auto p = sample.patch.particles.view();
    sample.each_particle([&](std::uint32_t s, const auto&) {
        mass += double(p.mass[s]);
        for (int a = 0; a < Dim; ++a) sum[static_cast<std::size_t>(a)] += double(p.mass[s]) * double(p.velocity[s][a]);
    });
    return sum;
}

}  // namespace

TEST_CASE_TEMPLATE("FMPM of orders 1 to 4 is the series with dense weights, and walls' impulse is all its momentum", C,
                   EVERY_CASE) {
    constexpr int dim = C::dim;
    using moraine::Shape;
    for (Shape shape : {Shape::linear, Shape::gimp, Shape::quadratic, Shape::cubic})
        for (bool periodic : {false, true})
            for (int order : {1, 2, 4}) {
                CAPTURE(int(shape));
                CAPTURE(periodic);
                CAPTURE(order);
                Scene scene = test::sample_scene(dim, shape, periodic);
                scene.transfer = Transfer::fmpm;
                scene.order = order;
                Sample<typename C::Real, dim> sample(scene, dim == 2 ? 300 : 600, 41);
                const auto p = sample.patch.particles.view();
                // A hat on a face gives a node without mass a force, which nobody feels.
                const double force = shape == Shape::linear ? 0 : 0.01;
                sample.each_particle([&](std::uint32_t s, const auto&) { p.volume[s] *= typename C::Real(force); });
                double mass = 0;
                const auto before = momentum_of(sample, mass);
                const auto expected = Series<typename C::Real, dim>(sample).velocities(order);
                const auto impulse = play(sample);
                const auto after = momentum_of(sample, mass);
                double worst = 0;
                for (const auto& [s, v] : expected)
                    for (int a = 0; a < dim; ++a) test::widen(worst, std::fabs(double(p.velocity[s][a]) - v[a]));
                CHECK(worst <= tolerance<C>);
                for (std::size_t a = 0; a < dim; ++a)
                    CHECK(std::fabs(after[a] - before[a] - mass * dt * pull<dim>()[static_cast<int>(a)] - impulse[a]) <=
                          tolerance<C> * mass);
            }
}
