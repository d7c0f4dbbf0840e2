#pragma once
// surroundings.vtkhdf: terrain and structures that stand still, as surfaces that ParaView shows beside the particles.
//
// VTKHDF 2.0, PolyData: in 3-D polygons, in 2-D lines; cell data `structure`: the structure's number in the scene, from
// 0 on (the terrain is the first). Terrain is drawn by the nodes of its model in the domain, a plane where it cuts the
// domain, round ones by facets. Structures that move are in structures.csv and in pictures, not here.

#include <string>

#include "core/scene_spec.hpp"

namespace moraine {

/// Whether a scene has something to show.
bool has_surroundings(const Scene& scene);

/// The bytes of the file.
std::string surroundings_image(const Scene& scene);

}  // namespace moraine
