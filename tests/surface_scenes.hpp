#pragma once
// Scenes whose structures act where they are (Bed::surface).

#include "sample_scenes.hpp"
#include "terrain_scene.hpp"

namespace moraine::test {

inline Scene on_surface(Scene s) {
    s.bed = Bed::surface;
    return s;
}

/// A slurry that falls on a plane 0.3 h over nodes, turned by `angle` degrees, and flows down.
inline Scene slurry_on_plane(InterfaceLaw law, double angle) {
    Scene s = slurry();
    s.walls[0][0].kind = s.walls[1][0].kind = WallKind::open;
    const double c = std::cos(angle * M_PI / 180), d = std::sin(angle * M_PI / 180);
    s.gravity = {3, -9.5, 0};
    StructureSpec plane;
    plane.name = "bed", plane.law = law, plane.friction = 0.2, plane.xi = 300, plane.density = 1500;
    plane.alpha = 0.5, plane.su = 400;
    plane.point = {2, 0.43, 0}, plane.normal = {d, c, 0};
    s.structures = {plane};
    s.bodies = {box({1.2, 0.80, 0}, {2.6, 1.3, 0}, 0)};
    s.bodies[0].velocity = {1, -3, 0};
    return on_surface(s);
}

/// With cells' pressures, nearly incompressible.
inline Scene wet(Scene s, int substeps) {
    s = with_fluid_terms(s);
    s.substeps = substeps;
    for (MaterialSpec& m : s.materials) m.volumetric = Volumetric::grid, m.parameters[1] = 0.49;
    return s;
}

/// A flow of cells' pressures in a valley.
inline Scene wet_valley(int substeps) {
    Scene valley = on_surface(small_valley(InterfaceLaw::voellmy, true));
    valley.materials = {
        material("bingham", 1500,
                 {{"young", 1e6}, {"poisson", 0.49}, {"yield_stress", 100}, {"consistency", 10}, {"viscosity", 10}})};
    for (BodySpec& body : valley.bodies) body.material = 0;
    return wet(valley, substeps);
}

}  // namespace moraine::test
