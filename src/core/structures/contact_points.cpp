#include "core/structures/contact_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace moraine {

namespace {

/// Of two axes that are as good, the one that comes first stays, so that faces that lie on each other keep theirs
/// [sizes of the smaller structure].
constexpr double axis_tie = 1e-6;

/// A convex body in the axes of the scene.
template <int Dim>
struct Hull {
    struct Face {
        Vec<double, Dim> normal;  ///< outward
        std::vector<int> corner;  ///< 3-D: counter-clockwise from outside
    };
    std::vector<Vec<double, Dim>> corner;
    std::vector<Face> faces;
    std::vector<std::array<int, 2>> edges;  ///< 3-D

    /// Of the corners, the least or greatest way along a direction.
    double least(const Vec<double, Dim>& n) const {
        double low = std::numeric_limits<double>::infinity();
        for (const Vec<double, Dim>& v : corner) low = std::fmin(low, dot(n, v));
        return low;
    }
    double greatest(const Vec<double, Dim>& n) const { return -least(-1.0 * n); }
    Vec<double, Dim> along(const std::array<int, 2>& edge) const {
        const Vec<double, Dim> way =
            corner[static_cast<std::size_t>(edge[1])] - corner[static_cast<std::size_t>(edge[0])];
        return (1 / magnitude(way)) * way;
    }
    Vec<double, Dim> middle(const std::array<int, 2>& edge) const {
        return 0.5 * (corner[static_cast<std::size_t>(edge[0])] - (-1.0) * corner[static_cast<std::size_t>(edge[1])]);
    }
};

/// Corners of the cross-section in x and y, counter-clockwise, in the structure's own axes.
template <int Dim>
std::vector<Vec<double, 2>> section_of(const Structure<Dim>& s, const Vec<double, 2>* corners) {
    if (s.shape == StructureShape::polygon) return {corners + s.first_corner, corners + s.first_corner + s.corners};
    const double x = s.along[0], y = s.along[1];
    return {{{-x, -y}}, {{x, -y}}, {{x, y}}, {{-x, y}}};
}

/// Adds what a prism has besides the corners of its two ends, n each.
void add_prism(int n, Hull<3>& hull) {
    std::vector<int> top, bottom;
    for (int i = 0; i < n; ++i) {
        const int j = (i + 1) % n;
        hull.faces.push_back({{}, {i, j, n + j, n + i}});
        hull.edges.insert(hull.edges.end(), {{i, j}, {n + i, n + j}, {i, n + i}});
        top.push_back(n + i), bottom.push_back(n - 1 - i);
    }
    hull.faces.push_back({{}, bottom});
    hull.faces.push_back({{}, top});
    for (auto& face : hull.faces) {
        const auto at = [&](std::size_t k) { return hull.corner[static_cast<std::size_t>(face.corner[k])]; };
        const Vec<double, 3> normal = moment_of<3>(at(1) - at(0), at(2) - at(1));
        face.normal = (1 / magnitude(normal)) * normal;
    }
}

template <int Dim>
Hull<Dim> hull_of(const Structure<Dim>& s, const Vec<double, 2>* corners) {
    const std::vector<Vec<double, 2>> section = section_of(s, corners);
    const auto n = static_cast<int>(section.size());
    Hull<Dim> hull;
    for (const double side : {-1.0, 1.0}) {
        for (const Vec<double, 2>& c : section) {
            Vec<double, Dim> own = zero_vec<double, Dim>();
            own[0] = c[0], own[1] = c[1];
            if constexpr (Dim == 3) own[2] = side * s.along[2];
            hull.corner.push_back(s.at - (-1.0) * (s.turns ? s.turn * own : own));
        }
        if (Dim == 2) break;
    }
    if constexpr (Dim == 3) {
        add_prism(n, hull);
    } else {
        for (int i = 0; i < n; ++i) {
            const int j = (i + 1) % n;
            const Vec<double, 2> along = hull.along({i, j});
            hull.faces.push_back({{{along[1], -along[0]}}, {i, j}});
        }
    }
    return hull;
}

/// The face of `a` beyond which `b` is furthest, and how far.
template <int Dim>
std::pair<std::size_t, double> best_face(const Hull<Dim>& a, const Hull<Dim>& b) {
    std::pair<std::size_t, double> best{0, -std::numeric_limits<double>::infinity()};
    for (std::size_t f = 0; f < a.faces.size(); ++f) {
        const auto& face = a.faces[f];
        const double apart =
            b.least(face.normal) - dot(face.normal, a.corner[static_cast<std::size_t>(face.corner[0])]);
        if (apart > best.second) best = {f, apart};
    }
    return best;
}

/// What of a polygon, or in 2-D of a segment, lies behind a plane: n . x <= level.
template <int Dim>
std::vector<Vec<double, Dim>> clipped(const std::vector<Vec<double, Dim>>& polygon, const Vec<double, Dim>& n,
                                      double level) {
    std::vector<Vec<double, Dim>> rest;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vec<double, Dim>&from = polygon[i], &to = polygon[(i + 1) % polygon.size()];
        const double here = dot(n, from) - level, there = dot(n, to) - level;
        if (here <= 0) rest.push_back(from);
        const bool last = Dim == 2 && i == 1;
        if (!last && ((here < 0 && there > 0) || (here > 0 && there < 0)))
            rest.push_back(from - (here / (there - here)) * (to - from));
    }
    return rest;
}

/// The points of the face of `b` that lies opposite to face `f` of `a`. sign: -1 where `a` is the second structure.
template <int Dim>
void add_face_points(const Hull<Dim>& a, std::size_t f, const Hull<Dim>& b, double margin, double sign,
                     std::vector<ContactPoint<Dim>>& points) {
    const auto& face = a.faces[f];
    const Vec<double, Dim>& n = face.normal;
    const auto opposite = std::min_element(b.faces.begin(), b.faces.end(), [&](const auto& one, const auto& other) {
        return dot(n, one.normal) < dot(n, other.normal);
    });
    std::vector<Vec<double, Dim>> part;
    for (const int c : opposite->corner) part.push_back(b.corner[static_cast<std::size_t>(c)]);
    for (std::size_t i = 0; i < face.corner.size(); ++i) {
        const Vec<double, Dim>& from = a.corner[static_cast<std::size_t>(face.corner[i])];
        const Vec<double, Dim> way =
            a.corner[static_cast<std::size_t>(face.corner[(i + 1) % face.corner.size()])] - from;
        Vec<double, Dim> out;
        if constexpr (Dim == 3)
            out = moment_of<3>((1 / magnitude(way)) * way, n);
        else
            out = (-1 / magnitude(way)) * way;  // of each end, away from the other
        part = clipped(part, out, dot(out, from));
    }
    const double level = dot(n, a.corner[static_cast<std::size_t>(face.corner[0])]);
    for (const Vec<double, Dim>& p : part) {
        const double gap = dot(n, p) - level;
        if (gap <= margin) points.push_back({p - (0.5 * gap) * n, sign * n, gap});
    }
}

/// The axis across two edges along which two bodies are furthest apart, from the first to the second.
struct EdgeAxis {
    Vec<double, 3> normal;
    double apart = -std::numeric_limits<double>::infinity();
    Vec<double, 3> a, b;  ///< along the edges
};

EdgeAxis best_edges(const Hull<3>& a, const Hull<3>& b, const Vec<double, 3>& from_a_to_b) {
    EdgeAxis best;
    for (const auto& edge_a : a.edges)
        for (const auto& edge_b : b.edges) {
            const Vec<double, 3> along_a = a.along(edge_a), along_b = b.along(edge_b);
            Vec<double, 3> n = moment_of<3>(along_a, along_b);
            const double sine = magnitude(n);
            if (sine < axis_tie) continue;
            n = ((dot(n, from_a_to_b) < 0 ? -1 : 1) / sine) * n;
            const double apart = b.least(n) - a.greatest(n);
            if (apart > best.apart) best = {n, apart, along_a, along_b};
        }
    return best;
}

/// The middle of the edge along `way` that is furthest along n.
Vec<double, 3> outermost_edge(const Hull<3>& hull, const Vec<double, 3>& way, const Vec<double, 3>& n) {
    Vec<double, 3> middle = hull.corner[0];
    double furthest = -std::numeric_limits<double>::infinity();
    for (const auto& edge : hull.edges) {
        const Vec<double, 3> at = hull.middle(edge);
        if (magnitude(moment_of<3>(hull.along(edge), way)) > axis_tie || dot(n, at) <= furthest) continue;
        furthest = dot(n, at), middle = at;
    }
    return middle;
}

ContactPoint<3> edge_point(const Hull<3>& a, const Hull<3>& b, const EdgeAxis& axis) {
    const Vec<double, 3> pa = outermost_edge(a, axis.a, axis.normal),
                         pb = outermost_edge(b, axis.b, -1.0 * axis.normal);
    const Vec<double, 3> way = pb - pa;
    const double cosine = dot(axis.a, axis.b), square = 1 - cosine * cosine;
    const double on_a = (dot(way, axis.a) - cosine * dot(way, axis.b)) / square;
    const double on_b = (cosine * dot(way, axis.a) - dot(way, axis.b)) / square;
    const Vec<double, 3> at_a = pa - (-on_a) * axis.a, at_b = pb - (-on_b) * axis.b;
    return {0.5 * (at_a - (-1.0) * at_b), axis.normal, dot(axis.normal, at_b - at_a)};
}

template <int Dim>
void add_prism_points(const Structure<Dim>& a, const Structure<Dim>& b, const Vec<double, 2>* corners, double margin,
                      std::vector<ContactPoint<Dim>>& points) {
    const Hull<Dim> one = hull_of(a, corners), other = hull_of(b, corners);
    const auto [face_a, apart_a] = best_face(one, other);
    if (apart_a > margin) return;
    const auto [face_b, apart_b] = best_face(other, one);
    if (apart_b > margin) return;
    const double tie = axis_tie * std::fmin(reach_of(a, corners), reach_of(b, corners));
    if constexpr (Dim == 3) {
        const EdgeAxis edges = best_edges(one, other, b.at - a.at);
        if (edges.apart > margin) return;
        if (edges.apart > std::fmax(apart_a, apart_b) + tie) return points.push_back(edge_point(one, other, edges));
    }
    if (apart_b > apart_a + tie)
        add_face_points(other, face_b, one, margin, -1.0, points);
    else
        add_face_points(one, face_a, other, margin, 1.0, points);
}

/// The surface of a structure beside a point, however far off.
template <int Dim>
Surface<Dim> surface_from(const Structure<Dim>& s, const Vec<double, 2>* corners, const Vec<double, Dim>& x,
                          double reach) {
    if (s.shape == StructureShape::ground) return ground_surface(corners + s.first_corner, reach, x);
    return surface_of_body(s, corners, x);
}

}  // namespace

template <int Dim>
double reach_of(const Structure<Dim>& s, const Vec<double, 2>* corners) {
    switch (s.shape) {
        case StructureShape::plane:
        case StructureShape::ground:
            return std::numeric_limits<double>::infinity();
        case StructureShape::sphere:
            return s.radius;
        case StructureShape::box:
            return magnitude(s.along);
        case StructureShape::polygon: {
            double reach = 0;
            for (int i = 0; i < s.corners; ++i) reach = std::fmax(reach, magnitude(corners[s.first_corner + i]));
            return Dim == 2 ? reach : std::hypot(reach, s.along[Dim - 1]);
        }
        default:
            return std::hypot(s.half, s.radius) + (s.shape == StructureShape::capsule ? s.radius : 0.0);
    }
}

template <int Dim>
void find_contact_points(const Structure<Dim>& a, const Structure<Dim>& b, const Vec<double, 2>* corners, double margin,
                         std::vector<ContactPoint<Dim>>& points) {
    const bool half_space = b.shape == StructureShape::plane || b.shape == StructureShape::ground;
    if (a.shape == StructureShape::sphere || b.shape == StructureShape::sphere) {
        const bool first = a.shape == StructureShape::sphere;
        const Structure<Dim>&ball = first ? a : b, &other = first ? b : a;
        const Surface<Dim> s = surface_from(other, corners, ball.at, ball.radius + margin);
        const double gap = s.distance - ball.radius;
        if (gap <= margin)
            points.push_back({ball.at - (ball.radius + 0.5 * gap) * s.normal, (first ? -1.0 : 1.0) * s.normal, gap});
    } else if (half_space) {
        for (const Vec<double, Dim>& corner : hull_of(a, corners).corner) {
            const Surface<Dim> s = surface_from(b, corners, corner, margin);
            if (s.distance <= margin)
                points.push_back({corner - (0.5 * s.distance) * s.normal, -1.0 * s.normal, s.distance});
        }
    } else {
        add_prism_points(a, b, corners, margin, points);
    }
}

bool is_convex(const std::vector<std::array<double, 2>>& polygon) {
    bool left = false, right = false;
    const std::size_t n = polygon.size();
    for (std::size_t i = 0; i < n; ++i) {
        const auto &a = polygon[i], &b = polygon[(i + 1) % n], &c = polygon[(i + 2) % n];
        const double ux = b[0] - a[0], uy = b[1] - a[1], vx = c[0] - b[0], vy = c[1] - b[1];
        const double sine = (ux * vy - uy * vx) / (std::hypot(ux, uy) * std::hypot(vx, vy));
        left = left || sine > 1e-9, right = right || sine < -1e-9;
    }
    return !(left && right);
}

template double reach_of(const Structure<2>&, const Vec<double, 2>*);
template double reach_of(const Structure<3>&, const Vec<double, 2>*);
template void find_contact_points(const Structure<2>&, const Structure<2>&, const Vec<double, 2>*, double,
                                  std::vector<ContactPoint<2>>&);
template void find_contact_points(const Structure<3>&, const Structure<3>&, const Vec<double, 2>*, double,
                                  std::vector<ContactPoint<3>>&);

}  // namespace moraine
