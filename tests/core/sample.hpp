#pragma once
// One rank's patch full of random particles in a small domain, and the plain reference of its transfers:
// shape functions of the distance to a node, summed over particles and nodes in double.
//
// The reference knows no blocks, tiles or binning cells: a node is its index, taken modulo the domain's
// length along periodic axes. Places are in cells from the domain's lower corner.

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <type_traits>
#include <vector>

#include "blocks/patch.hpp"
#include "core/material/laws.hpp"
#include "core/transfer/gather_call.hpp"
#include "core/transfer/method.hpp"

namespace moraine::test {

/// Keeps the larger of the two; what is not a number is larger than all.
inline void widen(double& worst, double difference) {
    if (!(difference <= worst)) worst = std::isnan(difference) ? HUGE_VAL : difference;
}

/// 8 x 10 (x 7) cells of 0.5 m: no-slip below, free slip above, axis 0 periodic if wanted.
inline Scene sample_scene(int dim, moraine::Shape shape, bool periodic) {
    Scene scene;
    scene.transfer = Transfer::flip;
    scene.dimensions = dim;
    scene.cell = 0.5;
    scene.max = {4, 5, dim == 3 ? 3.5 : 0};
    scene.shape = shape;
    scene.periodic[0] = periodic;
    for (std::size_t a = 0; a < static_cast<std::size_t>(dim); ++a) {
        scene.walls[a][0].kind = periodic && a == 0 ? WallKind::periodic : WallKind::no_slip;
        scene.walls[a][1].kind = periodic && a == 0 ? WallKind::periodic : WallKind::free_slip;
    }
    MaterialSpec material;
    material.law = "linear-elastic";
    material.density = 1000;
    for (const Parameter& p : find_law(material.law)->parameters)
        material.parameters.push_back(std::string(p.key) == "young" ? 1e6 : 0.3);
    scene.materials.push_back(material);
    BodySpec body;
    scene.bodies.push_back(body);
    body.particles_per_cell = {1, 3, 4};
    scene.bodies.push_back(body);
    return scene;
}

template <class Real, int Dim>
struct Sample {
    Scene scene;
    Method<Host, Real, Dim> method;
    DomainBlocks<Dim> domain;
    Patch<Host, Real, Dim> patch;
    std::mt19937_64 random;

    Sample(const Scene& s, int particles, unsigned seed)
        : scene(s), method(scene), domain(scene), patch(method.needs, method.stencil.width), random(seed) {
        const std::vector<std::uint32_t> slots = patch.take_slots(static_cast<std::size_t>(particles));
        std::vector<std::pair<std::pair<Key, int>, std::uint32_t>> placed;
        for (std::uint32_t slot : slots) placed.push_back({fill(slot), slot});
        std::sort(placed.begin(), placed.end());
        BinnedBlocks binned;
        std::vector<OccupiedBlock> occupied;
        for (const auto& [place, slot] : placed) {
            if (binned.key.empty() || binned.key.back() != place.first) {
                binned.key.push_back(place.first);
                binned.count.push_back(0);
                occupied.push_back({place.first, 0});
            }
            ++binned.count.back();
            binned.slot.push_back(slot);
        }
        const Topology<Dim> topology =
            make_topology<Dim>(domain, occupied, [](const BlockPosition<Dim>&) { return 0; });
        patch.install(make_epoch<Dim>(topology, domain, method.stencil, 0), binned);
    }

    double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }

    TransferCall<Real, Dim> call() {
        const std::span<const std::int32_t> blocks = patch.blocks();
        return {method.context,
                patch.particles.view(),
                patch.table(),
                patch.list(),
                patch.grid(),
                blocks.data(),
                static_cast<std::int64_t>(blocks.size())};
    }

    GatherRound<Real> round(unsigned what, double dt) const {
        return {what, method.tpic, method.flip, static_cast<Real>(dt)};
    }
    GatherNotes notes() { return {patch.moves(), patch.outgoing_count(), patch.shuffled(), patch.outcome()}; }

    /// Calls f(slot, x [cells]) for every particle.
    template <class F>
    void each_particle(const F& f) {
        const ListView<Dim> list = patch.list();
        for (int b = 0; b < patch.own(); ++b)
            for (std::uint32_t k = list.first[b]; k < list.first[b + 1]; ++k) {
                std::array<double, Dim> x{};
                for (int a = 0; a < Dim; ++a)
                    x[static_cast<std::size_t>(a)] =
                        local_of<Real>(patch.table().position[b][a], patch.particles.view().position[list.slot[k]][a]) -
                        method.stencil.offset();
                f(list.slot[k], x);
            }
    }

  private:
    std::pair<Key, int> fill(std::uint32_t s) {
        const ParticleView<Real, Dim> p = patch.particles.view();
        BlockPosition<Dim> block{};
        int cell = 0;
        for (int a = Dim - 1; a >= 0; --a) {
            const auto i = static_cast<std::size_t>(a);
            const double n = domain.nodes[i];
            double x = uniform(0, n);
            if (s % 17 == 3) x = s % 2 ? 0 : n;  // on the faces themselves
            if (s % 17 == 4) x = s % 2 ? uniform(0, 0.5) : n - uniform(0, 0.5);
            if (domain.periodic[i] && x >= n) x = 0;
            const Place<Real> at = place<Real>(x + method.stencil.offset());
            block[i] = at.block;
            p.position[s][a] = at.u;
            p.velocity[s][a] = static_cast<Real>(uniform(-2, 2));
            cell = 4 * cell + cell_of<Real>(at.u);
            if (p.log_stretch) p.log_stretch[s][a] = static_cast<Real>(uniform(-0.5, 1));
            if (p.body_force) p.body_force[s][a] = static_cast<Real>(uniform(-10, 10));
            for (int b = 0; p.affine && b < Dim; ++b) p.affine[s](a, b) = static_cast<Real>(uniform(-3, 3));
        }
        domain.wrap(block);
        p.id[s] = s;
        p.body[s] = static_cast<std::uint16_t>(s % 2);
        p.mass[s] = static_cast<Real>(uniform(1, 3));
        p.volume[s] = static_cast<Real>(uniform(0.01, 0.02));
        p.ln_J[s] = Real(0);
        for (int k = 0; k < Sym<Real, Dim>::size; ++k) p.stress[s][k] = static_cast<Real>(uniform(-500, 500));
        return {Morton<Dim>::encode(block), cell};
    }
};

/// Weight and slope [1/cell] of a shape function at distance d = x - x_i [cells].
inline std::array<double, 2> shape_at(moraine::Shape shape, double d, double half) {
    const double r = std::fabs(d);
    const double sign = d < 0 ? -1 : 1;
    // At its kinks a hat has the slope of the side above.
    if (shape == moraine::Shape::linear) return d >= -1 && d < 1 ? std::array{1 - r, -sign} : std::array{0.0, 0.0};
    if (shape == moraine::Shape::quadratic) {
        if (r < 0.5) return {0.75 - r * r, -2 * d};
        return r < 1.5 ? std::array{0.5 * (1.5 - r) * (1.5 - r), sign * (r - 1.5)} : std::array{0.0, 0.0};
    }
    if (shape == moraine::Shape::cubic) {
        if (r < 1) return {2.0 / 3 - r * r + r * r * r / 2, sign * (1.5 * r * r - 2 * r)};
        return r < 2 ? std::array{std::pow(2 - r, 3) / 6, -sign * 0.5 * (2 - r) * (2 - r)} : std::array{0.0, 0.0};
    }
    // The mean of the hat over a box: differences of its integral.
    const auto integral = [](double y) {
        const double c = std::clamp(y, -1.0, 1.0);
        return c + (c < 0 ? 0.5 : -0.5) * c * c;
    };
    const auto hat = [](double y) { return std::max(0.0, 1 - std::fabs(y)); };
    return {(integral(d + half) - integral(d - half)) / (2 * half), (hat(d + half) - hat(d - half)) / (2 * half)};
}

/// A place or node index per axis, not deduced: array sizes and dimensions have different types.
template <class T, int Dim>
using PerAxis = std::type_identity_t<std::array<T, static_cast<std::size_t>(Dim)>>;

struct AxisWeight {
    int node;
    double w;
    double dw;        ///< [1/cell]
    double distance;  ///< x_i - x_p [cells]
};

/// Weights along one axis. Where the scene wants it, ghosts behind closed walls follow by linear extrapolation: what
/// they have counts 2 and -1 times for the two nodes before them.
inline std::vector<AxisWeight> axis_weights(const Scene& scene, std::size_t a, int nodes, double x, double half) {
    std::vector<AxisWeight> weights;
    for (int i = static_cast<int>(std::floor(x)) - 2; i <= static_cast<int>(std::floor(x)) + 3; ++i) {
        const std::array<double, 2> n = shape_at(scene.shape, x - i, half);
        if (n[0] == 0 && n[1] == 0) continue;
        const auto add = [&](int node, double times) {
            const int place = scene.periodic[a] ? (node % nodes + nodes) % nodes : node;
            weights.push_back({place, times * n[0], times * n[1], node - x});
        };
        const bool ghost = scene.boundary_spline && scene.shape != moraine::Shape::linear && !scene.periodic[a] &&
                           (i < 0 || i > nodes);
        if (ghost) {
            add(i < 0 ? 0 : nodes, 2);
            add(i < 0 ? 1 : nodes - 1, -1);
        } else {
            add(i, 1);
        }
    }
    return weights;
}

template <int Dim>
using Node = std::array<int, Dim>;

/// Calls f(node, w, dw [1/cell] per axis, x_i - x_p [cells] per axis) for each node that the particle reaches.
template <class Real, int Dim, class F>
void each_weight(Sample<Real, Dim>& sample, std::uint32_t slot, const PerAxis<double, Dim>& x, const F& f) {
    const ParticleView<Real, Dim> p = sample.patch.particles.view();
    std::array<std::vector<AxisWeight>, 3> axis;
    axis[2] = {{0, 1, 0, 0}};
    for (std::size_t a = 0; a < Dim; ++a) {
        const BodySpec& body = sample.scene.bodies[p.body[slot]];
        double half = 0.5 / body.particles_per_cell[a];
        if (p.log_stretch) half *= std::exp(double(p.log_stretch[slot][static_cast<int>(a)]));
        axis[a] = axis_weights(sample.scene, a, sample.domain.nodes[a], x[a], std::min(half, 0.5));
    }
    for (const AxisWeight& k : axis[2])
        for (const AxisWeight& j : axis[1])
            for (const AxisWeight& i : axis[0]) {
                const AxisWeight* at[3] = {&i, &j, &k};
                Node<Dim> node{};
                std::array<double, Dim> dw{}, distance{};
                for (std::size_t a = 0; a < Dim; ++a) {
                    node[a] = at[a]->node;
                    distance[a] = at[a]->distance;
                    dw[a] = at[a]->dw;
                    for (std::size_t b = 0; b < Dim; ++b)
                        if (b != a) dw[a] *= at[b]->w;
                }
                f(node, i.w * j.w * (Dim == 3 ? k.w : 1), dw, distance);
            }
}

/// Mass, momentum and force of a node.
template <int Dim>
struct NodeSums {
    double mass = 0;
    std::array<double, Dim> momentum{}, force{};
};

template <class Real, int Dim>
std::map<Node<Dim>, NodeSums<Dim>> reference_sums(Sample<Real, Dim>& sample) {
    std::map<Node<Dim>, NodeSums<Dim>> nodes;
    const ParticleView<Real, Dim> p = sample.patch.particles.view();
    const double h = sample.scene.cell;
    sample.each_particle([&](std::uint32_t s, const std::array<double, Dim>& x) {
        each_weight(sample, s, x, [&](const Node<Dim>& node, double w, const auto& dw, const auto& distance) {
            NodeSums<Dim>& n = nodes[node];
            n.mass += w * double(p.mass[s]);
            for (int a = 0; a < Dim; ++a) {
                const auto i = static_cast<std::size_t>(a);
                double v = double(p.velocity[s][a]);
                double f = p.body_force ? w * double(p.mass[s]) * double(p.body_force[s][a]) : 0;
                for (int b = 0; b < Dim; ++b) {
                    const auto j = static_cast<std::size_t>(b);
                    if (p.affine) v += double(p.affine[s](a, b)) * distance[j] * h;
                    f -= double(p.volume[s]) * double(p.stress[s](a, b)) * dw[j] / h;
                }
                n.momentum[i] += w * double(p.mass[s]) * v;
                n.force[i] += f;
            }
        });
    });
    return nodes;
}

/// The node at place n of a node block or, with side, of a tile that begins there.
template <class Real, int Dim>
Node<Dim> node_at(const Sample<Real, Dim>& sample, const Vec<std::int32_t, Dim>& block, int n, int side) {
    Node<Dim> node{};
    for (int a = 0; a < Dim; ++a) {
        const auto i = static_cast<std::size_t>(a);
        node[i] = 4 * block[a] - sample.method.stencil.origin + n % side;
        n /= side;
        const int length = sample.domain.nodes[i];
        if (sample.domain.periodic[i]) node[i] = (node[i] % length + length) % length;
    }
    return node;
}

}  // namespace moraine::test
