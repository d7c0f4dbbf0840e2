#pragma once
// The method that a scene leaves out: one for each kind of law, where the scene can have it. Not collective.

#include "core/scene_spec.hpp"
#include "io/input_error.hpp"

namespace moraine {

/// numerics.substeps is left out or "auto", until all of the scene is read.
inline constexpr int substeps_by_scene = 0;

/// Sets what was not written, of a scene that is read and not yet checked:
///   what flows           at one volume, fluids and undrained clays: pressures on cells (core/fluid/), of fluids
///                        smoothed, with particle shifting, in substeps; where all flows and says none of these keys,
///                        and nobody asks for structures that act at nodes
///   numerics.bed         with those, surfaces (core/surfaces/); else nodes
///   numerics.transfer    aflip with those, else apic; flip with linear shapes
///   time.cfl             of that transfer
void take_defaults(Scene& scene, const Places& places);

/// "quadratic shapes, aflip, usl; structures act at nodes; slurry: pressures on cells, smoothed, shifted"
std::string method_text(const Scene& scene);

}  // namespace moraine
