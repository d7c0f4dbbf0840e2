#pragma once
// A traction (core/particles/traction.hpp) of a scene. Apart from its formulas, which devices compile at run time.

#include "core/particles/traction.hpp"
#include "core/scene_spec.hpp"

namespace moraine {

template <class Real, int Dim>
Traction<Real, Dim> make_traction(const Scene& scene, const TractionSpec& spec) {
    const BodySpec& body = scene.bodies[static_cast<std::size_t>(spec.body)];
    const MaterialSpec& m = scene.materials[static_cast<std::size_t>(body.material)];
    Traction<Real, Dim> t{{},
                          {},
                          static_cast<Real>(spec.pressure),
                          static_cast<Real>(spec.depth),
                          static_cast<Real>(spec.spacing),
                          static_cast<Real>(1 / m.density),
                          m.density_profile() ? m.density_profile()->scalar : -1,
                          spec.follows};
    for (int a = 0; a < Dim; ++a) {
        t.normal[a] = static_cast<Real>(spec.normal[static_cast<std::size_t>(a)]);
        t.shear[a] = static_cast<Real>(spec.shear[static_cast<std::size_t>(a)]);
    }
    return t;
}

/// What a particle that began at depth d has in load_place; what is not under the surface has 0 or less [m].
inline double load_place_at(const TractionSpec& spec, double d) {
    return spec.depth + 0.5 * spec.spacing - d;
}

}  // namespace moraine
