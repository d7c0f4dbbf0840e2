#pragma once
// The state that a seed (seeding/seed.hpp) begins with: where it is binned, and its stress.

#include <algorithm>
#include <cmath>

#include "core/gravity.hpp"
#include "core/transfer/method.hpp"
#include "seeding/property_profile.hpp"
#include "seeding/seed.hpp"

namespace moraine {

/// Place along an axis of what is at x [m], before blocks wrap along periodic axes.
template <class Real, int Dim>
Place<Real> place_along(const Scene& scene, const Method<Host, Real, Dim>& method, int a, double x) {
    const auto i = static_cast<std::size_t>(a);
    Place<Real> at = place<Real>((x - scene.min[i]) / scene.cell + method.stencil.offset());
    at.block += bin_below(method.ends.cell[a][1], method.ends.fraction[a][1], at.block, at.u);
    return at;
}

/// Of the water in a body's pores at the start, as its particles hold it: in excess of still water where that stands
/// above the soil [Pa].
inline double start_pore_pressure(const Scene& scene, const BodySpec& body, const Triple& x) {
    const bool wet = scene.materials[static_cast<std::size_t>(body.material)].porosity > 0;
    return wet && !scene.water.submerged ? still_water(scene, x[static_cast<std::size_t>(up_axis(scene))]) : 0;
}

/// sigma_v = -g times the mass above, up to the surface, less the pore pressure, sigma_h = k0 sigma_v by the gravity of
/// the start, along gravity's main axis: the normal components at a place [m]. Zero where the body has none.
template <class Real>
Vec<Real, 3> geostatic_stress(const Scene& scene, const BodySpec& body, const Triple& x) {
    Vec<Real, 3> stress = zero_vec<Real, 3>();
    if (!body.geostatic) return stress;
    const auto up = static_cast<std::size_t>(up_axis(scene));
    const MaterialSpec& m = scene.materials[static_cast<std::size_t>(body.material)];
    const double depth = std::max(0.0, body.geostatic_surface - x[up]), g = std::fabs(gravity_at(scene, 0)[up]);
    double weight = m.density_profile() ? mass_above(scene, body, x, depth) * g : m.density * g * depth;
    if (m.porosity > 0)  // effective stress
        weight -= scene.water.submerged ? scene.water.density * g * depth : start_pore_pressure(scene, body, x);
    for (std::size_t a = 0; a < 3; ++a)
        stress[static_cast<int>(a)] = static_cast<Real>(-weight * (a == up ? 1 : body.geostatic_k0));
    return stress;
}

/// The normal components of the stress at a body's lowest point [Pa]; of a table's, at the domain's.
inline Vec<double, 3> deepest_stress(const Scene& scene, const BodySpec& body) {
    const Triple lower = body.shape == BodyShape::table ? scene.min : extent_of(body, scene.dimensions).lower;
    return geostatic_stress<double>(scene, body, lower);
}

}  // namespace moraine
