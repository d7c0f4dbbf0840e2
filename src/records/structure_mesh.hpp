#pragma once
// Structures as surfaces: in 3-D polygons, in 2-D lines.
//
// Terrain is drawn by the nodes of its model in the domain, a plane where it cuts the domain, round ones by facets.

#include <cstdint>
#include <vector>

#include "core/scene_spec.hpp"

namespace moraine {

/// Points, and cells as lists of their numbers.
struct StructureMesh {
    std::vector<double> points;         ///< x, y, z of each [m]
    std::vector<std::size_t> of_point;  ///< its structure's number in the scene
    std::vector<std::int64_t> connectivity, offsets{0};
    std::vector<std::int64_t> structure;  ///< of each cell: its number in the scene

    std::int64_t count() const { return static_cast<std::int64_t>(points.size() / 3); }
    std::int64_t add(const Triple& x);
    void cell(const std::vector<std::int64_t>& corners, std::size_t of);
    /// A polygon, or in 2-D the line around it.
    void ring(const std::vector<Triple>& corners, std::size_t of, bool flat);
    /// A strip of quadrilaterals between two rings of as many points.
    void band(const std::vector<Triple>& low, const std::vector<Triple>& high, std::size_t of);
};

inline bool moves(const StructureSpec& s) {
    return s.motion.kind != StructureMotion::fixed;
}

/// Of those that move, where they are at the start, or of those that stand still.
StructureMesh structure_mesh(const Scene& scene, bool moving);

}  // namespace moraine
