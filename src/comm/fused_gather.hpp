#pragma once
// For which scenes a device has gather and stress update in one kernel (gpu/kernels/g2p/g2p.hpp). A fact about device
// kernels, and yet plain C++ below gpu: a program without device code predicts a device's memory (predict/memory.cpp),
// and only a gather apart from the stress keeps a velocity gradient per particle. What the grid gives a material
// besides its motion is in one kernel with the stress for fluids alone, and apart for other laws that flow
// (material/point.hpp).

#include "core/material/laws.hpp"
#include "core/scene_spec.hpp"

namespace moraine {

inline bool fuses(const Scene& scene) {
    const bool plain = scene.transfer == Transfer::flip || scene.transfer == Transfer::pic;
    const bool affine = scene.transfer == Transfer::apic || scene.transfer == Transfer::tpic;
    if (scene.stress_update != StressUpdate::usl || scene.materials.size() != 1) return false;
    const MaterialSpec& m = scene.materials.front();
    if ((has_fluid_terms(m) || m.volumetric == Volumetric::grid) && !find_law(m.law)->is_fluid) return false;
    if (scene.shape == Shape::quadratic) return plain || affine;
    return scene.shape == Shape::linear && plain && !has_fluid_terms(m);
}

}  // namespace moraine
