#pragma once
// What kernels read of the scene's bodies, on the device.

#include "core/scene_spec.hpp"
#include "core/transfer/method.hpp"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
struct BodyTables {
    Array<Vec<Real, Dim>> half_size;
    Array<std::uint16_t> material_of;
    Array<std::uint8_t> averaged;  ///< empty: all or none

    BodyTables(const Scene& scene, const Method<Host, Real, Dim>& method) {
        half_size.assign(method.context.half_size, scene.bodies.size());
        std::vector<std::uint16_t> materials;
        for (const BodySpec& body : scene.bodies) materials.push_back(static_cast<std::uint16_t>(body.material));
        material_of.assign(materials);
        if (method.averaged()) averaged.assign(method.averaged(), scene.bodies.size());
    }
};

}  // namespace moraine::gpu
