#pragma once
// Which kernels of a device step a scene: the one decision, and what `moraine check` prints of it. A device compiles
// them when a scene first wants them (gpu/compile). Plain C++ below gpu, because a program without device code predicts
// a device's memory, and only a gather apart from the stress keeps a velocity gradient per particle.
//
// The stress update is fused with the gather (one kernel, the gradient stays in registers) for what most runs are: USL,
// one material, quadratic splines of any transfer but AFLIP and FMPM, or hats without an affine field. Else it is
// split: a gather that leaves dL = dt grad v per list entry, and a stress update per material. In scenes of several
// materials that would each be fused, blocks whose particles are all of one material are sorted out and fused, the rest
// split. The two ways differ in rounding. What the grid gives a material besides its motion is fused for fluids alone.

#include <algorithm>
#include <string>
#include <vector>

#include "core/material/laws.hpp"
#include "core/scene_spec.hpp"

namespace moraine {

enum class GatherWay { fused, by_material, split };

/// A material's law as kernels know it.
struct LawKey {
    std::string name;     ///< of the scene's key
    const LawInfo* info;  ///< its position in Laws, or its file
    bool plain;           ///< an undrained strength that depends on no rate and does not soften
    bool cell_means;      ///< takes its volumetric part from the cell (core/grid/volumetric.hpp)
};

struct KernelKey {
    Precision real;
    int dimension;
    Shape shape;
    bool affine;  ///< particles carry a field
    std::vector<LawKey> laws;
    GatherWay way;
    // Terms.
    FluidGrid fluid;
    bool cell_means;   ///< of some body's material
    bool light_nodes;  ///< accelerations are limited (core/grid/light_nodes.hpp)
    bool structures;
    bool turning;   ///< and one turns
    bool surfaces;  ///< and they act where they are (Bed::surface)
    bool sleep;
    bool loads;         ///< tractions
    bool single_round;  ///< USL: one round of sums, nodes and gather a step

    int width() const { return shape == Shape::linear ? 2 : shape == Shape::cubic ? 4 : 3; }
    /// One line.
    std::string text() const;
};

KernelKey kernel_key(const Scene& scene);

/// How the scene's gather and stress update go together.
GatherWay gather_way(const Scene& scene);

}  // namespace moraine
