#include "gpu/engine_kernels.hpp"

#include "comm/fused_blocks.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
Kernels<Real, Dim> choose_kernels(const Scene& scene, const Method<Host, Real, Dim>& method) {
    const bool affine = method.needs.affine, fluid = method.fluid(), of_grid = method.grid_bulk();
    Kernels<Real, Dim> chosen;
    if (takes_means(method))
        chosen.p2g_mean = choose_p2g_mean<Real, Dim>(scene.shape, affine);
    else
        chosen.p2g = choose_p2g<Real, Dim>(scene.shape, affine);
    chosen.find_limited = choose_find_limited<Real, Dim>(scene.shape);
    if (fuses(scene)) {
        const MaterialSpec& material = scene.materials.front();
        chosen.gather = of_grid ? make_fused_pressure_gather<Real, Dim>(material, affine)
                        : fluid ? make_fused_fluid_gather<Real, Dim>(material, affine)
                                : make_fused_gather<Real, Dim>(material, scene.shape, affine);
        return chosen;
    }
    chosen.gather = of_grid ? make_pressure_gather<Real, Dim>(affine)
                    : fluid ? make_fluid_gather<Real, Dim>(scene.shape, affine)
                            : make_gather<Real, Dim>(scene.shape, affine, method.averaged() != nullptr);
    for (const MaterialSpec& material : scene.materials) chosen.stress.push_back(make_stress<Real, Dim>(material));
    return chosen;
}

template Kernels<float, 2> choose_kernels(const Scene&, const Method<Host, float, 2>&);
template Kernels<float, 3> choose_kernels(const Scene&, const Method<Host, float, 3>&);
template Kernels<double, 2> choose_kernels(const Scene&, const Method<Host, double, 2>&);
template Kernels<double, 3> choose_kernels(const Scene&, const Method<Host, double, 3>&);

}  // namespace moraine::gpu
