#include "gpu/engine_kernels.hpp"

#include "gpu/compile/kernel_store.hpp"
#include "gpu/kernels/programs.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
Kernels<Real, Dim>::Kernels(const Scene& scene) : key(device_kernel_key<Real, Dim>(scene)) {
    KernelStore::instance().prepare(programs_of(key));
    p2g = P2g<Real, Dim>(key, key.fluid != FluidGrid::none);
    nodes = Nodes<Real, Dim>(key);
    if (key.fluid == FluidGrid::pressure) pressure = Pressure<Real, Dim>(key);
    if (key.light_nodes) find_limited = FindLimited<Real, Dim>(key);
    if (key.way == GatherWay::fused) {
        gather.emplace(key, scene.materials.front(), 0);
        return;
    }
    gather.emplace(key);
    for (std::size_t m = 0; m < scene.materials.size(); ++m) stress.emplace_back(key, scene.materials[m], m);
}

template <class Real, int Dim>
void Kernels<Real, Dim>::take_strengths(const std::vector<MaterialSpec>& materials) {
    if (stress.empty()) gather->take_strength(materials.front());
    for (std::size_t m = 0; m < stress.size(); ++m) stress[m].take_strength(materials[m]);
}

template struct Kernels<float, 2>;
template struct Kernels<float, 3>;
template struct Kernels<double, 2>;
template struct Kernels<double, 3>;

}  // namespace moraine::gpu
