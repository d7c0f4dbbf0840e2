#pragma once
// Terrain and structures as surfaces that ParaView shows beside the particles (structure_mesh.hpp).
//
//   surroundings.vtkhdf   what stands still
//   structures.vtkhdf     what moves, at the times of particles.vtkhdf: places of all times, one set of cells
//
// VTKHDF 2.0, PolyData; cell data `structure`: the structure's number in the scene, from 0 on (the terrain is the
// first). A plane that moves is drawn where it cut the domain at the start, moved with it.

#include <string>
#include <vector>

#include "core/scene_spec.hpp"
#include "core/structures/rotation.hpp"

namespace moraine {

/// Whether a scene has something that stands still.
bool has_surroundings(const Scene& scene);

/// How a structure has moved since the start.
struct StructureShift {
    Triple way{};          ///< [m]
    Rotation<3> turned{};  ///< about its centre of mass; in 2-D about z
};

/// The bytes of the files. shifts: of each structure of the scene, time by time.
std::string surroundings_image(const Scene& scene);
std::string moving_image(const Scene& scene, const std::vector<double>& times,
                         const std::vector<StructureShift>& shifts);

}  // namespace moraine
