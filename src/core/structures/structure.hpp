#pragma once
// A rigid structure as a value: a shape, where it is, how fast it goes. Never made of particles.
//
//   distance d(x) [m]: negative inside; normal n(x): unit, outward, = grad d where that exists
//
// Exact distances of plane, sphere (2-D: circle), cylinder with flat ends, box, capsule (a segment with a radius; 2-D:
// stadium) and of a polygon, in 3-D a prism along z. An exact distance grows by at most the way walked (Lipschitz
// constant 1), so one evaluation at the middle of a block of nodes tells that none of them is near. Positions are
// doubles also where the particles are single: a structure moves by a millionth of a cell per step.
//
// Ground (core/structures/ground.hpp) has its distance by one step to the foot point, exact to 0.004 h on real models,
// and only where it may be below `radius`; further off it is a lower bound, and so is all of distance_bound().
//
//   g = z - b(x),  q = x + g grad b / (1 + |grad b|^2),  n = (-grad b(q), 1) / |..|,  d = n . (x - q, z - b(q))

#include <cmath>

#include "core/data/scene_choices.hpp"
#include "core/data/vec.hpp"
#include "core/structures/ground_table.hpp"

namespace moraine {

/// What of a ground's law has a table of its own, in this order; bits of Structure::corners.
enum BedTables { bed_friction = 1, bed_cap = 2 };

/// Whether what is asked may turn: kernels of a device know none that does unless their program (MORAINE_TURNS) or an
/// argument of their template says that the scene has one.
#if defined(__CUDA_ARCH__) && !defined(MORAINE_TURNS)
inline constexpr bool may_turn = false;
#else
inline constexpr bool may_turn = true;
#endif

/// Axes about which a structure can turn.
template <int Dim>
inline constexpr int moments = Dim == 2 ? 1 : 3;

template <int Dim>
struct Structure {
    StructureShape shape;
    Vec<double, Dim> at;        ///< now: a point of the plane; centre; middle of segment, box, prism, domain [m]
    Vec<double, Dim> along;     ///< plane: normal; cylinder, capsule: unit vector; box, prism: half lengths [m]
    double radius;              ///< ground: where distances are not bounds; polygon: how exact they are [m]
    double half;                ///< cylinder, capsule: half length [m]
    int first_corner, corners;  ///< polygon: relative to `at`, counter-clockwise; ground: its table, BedTables
    Vec<double, Dim> velocity;  ///< in this step [m/s]
    InterfaceLaw law;
    bool follows_soil;               ///< undrained: the soil bears a share of `cap` (SoilShare)
    double friction;                 ///< Coulomb coefficient [-]
    double cap;                      ///< largest shear stress [Pa]; voellmy: that at 1 m/s
    bool turns;                      ///< `along` and corners are in its own axes, which turn about `at`
    Mat<double, Dim> turn;           ///< from its own axes to the scene's
    Vec<double, moments<Dim>> spin;  ///< angular velocity in this step [rad/s]
};

template <int Dim>
struct Surface {
    double distance;          ///< [m]
    Vec<double, Dim> normal;  ///< away from the structure
};

template <int N>
MORAINE_HD double dot(const Vec<double, N>& a, const Vec<double, N>& b) {
    double sum = 0;
    for (int i = 0; i < N; ++i) sum += a[i] * b[i];
    return sum;
}
template <int N>
MORAINE_HD double magnitude(const Vec<double, N>& a) {
    using std::sqrt;
    return sqrt(dot(a, a));
}
template <int N>
MORAINE_HD Vec<double, N> operator*(double s, const Vec<double, N>& a) {
    Vec<double, N> r;
    for (int i = 0; i < N; ++i) r[i] = s * a[i];
    return r;
}
template <int N>
MORAINE_HD Vec<double, N> operator-(const Vec<double, N>& a, const Vec<double, N>& b) {
    Vec<double, N> r;
    for (int i = 0; i < N; ++i) r[i] = a[i] - b[i];
    return r;
}

template <int N>
MORAINE_HD Vec<double, N> operator*(const Mat<double, N>& m, const Vec<double, N>& a) {
    Vec<double, N> r = zero_vec<double, N>();
    for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j) r[i] += m(i, j) * a[j];
    return r;
}
/// Transposed m times a.
template <int N>
MORAINE_HD Vec<double, N> turned_back(const Mat<double, N>& m, const Vec<double, N>& a) {
    Vec<double, N> r = zero_vec<double, N>();
    for (int i = 0; i < N; ++i)
        for (int j = 0; j < N; ++j) r[i] += m(j, i) * a[j];
    return r;
}
/// r x f: the moment of a force at an arm.
template <int Dim>
MORAINE_HD Vec<double, moments<Dim>> moment_of(const Vec<double, Dim>& r, const Vec<double, Dim>& f) {
    Vec<double, moments<Dim>> m;
    if constexpr (Dim == 2)
        m[0] = r[0] * f[1] - r[1] * f[0];
    else
        for (int a = 0; a < 3; ++a) m[a] = r[(a + 1) % 3] * f[(a + 2) % 3] - r[(a + 2) % 3] * f[(a + 1) % 3];
    return m;
}
/// w x r: the velocity of a point at an arm.
MORAINE_HD Vec<double, 2> swept_by(const Vec<double, 1>& w, const Vec<double, 2>& r) {
    return {{-w[0] * r[1], w[0] * r[0]}};
}
MORAINE_HD Vec<double, 3> swept_by(const Vec<double, 3>& w, const Vec<double, 3>& r) {
    return moment_of<3>(w, r);
}

/// V + w x r of the structure at x, beside it and not at a periodic image [m/s].
template <int Dim>
MORAINE_HD Vec<double, Dim> velocity_at(const Structure<Dim>& s, const Vec<double, Dim>& x) {
    if constexpr (may_turn)
        if (s.turns) return s.velocity - (-1.0) * swept_by(s.spin, x - s.at);
    return s.velocity;
}

/// From the point's offset to the nearest point of an axis or corner; `spare` where they coincide.
template <int Dim>
MORAINE_HD Surface<Dim> round_surface(const Vec<double, Dim>& offset, double radius, const Vec<double, Dim>& spare) {
    const double r = magnitude(offset);
    return {r - radius, r > 0 ? (1 / r) * offset : spare};
}

template <int Dim>
MORAINE_HD Vec<double, Dim> last_axis() {
    Vec<double, Dim> up = zero_vec<double, Dim>();
    up[Dim - 1] = 1;
    return up;
}

template <int Dim>
MORAINE_HD Surface<Dim> box_surface(const Vec<double, Dim>& half, const Vec<double, Dim>& x) {
    using std::fabs;
    Vec<double, Dim> beyond;  // the face of each axis
    Surface<Dim> s{-1e300, zero_vec<double, Dim>()};
    int axis = 0;
    bool outside = false;
    for (int a = 0; a < Dim; ++a) {
        const double past = fabs(x[a]) - half[a];
        if (past > s.distance) s.distance = past, axis = a;
        beyond[a] = past > 0 ? (x[a] < 0 ? -past : past) : 0;
        outside = outside || past > 0;
    }
    s.normal[axis] = x[axis] < 0 ? -1 : 1;
    return outside ? round_surface(beyond, 0, s.normal) : s;
}

/// Cylinder with flat ends: a rectangle in (along the axis, away from it).
template <int Dim>
MORAINE_HD Surface<Dim> cylinder_surface(const Structure<Dim>& c, const Vec<double, Dim>& x) {
    const double t = dot(x, c.along);
    const Vec<double, Dim> away = x - t * c.along;
    const double r = magnitude(away);
    Vec<double, Dim> out = r > 0 ? (1 / r) * away : zero_vec<double, Dim>();
    if (!(r > 0)) out[c.along[0] * c.along[0] < 0.5 ? 0 : 1] = 1;  // on the axis: only deep inside
    const Surface<2> flat = box_surface<2>({{c.half, c.radius}}, {{t, r}});
    return {flat.distance, flat.normal[0] * c.along - (-flat.normal[1]) * out};
}

/// The nearest parts of a polygon: edges by their own outward normals, corners by the way from them.
struct NearestParts {
    double distance = 1e300;                                     ///< to the nearest
    Vec<double, 2> edges = zero_vec<double, 2>();                ///< sum of the normals
    Vec<double, 2> corners = zero_vec<double, 2>();              ///< sum of the unit ways
    Vec<double, 2> foremost = Vec<double, 2>{{-1e300, -1e300}};  ///< the largest of the normals, x first

    /// Parts whose distances differ by at most `tie` are equally near. to: from the nearest point of the part.
    MORAINE_HD void add(const Vec<double, 2>& to, bool at_corner, const Vec<double, 2>& normal, double tie) {
        const double d = magnitude(to);
        if (d > distance + tie) return;
        if (d < distance - tie) edges = corners = zero_vec<double, 2>(), foremost = {{-1e300, -1e300}};
        if (d < distance) distance = d;
        if (at_corner && d > tie)
            corners = corners - (-1 / d) * to;
        else
            edges = edges - (-1.0) * normal;
        if (normal[0] > foremost[0] || (normal[0] == foremost[0] && normal[1] > foremost[1])) foremost = normal;
    }
    /// The mean of their normals; between two that face away from each other the foremost.
    MORAINE_HD Surface<2> surface(bool inside) const {
        const Vec<double, 2> all = edges - (inside ? 1.0 : -1.0) * corners;
        const double length = magnitude(all);
        return {inside ? -distance : distance, length > 1e-6 ? (1 / length) * all : foremost};
    }
};

/// Distance and normal of a polygon in x and y; corners counter-clockwise. On an edge the normal is the edge's, where
/// several parts are equally near the mean of theirs: neither is made of an offset that is rounding, nor of the order
/// of the corners.
template <int Dim>
MORAINE_HD Surface<2> polygon_surface(const Vec<double, 2>* corner, int n, double tie, double x, double y) {
    NearestParts nearest;
    bool inside = false;
    for (int i = 0, j = n - 1; i < n; j = i++) {
        const double ex = corner[i][0] - corner[j][0], ey = corner[i][1] - corner[j][1];
        const double px = x - corner[j][0], py = y - corner[j][1];
        const double square = ex * ex + ey * ey;
        const double along = (px * ex + py * ey) / square;
        const double t = along < 0 ? 0 : (along > 1 ? 1 : along);
        nearest.add({{px - t * ex, py - t * ey}}, t != along, (1 / std::sqrt(square)) * Vec<double, 2>{{ey, -ex}}, tie);
        if ((corner[i][1] > y) != (corner[j][1] > y) && x < corner[j][0] + ex * (y - corner[j][1]) / ey)
            inside = !inside;
    }
    return nearest.surface(inside);
}

/// Of a prism's side and end, by the distances to them: across the side, along the axis.
MORAINE_HD Surface<2> side_and_end(double aside, double above, double tie) {
    using std::fabs;
    const double half = 0.70710678118654752;
    if (aside > tie && above > tie) return round_surface<2>({{aside, above}}, 0.0, {{1, 0}});
    if (fabs(aside - above) <= tie) return {aside > above ? aside : above, {{half, half}}};
    return above > aside ? Surface<2>{above, {{0, 1}}} : Surface<2>{aside, {{1, 0}}};
}

template <int Dim>
MORAINE_HD Surface<Dim> prism_surface(const Structure<Dim>& p, const Vec<double, 2>* corners,
                                      const Vec<double, Dim>& x) {
    const Surface<2> flat = polygon_surface<Dim>(corners + p.first_corner, p.corners, p.radius, x[0], x[1]);
    Surface<Dim> s{flat.distance, zero_vec<double, Dim>()};
    double sideways = 1;
    if constexpr (Dim == 3) {
        const Surface<2> both = side_and_end(flat.distance, std::fabs(x[2]) - p.along[2], p.radius);
        s.distance = both.distance, sideways = both.normal[0];
        s.normal[2] = x[2] < 0 ? -both.normal[1] : both.normal[1];
    }
    s.normal[0] = sideways * flat.normal[0];
    s.normal[1] = sideways * flat.normal[1];
    return s;
}

/// Of the ground with this table at x [m]; lower bounds beyond `reach`.
template <int Dim>
MORAINE_HD Surface<Dim> ground_surface(const Vec<double, 2>* table, double reach, const Vec<double, Dim>& x) {
    using std::fabs;
    using std::sqrt;
    const Vec<double, Dim> up = last_axis<Dim>();
    const double cosine = table[1][1], over_all = (x[Dim - 1] - table[2][1]) * cosine;
    if (over_all > reach) return {over_all, up};
    GroundPoint<Dim> b = ground_at(table, x);
    const double gap = x[Dim - 1] - b.height;
    if (fabs(gap) * cosine > reach) return {gap * cosine, up};
    Vec<double, Dim> foot = x - (-gap / (1 + dot(b.slope, b.slope))) * b.slope;
    b = ground_at(table, foot);
    foot[Dim - 1] = b.height;
    const Vec<double, Dim> normal = (1 / sqrt(1 + dot(b.slope, b.slope))) * (up - b.slope);
    return {dot(x - foot, normal), normal};
}

/// Of one structure that is no ground at a point `from` its middle, in its own axes [m]; `corners` of all polygons.
template <int Dim>
MORAINE_HD Surface<Dim> surface_in_own_axes(const Structure<Dim>& s, const Vec<double, 2>* corners,
                                            const Vec<double, Dim>& from) {
    switch (s.shape) {
        case StructureShape::plane:
            return {dot(from, s.along), s.along};
        case StructureShape::sphere:
            return round_surface(from, s.radius, last_axis<Dim>());
        case StructureShape::cylinder:
            return cylinder_surface(s, from);
        case StructureShape::box:
            return box_surface(s.along, from);
        case StructureShape::capsule: {
            double t = dot(from, s.along);
            t = t < -s.half ? -s.half : (t > s.half ? s.half : t);
            return round_surface(from - t * s.along, s.radius, last_axis<Dim>());
        }
        default:
            return prism_surface(s, corners, from);
    }
}

/// The same at x [m].
template <bool Turns = may_turn, int Dim>
MORAINE_HD Surface<Dim> surface_of_body(const Structure<Dim>& s, const Vec<double, 2>* corners,
                                        const Vec<double, Dim>& x) {
    Vec<double, Dim> from = x - s.at;
    if constexpr (Turns)
        if (s.turns) from = turned_back(s.turn, from);
    Surface<Dim> at = surface_in_own_axes(s, corners, from);
    if constexpr (Turns)
        if (s.turns) at.normal = s.turn * at.normal;
    return at;
}

/// Of any structure; `corners` also has the tables of ground.
template <bool Turns = may_turn, int Dim>
MORAINE_HD Surface<Dim> surface(const Structure<Dim>& s, const Vec<double, 2>* corners, const Vec<double, Dim>& x) {
    if (s.shape == StructureShape::ground) return ground_surface(corners + s.first_corner, s.radius, x);
    return surface_of_body<Turns>(s, corners, x);
}

/// No more than the distance, and it grows by at most the way walked.
template <int Dim>
MORAINE_HD double distance_bound(const Structure<Dim>& s, const Vec<double, 2>* corners, const Vec<double, Dim>& x) {
    if (s.shape != StructureShape::ground) return surface_of_body(s, corners, x).distance;
    const Vec<double, 2>* table = corners + s.first_corner;
    return (x[Dim - 1] - ground_at(table, x).height) * table[1][1];
}

/// What of the ground a node asks for: it does not move, and is kept for an epoch.
template <int Dim>
struct GroundNode {
    Surface<Dim> surface;  ///< not a number: not found yet
    double friction, cap;  ///< of its law there, as Structure's

    MORAINE_HD bool is_known() const { return surface.distance == surface.distance; }
};

template <int Dim>
MORAINE_HD GroundNode<Dim> ground_node(const Structure<Dim>& s, const Vec<double, 2>* corners,
                                       const Vec<double, Dim>& x) {
    GroundNode<Dim> n{surface(s, corners, x), s.friction, s.cap};
    const Vec<double, 2>* table = corners + s.first_corner;
    if (s.corners & bed_friction) n.friction = bed_value(table, 0, x);
    if (s.corners & bed_cap) n.cap = bed_value(table, s.corners & bed_friction ? 1 : 0, x);
    return n;
}

}  // namespace moraine
