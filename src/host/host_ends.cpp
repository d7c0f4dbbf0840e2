// Absorbing ends on the host (core/nodes/absorbing_ends.hpp): how they are measured, and where they lie in an epoch.
//
// A column in place of the masses gives its mean at the nodes by the sums of a step: m c for the speeds of the soil
// beside an end, layers and all; V rho c for those of what is named behind it. The last sums are the step's own, whose
// forces are what the ends bear.

#include "host/host_ends.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/host_engine.hpp"

namespace moraine {
namespace {

template <class Real, int Dim>
struct BorderSums {
    using Scratch = TileSums<Real, Dim>;

    BlockTable<Dim> table;
    TileView<Real> grid;
    int width;
    const std::int32_t* chosen;
    Scratch* out;  ///< by chosen node block

    void operator()(const SoloTeam& team, int item, Scratch&) const {
        if (grid.node_of[chosen[item]] >= 0) out[item].find(team, table, grid, width, chosen[item]);
    }
};

/// Node blocks with a node on one of these faces. on(axis, side): whether it is one.
template <class Real, int Dim, class On>
std::vector<std::int32_t> blocks_at(const Walls<Real, Dim>& walls, const BlockTable<Dim>& table, int origin,
                                    const On& on) {
    std::vector<std::int32_t> found;
    for (int c = 0; c < table.node_blocks; ++c)
        if (is_at_face(walls, table.node_position[c], origin, on)) found.push_back(c);
    return found;
}

/// Signal speed of a particle without its own [m/s].
template <class Real, int Dim>
double wave_speed_of(const LawBatch<Real, Dim>& law, const ParticleView<Real, Dim>& p, std::uint32_t slot) {
    double square = 0;
    for (int a = 0; a < Dim; ++a) square += double(p.velocity[slot][a]) * double(p.velocity[slot][a]);
    return law.signal(p, slot) - std::sqrt(square);
}

/// B-spline of this order.
double spline(Shape shape, double x) {
    x = std::fabs(x);
    if (shape == Shape::quadratic) return x < 0.5 ? 0.75 - x * x : x < 1.5 ? 0.5 * (1.5 - x) * (1.5 - x) : 0;
    return x < 1 ? 2.0 / 3 - x * x + 0.5 * x * x * x : x < 2 ? (2 - x) * (2 - x) * (2 - x) / 6 : 0;
}

/// Share of a node inside that the node on the end of an axis holds of a body's particles, b: of a lattice, its own
/// sum, 4.8 % less than the integral 13/24 for two particles a cell and quadratic splines; else the integral.
double share_on_end(const Scene& scene, const BodySpec& body, std::size_t axis, bool folded) {
    const bool splines = scene.shape == Shape::quadratic || scene.shape == Shape::cubic;
    if (!splines || body.seeding != Seeding::lattice) return end_capacity(scene.shape, folded).on;
    const int count = body.particles_per_cell[axis];
    double sum = 0;
    for (int k = 0; k < 2 * count; ++k) {
        const double x = (k + 0.5) / count;
        sum += (spline(scene.shape, x) + (folded ? 2 * spline(scene.shape, x + 1) : 0)) / count;
    }
    return sum;
}

/// What is added up for the waves of one kind against one face, over b: m c, or V Z with what is behind it.
template <class Real, int Dim>
void fill_column(const Scene& scene, const Method<Host, Real, Dim>& method, const ListView<Dim>& list, int blocks,
                 const ParticleView<Real, Dim>& p, double behind, bool shear, int face, std::vector<Real>& column) {
    const auto first = list.first[0], last = list.first[blocks];
    if (first == last) return;
    column.resize(std::size_t(*std::max_element(list.slot + first, list.slot + last)) + 1);
    std::vector<double> share;  // of the speed of P waves over b, by body
    for (const BodySpec& body : scene.bodies) {
        const double poisson = poisson_ratio(scene.materials[static_cast<std::size_t>(body.material)]);
        const double on = share_on_end(scene, body, static_cast<std::size_t>(face / 2),
                                       method.context.walls.fold[face / 2][face % 2]);
        share.push_back((shear && !(behind > 0) ? std::sqrt((1 - 2 * poisson) / (2 - 2 * poisson)) : 1) / on);
    }
    for (auto k = first; k < last; ++k) {
        const std::uint32_t s = list.slot[k];
        const int body = p.body[s];
        const double value =
            behind > 0 ? double(p.volume[s]) * behind : double(p.mass[s]) * wave_speed_of(method.law_of(body), p, s);
        column[s] = static_cast<Real>(share[static_cast<std::size_t>(body)] * value);
    }
}

/// What waves of both kinds give the nodes of a block against each face: rho c A h [kg m/s], by node.
template <int Dim>
using WaveSums = std::array<std::array<std::array<double, Block<Dim>::cells>, 2>, 2 * Dim>;

/// The same of all components at one node over its mass and h: k [1/s]; whether a face that is asked for has it.
template <class Real, int Dim>
bool add_drags(const EndQuery<Dim>& query, const Walls<Real, Dim>& walls, const WaveSums<Dim>& waves, int n,
               double mass_cell, EndNode<Dim>& found) {
    bool asked = false;
    for (std::size_t f = 0; f < 2 * Dim; ++f) {
        const std::size_t axis = f / 2;
        const auto& face = query.face[axis][f % 2];
        if (!face.absorbs || found.node[axis] != walls.plane[axis][f % 2]) continue;
        asked = asked || face.asked;
        for (std::size_t a = 0; a < Dim; ++a)
            found.drag[a] += waves[f][a == axis ? 0 : 1][static_cast<std::size_t>(n)] / mass_cell;
    }
    return asked;
}

}  // namespace

template <class Real, int Dim>
void HostEngine<Real, Dim>::measure(EndQuery<Dim>& query) {
    const Walls<Real, Dim>& walls = method_.context.walls;
    const BlockTable<Dim> table = patch_.table();
    const std::vector<std::int32_t> chosen = blocks_at(walls, table, method_.stencil.origin, [&](int a, int s) {
        return query.face[static_cast<std::size_t>(a)][static_cast<std::size_t>(s)].asked;
    });
    const auto count = static_cast<std::int64_t>(chosen.size());
    std::vector<TileSums<Real, Dim>> sums(chosen.size());
    const auto sum = [&](Real* column) {
        sum_column(column);
        Host::launch_teams(
            count, BorderSums<Real, Dim>{table, patch_.grid(), method_.stencil.width, chosen.data(), sums.data()});
    };
    std::vector<WaveSums<Dim>> waves(chosen.size());
    std::vector<Real> column;
    for (std::size_t f = 0; f < 2 * Dim; ++f)
        for (const std::size_t kind : {0, 1}) {
            const auto& face = query.face[f / 2][f % 2];
            if (!face.absorbs) continue;
            fill_column(scene_, method_, patch_.list(), table.own, patch_.particles.view(), kind == 0 ? face.p : face.s,
                        kind == 1, static_cast<int>(f), column);
            sum(column.data());
            for (std::size_t i = 0; i < chosen.size(); ++i)
                for (std::size_t n = 0; n < Block<Dim>::cells; ++n)
                    waves[i][f][kind][n] = double(sums[i].sums[2 * n][0]);
        }
    sum(patch_.particles.view().mass);
    for (std::size_t i = 0; i < chosen.size(); ++i)
        for (int n = 0; n < Block<Dim>::cells; ++n) {
            const double m = double(sums[i].sums[2 * n][0]);
            const bool mine = sums[i].counted_by[n] >= 0 && sums[i].counted_by[n] < table.own;
            if (patch_.grid().node_of[chosen[i]] < 0 || !mine || !(m > query.mass_cutoff)) continue;
            EndNode<Dim> found{};
            for (int a = 0; a < Dim; ++a) {
                const auto at = static_cast<std::size_t>(a);
                found.node[at] = node_along(table.node_position[chosen[i]], method_.stencil.origin, n, a);
                found.hold[at] = -(double(sums[i].sums[2 * n + 1][a]) / m + query.gravity[at]);
            }
            if (add_drags(query, walls, waves[i], n, m * scene_.cell, found)) query.found.push_back(found);
        }
}

template <class Real, int Dim>
void HostEnds<Real, Dim>::act(const Method<Host, Real, Dim>& method, Patch<Host, Real, Dim>& patch,
                              const NodeRound<Real, Dim>& round) {
    if (!std::exchange(laid_, true))
        sites_ = end_sites<Real, Dim>(method.context.walls, method.absorbs, method.stencil.origin,
                                      patch.tables().node_position, measured_);
    gifts_.resize(sites_.size());
    Host::launch(static_cast<std::int64_t>(sites_.size()),
                 ActAtEnds<Real, Dim>{method.context.walls, patch.table(), patch.grid(), method.stencil.width,
                                      method.stencil.origin, round, sites_.data(), gifts_.data()});
}

template <class Real, int Dim>
void HostEnds<Real, Dim>::count(const Quantum& quantum, bool with_energy, Budget<Dim>& budget) const {
    for (const EndGift<Dim>& gift : gifts_) {
        for (std::size_t a = 0; a < Dim; ++a) budget.impulse[a].add(quantum.of(gift.impulse[a]));
        if (with_energy) budget.energy.nodes.walls.add(quantum.of(gift.taken));
    }
}

template class HostEnds<float, 2>;
template class HostEnds<float, 3>;
template class HostEnds<double, 2>;
template class HostEnds<double, 3>;
template void HostEngine<float, 2>::measure(EndQuery<2>&);
template void HostEngine<float, 3>::measure(EndQuery<3>&);
template void HostEngine<double, 2>::measure(EndQuery<2>&);
template void HostEngine<double, 3>::measure(EndQuery<3>&);

}  // namespace moraine
