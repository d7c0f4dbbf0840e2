#pragma once
// What particles tell nodes about structures: the gap, and how much of the surface the soil lies on.
//
//   g_i = min over the particles that reach node i of (d(x_p) - s_p / 2),    s_p = V_p^(1/D)        [cells]
//   A_i = sum_p w_ip a_p,    a_p = (s_p / J_p^(1/D))^(D-1) where d(x_p) < s_p, else 0               [cells^(D-1)]
//   and, of a surface element, the same of particles up to 1.4 s_p; for a drag no more than the element
//   and, of an undrained interface that follows the soil, a_p times s_u,p over the greatest s_u of the scene
//
// s_p is the side of a square or cube of the particle's present volume: soil of rows s_p apart touches when the centres
// of its lowest row stand s_p / 2 over the surface, whatever its thickness. A particle whose centre is less than its
// own size off the surface lies on it, and stands for a face of its cube: one row of a lattice, and of a disordered
// body as many as fill a layer of that depth; pressed soil keeps its width. Both follow from particles alone. The mass
// of a node, which told the gap before, cannot tell a thin layer that touches from a thick one at a distance.
// Soil that stretches along the surface thins its lowest row before the next one has come down: an element looks for
// it, and is covered wholly where both are there. A node's area has no end to stop at.
//
// A block's particles give to a tile of their own per structure, as in P2G, but in whole numbers: fixed-point minima
// and sums are the same in any order, by any thread and on any rank. Tiles of blocks that others need travel with the
// halo. Positions change once per step, so all rounds of a step share the tiles. A scene without structures has none.

#include "core/grid/stencil.hpp"
#include "core/structures/contact_field.hpp"
#include "core/structures/gap_tiles.hpp"
#include "core/structures/ground_bound.hpp"

namespace moraine {

/// A block and a structure that may touch its particles; `tile`: of the gaps.
struct ContactPair {
    std::int32_t block;
    std::int32_t structure;
    std::int32_t tile;
};

/// Who lies on a surface, by the distance over the particle's size.
struct Lying {
    double below;  ///< wholly
    double above;  ///< not at all
};
MORAINE_HD constexpr Lying lying_at_nodes() {
    return {0.9, 1.1};
}
MORAINE_HD constexpr Lying lying_on_elements() {
    return {1.0, 1.4};
}
/// Particles further off a surface are not looked at [cells].
inline constexpr double particle_reach = 1.5;

/// Whether a particle of the block at `position` may be looked at. Exact distances grow by at most the way walked.
template <int Dim>
MORAINE_HD bool is_near_block(const ContactField<Dim>& f, const Structure<Dim>& s,
                              const Vec<std::int32_t, Dim>& position) {
    int lowest[Dim];
    for (int a = 0; a < Dim; ++a) lowest[a] = 4 * position[a];
    const double reach = f.cell * (particle_reach + 2 * (Dim == 2 ? 1.4143 : 1.7321));  // and half of the diagonal
    return distance_bound(s, f.corners, node_place(f, s, lowest, 2 - f.offset)) < reach;
}

/// The plane over the ground under a block; none where its particles are at two ends of the domain.
template <int Dim>
GroundBound<Dim> bound_of_block(const ContactField<Dim>& f, const Structure<Dim>& s,
                                const Vec<std::int32_t, Dim>& position) {
    int ends[2][Dim];
    for (int a = 0; a < Dim; ++a) ends[0][a] = 4 * position[a], ends[1][a] = ends[0][a] + 4;
    const Vec<double, Dim> low = node_place(f, s, ends[0], -f.offset), high = node_place(f, s, ends[1], -f.offset);
    const Vec<double, Dim> middle = node_place(f, s, ends[0], 2 - f.offset);
    GroundBound<Dim> bound = bound_ground(s, f.corners, middle, 2 * f.cell, particle_reach * f.cell);
    for (int a = 0; a < Dim; ++a)
        if (!(high[a] - low[a] > 3 * f.cell)) bound.top = 1e300;
    return bound;
}

/// Of one particle: what it tells the nodes that it reaches.
struct ParticleGap {
    std::int32_t gap;  ///< fixed point; NodeGap::none: too far
    double area;       ///< a_p [cells^(D-1)]
};

/// Side of a square or cube.
template <int Dim>
MORAINE_HD double side_of(double volume) {
    using std::cbrt;
    using std::sqrt;
    return Dim == 2 ? sqrt(volume) : cbrt(volume);
}

/// Where contact sees a particle [m].
template <class Real, int Dim>
MORAINE_HD Vec<double, Dim> contact_place(const ContactField<Dim>& f, const Structure<Dim>& s,
                                          const Vec<std::int32_t, Dim>& block, const Vec<Coordinate<Real>, Dim>& u) {
    Vec<double, Dim> x;
    for (int a = 0; a < Dim; ++a) x[a] = f.origin[a] + f.cell * (local_of<Real>(block[a], u[a]) - f.offset);
    return image_near(f, s, x);
}

/// d: distance of the particle [cells].
template <class Real, int Dim>
MORAINE_HD ParticleGap gap_at(const ContactField<Dim>& f, const Lying& lying, double d, Real volume, Real ln_J) {
    using std::exp;
    if (!(d < particle_reach)) return {NodeGap::none, 0};
    const double size = side_of<Dim>(double(volume)) / f.cell;
    const double lies = ramp(d / size, lying.below, lying.above);
    const double width = side_of<Dim>(double(volume) * exp(-double(ln_J))) / f.cell;
    return {NodeGap::fixed(d - 0.5 * size), lies * (Dim == 2 ? width : width * width)};
}

/// a_p of a particle as the structure counts it. scalar(k): the particle's, of its law.
template <int Dim, class Scalar>
MORAINE_HD double bearing_area(const ContactField<Dim>& f, const Structure<Dim>& s, double area, int body,
                               const Scalar& scalar) {
    if (!s.follows_soil || !(area > 0)) return area;
    const SoilShare soil = f.soil[body];
    return area * soil.share * (soil.scalar < 0 ? 1.0 : double(scalar(soil.scalar)));
}

/// Calls f(node of the tile, what it is told) for the nodes that a particle reaches; half: of its box, where the shape
/// has one [cells]. Weights of ghosts behind walls go to the nodes that they follow, as the masses do.
template <class Shape, class Real, int Dim, class F>
MORAINE_HD void each_gap_node(const Walls<Real, Dim>& walls, bool border, const Vec<std::int32_t, Dim>& block,
                              const Vec<Coordinate<Real>, Dim>& u, const Vec<Real, Dim>& half, const ParticleGap& own,
                              const F& f) {
    constexpr int width = Shape::width;
    Real w[Dim][width], dw[Dim][width];
    int cell = 0;
    for (int a = Dim - 1; a >= 0; --a) {
        const int c = cell_of<Real>(u[a]);
        cell = 4 * cell + c;
        Shape::weights(fraction_of<Real>(u[a]), half[a], w[a], dw[a]);
        if constexpr (width > 2)
            if (border) fold_weights<width>(walls.ghosts(a, first_node<Shape>(block[a]) + c, width), w[a], dw[a]);
    }
    const int first = tile_offset<Dim, width>(cell);
    each_node<Dim, width>([&](int at, int i, int j, int k) {
        const double weight = double(w[0][i]) * double(w[1][j]) * (Dim == 2 ? 1.0 : double(w[Dim - 1][k]));
        if (weight > 0) f(first + at, NodeGap{own.gap, NodeGap::fixed_area(weight * own.area)});
    });
}

/// The loop of the host.
template <class Real, int Dim, class Shape>
struct ParticlesToGaps {
    static constexpr int tile_nodes = power<Dim>(tile_side(Shape::width));
    struct Scratch {};

    StencilContext<Real, Dim> context;
    ParticleView<Real, Dim> p;
    BlockTable<Dim> table;
    ListView<Dim> list;
    ContactField<Dim> field;
    NodeGap* tiles;
    const ContactPair* chosen;
    const GroundBound<Dim>* bounds = nullptr;  ///< by block; null: there is no ground

    template <class Team>
    MORAINE_HD void operator()(const Team& team, int item, Scratch&) const {
        const ContactPair& pair = chosen[item];
        if (list.count(pair.block) == 0) return;
        const Structure<Dim>& structure = field.structure[pair.structure];
        const GroundBound<Dim>* bound =
            bounds && structure.shape == StructureShape::ground ? bounds + pair.block : nullptr;
        NodeGap* tile = tiles + std::size_t(pair.tile) * tile_nodes;
        team.each(tile_nodes, [&](int n) { tile[n] = NodeGap{}; });
        team.sync();
        const std::uint32_t end = list.first[pair.block + 1];
        for (std::uint32_t k = list.first[pair.block]; k < end; k += chunk)
            add_chunk(pair.block, structure, bound, k, end - k < chunk ? end - k : chunk, tile);
    }

  private:
    static constexpr std::uint32_t chunk = 64;

    /// Of some particles first who is near, then how near: distances do not wait for one another.
    MORAINE_HD void add_chunk(std::int32_t b, const Structure<Dim>& structure, const GroundBound<Dim>* bound,
                              std::uint32_t from, std::uint32_t count, NodeGap* tile) const {
        const Vec<std::int32_t, Dim>& block = table.position[b];
        std::uint32_t slot[chunk];
        Vec<double, Dim> place[chunk];
        double distance[chunk];
        int near = 0;
        for (std::uint32_t k = 0; k < count; ++k) {
            slot[near] = list.slot[from + k];
            place[near] = contact_place<Real>(field, structure, block, p.position[slot[near]]);
            near += !(bound && bound->is_clear(place[near]));
        }
        for (int k = 0; k < near; ++k) distance[k] = surface(structure, field.corners, place[k]).distance / field.cell;
        for (int k = 0; k < near; ++k) {
            const std::uint32_t s = slot[k];
            ParticleGap own = gap_at<Real, Dim>(field, lying_at_nodes(), distance[k], p.volume[s], p.ln_J[s]);
            if (own.gap == NodeGap::none) continue;
            own.area = bearing_area(field, structure, own.area, p.body[s], [&](int n) { return p.history[n][s]; });
            Vec<Real, Dim> half = zero_vec<Real, Dim>();
            if constexpr (Shape::sized)
                for (int a = 0; a < Dim; ++a) half[a] = gimp_half(context, p, s, a);
            each_gap_node<Shape>(context.walls, table.border[b] != 0, block, p.position[s], half, own,
                                 [&](int n, const NodeGap& gap) { tile[n].add(gap); });
        }
    }
};

}  // namespace moraine
