#pragma once
// Contact of soil with rigid structures, at the nodes.
//
//   f_n = (m_i / dt) S(d) max(0, -g_i / dt - w_n) n,   w = v_i' - V
//
//   |f_t| <= mu |f_n|, or alpha s_u A_i, or what stops it (rough)
//
// f_n: in a step the soil goes as far as it has space. f_t opposes what is left of w along the surface.
//
// This is Signorini's condition at the level of velocities (Moreau 1988): the gap does not close beyond zero, nothing
// is drawn back, and no stiffness, no time of contact is chosen. A gap of zero makes it the momentum exchange of
// Bardenhagen et al. (2001). The gap g_i is that of the nearest of the particles that the node feels, less their half
// size (core/structures/particle_gaps.hpp): a node's mass cannot tell a thin layer that touches from a thick one at a
// distance.
//
// S: nodes up to 0.5 h outside the surface are held, those from 0.6 h on are free: on average over all places of the
// surface between the nodes the last node that is held stands 0.05 h outside of it. Where no node stands near it the
// soil sinks in, as the spline of the free node reaches half a cell past the last one that is held: how deep particles
// may go is said in core/structures/particle_depth.hpp. The ramp is narrow because a node held in part is a dashpot m /
// dt: under load it is free, and more so the longer the step.
//
// The area A_i of a node is that of the particles that lie on the surface, by their weights: its sum over the nodes is
// the area that the soil covers. An undrained interface bears its strength wherever the soil touches, pressed or not:
// some of its nodes carry no load, and would lose their part of the area. A rough one holds what comes nearer and
// touches.
//
// Voellmy's law is Coulomb's with a drag by the square of the speed, |f_t| <= mu |f_n| + k w^2 A_i, k = rho g / xi, at
// the speed w that is left after the step: a quadratic equation. The drag also acts wherever the soil touches.

#include "core/structures/contact_field.hpp"
#include "core/structures/gap_tiles.hpp"

namespace moraine {

inline constexpr double held_below = 0.5;  ///< S = 1 [cells]
inline constexpr double free_above = 0.6;  ///< S = 0
inline constexpr double touching = 0.05;   ///< gap of soil that a rough surface holds [cells]
inline constexpr double look_from = 2.0;   ///< distance of nodes at which nothing of this is left [cells]

/// A node as contact sees it.
template <int Dim>
struct ContactNode {
    Vec<double, Dim> x;  ///< relative to the structure's image [m]
    Surface<Dim> surface;
    double hold;           ///< S, 0: free
    double gap;            ///< 0: touches [m]
    double area;           ///< A_i [m2, m]
    bool sticks;           ///< where it comes nearer: it touches a rough surface
    double friction, cap;  ///< of the structure there
};

/// The times of a round: a substep is shorter than the step in which particles go by what comes of it.
struct ContactTime {
    double dt;       ///< in which forces act; 0: they have, and elements (core/surfaces) act once more [s]
    double closing;  ///< in which gaps may close [s]

    MORAINE_HD bool is_second() const { return !(dt > 0); }
    MORAINE_HD ContactTime second() const { return {0, closing}; }
};

/// Whether a node of the block whose lowest node is `node` may touch the structure. Ground: whether that may be one.
template <bool Ground = true, bool Turns = may_turn, int Dim>
MORAINE_HD bool is_near(const ContactField<Dim>& f, const Structure<Dim>& s, const int* node) {
    const double reach = f.cell * (look_from + 1.5 * (Dim == 2 ? 1.4143 : 1.7321));  // and half of the block's diagonal
    const Vec<double, Dim> middle = node_place(f, s, node, 1.5);
    if constexpr (Ground)
        return distance_bound(s, f.corners, middle) < reach;
    else
        return surface_of_body<Turns>(s, f.corners, middle).distance < reach;
}

/// The ground at x. kept: the node's; on a device it is known (gpu/kernels/gaps/gaps.cu), on the host it may be null.
template <int Dim>
MORAINE_HD GroundNode<Dim> ground_under(const ContactField<Dim>& f, const Structure<Dim>& s, const Vec<double, Dim>& x,
                                        GroundNode<Dim>* kept) {
#if !defined(__CUDA_ARCH__)
    if (!kept) return ground_node(s, f.corners, x);
    if (!kept->is_known()) *kept = ground_node(s, f.corners, x);
#endif
    return *kept;
}

template <int Dim>
MORAINE_HD ContactNode<Dim> look_at(const ContactField<Dim>& f, const Structure<Dim>& s, const int* node,
                                    const NodeGap& gap, GroundNode<Dim>* kept = nullptr) {
    ContactNode<Dim> n{};
    if (gap.is_none()) return n;
    n.x = node_place(f, s, node, 0.0);
    n.friction = s.friction, n.cap = s.cap;
    if (s.shape == StructureShape::ground) {
        const GroundNode<Dim> ground = ground_under(f, s, n.x, kept);
        n.surface = ground.surface;
        n.friction = ground.friction, n.cap = ground.cap;
    } else {
        n.surface = surface_of_body(s, f.corners, n.x);
    }
    n.hold = ramp(n.surface.distance / f.cell, held_below, free_above);
    n.gap = gap.cells() > 0 ? gap.cells() * f.cell : 0;
    n.sticks = s.law == InterfaceLaw::rough && gap.cells() < touching;
    n.area = gap.faces() * (Dim == 2 ? f.cell : f.cell * f.cell);
    return n;
}

/// w of w + drag w^2 = speed [m/s]; 0 where that is negative. drag [s/m].
MORAINE_HD double after_drag(double speed, double drag) {
    using std::sqrt;
    return speed > 0 ? 2 * speed / (1 + sqrt(1 + 4 * drag * speed)) : 0.0;
}

/// Whether the law has a part that acts where the soil touches, pressed or not.
MORAINE_HD bool acts_where_it_touches(InterfaceLaw law) {
    return law == InterfaceLaw::undrained || law == InterfaceLaw::voellmy;
}

/// Change of the velocity relative to the structure along its surface that the interface gives [m/s].
template <int Dim>
MORAINE_HD void slow_slip(const Structure<Dim>& s, const ContactNode<Dim>& n, double pressed, double dt_over_mass,
                          Vec<double, Dim>& slip) {
    const double speed = magnitude(slip);
    double most = 0;
    switch (s.law) {
        case InterfaceLaw::smooth:
            break;
        case InterfaceLaw::rough:
            most = n.sticks ? n.hold * speed : 0.0;
            break;
        case InterfaceLaw::coulomb:
            most = n.friction * pressed;
            break;
        case InterfaceLaw::undrained:
            most = n.cap * n.area * dt_over_mass;
            break;
        case InterfaceLaw::voellmy:
            most = speed - after_drag(speed - n.friction * pressed, n.cap * n.area * dt_over_mass);
            break;
    }
    slip = (most < speed ? most / speed : 1.0) * slip;
}

/// Takes the contact with one structure from the node's velocity v. Returns whether they touch.
template <class Real, int Dim>
MORAINE_HD bool touch_structure(const Structure<Dim>& s, const ContactNode<Dim>& n, const ContactTime& time,
                                double mass, Vec<Real, Dim>& v) {
    if (!(n.hold > 0 || n.area > 0)) return false;
    const Vec<double, Dim> of_structure = velocity_at(s, n.x);
    Vec<double, Dim> slip;
    for (int a = 0; a < Dim; ++a) slip[a] = double(v[a]) - of_structure[a];
    const double approach = dot(slip, n.surface.normal);
    const double too_fast = -n.gap / time.closing - approach;
    const double pressed = too_fast > 0 ? too_fast * n.hold : 0.0;
    if (!(pressed > 0 || (n.sticks && approach < 0) || (acts_where_it_touches(s.law) && n.area > 0))) return false;
    slip = slip - approach * n.surface.normal;
    slow_slip(s, n, pressed, time.dt / mass, slip);
    for (int a = 0; a < Dim; ++a) v[a] = Real(double(v[a]) + pressed * n.surface.normal[a] - slip[a]);
    return true;
}

/// What the structure gets from a node that gave it `impulse` [kg m/s].
template <int Dim>
MORAINE_HD void tell_structure(const Structure<Dim>& s, const ContactNode<Dim>& n, double mass,
                               const Vec<double, Dim>& impulse, double (&all)[StructureSums<Dim>::count]) {
    const Vec<double, moments<Dim>> moment = moment_of(n.x - s.at, impulse);
    for (int a = 0; a < Dim; ++a) all[a] = impulse[a];
    for (int a = 0; a < moments<Dim>; ++a) all[Dim + a] = moment[a];
    for (int a = 0; a < Dim; ++a) {
        const double across = n.surface.normal[a] * n.surface.normal[a];
        all[StructureSums<Dim>::first_mass + a] = mass * n.hold * (s.law == InterfaceLaw::rough ? 1 : across);
    }
    all[StructureSums<Dim>::work] = dot(impulse, velocity_at(s, n.x));
}

/// What of a node that gave `impulse`, and had the velocity `before`, follows a structure that turns. What slips
/// follows by what it gave over its slip.
template <class Real, int Dim>
MORAINE_HD Following<Dim> following_of(const Structure<Dim>& s, const ContactNode<Dim>& n, double mass,
                                       const Vec<Real, Dim>& before, const Vec<double, Dim>& impulse) {
    Vec<double, Dim> slip = velocity_at(s, n.x);
    for (int a = 0; a < Dim; ++a) slip[a] = double(before[a]) - slip[a];
    const Vec<double, Dim>& normal = n.surface.normal;
    slip = slip - dot(slip, normal) * normal;
    const double pressed = -dot(impulse, normal), speed = magnitude(slip);
    const double along = speed > 0 ? magnitude(impulse - (-pressed) * normal) / speed : 0.0;
    return {pressed > 0 ? mass * n.hold : 0.0, along, normal, n.x - s.at};
}

/// All structures in turn on one node: changes v. gap_of(k): what particles tell of structure k. tell(k, values,
/// following): takes what that gets from the node (StructureSums), and what following() says of one that turns.
/// `given`: what they got together [kg m/s]. `ground`: the node's, where it is kept. Returns whether one touches.
template <class Real, int Dim, class GapOf, class Tell>
MORAINE_HD bool touch_structures(const ContactField<Dim>& f, const int* node, Real mass, const ContactTime& time,
                                 const GapOf& gap_of, const Tell& tell, Vec<Real, Dim>& v, Vec<double, Dim>& given,
                                 GroundNode<Dim>* ground = nullptr) {
    bool touched = false;
    for (int k = 0; k < f.count; ++k) {
        const Structure<Dim>& s = f.structure[k];
        const ContactNode<Dim> n = look_at(f, s, node, gap_of(k), ground);
        const Vec<Real, Dim> before = v;
        if (!touch_structure(s, n, time, double(mass), v)) continue;
        touched = true;
        Vec<double, Dim> impulse;
        for (int a = 0; a < Dim; ++a) {
            impulse[a] = double(mass) * (double(before[a]) - double(v[a]));
            given[a] += impulse[a];
        }
        double all[StructureSums<Dim>::count];
        tell_structure(s, n, double(mass), impulse, all);
        tell(k, all, [&] { return following_of(s, n, double(mass), before, impulse); });
    }
    return touched;
}

}  // namespace moraine
