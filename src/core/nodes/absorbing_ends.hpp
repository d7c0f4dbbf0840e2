#pragma once
// Ends that absorb: a viscous boundary for P and S waves on a face of the domain, after Lysmer and Kuhlemeyer (1969).
//
//   t_n = -rho c_p v_n,   t_t = -rho c_s v_t      on the wall, with a constant part t_0 on which the ground rests
//   m v' = m v + dt (f + m g + m r) - dt k m (v + v') / 2,     k_i = sum over faces of A_i Z / m_i = c / (b h)
//
// Trapezoidal and implicit at the node, so it sets no bound on the step, and takes m k (v + v')^2 / 4 a second.
// m_i = b A_i h rho, where b is what a node on the wall holds of a node inside (13/24 for quadratic splines, and what a
// lattice makes of it): so A_i follows the mass, and is right where a face is covered in part, too.
//
// r = -(f / m + g), when the end was measured: what the ground was held by. A dashpot alone bears no weight, and ground
// would creep away at sigma / (rho c). It is an acceleration, so that it goes with the soil. Nodes that held no soil
// when their end was measured are a smooth wall.
//
// What an end gives is a force like any other: it is added to the first tile of the node, which is the same on all
// ranks, between the halo and the nodes. So kernels of nodes know nothing of ends.

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/data/exact_sum.hpp"
#include "core/data/grid_views.hpp"
#include "core/data/quad.hpp"
#include "core/grid/walls.hpp"
#include "core/nodes/nodes.hpp"

namespace moraine {

/// What a node on an absorbing end was measured to have; the same on all ranks.
template <int Dim>
struct EndNode {
    std::array<int, Dim> node;     ///< its index
    std::array<double, Dim> hold;  ///< r [m/s2]
    std::array<double, Dim> drag;  ///< k [1/s]
};

/// Ascending by node.
template <int Dim>
using EndNodes = std::vector<EndNode<Dim>>;

/// Where such a node is in an epoch, and what the end does there.
template <class Real, int Dim>
struct EndSite {
    std::int32_t block;  ///< node block
    std::int32_t at;     ///< node of it
    Vec<Real, Dim> hold;
    Vec<Real, Dim> drag;  ///< below 0: held fast

    /// Velocity from that before the forces and that by them alone.
    MORAINE_HD Vec<Real, Dim> velocity(Real dt, const Vec<Real, Dim>& start, const Vec<Real, Dim>& trial) const {
        Vec<Real, Dim> v;
        for (int a = 0; a < Dim; ++a) {
            const Real half = Real(0.5) * dt * drag[a];
            v[a] = half < Real(0) ? Real(0) : (trial[a] + dt * hold[a] - half * start[a]) / (Real(1) + half);
        }
        return v;
    }
};

/// Index along an axis of node n of the node block at a position.
template <int Dim>
int node_along(const Vec<std::int32_t, Dim>& block, int origin, int n, int a) {
    return 4 * block[a] - origin + ((n >> (2 * a)) & 3);
}

/// Whether a node block has a node on one of these faces. on(axis, side): whether it is one.
template <class Real, int Dim, class On>
bool is_at_face(const Walls<Real, Dim>& walls, const Vec<std::int32_t, Dim>& block, int origin, const On& on) {
    for (int a = 0; a < Dim; ++a)
        for (int s = 0; s < 2; ++s) {
            const int beyond = walls.plane[a][s] - node_along(block, origin, 0, a);
            if (on(a, s) && beyond >= 0 && beyond < 4) return true;
        }
    return false;
}

/// Of an epoch: its nodes on faces that absorb. origin: of the stencil; blocks: positions of its node blocks.
template <class Real, int Dim>
std::vector<EndSite<Real, Dim>> end_sites(const Walls<Real, Dim>& walls, const bool (&absorbs)[Dim][2], int origin,
                                          std::span<const Vec<std::int32_t, Dim>> blocks,
                                          const EndNodes<Dim>& measured) {
    std::vector<EndSite<Real, Dim>> sites;
    for (std::size_t c = 0; c < blocks.size(); ++c) {
        if (!is_at_face(walls, blocks[c], origin, [&](int a, int s) { return absorbs[a][s]; })) continue;
        for (int n = 0; n < Block<Dim>::cells; ++n) {
            EndSite<Real, Dim> site{static_cast<std::int32_t>(c), n, zero_vec<Real, Dim>(), zero_vec<Real, Dim>()};
            std::array<int, Dim> node;
            bool on = false;
            for (int a = 0; a < Dim; ++a) {
                node[static_cast<std::size_t>(a)] = node_along(blocks[c], origin, n, a);
                for (int s = 0; s < 2; ++s)
                    if (absorbs[a][s] && node[static_cast<std::size_t>(a)] == walls.plane[a][s])
                        site.drag[a] = Real(-1), on = true;
            }
            if (!on) continue;
            const auto found = std::lower_bound(measured.begin(), measured.end(), node,
                                                [](const EndNode<Dim>& e, const auto& key) { return e.node < key; });
            for (std::size_t a = 0; found != measured.end() && found->node == node && a < Dim; ++a) {
                site.hold[static_cast<int>(a)] = static_cast<Real>(found->hold[a]);
                site.drag[static_cast<int>(a)] = static_cast<Real>(found->drag[a]);
            }
            sites.push_back(site);
        }
    }
    return sites;
}

/// What an end did to a node in a round; zero where another rank counts it.
template <int Dim>
struct EndGift {
    std::array<double, Dim> impulse;  ///< [kg m/s]
    double taken;                     ///< [J]
};

/// Adds the forces of ends to tiles, a site each.
template <class Real, int Dim>
struct ActAtEnds {
    Walls<Real, Dim> walls;
    BlockTable<Dim> table;
    TileView<Real> grid;
    int width;
    int origin;
    NodeRound<Real, Dim> round;
    const EndSite<Real, Dim>* sites;
    EndGift<Dim>* gifts;  ///< by site

    MORAINE_HD void operator()(int i) const {
        const EndSite<Real, Dim>& site = sites[i];
        gifts[i] = {};
        const Sums sums = sums_of(site);
        const Real m = sums.first[0];
        if (!sums.tile || !(m > round.mass_cutoff)) return;
        Vec<Real, Dim> start, trial;
        for (int a = 0; a < Dim; ++a) {
            start[a] = sums.first[1 + a] / m;
            trial[a] = start[a] + round.dt * (sums.second[a] / m + round.gravity[a]);
        }
        Vec<Real, Dim> v = site.velocity(round.dt, start, trial);
        for (int a = 0; a < Dim; ++a) sums.tile[quad + a] += m * (v[a] - trial[a]) / round.dt;
        if (!sums.counted) return;
        const Sums now = sums_of(site);
        int node[Dim];
        for (int a = 0; a < Dim; ++a)
            node[a] = 4 * table.node_position[site.block][a] - origin + ((site.at >> (2 * a)) & 3);
        walls.constrain(node, v);
        for (int a = 0; a < Dim; ++a) {
            const double given = double(round.dt) * (double(now.second[a]) - double(sums.second[a]));
            gifts[i].impulse[std::size_t(a)] = given;
            gifts[i].taken -= 0.5 * given * (double(start[a]) + double(v[a]));
        }
    }

  private:
    /// Of a node: (m, q), f, and where its first tile has it.
    struct Sums {
        Quad<Real> first, second;
        Real* tile = nullptr;
        bool counted = false;
    };

    MORAINE_HD Sums sums_of(const EndSite<Real, Dim>& site) const {
        Sums sums{Quad<Real>::zero(), Quad<Real>::zero()};
        for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
            const int source = table.source[site.block * Block<Dim>::corners + delta];
            const int tile = source < 0 ? -1 : grid.tile_of[source];
            const int at = tile < 0 ? -1 : tile_node<Dim>(site.at, delta, width);
            if (at < 0) continue;
            Real* const of = grid.tiles + (std::size_t(tile) * power<Dim>(tile_side(width)) + at) * node_reals;
            sums.first = sums.first + Quad<Real>::load(of);
            sums.second = sums.second + Quad<Real>::load(of + quad);
            if (sums.tile) continue;
            sums.tile = of;
            sums.counted = source < table.own;
        }
        return sums;
    }
};

}  // namespace moraine
