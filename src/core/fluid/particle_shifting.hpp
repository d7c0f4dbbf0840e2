#pragma once
// Particle shifting: particles of what flows (material/point.hpp) leave nodes that hold more than fits.
//
//   e_i = max(0, v_i / (h^d c_i) - 1),  v_i = sum_p w_ip V_p         c_i: over_filling.hpp
//   x_p <- x_p - n gamma (c dt) h sum_i e_i grad w_ip,  |shift| <= 0.05 h    in every n-th step; velocities as they
//   were
//
// In those steps tiles sum volumes in the lane that has stresses in all others: pressures are then not smoothed, and a
// little more in the others. Masses would do only for one density, and with the volume ratio that pressure says, which
// after a geostatic start is another by rho g H / K.
//
// Only over-filling counts: a free surface (e = 0) does not move, and voids are not closed from outside. But at a bed,
// a closed end that gravity presses the flow against, e_i also says what a node lacks (e_i < 0), if that is a twentieth
// or more, and the node above it is nearly full: there cells empty in a collapse, nothing else would fill them again,
// and what is missing bears no shear where shear is largest. Films thinner than 1.6 cells are not filled: no node above
// the bed is full.
//
// Velocities are untouched, so linear momentum is exact; the centre of mass moves, and with it some potential energy
// that no force gave. It is stable while n gamma c dt / h is below about 1 (the largest of k^2 w^2 is 1.4 per axis).
//
// Nothing goes into a wall, out of an end or into a structure by it: within a quarter of a cell of an end, or of a
// surface that acts where it is, there is no shift towards it. Half a cell is too much: what a fluctuation has shifted
// out of that half is not let back in, and it empties. Beside such surfaces c_i is what is open of a node; one that is
// open to less than a tenth does not count. Where structures act at nodes their share of a node is not known, and there
// is no shift where a node of the stencil reaches one.
//
// Shifting by concentration: Xu et al. 2009, Lind et al. 2012 (SPH); in MPM Zhang et al. 2018, Baumgarten and Kamrin
// 2023. Not scaled by the rate of shear, which is too weak at fine cells.

#include <cmath>

#include "core/data/quad.hpp"
#include "core/fluid/over_filling.hpp"
#include "core/fluid/pressure_smoothing.hpp"
#include "core/grid/stencil.hpp"
#include "core/particles/place_step.hpp"
#include "core/structures/contact.hpp"
#include "core/structures/surface_space.hpp"

namespace moraine {

inline constexpr int shift_interval = 5;  ///< n, counted from step number 0, so that a restart goes on with it

/// Whether particles are shifted in the step with this number.
constexpr bool shifts_in(std::int64_t step) {
    return step % shift_interval == shift_interval - 1;
}

/// In place of e_i at a node that reaches a structure.
template <class Real>
inline constexpr Real at_structure = Real(-1e30);

/// What all particles of a shift share.
template <class Real, int Dim>
struct Shifting {
    NodeCapacity<Real, Dim> capacity;
    Real inverse_volume;  ///< 1 / h^d [1/m3]
    DomainEnds<Real, Dim> ends;
    ContactField<Dim> contact;  ///< of structures that act at nodes; count 0: there are none
    SurfaceSpace surfaces;      ///< of those that act where they are
};

/// Share of its capacity that a node on a bed may lack: particles in a lattice leave it a few parts in a hundred short.
inline constexpr double spared_share = 0.05;

/// e_i. filling: v_i / h^d; full: it is on a bed, and the nodes above it are full.
template <class Real>
MORAINE_HD Real node_excess(Real filling, Real capacity, bool full = false) {
    const Real excess = filling / capacity - Real(1);
    if (excess > Real(0)) return excess;
    return full && excess < -Real(spared_share) ? excess : Real(0);
}

/// What must be open of a node beside a surface that it counts.
inline constexpr double counts_from = 0.1;

/// The same beside a surface that acts where it is.
template <class Real>
MORAINE_HD Real excess_beside(const SpaceNode& node, Real filling) {
    return node.capacity < counts_from ? Real(0) : node_excess(filling, Real(node.capacity));
}

/// Whether a surface is so near that it says what a node can hold.
MORAINE_HD bool limits_node(const SpaceNode* node) {
    constexpr double reach = 1.5;  // of a quadratic spline, and of a corner at that distance
    return node && node->distance < reach;
}

/// Share of its capacity from which a node above one on a bed is full.
inline constexpr double full_share = 0.9;

/// Whether the next node along an axis, upwards or downwards (step: 1 or -1), is full. filling: its v / h^d.
template <class Real, int Dim>
MORAINE_HD bool is_full(const NodeCapacity<Real, Dim>& capacity, const int* node, int axis, int step, Real filling) {
    int beside[Dim];
    for (int a = 0; a < Dim; ++a) beside[a] = node[a] + (a == axis ? step : 0);
    return filling > Real(full_share) * capacity.of(beside);
}

/// Whether the shape function of a node, `reach` cells wide to each side, reaches a structure. Ground: whether it may
/// be one; a device has the ground's distance at hand.
template <bool Ground = true, int Dim>
MORAINE_HD bool reaches_structure(const ContactField<Dim>& field, const int* node, double reach) {
    bool reached = false;
    for (int k = 0; k < field.count && !reached; ++k) {
        const Structure<Dim>& s = field.structure[k];
        const Vec<double, Dim> x = node_place(field, s, node, 0.0);
        if constexpr (Ground)
            reached = surface(s, field.corners, x).distance < reach * field.cell;
        else if (s.shape != StructureShape::ground)
            reached = surface_of_body(s, field.corners, x).distance < reach * field.cell;
    }
    return reached;
}

/// Whether a structure is so near the cube of `side` nodes from `lowest` on that one of them may reach it.
template <bool Ground = true, int Dim>
MORAINE_HD bool structure_within(const ContactField<Dim>& field, const int* lowest, int side, double reach) {
    const double half = 0.5 * (side - 1);
    bool near = false;
    for (int k = 0; k < field.count && !near; ++k) {
        const Structure<Dim>& s = field.structure[k];
        const double far = (reach + half * (Dim == 2 ? 1.4143 : 1.7321)) * field.cell;
        const Vec<double, Dim> middle = node_place(field, s, lowest, half);
        if constexpr (Ground)
            near = distance_bound(s, field.corners, middle) < far;
        else if (s.shape != StructureShape::ground)
            near = surface_of_body(s, field.corners, middle).distance < far;
    }
    return near;
}

/// Whether node n of a tile that begins at node base[] is on beds and all nodes above it are full. volume: as in
/// find_excess.
template <class Real, int Dim, class Volume>
MORAINE_HD bool full_above(const NodeCapacity<Real, Dim>& capacity, const int* base, const int* node, int n, int side,
                           const Volume& volume) {
    const unsigned beds = capacity.beds_at(node);
    bool full = beds != 0;
    for (int bed = 0, stride = 1; bed < 2 * Dim; ++bed) {
        const int axis = bed / 2, step = bed % 2 == 0 ? 1 : -1, place = node[axis] - base[axis] + step;
        const bool inside = place >= 0 && place < side;
        if (beds >> bed & 1) full = full && inside && is_full(capacity, node, axis, step, volume(n + step * stride));
        if (bed % 2 == 1) stride *= side;
    }
    return full;
}

/// e_i of the nodes of a tile that begins at node base[]; ghosts behind walls follow as velocities do. volume(n): v_i
/// of a node of the tile, over h^d; space(n): what it finds of surfaces, or null.
template <class Shape, class Real, int Dim, class Volume, class Space>
MORAINE_HD void find_excess(const Shifting<Real, Dim>& shifting, const Walls<Real, Dim>& walls, const int* base,
                            const Volume& volume, const Space& space, Real* excess) {
    constexpr int side = tile_side(Shape::width);
    const double reach = 0.5 * Shape::width;
    const bool near = structure_within(shifting.contact, base, side, reach);
    for (int n = 0, rest = 0; n < power<Dim>(side); rest = ++n) {
        int node[Dim];
        for (int a = 0; a < Dim; ++a, rest /= side) node[a] = base[a] + rest % side;
        if (near && reaches_structure(shifting.contact, node, reach))
            excess[n] = at_structure<Real>;
        else if (const SpaceNode* beside = space(n); limits_node(beside))
            excess[n] = excess_beside(*beside, volume(n));
        else
            excess[n] = node_excess(volume(n), shifting.capacity.of(node),
                                    full_above(shifting.capacity, base, node, n, side, volume));
    }
    each_ghost(walls, base, side, [&](int ghost, int step) {
        const Real* first = excess + ghost + step;
        excess[ghost] = Real(2) * first[0] - first[step];
    });
}

/// sum_i e_i grad w_ip [1/m], or zero where a node of the stencil reaches a structure. excess: by tile offset from the
/// stencil's first node.
template <class Shape, class Real, int Dim>
MORAINE_HD Vec<Real, Dim> gradient_of_excess(const Weights<Real, Dim, Shape>& n, const Real* excess) {
    Vec<Real, Dim> gradient = zero_vec<Real, Dim>();
    bool open = true;
    each_node<Dim, Shape::width>([&](int at, int i, int j, int k) {
        const int place[3] = {i, j, k};
        const Real e = excess[at];
        open = open && e != at_structure<Real>;
        for (int b = 0; b < Dim; ++b) {
            Real slope = e;
            for (int a = 0; a < Dim; ++a) slope *= a == b ? n.dw[a][place[a]] : n.w[a][place[a]];
            gradient[b] += slope;
        }
    });
    return open ? gradient : zero_vec<Real, Dim>();
}

/// Distance from an end within which nothing is shifted towards it [cells]: where the outermost of 2 particles per cell
/// stands.
inline constexpr double kept_from_ends = 0.25;

/// Takes from a shift what goes into a surface that is nearer than kept_from_ends. distance [cells], and its gradient.
template <class Real, int Dim>
MORAINE_HD void keep_from_surface(Real distance, const Vec<Real, Dim>& gradient, Vec<Real, Dim>& shift) {
    Real leaves = Real(0), square = Real(0);
    for (int a = 0; a < Dim; ++a) leaves += shift[a] * gradient[a], square += gradient[a] * gradient[a];
    if (!(distance < Real(kept_from_ends) && leaves < Real(0) && square > Real(0))) return;
    for (int a = 0; a < Dim; ++a) shift[a] -= leaves / square * gradient[a];
}

/// The shift by a gradient of e [1/m] in a step [m]. cell: h.
template <class Real, int Dim>
MORAINE_HD Vec<Real, Dim> shift_by(Real shifting, Real dt, Real cell, const Vec<Real, Dim>& gradient) {
    using std::sqrt;
    Real square = Real(0);
    for (int a = 0; a < Dim; ++a) square += gradient[a] * gradient[a];
    const Real most = Real(0.05) * cell, size = shifting * dt * sqrt(square);
    const Real factor = size > most ? most / sqrt(square) : shifting * dt;
    Vec<Real, Dim> shift;
    for (int a = 0; a < Dim; ++a) shift[a] = -factor * gradient[a];
    return shift;
}

/// Takes from a shift what goes towards an end of the domain that is nearer than kept_from_ends once the particle has
/// moved by `move` [cells].
template <class Real, int Dim>
MORAINE_HD void keep_from_ends(const DomainEnds<Real, Dim>& ends, const Vec<std::int32_t, Dim>& block,
                               const Vec<Coordinate<Real>, Dim>& u, const Vec<Real, Dim>& move, Vec<Real, Dim>& shift) {
    for (int a = 0; a < Dim; ++a) {
        const std::int32_t cell = 4 * block[a] + cell_of<Real>(u[a]);
        const Real f = fraction_of<Real>(u[a]) + move[a];
        const Real below = Real(cell - ends.cell[a][0]) + (f - ends.fraction[a][0]);
        const Real above = Real(ends.cell[a][1] - cell) + (ends.fraction[a][1] - f);
        if ((shift[a] < Real(0) ? below : above) < Real(kept_from_ends)) shift[a] = Real(0);
    }
}

}  // namespace moraine
