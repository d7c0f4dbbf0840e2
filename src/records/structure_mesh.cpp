#include "records/structure_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/structures/ground.hpp"

namespace moraine {
namespace {

constexpr int around = 48;  ///< facets of a circle

Triple operator+(const Triple& a, const Triple& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
Triple operator-(const Triple& a, const Triple& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Triple operator*(double s, const Triple& a) {
    return {s * a[0], s * a[1], s * a[2]};
}
double dot(const Triple& a, const Triple& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Triple cross(const Triple& a, const Triple& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Triple unit(const Triple& a) {
    return (1 / std::sqrt(dot(a, a))) * a;
}

/// Circle of radius r around `middle`, across an axis.
std::vector<Triple> circle(const Triple& middle, const Triple& axis, double r) {
    const Triple a = unit(cross(axis, std::fabs(axis[0]) < 0.5 ? Triple{1, 0, 0} : Triple{0, 1, 0}));
    const Triple b = cross(axis, a);
    std::vector<Triple> ring;
    for (int k = 0; k < around; ++k) {
        const double t = 2 * std::numbers::pi * k / around;
        ring.push_back(middle + r * std::cos(t) * a + r * std::sin(t) * b);
    }
    return ring;
}

void add_terrain(StructureMesh& mesh, const Scene& scene, const Ground& g, std::size_t of) {
    std::int64_t first[2] = {0, 0}, last[2] = {g.count[0] - 1, g.count[1] - 1};
    const std::size_t axes = scene.dimensions == 2 ? 1 : 2;
    for (std::size_t a = 0; a < axes; ++a) {
        first[a] = std::max<std::int64_t>(first[a], std::llround(std::floor((scene.min[a] - g.first[a]) / g.spacing)));
        last[a] = std::min<std::int64_t>(last[a], std::llround(std::ceil((scene.max[a] - g.first[a]) / g.spacing)));
    }
    const std::int64_t start = mesh.count(), row = last[0] - first[0] + 1;
    for (std::int64_t j = first[1]; j <= last[1]; ++j)
        for (std::int64_t i = first[0]; i <= last[0]; ++i) {
            const double x = g.first[0] + static_cast<double>(i) * g.spacing;
            const double z = g.height[static_cast<std::size_t>(j * g.count[0] + i)];
            mesh.add(axes == 1 ? Triple{x, z, 0} : Triple{x, g.first[1] + static_cast<double>(j) * g.spacing, z});
        }
    if (axes == 1) {
        std::vector<std::int64_t> line;
        for (std::int64_t i = 0; i < row; ++i) line.push_back(start + i);
        return mesh.cell(line, of);
    }
    for (std::int64_t j = 0; j + 1 <= last[1] - first[1]; ++j)
        for (std::int64_t i = 0; i + 1 < row; ++i) {
            const std::int64_t k = start + j * row + i;
            mesh.cell({k, k + 1, k + row + 1, k + row}, of);
        }
}

/// Where a plane cuts the edges of the domain, in order around its normal.
void add_plane(StructureMesh& mesh, const Scene& scene, const StructureSpec& s, std::size_t of) {
    const auto d = static_cast<unsigned>(scene.dimensions);
    std::vector<Triple> cuts;
    for (unsigned corner = 0; corner < 1u << d; ++corner)
        for (unsigned a = 0; a < d; ++a) {
            if (corner >> a & 1u) continue;
            Triple low{}, high{};
            for (unsigned b = 0; b < d; ++b) low[b] = high[b] = corner >> b & 1u ? scene.max[b] : scene.min[b];
            high[a] = scene.max[a];
            const double from = dot(low - s.point, s.normal), to = dot(high - s.point, s.normal);
            if ((from < 0) == (to < 0)) continue;
            cuts.push_back(low + from / (from - to) * (high - low));
        }
    if (cuts.size() < d) return;
    if (d == 2) {
        const std::int64_t from = mesh.add(cuts[0]), to = mesh.add(cuts[1]);
        return mesh.cell({from, to}, of);
    }
    Triple middle{};
    for (const Triple& x : cuts) middle = middle + 1.0 / static_cast<double>(cuts.size()) * x;
    const Triple n = unit(s.normal), a = unit(cross(n, std::fabs(n[0]) < 0.5 ? Triple{1, 0, 0} : Triple{0, 1, 0}));
    const auto angle = [&](const Triple& x) { return std::atan2(dot(x - middle, cross(n, a)), dot(x - middle, a)); };
    std::sort(cuts.begin(), cuts.end(), [&](const Triple& x, const Triple& y) { return angle(x) < angle(y); });
    mesh.ring(cuts, of, false);
}

void add_prism(StructureMesh& mesh, const std::vector<std::array<double, 2>>& corners, double low, double high,
               bool flat, std::size_t of) {
    std::vector<Triple> bottom, top;
    for (const auto& p : corners) bottom.push_back({p[0], p[1], flat ? 0 : low}), top.push_back({p[0], p[1], high});
    mesh.ring(bottom, of, flat);
    if (flat) return;
    mesh.ring(top, of, false);
    mesh.band(bottom, top, of);
}

/// Rings along the axis from one end to the other: flat ends, half-spheres, or a whole sphere.
void add_round(StructureMesh& mesh, const StructureSpec& s, std::size_t of) {
    const bool sphere = s.shape == StructureShape::sphere, flat = s.shape == StructureShape::cylinder;
    const Triple from = sphere ? s.center : s.from, to = sphere ? s.center : s.to;
    const Triple axis = sphere ? Triple{0, 0, 1} : unit(to - from);
    std::vector<std::vector<Triple>> rings;
    if (flat) {
        rings = {circle(from, axis, s.radius), circle(to, axis, s.radius)};
        for (const auto& ring : rings) mesh.ring(ring, of, false);
    } else {
        constexpr int steps = around / 4;
        const double smallest = 1e-6 * s.radius;
        for (int k = -steps; k <= steps; ++k) {
            const double t = std::numbers::pi / 2 * k / steps;
            const double r = std::max(smallest, s.radius * std::cos(t)), up = s.radius * std::sin(t);
            if (k == 0 || k < 0) rings.push_back(circle(from + up * axis, axis, r));
            if (k == 0 || k > 0) rings.push_back(circle(to + up * axis, axis, r));
        }
    }
    for (std::size_t k = 0; k + 1 < rings.size(); ++k) mesh.band(rings[k], rings[k + 1], of);
}

/// In 2-D: a disk, or a segment with a radius.
void add_round_line(StructureMesh& mesh, const StructureSpec& s, std::size_t of) {
    const bool disk = s.shape == StructureShape::sphere;
    const Triple from = disk ? s.center : s.from, to = disk ? s.center : s.to;
    const double turn = disk ? 0 : std::atan2(to[1] - from[1], to[0] - from[0]);
    std::vector<Triple> ring;
    for (int k = 0; k <= around; ++k) {
        const double t = turn + std::numbers::pi / 2 + 2 * std::numbers::pi * k / around;
        ring.push_back((2 * k < around ? from : to) + s.radius * Triple{std::cos(t), std::sin(t), 0});
        if (2 * k == around) ring.insert(ring.end() - 1, from + s.radius * Triple{std::cos(t), std::sin(t), 0});
    }
    mesh.ring(ring, of, true);
}

void add_structure(StructureMesh& mesh, const Scene& scene, std::size_t of) {
    const StructureSpec& s = scene.structures[of];
    const bool flat = scene.dimensions == 2;
    switch (s.shape) {
        case StructureShape::ground:
            return add_terrain(mesh, scene, *s.ground, of);
        case StructureShape::plane:
            return add_plane(mesh, scene, s, of);
        case StructureShape::box:
            return add_prism(mesh,
                             {{s.min[0], s.min[1]}, {s.max[0], s.min[1]}, {s.max[0], s.max[1]}, {s.min[0], s.max[1]}},
                             s.min[2], s.max[2], flat, of);
        case StructureShape::polygon:
            return add_prism(mesh, s.points, s.min[2], s.max[2], flat, of);
        case StructureShape::sphere:
        case StructureShape::cylinder:
        case StructureShape::capsule:
            return flat ? add_round_line(mesh, s, of) : add_round(mesh, s, of);
    }
}

}  // namespace

StructureMesh structure_mesh(const Scene& scene, bool moving) {
    StructureMesh mesh;
    for (std::size_t k = 0; k < scene.structures.size(); ++k)
        if (moves(scene.structures[k]) == moving) {
            add_structure(mesh, scene, k);
            mesh.of_point.resize(static_cast<std::size_t>(mesh.count()), k);
        }
    return mesh;
}

std::int64_t StructureMesh::add(const Triple& x) {
    points.insert(points.end(), x.begin(), x.end());
    return count() - 1;
}

void StructureMesh::cell(const std::vector<std::int64_t>& corners, std::size_t of) {
    connectivity.insert(connectivity.end(), corners.begin(), corners.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
    structure.push_back(static_cast<std::int64_t>(of));
}

void StructureMesh::ring(const std::vector<Triple>& corners, std::size_t of, bool flat) {
    std::vector<std::int64_t> numbers;
    for (const Triple& x : corners) numbers.push_back(add(x));
    if (flat) numbers.push_back(numbers.front());
    cell(numbers, of);
}

void StructureMesh::band(const std::vector<Triple>& low, const std::vector<Triple>& high, std::size_t of) {
    const std::int64_t first = count(), n = static_cast<std::int64_t>(low.size());
    for (const Triple& x : low) add(x);
    for (const Triple& x : high) add(x);
    for (std::int64_t i = 0; i < n; ++i) {
        const std::int64_t j = (i + 1) % n;
        cell({first + i, first + j, first + n + j, first + n + i}, of);
    }
}

}  // namespace moraine
