#pragma once
// Scenes of boxes that a lattice fills, which between them have what seeding differs in: bodies that share blocks and
// cells, periodic axes, stresses and waves at the start, columns of transfers and laws, odd spacings.

#include <vector>

#include "sample_scenes.hpp"

namespace moraine::test {

inline Scene without_jitter(Scene scene) {
    for (BodySpec& body : scene.bodies) body.seeding = Seeding::lattice;
    return scene;
}

/// Three boxes in 2-D whose sides are no multiples of anything; two share cells.
inline Scene odd_boxes() {
    Scene s = without_jitter(slurry());
    s.bodies.push_back(box({0.013, 0.17, 0}, {2.49, 0.913, 0}, 0));
    s.bodies.push_back(box({2.491, 1.01, 0}, {3.3, 1.77, 0}, 0));
    s.bodies[1].particles_per_cell = {3, 1, 2};
    s.bodies[2].wave = {{0, 0.5, 0}, 0, 0.3, 0.7};
    return without_jitter(s);
}

/// Two soils in 3-D across a periodic axis, with a wave along the last axis.
inline Scene stacked_boxes() {
    Scene s = without_jitter(column());
    s.bodies[0].particles_per_cell = {2, 3, 1};
    s.bodies[1].geostatic = true;
    s.bodies[1].geostatic_surface = 3;
    s.bodies[1].geostatic_k0 = 0.6;
    s.bodies[1].wave = {{0.1, 0.2, 0.3}, 2, 0, 2};
    return s;
}

/// All of them, under shapes and transfers that file and keep differently.
inline std::vector<Scene> lattice_scenes() {
    std::vector<Scene> scenes;
    for (const Scene& scene : {without_jitter(slurry()), odd_boxes(), stacked_boxes()})
        for (const auto& [shape, transfer] :
             {std::pair(moraine::Shape::quadratic, Transfer::flip), std::pair(moraine::Shape::linear, Transfer::flip),
              std::pair(moraine::Shape::gimp_contiguous, Transfer::apic),
              std::pair(moraine::Shape::cubic, Transfer::apic)}) {
            scenes.push_back(scene);
            scenes.back().shape = shape;
            scenes.back().transfer = transfer;
            if (shape == moraine::Shape::linear) scenes.back().cfl = 0.1;  // a long step turns particles inside out
        }
    return scenes;
}

}  // namespace moraine::test
