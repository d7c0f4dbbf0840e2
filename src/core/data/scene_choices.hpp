#pragma once
// What a scene chooses from, as names that kernels know, too (core/scene_spec.hpp has the scene).

namespace moraine {

enum class Shape { linear, gimp, gimp_contiguous, quadratic, cubic };
/// pic is flip with blend 0; aflip is flip with the affine field of apic (Fei et al. 2021).
enum class Transfer { flip, pic, apic, tpic, fmpm, aflip };

/// The transfer of a scene that names none: what reaches 1 % of error soonest in most problems (docs/accuracy.md); hats
/// have no affine one.
constexpr Transfer standard_transfer(Shape shape) {
    return shape == Shape::linear ? Transfer::flip : Transfer::apic;
}

/// Share of FLIP where a scene does not say its own: all of it rings where the affine field has no part.
constexpr double standard_flip(Transfer transfer) {
    return transfer == Transfer::aflip ? 0.95 : 1;
}

/// Whether particles carry an affine velocity field.
constexpr bool is_affine(Transfer transfer) {
    return transfer == Transfer::apic || transfer == Transfer::tpic || transfer == Transfer::aflip;
}

enum class StressUpdate { usl, usf, musl };
enum class Precision { single_, double_ };
/// law: closed, and what acts on it is a plane structure at the face, or an absorbing end.
enum class WallKind { none, no_slip, free_slip, friction, open, periodic, law };
/// layer: a release, draped on the ground.
enum class BodyShape { box, polygon, sphere, table, layer, inflow };
enum class Seeding { lattice, jittered };
enum class StructureShape { plane, sphere, cylinder, box, capsule, polygon, ground };
enum class StructureMotion { fixed, velocity, sinusoid, table, free };
/// Where structures act along their surfaces: at the nodes near them, or on the surfaces
/// (core/surfaces/surface_elements.hpp).
enum class Bed { nodes, surface };
enum class InterfaceLaw { smooth, rough, coulomb, undrained, voellmy };
enum class Volumetric { particle, cell, grid };
enum class Trigger { never, every, threshold, planned };

/// What fluids take from the grid besides their motion: nothing; the means of nodes (core/fluid/pressure_smoothing.hpp,
/// core/fluid/particle_shifting.hpp); these, and the pressure of cells (core/fluid/grid_pressure.hpp).
enum class FluidGrid { none, means, pressure };

}  // namespace moraine
