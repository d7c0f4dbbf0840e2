#pragma once
// How a rigid structure is turned: an angle in 2-D, a unit quaternion (w, x, y, z) in 3-D, from its own axes to those
// of the scene, which it has at the start.
//
//   rotation_by(r)   by |r| about r;   R(r2) R(r1): first r1, then r2
//
// A quaternion turns by any angle without a place where it stands still, and rounding takes only its length, which is
// set to 1 in each step; matrices lose their right angles.

#include <cmath>

#include "core/structures/structure.hpp"

namespace moraine {

template <int Dim>
struct Rotation;

template <>
struct Rotation<2> {
    static constexpr int count = 1;
    double e[count] = {0};  ///< [rad], counter-clockwise, not brought back to a turn
};

template <>
struct Rotation<3> {
    static constexpr int count = 4;
    double e[count] = {1, 0, 0, 0};
};

/// r [rad].
inline Rotation<2> rotation_by(const Vec<double, 1>& r) {
    return {{r[0]}};
}
inline Rotation<3> rotation_by(const Vec<double, 3>& r) {
    const double angle = magnitude(r), s = angle > 0 ? std::sin(0.5 * angle) / angle : 0.5;
    return {{std::cos(0.5 * angle), s * r[0], s * r[1], s * r[2]}};
}

/// First `first`, then `then`.
inline Rotation<2> operator*(const Rotation<2>& then, const Rotation<2>& first) {
    return {{then.e[0] + first.e[0]}};
}
inline Rotation<3> operator*(const Rotation<3>& then, const Rotation<3>& first) {
    const double(&p)[4] = then.e, (&q)[4] = first.e;
    return {
        {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
         p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3], p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1]}};
}

inline Rotation<2> inverse(const Rotation<2>& r) {
    return {{-r.e[0]}};
}
inline Rotation<3> inverse(const Rotation<3>& r) {
    return {{r.e[0], -r.e[1], -r.e[2], -r.e[3]}};
}

inline Rotation<2> normalised(const Rotation<2>& r) {
    return r;
}
inline Rotation<3> normalised(const Rotation<3>& r) {
    double square = 0;
    for (const double e : r.e) square += e * e;
    const double by = 1 / std::sqrt(square);
    return {{by * r.e[0], by * r.e[1], by * r.e[2], by * r.e[3]}};
}

/// r of rotation_by(r); in 3-D |r| <= pi.
inline Vec<double, 1> vector_of(const Rotation<2>& r) {
    return {{r.e[0]}};
}
inline Vec<double, 3> vector_of(const Rotation<3>& r) {
    const double sign = r.e[0] < 0 ? -1 : 1;
    const Vec<double, 3> v{{sign * r.e[1], sign * r.e[2], sign * r.e[3]}};
    const double sine = magnitude(v);
    return (sine > 0 ? 2 * std::atan2(sine, sign * r.e[0]) / sine : 2.0) * v;
}

inline Mat<double, 2> matrix_of(const Rotation<2>& r) {
    const double c = std::cos(r.e[0]), s = std::sin(r.e[0]);
    return {{{c, -s}, {s, c}}};
}
inline Mat<double, 3> matrix_of(const Rotation<3>& r) {
    const double w = r.e[0], x = r.e[1], y = r.e[2], z = r.e[3];
    return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
             {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
             {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

}  // namespace moraine
