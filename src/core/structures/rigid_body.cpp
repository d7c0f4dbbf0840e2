#include "core/structures/rigid_body.hpp"

#include <numbers>

#include "core/structures/structure_set.hpp"

namespace moraine {

namespace {

constexpr double pi = std::numbers::pi;

/// Of unit density: area, and its first and second moments about the origin.
struct AreaMoments {
    double area = 0, first[2] = {0, 0}, xx = 0, yy = 0, xy = 0;
};

/// By Green's theorem, positive either way round.
AreaMoments moments_of(const std::vector<std::array<double, 2>>& points) {
    AreaMoments m;
    for (std::size_t i = 0, j = points.size() - 1; i < points.size(); j = i++) {
        // about the first corner, so that a polygon far from the origin keeps its digits
        const double ax = points[j][0] - points[0][0], ay = points[j][1] - points[0][1];
        const double bx = points[i][0] - points[0][0], by = points[i][1] - points[0][1];
        const double twice = ax * by - bx * ay;
        m.area += twice / 2;
        m.first[0] += twice * (ax + bx) / 6, m.first[1] += twice * (ay + by) / 6;
        m.xx += twice * (ax * ax + ax * bx + bx * bx) / 12, m.yy += twice * (ay * ay + ay * by + by * by) / 12;
        m.xy += twice * (ax * by + 2 * ax * ay + 2 * bx * by + bx * ay) / 24;
    }
    const double sign = m.area < 0 ? -1 : 1;
    for (double* of : {&m.area, &m.first[0], &m.first[1], &m.xx, &m.yy, &m.xy}) *of *= sign;
    return m;
}

/// Over the mass: squares of the radii of gyration about the centre, and the angle of their first axis (3-D: in x, y).
struct Gyration {
    double square[3];
    double angle = 0;
};

Gyration gyration_of_polygon(const StructureSpec& spec, bool flat) {
    const AreaMoments m = moments_of(spec.points);
    const double cx = m.first[0] / m.area, cy = m.first[1] / m.area;
    const double xx = m.xx / m.area - cx * cx, yy = m.yy / m.area - cy * cy, xy = m.xy / m.area - cx * cy;
    if (flat) return {{0, 0, xx + yy}};
    const double length = spec.max[2] - spec.min[2], zz = length * length / 12;
    const double mean = (xx + yy) / 2, way = std::hypot((xx - yy) / 2, xy);
    // along the first axis the area reaches furthest: the least inertia
    return {{mean - way + zz, mean + way + zz, xx + yy}, 0.5 * std::atan2(2 * xy, xx - yy)};
}

/// Half the length, and the shares of a capsule's middle and of its ends.
struct Bar {
    double half, middle, ends;
};

Bar bar_of(const StructureSpec& s, bool flat) {
    const double half = 0.5 * magnitude(vec_of<3>(s.to) - vec_of<3>(s.from)), r = s.radius;
    const double middle = flat ? 4 * half * r : 2 * pi * r * r * half;
    const double ends = s.shape == StructureShape::cylinder ? 0 : flat ? pi * r * r : 4 * pi / 3 * r * r * r;
    return {half, middle / (middle + ends), ends / (middle + ends)};
}

/// About the axis: the third; it is turned to the axis by axes_of().
Gyration gyration_of_bar(const StructureSpec& s, bool flat) {
    const Bar b = bar_of(s, flat);
    const double r2 = s.radius * s.radius, h2 = b.half * b.half, hr = b.half * s.radius;
    if (flat) return {{0, 0, b.middle * (h2 + r2) / 3 + b.ends * (r2 / 2 + h2 + 8 / (3 * pi) * hr)}};
    const double across = b.middle * (r2 / 4 + h2 / 3) + b.ends * (0.4 * r2 + h2 + 0.75 * hr);
    return {{across, across, b.middle * r2 / 2 + b.ends * 0.4 * r2}};
}

Gyration gyration_of(const StructureSpec& s, bool flat) {
    switch (s.shape) {
        case StructureShape::sphere: {
            const double square = (flat ? 0.5 : 0.4) * s.radius * s.radius;
            return {{square, square, square}};
        }
        case StructureShape::box: {
            double square[3];
            for (std::size_t a = 0; a < 3; ++a) square[a] = (s.max[a] - s.min[a]) * (s.max[a] - s.min[a]) / 12;
            return {{square[1] + square[2], square[0] + square[2], square[0] + square[1]}};
        }
        case StructureShape::polygon:
            return gyration_of_polygon(s, flat);
        default:
            return gyration_of_bar(s, flat);
    }
}

/// From the axes of inertia to the structure's own.
Rotation<3> axes_of(const StructureSpec& s, const Gyration& g) {
    if (s.shape == StructureShape::polygon) return rotation_by(Vec<double, 3>{{0, 0, g.angle}});
    if (s.shape != StructureShape::cylinder && s.shape != StructureShape::capsule) return {};
    const Vec<double, 3> way = vec_of<3>(s.to) - vec_of<3>(s.from), axis = (1 / magnitude(way)) * way;
    // the shortest turn of z to the axis; half a turn about x where that is -z
    if (axis[2] < -1 + 1e-12) return {{0, 1, 0, 0}};
    return normalised(Rotation<3>{{1 + axis[2], -axis[1], axis[0], 0}});
}

/// L of one that is turned, in its axes of inertia: taken from the one about axis k for a while, and the turn of that.
void turn_about(int k, double time, const Vec<double, 3>& about, Vec<double, 3>& L, Rotation<3>& turned) {
    const double angle = time * L[k] / about[k], c = std::cos(angle), s = std::sin(angle);
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double li = L[i], lj = L[j];
    L[i] = c * li + s * lj, L[j] = c * lj - s * li;
    Vec<double, 3> by = zero_vec<double, 3>();
    by[k] = angle;
    turned = turned * rotation_by(by);
}

/// K by its upper half, row by row.
template <int Dim>
Mat<double, FreeMotion<Dim>::axes> unpacked(const Vec<double, TurningSums<Dim>::count>& half) {
    Mat<double, FreeMotion<Dim>::axes> all;
    int q = 0;
    for (int i = 0; i < FreeMotion<Dim>::axes; ++i)
        for (int j = i; j < FreeMotion<Dim>::axes; ++j) all(i, j) = all(j, i) = half[q++];
    return all;
}

/// Cholesky's lower factor, in place.
template <int N>
void factor(Mat<double, N>& all) {
    for (int j = 0; j < N; ++j) {
        for (int k = 0; k < j; ++k)
            for (int i = j; i < N; ++i) all(i, j) -= all(i, k) * all(j, k);
        const double root = std::sqrt(all(j, j));
        for (int i = j; i < N; ++i) all(i, j) /= root;
    }
}

/// By that factor.
template <int N>
void solve(const Mat<double, N>& all, Vec<double, N>& x) {
    for (int i = 0; i < N; ++i) {
        for (int k = 0; k < i; ++k) x[i] -= all(i, k) * x[k];
        x[i] /= all(i, i);
    }
    for (int i = N - 1; i >= 0; --i) {
        for (int k = i + 1; k < N; ++k) x[i] -= all(k, i) * x[k];
        x[i] /= all(i, i);
    }
}

}  // namespace

double volume_of(const StructureSpec& s, int dimensions) {
    const bool flat = dimensions == 2;
    const double r = s.radius, length = magnitude(vec_of<3>(s.to) - vec_of<3>(s.from));
    const double width = s.max[0] - s.min[0], height = s.max[1] - s.min[1], depth = flat ? 1 : s.max[2] - s.min[2];
    switch (s.shape) {
        case StructureShape::sphere:
            return flat ? pi * r * r : 4 * pi / 3 * r * r * r;
        case StructureShape::cylinder:
            return pi * r * r * length;
        case StructureShape::capsule:
            return flat ? 2 * r * length + pi * r * r : pi * r * r * (length + 4 * r / 3);
        case StructureShape::box:
            return width * height * depth;
        case StructureShape::polygon:
            return moments_of(s.points).area * depth;
        default:
            return 0;
    }
}

template <int Dim>
Vec<double, Dim> centre_of_mass(const StructureSpec& s) {
    const auto middle = [](const Triple& a, const Triple& b) {
        return 0.5 * (vec_of<Dim>(a) - (-1.0) * vec_of<Dim>(b));
    };
    switch (s.shape) {
        case StructureShape::sphere:
            return vec_of<Dim>(s.center);
        case StructureShape::polygon: {
            const AreaMoments m = moments_of(s.points);
            Vec<double, Dim> c = middle(s.min, s.max);
            for (int a = 0; a < 2; ++a) c[a] = s.points[0][static_cast<std::size_t>(a)] + m.first[a] / m.area;
            return c;
        }
        case StructureShape::cylinder:
        case StructureShape::capsule:
            return middle(s.from, s.to);
        default:
            return middle(s.min, s.max);
    }
}

template <int Dim>
RigidBody<Dim> rigid_body(const StructureSpec& spec) {
    RigidBody<Dim> body;
    body.mass = spec.motion.mass;
    const Gyration g = gyration_of(spec, Dim == 2);
    for (int k = 0; k < moments<Dim>; ++k) body.about[k] = body.mass * g.square[Dim == 2 ? 2 : k];
    if constexpr (Dim == 3) body.axes = axes_of(spec, g);
    if (spec.motion.inertia.empty()) return body;
    body.axes = {};
    for (int k = 0; k < moments<Dim>; ++k) body.about[k] = spec.motion.inertia[static_cast<std::size_t>(k)];
    return body;
}

template <>
Mat<double, 1> RigidBody<2>::inertia(const Rotation<2>&) const {
    return {{{about[0]}}};
}

template <>
Mat<double, 3> RigidBody<3>::inertia(const Rotation<3>& turned) const {
    const Mat<double, 3> r = matrix_of(turned * axes);
    Mat<double, 3> all = zero_mat<double, 3>();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k) all(i, j) += r(i, k) * about[k] * r(j, k);
    return all;
}

template <>
Rotation<2> RigidBody<2>::turn(const Rotation<2>&, const Vec<double, 1>& L, double dt) const {
    return {{dt * L[0] / about[0]}};
}

template <>
Rotation<3> RigidBody<3>::turn(const Rotation<3>& turned, const Vec<double, 3>& L, double dt) const {
    const double outer = 1 / (4 - std::cbrt(4.0));
    Rotation<3> now = turned * axes;
    Vec<double, 3> own = turned_back(matrix_of(now), L);
    for (const double part : {outer, outer, 1 - 4 * outer, outer, outer}) {
        turn_about(0, 0.5 * part * dt, about, own, now);
        turn_about(1, 0.5 * part * dt, about, own, now);
        turn_about(2, part * dt, about, own, now);
        turn_about(1, 0.5 * part * dt, about, own, now);
        turn_about(0, 0.5 * part * dt, about, own, now);
    }
    return normalised(now * inverse(turned * axes));
}

template <int Dim>
Mat<double, FreeMotion<Dim>::axes> followed_mass(const RigidBody<Dim>& body, const Rotation<Dim>& turned,
                                                 const Vec<double, TurningSums<Dim>::count>& follows) {
    Mat<double, FreeMotion<Dim>::axes> all = unpacked<Dim>(follows);
    const Mat<double, moments<Dim>> inertia = body.inertia(turned);
    for (int i = 0; i < Dim; ++i) all(i, i) += body.mass;
    for (int i = 0; i < moments<Dim>; ++i)
        for (int j = 0; j < moments<Dim>; ++j) all(Dim + i, Dim + j) += inertia(i, j);
    return all;
}

template <int N>
Mat<double, N> inverse_mass(Mat<double, N> all) {
    factor(all);
    Mat<double, N> of;
    for (int j = 0; j < N; ++j) {
        Vec<double, N> x = zero_vec<double, N>();
        x[j] = 1;
        solve(all, x);
        for (int i = 0; i < N; ++i) of(i, j) = x[i];
    }
    return of;
}

/// M is positive definite, and K has no negative eigenvalue.
template <int Dim>
Vec<double, FreeMotion<Dim>::axes> expected_motion(const RigidBody<Dim>& body, const Rotation<Dim>& turned,
                                                   const FreeMotion<Dim>& motion) {
    Vec<double, FreeMotion<Dim>::axes> x = unpacked<Dim>(motion.follows) * motion.seen;
    for (int i = 0; i < FreeMotion<Dim>::axes; ++i) x[i] += motion.momentum[i] + motion.impulse[i];
    Mat<double, FreeMotion<Dim>::axes> all = followed_mass(body, turned, motion.follows);
    factor(all);
    solve(all, x);
    return x;
}

template Vec<double, 2> centre_of_mass<2>(const StructureSpec&);
template Vec<double, 3> centre_of_mass<3>(const StructureSpec&);
template RigidBody<2> rigid_body(const StructureSpec&);
template RigidBody<3> rigid_body(const StructureSpec&);
template Mat<double, 3> followed_mass(const RigidBody<2>&, const Rotation<2>&, const Vec<double, 6>&);
template Mat<double, 6> followed_mass(const RigidBody<3>&, const Rotation<3>&, const Vec<double, 21>&);
template Mat<double, 3> inverse_mass(Mat<double, 3>);
template Mat<double, 6> inverse_mass(Mat<double, 6>);
template Vec<double, 3> expected_motion(const RigidBody<2>&, const Rotation<2>&, const FreeMotion<2>&);
template Vec<double, 6> expected_motion(const RigidBody<3>&, const Rotation<3>&, const FreeMotion<3>&);

}  // namespace moraine
