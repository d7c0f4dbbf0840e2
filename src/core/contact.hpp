#pragma once
// Contact of soil with rigid structures, at the nodes.
//
//   f_n = -k (w_n dt) n,  k = p S(d) G(g) m_i / dt^2   where  w = v_i' - V  approaches the structure (w_n < 0)
//   f_t opposes what is left of w along the surface, at most mu |f_n|, or alpha s_u A_i, or what stops it (rough)
//
// The penalty works on the way into the structure that the node would go in this step: m / dt^2 is the stiffest that is
// stable and leaves no creep; p = 1 makes it the momentum exchange of Bardenhagen et al. (2001). The method paper's
// Geocontact scales such a nodal force by the node's distance from the surface; S and G do that here:
//
// S: nodes up to 0.65 h outside the surface are held, those from 0.75 h on are free: the last node that is held stands
// 0.2 h outside of it, averaged over all places of the surface between the nodes. Soil that is drawn along goes on
// towards that node's surface some way, as the spline of the free node behind it reaches half a cell past it: with
// h/4 and 3h/4 it sank in by up to 0.7 h beside a loaded T-bar, whose load was 9 % too low. The ramps of S and
// G are narrow because a node held in part is a dashpot m / dt: under load it is free, and more so the longer the step.
//
// G: nothing touches before the soil is there. A node feels particles up to the reach of its shape function away; its
// mass tells how far the soil's edge is. `fill(s)` is the mass, over that of a full node, of a node at the distance s
// outside of a straight edge; soil whose edge has the gap g to the surface fills a node at the distance d by
// fill(g - d). Without G soil stops about one cell above a structure.
//
// The area of a node, sum A_i = contact area: h^(D-1) times a hat of the distance whose width |n_x| + |n_y| + |n_z|
// makes the sum over the nodes exact for planes along the grid, times G and the mass that is there over that of a full
// contact. An undrained interface bears its strength wherever the soil touches, pressed or not: some of its nodes carry
// no load, and would lose their part of the area. A node at the edge of a contact is half full, as if there were a gap.

#include "core/exact_sum.hpp"
#include "core/structure.hpp"

namespace moraine {

template <int Dim>
inline constexpr int moments = Dim == 2 ? 1 : 3;

/// What the soil gave to one structure in one step: impulse [N s], moment of impulse about its reference point, per
/// axis the mass of the nodes that follow the structure there [kg]: how much more it would have got had it been faster,
/// and the work on it, impulse times velocity [J].
template <int Dim>
struct StructureSums {
    static constexpr int first_mass = Dim + moments<Dim>;
    static constexpr int work = first_mass + Dim;
    static constexpr int count = work + 1;
    ExactSum sum[count];

    void add(const StructureSums& o) {
        for (int k = 0; k < count; ++k) sum[k].add(o.sum[k]);
    }
};

/// All structures as a kernel sees them, and where it adds up what they feel.
template <int Dim>
struct ContactField {
    const Structure<Dim>* structure;
    int count;
    const Vec<double, 2>* corners;  ///< of all polygons
    Vec<double, Dim> origin;        ///< place of node 0 [m]
    Vec<double, Dim> period;        ///< of periodic axes, else 0 [m]
    double cell;                    ///< h [m]
    double full_mass;               ///< of a node in the middle of the lightest soil [kg]
    double half;                    ///< fill: the hat is averaged over a box of this half-size [cells]
    double stretch;                 ///< and stretched by this
    int faces[Dim][2];              ///< nodes on closed axes' ends: half of their surroundings is missing
    StructureSums<Dim>* sums;       ///< by structure; shared
};

inline constexpr double held_below = 0.65;     ///< S = 1 [cells]
inline constexpr double free_above = 0.75;     ///< S = 0
inline constexpr double touching_at = 0.05;    ///< G = 1: gap [cells]
inline constexpr double touching_from = 0.15;  ///< G = 0
inline constexpr double look_from =
    1.75;  ///< distance at which nothing of this is left; the area's hat ends at 3^(1/2)

/// Mass of a node over that of a full one, s [cells] outside the straight edge of a half-space.
MORAINE_HD double tail_of_box(double s, double l) {
    if (s >= 1 + l) return 0;
    if (s > 1 - l) return (1 + l - s) * (1 + l - s) * (1 + l - s) / (12 * l);
    if (s >= l) return (1 - s) * (1 - s) / 2 + l * l / 6;
    return 0.5 - s + s * s * s / (6 * l) + s * l / 2;
}
template <int Dim>
MORAINE_HD double fill(const ContactField<Dim>& f, double s) {
    const double t = s / f.stretch;
    return t >= 0 ? tail_of_box(t, f.half) : 1 - tail_of_box(-t, f.half);
}

MORAINE_HD double ramp(double x, double one, double zero) {
    const double t = (zero - x) / (zero - one);
    return t < 0 ? 0 : (t > 1 ? 1 : t);
}

/// A node as contact sees it.
template <int Dim>
struct ContactNode {
    Vec<double, Dim> x;  ///< relative to the structure's image [m]
    Surface<Dim> surface;
    double hold;  ///< S G p, 0: free
    double area;  ///< A_i [m2, m]
};

/// x, or its periodic image nearest to the structure.
template <int Dim>
MORAINE_HD Vec<double, Dim> image_near(const ContactField<Dim>& f, const Structure<Dim>& s, Vec<double, Dim> x) {
    using std::rint;
    for (int a = 0; a < Dim; ++a)
        if (f.period[a] > 0) x[a] -= f.period[a] * rint((x[a] - s.at[a]) / f.period[a]);
    return x;
}

template <int Dim>
MORAINE_HD Vec<double, Dim> node_place(const ContactField<Dim>& f, const Structure<Dim>& s, const int* node,
                                       double shift) {
    Vec<double, Dim> x;
    for (int a = 0; a < Dim; ++a) x[a] = f.origin[a] + f.cell * (node[a] + shift);
    return image_near(f, s, x);
}

/// Whether a node of the block whose lowest node is `node` may touch the structure.
template <int Dim>
MORAINE_HD bool is_near(const ContactField<Dim>& f, const Structure<Dim>& s, const int* node) {
    const double reach = f.cell * (look_from + 1.5 * (Dim == 2 ? 1.4143 : 1.7321));  // and half of the block's diagonal
    return surface(s, f.corners, node_place(f, s, node, 1.5)).distance < reach;
}

/// How full the node is, over a node that has soil all around.
template <int Dim>
MORAINE_HD double fullness(const ContactField<Dim>& f, const int* node, double mass) {
    double full = f.full_mass;
    for (int a = 0; a < Dim; ++a)
        if (node[a] == f.faces[a][0] || node[a] == f.faces[a][1]) full *= 0.5;
    return mass / full;
}

template <int Dim>
MORAINE_HD ContactNode<Dim> look_at(const ContactField<Dim>& f, const Structure<Dim>& s, const int* node, double mass) {
    using std::fabs;
    ContactNode<Dim> n;
    n.x = node_place(f, s, node, 0.0);
    n.surface = surface(s, f.corners, n.x);
    n.hold = n.area = 0;
    const double d = n.surface.distance / f.cell;
    if (!(d < look_from)) return n;
    const double there = fullness(f, node, mass);
    const double least = fill(f, touching_from - d), most = fill(f, touching_at - d);
    const double touch = there >= most ? 1 : (there <= least ? 0 : (there - least) / (most - least));
    n.hold = s.penalty * ramp(d, held_below, free_above) * touch;
    double width = 0;
    for (int a = 0; a < Dim; ++a) width += fabs(n.surface.normal[a]);
    const double hat = 1 - fabs(d) / width;
    if (hat > 0 && most > 0) {
        const double share = there < most ? there / most : 1;
        n.area = hat / width * share * touch * (Dim == 2 ? f.cell : f.cell * f.cell);
    }
    return n;
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
            most = n.hold * speed;
            break;
        case InterfaceLaw::coulomb:
            most = s.friction * pressed;
            break;
        case InterfaceLaw::undrained:
            most = s.cap * n.area * dt_over_mass;
            break;
    }
    slip = (most < speed ? most / speed : 1.0) * slip;
}

/// Takes the contact with one structure from the node's velocity v. Returns whether they touch.
template <class Real, int Dim>
MORAINE_HD bool touch_structure(const Structure<Dim>& s, const ContactNode<Dim>& n, double dt_over_mass,
                                Vec<Real, Dim>& v) {
    if (!(n.hold > 0 || n.area > 0)) return false;
    Vec<double, Dim> slip;
    for (int a = 0; a < Dim; ++a) slip[a] = double(v[a]) - s.velocity[a];
    const double approach = dot(slip, n.surface.normal);
    if (!(approach < 0) && s.law != InterfaceLaw::undrained) return false;
    slip = slip - approach * n.surface.normal;
    const double pressed = approach < 0 ? -approach * n.hold : 0.0;
    slow_slip(s, n, pressed, dt_over_mass, slip);
    for (int a = 0; a < Dim; ++a) v[a] = Real(double(v[a]) + pressed * n.surface.normal[a] - slip[a]);
    return true;
}

/// What the structure gets from a node that gave it `impulse` [kg m/s].
template <int Dim>
MORAINE_HD void tell_structure(const Structure<Dim>& s, const ContactNode<Dim>& n, double mass,
                               const Vec<double, Dim>& impulse, double (&all)[StructureSums<Dim>::count]) {
    const Vec<double, Dim> arm = n.x - s.at;
    for (int a = 0; a < Dim; ++a) all[a] = impulse[a];
    if constexpr (Dim == 2)
        all[2] = arm[0] * impulse[1] - arm[1] * impulse[0];
    else
        for (int a = 0; a < 3; ++a)
            all[3 + a] = arm[(a + 1) % 3] * impulse[(a + 2) % 3] - arm[(a + 2) % 3] * impulse[(a + 1) % 3];
    for (int a = 0; a < Dim; ++a) {
        const double across = n.surface.normal[a] * n.surface.normal[a];
        all[StructureSums<Dim>::first_mass + a] = mass * n.hold * (s.law == InterfaceLaw::rough ? 1 : across);
    }
    all[StructureSums<Dim>::work] = dot(impulse, s.velocity);
}

/// All structures in turn on one node: changes v, adds up at the structures if the node is counted here. `given`: what
/// they got together [kg m/s]. Returns whether one touches.
template <class Real, int Dim>
MORAINE_HD bool touch_structures(const ContactField<Dim>& f, const int* node, Real mass, Real dt, bool counted,
                                 const Quantum& quantum, Vec<Real, Dim>& v, Vec<double, Dim>& given) {
    bool touched = false;
    for (int k = 0; k < f.count; ++k) {
        const Structure<Dim>& s = f.structure[k];
        const ContactNode<Dim> n = look_at(f, s, node, double(mass));
        const Vec<Real, Dim> before = v;
        if (!touch_structure(s, n, double(dt) / double(mass), v)) continue;
        touched = true;
        Vec<double, Dim> impulse;
        for (int a = 0; a < Dim; ++a) {
            impulse[a] = double(mass) * (double(before[a]) - double(v[a]));
            given[a] += impulse[a];
        }
        double all[StructureSums<Dim>::count];
        tell_structure(s, n, double(mass), impulse, all);
        for (int q = 0; counted && q < StructureSums<Dim>::count; ++q)
            add_shared(&f.sums[k].sum[q], quantum.of(all[q]));
    }
    return touched;
}

}  // namespace moraine
