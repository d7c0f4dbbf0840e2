#include <doctest/doctest.h>

#include "core/data/hash.hpp"
#include "core/sample.hpp"
#include "core/transfer/g2p.hpp"
#include "every_case.hpp"

using namespace moraine;
using moraine::test::Node;
using moraine::test::Sample;

namespace {

/// A material that only writes down the velocity gradients it is given.
template <class Real, int Dim>
struct Recorder final : LawBatch<Real, Dim> {
    mutable std::map<std::uint32_t, Mat<Real, Dim>> seen;

    void update(const ParticleView<Real, Dim>&, const std::uint32_t* slots, const Mat<Real, Dim>* gradients, int n,
                Real, const std::uint16_t*, int, BlockOutcome&) const override {
        for (int k = 0; k < n; ++k) seen[slots[k]] = gradients[k];
    }
    void begin(const BodyStart&, const ParticleView<Real, Dim>&, std::uint32_t) const override {}
    double strain_energy(const ParticleView<Real, Dim>&, std::uint32_t) const override { return 0; }
    double signal(const ParticleView<Real, Dim>&, std::uint32_t) const override { return 0; }
};

/// Fills the nodes with velocity(node, axis) and change(node, axis), and gathers.
template <class Real, int Dim, class V, class D>
std::map<std::uint32_t, Mat<Real, Dim>> gather(Sample<Real, Dim>& sample, unsigned what, double dt, const V& velocity,
                                               const D& change) {
    const TileView<Real> grid = sample.patch.grid();
    for (std::int32_t c : sample.patch.node_blocks()) {
        if (grid.node_of[c] < 0) continue;
        for (int n = 0; n < Block<Dim>::cells; ++n) {
            const Node<Dim> node = node_at(sample, sample.patch.table().node_position[c], n, 4);
            Real* to = grid.nodes + (grid.node_of[c] * Block<Dim>::cells + n) * node_reals;
            for (int q = 0; q < quad; ++q) {
                to[q] = q < Dim ? static_cast<Real>(velocity(node, q)) : Real(0);
                to[quad + q] = q < Dim ? static_cast<Real>(change(node, q)) : Real(0);
            }
        }
    }
    const Recorder<Real, Dim> recorder;
    const LawBatch<Real, Dim>* laws[] = {&recorder};
    GatherCall<Real, Dim> call{{laws, 1, nullptr}, sample.method.ends, sample.round(what, dt), sample.notes()};
    call.terms.template get<MeansTerm<Real>>().averaged = sample.method.averaged();
    sample.method.kernels.g2p(sample.call(), call);
    return recorder.seen;
}

/// A fixed random number in [-1, 1) for each node.
template <int Dim>
double noise(const test::PerAxis<int, Dim>& node, int axis, std::uint64_t salt) {
    std::uint64_t h = mix(salt + static_cast<std::uint64_t>(axis));
    for (int i : node) h = mix(h ^ static_cast<std::uint64_t>(i + 100));
    return std::ldexp(static_cast<double>(h >> 11), -52) - 1;
}

template <class C, class F>
void each_method(const F& f) {
    using moraine::Shape;
    for (Shape shape : {Shape::linear, Shape::gimp, Shape::gimp_contiguous, Shape::quadratic, Shape::cubic})
        for (Transfer transfer : {Transfer::flip, Transfer::apic, Transfer::tpic, Transfer::aflip})
            for (bool periodic : {false, true}) {
                CAPTURE(int(shape));
                CAPTURE(int(transfer));
                CAPTURE(periodic);
                Scene scene = test::sample_scene(C::dim, shape, periodic);
                scene.transfer = transfer;
                scene.flip = 0.75;
                Sample<typename C::Real, C::dim> sample(scene, C::dim == 2 ? 200 : 400, 31);
                f(sample);
            }
}

/// What a plain loop over nodes gives one particle.
template <int Dim>
struct Expected {
    Vec<double, Dim> velocity = zero_vec<double, Dim>(), change = zero_vec<double, Dim>();
    Mat<double, Dim> gradient = zero_mat<double, Dim>(), moment = zero_mat<double, Dim>();
    Vec<double, Dim> spread = zero_vec<double, Dim>();  ///< sum w (x_i - x_p)^2 [cells^2]
};

template <class Real, int Dim>
Expected<Dim> expected_at(Sample<Real, Dim>& sample, std::uint32_t s, const test::PerAxis<double, Dim>& x) {
    Expected<Dim> e;
    each_weight(sample, s, x, [&](const Node<Dim>& node, double w, const auto& dw, const auto& distance) {
        for (int a = 0; a < Dim; ++a) {
            const double v = double(static_cast<Real>(noise<Dim>(node, a, 1)));
            e.velocity[a] += w * v;
            e.change[a] += w * double(static_cast<Real>(noise<Dim>(node, a, 2)));
            for (int b = 0; b < Dim; ++b) {
                e.gradient(a, b) += v * dw[static_cast<std::size_t>(b)] / sample.scene.cell;
                e.moment(a, b) += w * v * distance[static_cast<std::size_t>(b)] / sample.scene.cell;
            }
            e.spread[a] += w * distance[static_cast<std::size_t>(a)] * distance[static_cast<std::size_t>(a)];
        }
    });
    return e;
}

/// Is the particle so near a closed wall that its stencil has a ghost along this axis?
template <class Real, int Dim>
bool near_wall(const Sample<Real, Dim>& sample, const test::PerAxis<double, Dim>& x, int a) {
    const auto i = static_cast<std::size_t>(a);
    if (sample.domain.periodic[i]) return false;
    const double reach = sample.scene.shape == moraine::Shape::cubic ? 1 : 0.5;
    const double n = sample.domain.nodes[i];
    return x[i] < reach || x[i] >= n - reach;
}

}  // namespace

TEST_CASE_TEMPLATE("velocities, gradients and affine fields are those of a plain loop over nodes", C, EVERY_CASE) {
    using Real = typename C::Real;
    constexpr int dim = C::dim;
    each_method<C>([](auto& sample) {
        const auto p = sample.patch.particles.view();
        std::map<std::uint32_t, Vec<Real, dim>> old;
        sample.each_particle([&](std::uint32_t s, const auto&) { old[s] = p.velocity[s]; });
        std::map<std::uint32_t, Expected<dim>> expected;
        std::map<std::uint32_t, std::array<double, dim>> place;
        sample.each_particle([&](std::uint32_t s, const std::array<double, dim>& x) {
            expected[s] = expected_at(sample, s, x);
            place[s] = x;
        });
        const double dt = 0.125;
        const auto gradients = gather(
            sample, gather_velocity | gather_gradient, dt,
            [](const Node<dim>& n, int a) { return noise<dim>(n, a, 1); },
            [](const Node<dim>& n, int a) { return noise<dim>(n, a, 2); });
        const double flip = double(sample.method.flip);
        double speed = 0, gradient = 0, affine = 0;
        for (const auto& [s, e] : expected)
            for (int a = 0; a < dim; ++a) {
                const double full = double(old[s][a]) + e.change[a];
                const double v = flip * full + (1 - flip) * e.velocity[a];
                test::widen(speed, std::fabs(double(p.velocity[s][a]) - v));
                for (int b = 0; b < dim; ++b) {
                    test::widen(gradient, std::fabs(double(gradients.at(s)(a, b)) / dt - e.gradient(a, b)));
                    if (!p.affine) continue;
                    const bool plain = sample.method.tpic || sample.scene.shape == moraine::Shape::linear ||
                                       near_wall(sample, place[s], b);
                    const double c = plain ? e.gradient(a, b) : e.moment(a, b) / e.spread[b];
                    test::widen(affine, std::fabs(double(p.affine[s](a, b)) - c));
                }
            }
        CHECK(gradients.size() == expected.size());
        CHECK(speed <= C::tolerance);
        CHECK(gradient <= 10 * C::tolerance);  // slopes of a gimp box are up to 1 / its half-size
        CHECK(affine <= 10 * C::tolerance);
    });
}

TEST_CASE_TEMPLATE("an affine velocity field is gathered exactly, next to walls too, and C is its gradient", C,
                   EVERY_CASE) {
    constexpr int dim = C::dim;
    each_method<C>([](auto& sample) {
        if (sample.domain.periodic[0]) return;  // no affine field is periodic
        const auto slope = [](int a, int b) { return 0.5 * a - 0.25 * b + 0.125; };
        const auto field = [&](const auto& x, int a) {
            double v = 1 - a;
            for (int b = 0; b < dim; ++b) v += slope(a, b) * double(x[static_cast<std::size_t>(b)]) * sample.scene.cell;
            return v;
        };
        const auto p = sample.patch.particles.view();
        sample.each_particle([&](std::uint32_t s, const auto&) { p.velocity[s] = {}; });
        const auto gradients = gather(sample, gather_velocity | gather_gradient, 1, field, field);
        double worst = 0;
        sample.each_particle([&](std::uint32_t s, const std::array<double, dim>& x) {
            for (int a = 0; a < dim; ++a) {
                test::widen(worst, std::fabs(double(p.velocity[s][a]) - field(x, a)));
                for (int b = 0; b < dim; ++b) {
                    test::widen(worst, std::fabs(double(gradients.at(s)(a, b)) - slope(a, b)));
                    if (p.affine) test::widen(worst, std::fabs(double(p.affine[s](a, b)) - slope(a, b)));
                }
            }
        });
        CHECK(worst <= 10 * C::tolerance);
    });
}

TEST_CASE_TEMPLATE("particles move with the field and are told their next cell and block", C, EVERY_CASE) {
    constexpr int dim = C::dim;
    each_method<C>([](auto& sample) {
        std::map<std::uint32_t, std::array<double, dim>> before;
        sample.each_particle([&](std::uint32_t s, const std::array<double, dim>& x) { before[s] = x; });
        const auto p = sample.patch.particles.view();
        const double dt = 0.4;  // up to 0.8 cells
        for (auto& axis : sample.method.ends.still)
            for (bool& still : axis) still = false;  // stop_at_walls() has tests of its own
        gather(
            sample, gather_motion, dt, [](const Node<dim>& n, int a) { return noise<dim>(n, a, 1); },
            [](const Node<dim>&, int) { return 0.0; });
        const ListView<dim> list = sample.patch.list();
        int bad = 0;
        double worst = 0;
        for (int b = 0; b < sample.patch.own(); ++b) {
            std::uint32_t outgoing_count = 0;
            bool shuffled = false;
            for (std::uint32_t k = list.first[b]; k < list.first[b + 1]; ++k) {
                const std::uint32_t s = list.slot[k];
                const std::uint16_t m = sample.patch.moves()[k];
                const auto& x = before[s];
                const Expected<dim> e = expected_at(sample, s, x);
                bool out = false;
                int old_cell = 0, new_cell = 0, code = 0;
                for (int a = dim - 1; a >= 0; --a) {
                    const auto i = static_cast<std::size_t>(a);
                    const double to = x[i] + dt * e.velocity[a] / sample.scene.cell;
                    out = out || (!sample.domain.periodic[i] && (to < 0 || to > sample.domain.nodes[i]));
                    const double offset = sample.method.stencil.offset();
                    const int old_at = static_cast<int>(std::floor(x[i] + offset));
                    const int at = static_cast<int>(std::floor(to + offset));
                    old_cell = 4 * old_cell + (old_at & 3);
                    new_cell = 4 * new_cell + (at & 3);
                    code = 3 * code + (at >> 2) - (old_at >> 2) + 1;
                }
                const bool stays = move_code(m) == Block<dim>::centre && move_cell(m) == old_cell;
                if (out) {
                    bad += !stays;  // closed: it stays where it was, and the run ends
                    continue;
                }
                bad += move_code(m) != code || move_cell(m) != new_cell;
                outgoing_count += code != Block<dim>::centre;
                shuffled = shuffled || !stays;
                for (int a = 0; a < dim; ++a) {
                    const auto i = static_cast<std::size_t>(a);
                    const int block = sample.patch.table().position[b][a] + Block<dim>::offset(code, a);
                    const double to = x[i] + dt * e.velocity[a] / sample.scene.cell + sample.method.stencil.offset();
                    test::widen(worst, std::fabs(local_of<typename C::Real>(block, p.position[s][a]) - to));
                }
            }
            CHECK(sample.patch.outgoing_count()[b] == outgoing_count);
            CHECK(bool(sample.patch.shuffled()[b]) == shuffled);
        }
        CHECK(bad <= (sizeof(typename C::Real) == 8 ? 0 : 1));  // a float may round across a face
        CHECK(worst <= C::tolerance);
    });
}

TEST_CASE_TEMPLATE(
    "bodies that want it take the mean volumetric rate and pressure of their cell, crowded ones too, others their own",
    C, EVERY_CASE) {
    using Real = typename C::Real;
    constexpr int dim = C::dim;
    for (moraine::Shape shape : {moraine::Shape::linear, moraine::Shape::gimp, moraine::Shape::quadratic})
        for (int particles : {dim == 2 ? 400 : 900, dim == 2 ? 9000 : 40000}) {
            CAPTURE(int(shape));
            CAPTURE(particles);
            Scene scene = test::sample_scene(dim, shape, false);
            scene.materials.push_back(scene.materials.front());
            scene.materials.back().volumetric = Volumetric::cell;
            scene.bodies[1].material = 1;
            Sample<Real, dim> sample(scene, particles, 31);
            const double dt = 0.125;
            std::map<std::uint32_t, Mat<double, dim>> expected;
            std::map<std::pair<int, int>, VolumetricMean<double>> mean;  // by block and cell
            std::map<std::uint32_t, std::pair<int, int>> cell;
            std::map<std::uint32_t, double> pressure;
            const auto p = sample.patch.particles.view();
            const ListView<dim> list = sample.patch.list();
            for (int b = 0; b < sample.patch.own(); ++b)
                for (std::uint32_t k = list.first[b]; k < list.first[b + 1]; ++k)
                    cell[list.slot[k]] = {b, sample.patch.cell_of_slot(list.slot[k])};
            sample.each_particle([&](std::uint32_t s, const std::array<double, dim>& x) {
                expected[s] = expected_at(sample, s, x).gradient;
                pressure[s] = double(p.stress[s].trace());
                if (p.body[s] == 1) mean[cell.at(s)].add(double(p.mass[s]), trace(expected[s]), pressure[s]);
            });
            for (auto& [at, m] : mean) m.finish();
            const auto found = gather(
                sample, gather_gradient, dt, [](const Node<dim>& n, int a) { return noise<dim>(n, a, 1); },
                [](const Node<dim>&, int) { return 0.0; });
            double worst = 0, changed = 0, off = 0;
            for (auto& [s, L] : expected) {
                const double own = trace(L);
                if (p.body[s] == 1) set_trace(L, mean.at(cell.at(s)).rate);
                const double wanted = p.body[s] == 1 ? mean.at(cell.at(s)).stress : pressure.at(s);
                test::widen(off, std::fabs(double(p.stress[s].trace()) - wanted));
                test::widen(changed, std::fabs(trace(L) - own));
                for (int a = 0; a < dim; ++a)
                    for (int b = 0; b < dim; ++b)
                        test::widen(worst, std::fabs(double(found.at(s)(a, b)) / dt - L(a, b)));
            }
            CHECK(changed > 0.1);
            CHECK(off <= 1500 * C::tolerance);
            CHECK(worst <= 20 * C::tolerance);
        }
}

TEST_CASE("AFLIP has FLIP's share and APIC's affine field") {
    Scene scene = test::sample_scene(2, moraine::Shape::quadratic, false);
    scene.transfer = Transfer::aflip;
    scene.flip = 0.95;
    const Method<Host, double, 2> method(scene);
    CHECK(method.flip == 0.95);
    CHECK(method.needs.affine);
    CHECK(!method.tpic);
}
