#pragma once
// Small scenes made in code, which between them have what runs differ in: an open wall, a periodic axis, friction,
// damping, two materials.

#include <algorithm>
#include <map>
#include <string>

#include "core/material/laws.hpp"
#include "core/scene_spec.hpp"

namespace moraine::test {

inline MaterialSpec material(const std::string& law, double density, const std::map<std::string, double>& values) {
    MaterialSpec m;
    m.name = law;
    m.law = law;
    m.density = density;
    for (const Parameter& p : find_law(law)->parameters) {
        const auto it = values.find(p.key);
        m.parameters.push_back(it == values.end() ? p.standard : it->second);
    }
    return m;
}

inline BodySpec box(const Triple& min, const Triple& max, int of_material) {
    BodySpec b;
    b.min = min;
    b.max = max;
    b.material = of_material;
    b.seeding = Seeding::jittered;
    b.jitter = 0.2;
    return b;
}

/// A slurry that collapses in 2-D and flows out through an open wall.
inline Scene slurry() {
    Scene s;
    s.transfer = Transfer::flip;
    s.dimensions = 2;
    s.max = {4.1, 2, 0};
    s.cell = 0.1;
    s.gravity = {2, -9.81, 0};
    s.walls[0][0].kind = WallKind::free_slip;
    s.walls[0][1].kind = WallKind::open;
    s.walls[1][0].kind = WallKind::no_slip;
    s.materials = {
        material("bingham", 1500,
                 {{"young", 250e3}, {"poisson", 0.4}, {"yield_stress", 500}, {"consistency", 50}, {"viscosity", 50}})};
    s.bodies = {box({2.5, 0, 0}, {4, 1, 0}, 0)};
    s.bodies[0].velocity = {4, 0, 0};
    s.bodies[0].geostatic = true;
    s.bodies[0].geostatic_surface = 1;
    return s;
}

/// Two soils in 3-D between friction and free-slip walls, periodic across.
inline Scene column() {
    Scene s;
    s.transfer = Transfer::flip;
    s.dimensions = 3;
    s.max = {8, 8, 7};
    s.cell = 1;
    s.gravity = {0, 0, -9.81};
    s.periodic[1] = true;
    s.walls[1][0].kind = s.walls[1][1].kind = WallKind::periodic;
    s.walls[0][0].kind = s.walls[0][1].kind = WallKind::free_slip;
    s.walls[2][0].kind = WallKind::friction;
    s.walls[2][0].friction = 0.3;
    s.walls[2][1].kind = WallKind::free_slip;
    s.materials = {material("von-mises", 1500, {{"young", 1e6}, {"poisson", 0.4}, {"su", 2000}}),
                   material("neo-hookean", 1800, {{"young", 2e6}, {"poisson", 0.3}})};
    s.bodies = {box({0, 0, 0}, {4, 8, 5}, 0), box({4, 2, 0}, {7, 6, 3}, 1)};
    s.bodies[0].velocity = {0.5, 3, 0};
    s.damping = 0.05;
    return s;
}

/// Thin layers fall on a slope, and a disk that is free on them; a rod goes through them.
inline Scene layers_on_slope(int dimensions) {
    Scene s = slurry();
    s.dimensions = dimensions;
    s.walls[1][0].kind = WallKind::none;
    s.max[2] = dimensions == 3 ? 0.8 : 0;
    s.walls[2][0].kind = s.walls[2][1].kind = WallKind::free_slip;
    s.materials.push_back(material("drucker-prager", 1800, {{"young", 1e6}, {"poisson", 0.3}, {"friction_angle", 30}}));
    s.bodies = {box({1.05, 0.5, 0}, {3.15, 0.55, 0.8}, 0), box({1.25, 0.8, 0}, {2.55, 1, 0.8}, 1)};
    for (BodySpec& body : s.bodies) body.velocity = {1, -3, 0};
    StructureSpec slope, disk, rod;
    slope.name = "slope", slope.law = InterfaceLaw::undrained, slope.alpha = 0.5, slope.su = 400;
    slope.point = {0, 0.43, 0}, slope.normal = {0.1, 1, 0};
    disk.name = "disk", disk.shape = StructureShape::sphere, disk.law = InterfaceLaw::rough;
    disk.center = {1.9, 1.25, 0.4}, disk.radius = 0.2;
    disk.motion.kind = StructureMotion::free, disk.motion.mass = 40, disk.motion.velocity = {1, -3, 0};
    rod.name = "rod", rod.shape = StructureShape::capsule, rod.law = InterfaceLaw::coulomb, rod.friction = 0.3;
    rod.from = {3.4, 0.3, 0.2}, rod.to = {3.4, 0.9, 0.6}, rod.radius = 0.08;
    rod.motion.kind = StructureMotion::velocity, rod.motion.velocity = {-4, 0, 0};
    s.structures = {slope, disk, rod};
    return s;
}

/// Nodes with little mass: a single layer near a floor and in its corner, droplets and particles alone that fall, over
/// free-slip walls and one with friction. Two materials, one nearly incompressible.
inline Scene spray(int dimensions) {
    Scene s;
    s.transfer = Transfer::flip;
    s.dimensions = dimensions;
    s.cell = 0.1;
    s.max = {2, 0.8, 0};
    if (dimensions == 3) s.max = {2, 0.8, 0.8};
    const auto up = static_cast<std::size_t>(dimensions - 1);
    s.gravity = {0, 0, 0};
    s.gravity[up] = -9.81;
    for (std::size_t a = 0; a <= up; ++a) s.walls[a][0].kind = s.walls[a][1].kind = WallKind::free_slip;
    s.walls[0][1] = {WallKind::friction, 0.3};
    s.materials = {material("linear-elastic", 1500, {{"young", 2e5}, {"poisson", 0.49}}),
                   material("von-mises", 1000, {{"young", 1e6}, {"poisson", 0.4}, {"su", 2000}})};
    const auto put = [&](double x, double z, double length, double height, int of_material) {
        Triple min = {x, 0.3, 0}, max = {x + length, 0.3 + std::min(length, 0.4), 0};
        min[up] = z, max[up] = z + height;
        s.bodies.push_back(box(min, max, of_material));
    };
    put(0, 0.0002, 0.6, 0.05, 0);
    put(1.6, 0.0002, 0.4, 0.05, 1);
    put(0.8, 0.31, 0.1, 0.1, 0);
    put(1.2, 0.02, 0.05, 0.05, 0);
    put(1.41, 0.5, 0.1, 0.15, 1);
    for (BodySpec& b : s.bodies) b.velocity = {3, 0, 0}, b.velocity[up] = -2;
    return s;
}

/// Of its elastic material alone, at a step that with every transfer is too large for its light nodes.
inline Scene elastic_spray(int dimensions, Transfer transfer) {
    Scene s = spray(dimensions);
    s.transfer = transfer;
    s.materials.pop_back();
    for (BodySpec& b : s.bodies) b.material = 0;
    if (dimensions == 2 && is_affine(transfer)) s.cfl = 0.65;  // at 0.5 no reaction reaches its limit
    return s;
}

/// With keys of its fluids, whose particles are crowded here and there.
inline Scene with_fluid_terms(Scene s, double smoothing = 0.22, double shifting = 0.1) {
    for (MaterialSpec& m : s.materials)
        if (find_law(m.law)->is_fluid) m.pressure_smoothing = smoothing, m.particle_shifting = shifting;
    for (BodySpec& b : s.bodies) b.seeding = Seeding::jittered, b.jitter = 0.5;
    return s;
}

/// Two fluids of other densities and stiffness, and a soil, between the walls of column().
inline Scene fluid_column() {
    Scene s = column();
    s.materials = {
        material("newtonian", 1500, {{"young", 1e6}, {"poisson", 0.45}, {"viscosity", 100}}),
        material("linear-elastic", 1500, {{"young", 2e6}, {"poisson", 0.3}}),
        material("bingham", 1200,
                 {{"young", 4e5}, {"poisson", 0.4}, {"yield_stress", 300}, {"consistency", 20}, {"viscosity", 20}})};
    s.bodies.push_back(box({0, 0, 5}, {3, 8, 6}, 2));
    return s;
}

/// spray() of a fluid and a soil, or of the fluid alone.
inline Scene wet_spray(int dimensions, bool alone) {
    Scene s = spray(dimensions);
    s.materials[0] = material("newtonian", 1500, {{"young", 2e5}, {"poisson", 0.45}, {"viscosity", 5}});
    if (alone) s.materials.pop_back();
    for (BodySpec& b : s.bodies) b.material = alone ? 0 : b.material;
    return s;
}

}  // namespace moraine::test
