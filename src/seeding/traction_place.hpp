#pragma once
// Where a particle begins under the surface that a traction is on (core/particles/traction.hpp).

#include "core/scene_spec.hpp"

namespace moraine {

/// What a particle of a body that begins at x has in its load_place: more than 0 where it is under the loaded part, and
/// within the depth that takes it. The body is a box or a polygon [m].
double load_place(const Scene& scene, const TractionSpec& traction, int body, const Triple& x);

/// Distance of particles along its normal; sideways where that is no axis of the lattice [m].
double line_spacing(const Scene& scene, const TractionSpec& traction);

/// Of all particles at the start.
struct LoadedPart {
    double area = 0;     ///< [m2], in 2-D [m]
    double through = 0;  ///< of it, where the body is less thick than the depth
};
LoadedPart loaded_part(const Scene& scene, const TractionSpec& traction);

}  // namespace moraine
