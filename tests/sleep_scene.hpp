#pragma once
// A bed that falls asleep, and wakes where it is struck.

#include "sample_scenes.hpp"

namespace moraine::test {

/// A bed of sand whose edge fails, and a disk that strikes its other end once that has fallen asleep.
inline Scene bed(int dimensions) {
    Scene s;
    const std::size_t up = dimensions == 2 ? 1 : 2;
    s.dimensions = dimensions;
    s.cell = 0.1;
    s.max = {6.4, 1.6, 0};
    if (dimensions == 3) s.max = {4.8, 0.8, 1.6}, s.periodic[1] = true;
    s.walls[1][0].kind = s.walls[1][1].kind = dimensions == 3 ? WallKind::periodic : WallKind::none;
    s.walls[0][0].kind = s.walls[0][1].kind = WallKind::free_slip;
    s.walls[up][0].kind = WallKind::no_slip;
    s.walls[up][1].kind = WallKind::free_slip;
    s.gravity[up] = -9.81;
    s.cfl = 0.5;
    s.materials = {material("drucker-prager", 1500, {{"young", 5e5}, {"poisson", 0.3}, {"friction_angle", 30}})};
    s.bodies = {box({0, 0, 0}, {dimensions == 2 ? 5.0 : 3.6, 0.6, 0}, 0)};
    if (dimensions == 3) s.bodies[0].max = {3.6, 0.8, 0.6};
    s.bodies[0].seeding = Seeding::lattice, s.bodies[0].jitter = 0;
    s.bodies[0].geostatic = true;
    s.bodies[0].geostatic_surface = 0.6, s.bodies[0].geostatic_k0 = 0.6;
    s.bodies.push_back(box({0.8, 1, 0}, {1.1, 1.3, 0}, 0));
    if (dimensions == 3) s.bodies[1].min = {0.8, 0.2, 1}, s.bodies[1].max = {1.1, 0.5, 1.3};
    s.sleep.on = true;
    s.sleep.displacement = 0.01, s.sleep.wake = 4;
    return s;
}

/// A plate over that bed, which stands until the bed sleeps and then goes down into it.
inline Scene plate_over_bed(int dimensions) {
    Scene scene = bed(dimensions);
    scene.bodies.pop_back();
    scene.sleep.wake = 2;
    StructureSpec plate;
    plate.name = "plate";
    plate.shape = StructureShape::box;
    plate.law = InterfaceLaw::coulomb, plate.friction = 0.3;
    plate.min = {1.9, 0.63, 0}, plate.max = {2.3, 0.9, 0};
    if (dimensions == 3) plate.min = {1.9, 0.2, 0.63}, plate.max = {2.3, 0.6, 0.9};
    plate.motion.kind = StructureMotion::table;
    plate.motion.velocity = {0, 0, 0};
    plate.motion.velocity[dimensions == 2 ? 1 : 2] = -0.2;
    plate.motion.factor = {{0.25, 0.3}, {0, 1}};
    scene.structures.push_back(plate);
    return scene;
}

/// The same of mud whose cells bear the pressure.
inline Scene mud() {
    Scene scene = bed(2);
    scene.materials = {material(
        "bingham", 1500,
        {{"young", 2.5e5}, {"poisson", 0.49}, {"yield_stress", 1500}, {"consistency", 50}, {"viscosity", 50}})};
    scene.materials[0].volumetric = Volumetric::grid;
    scene.materials[0].pressure_smoothing = scene.materials[0].particle_shifting = 0.2;
    scene.bodies[0].geostatic_k0 = 1;
    scene.sleep.stress = 0.5, scene.sleep.displacement = 0.03;
    return scene;
}

}  // namespace moraine::test
