#pragma once
// A scene of one structure, for tests of structures.

#include "core/scene_spec.hpp"

namespace moraine {

/// A scene that holds one structure and what a set needs besides.
inline Scene scene_with(int dimensions, const StructureSpec& structure) {
    Scene scene;
    scene.transfer = Transfer::flip;
    scene.dimensions = dimensions;
    scene.min = {-5, -5, -5};
    scene.max = {5, 5, 5};
    scene.cell = 0.1;
    scene.materials.resize(1);
    scene.materials[0].density = 1000;
    scene.bodies.resize(1);
    scene.structures = {structure};
    return scene;
}

}  // namespace moraine
