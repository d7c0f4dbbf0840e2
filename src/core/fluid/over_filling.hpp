#pragma once
// Over-filling: the share of the volume that does not fit where its particles are.
//
//   v_i = sum_p w_ip V_p,    over-filling = sum_i max(0, v_i - h^d c_i) / sum_p V_p
//   c_i = product over axes of the integral over the domain of w_i dx / h: 1 inside
//
// ln J says how much space a particle takes, its place where: the two part when particles crowd, and no stress sees
// it. At a closed end c_i is less than 1, because the node's shape function reaches past it: with the boundary spline
// (walls.hpp) 13/24 on the wall and 23/24 next to it for the quadratic, 7/12 and 11/12 for the cubic. A box of GIMP
// lies in the domain, so its node on the wall is half a node and all others are whole. Ends that are open are taken as
// not there: what their nodes hold is less. Nor is space that structures fill: beside one over-filling is told too low.
//
// Spatial integration errors and over-filling: Baumgarten and Kamrin (2023); Steffen et al. (2008).

#include "core/data/exact_sum.hpp"
#include "core/data/grid_views.hpp"
#include "core/grid/shape.hpp"
#include "core/grid/walls.hpp"

namespace moraine {

/// What nodes hold along the axis of a closed end, over a node inside [-].
struct EndCapacity {
    double on;    ///< the node on the wall
    double next;  ///< the one after it
};

/// folded: the ghost node behind it follows by extrapolation.
constexpr EndCapacity end_capacity(Shape shape, bool folded) {
    // Of the half of a shape function, the ghost's tail; a fold gives the ghost's share twice to the first, and takes
    // it from the second.
    const double tail = shape == Shape::quadratic ? 1.0 / 48 : shape == Shape::cubic ? 1.0 / 24 : 0;
    return {0.5 + (folded ? 2 * tail : 0), 1 - tail - (folded ? tail : 0)};
}

/// c_i of every node.
template <class Real, int Dim>
struct NodeCapacity {
    int plane[Dim][2];  ///< as in Walls
    Real on[Dim][2], next[Dim][2];
    unsigned beds;  ///< bit 2 a + s: end s of axis a is closed, and gravity presses what is there against it

    /// The factor of axis a.
    MORAINE_HD Real along(int a, int node) const {
        Real c = Real(1);
        for (int s = 0; s < 2; ++s) {
            const int inside = s == 0 ? node - plane[a][0] : plane[a][1] - node;
            if (inside == 0) c *= on[a][s];
            if (inside == 1) c *= next[a][s];
        }
        return c;
    }
    MORAINE_HD Real of(const int* node) const {
        Real c = Real(1);
        for (int a = 0; a < Dim; ++a) c *= along(a, node[a]);
        return c;
    }
    /// Of the beds that a node is on, by the same bits.
    MORAINE_HD unsigned beds_at(const int* node) const {
        unsigned on_them = 0;
        for (int bed = 0; bed < 2 * Dim; ++bed)
            if ((beds >> bed & 1) && node[bed / 2] == plane[bed / 2][bed % 2]) on_them |= 1u << bed;
        return on_them;
    }
};

/// Sums over nodes, each counted once over all ranks.
struct NodeVolumes {
    ExactSum above;  ///< max(0, v_i / h^d - c_i)
    ExactSum all;    ///< v_i / h^d

    void add(const NodeVolumes& o) {
        above.add(o.above);
        all.add(o.all);
    }
    /// Of their terms, which are full nodes: a thousand times one node, 2^30 times.
    static Quantum quantum() { return Quantum::for_largest(1024); }
    double over_filling() const {
        const double volume = quantum().value(all);
        return volume > 0 ? quantum().value(above) / volume : 0;
    }
};

/// From tiles whose first lanes are sums of volumes: what is above capacity, by node block. A node is +0 plus its
/// tiles by offset, and is counted by the owner of the first, as in nodes.hpp.
template <class Real, int Dim>
struct CountVolumes {
    struct Scratch {
        Real volume[Block<Dim>::cells];
        std::int32_t counted_by[Block<Dim>::cells];
    };

    NodeCapacity<Real, Dim> capacity;
    BlockTable<Dim> table;
    TileView<Real> grid;
    int width;
    int origin;
    double inverse_volume;  ///< 1 / h^d [1/m3]
    NodeVolumes* volumes;   ///< by node block

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int c, Scratch& scratch) const {
        volumes[c] = {};
        if (grid.node_of[c] < 0) return;
        team.each(Block<Dim>::cells, [&](int n) { scratch.volume[n] = Real(0), scratch.counted_by[n] = -1; });
        for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
            const int source = table.source[c * Block<Dim>::corners + delta];
            const int tile = source < 0 ? -1 : grid.tile_of[source];
            if (tile < 0) continue;
            team.each(Block<Dim>::cells, [&](int n) { add_tile_node(n, delta, source, tile, scratch); });
        }
        for (int n = 0; n < Block<Dim>::cells; ++n)
            if (scratch.counted_by[n] >= 0 && scratch.counted_by[n] < table.own) count(c, n, double(scratch.volume[n]));
    }

  private:
    MORAINE_HD void add_tile_node(int n, int delta, int source, int tile, Scratch& scratch) const {
        const int at = tile_node<Dim>(n, delta, width);
        if (at < 0) return;
        scratch.volume[n] += grid.tiles[(std::size_t(tile) * power<Dim>(tile_side(width)) + at) * node_reals];
        if (scratch.counted_by[n] < 0) scratch.counted_by[n] = source;
    }

    MORAINE_HD void count(int c, int n, double volume) const {
        int node[Dim];
        for (int a = 0; a < Dim; ++a) node[a] = 4 * table.node_position[c][a] - origin + ((n >> (2 * a)) & 3);
        const double full = volume * inverse_volume, above = full - double(capacity.of(node));
        volumes[c].all.add(NodeVolumes::quantum().of(full));
        if (above > 0) volumes[c].above.add(NodeVolumes::quantum().of(above));
    }
};

}  // namespace moraine
