#include "gpu/kernels/sleep/waves.hpp"

#include "gpu/compile/kernel_store.hpp"
#include "gpu/kernels/programs.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
WaveKernel<Real, Dim>::WaveKernel(const KernelKey& key, const MaterialSpec& material, std::size_t number)
    : kernel_(KernelStore::instance().kernels(waves_program(key, number)).front()),
      law_(LawValue::of<Real>(material)) {}

template <class Real, int Dim>
void WaveKernel<Real, Dim>::run(const View<Real, Dim>& view, const std::uint8_t* asleep, double* wave,
                                const std::uint16_t* material_of, int mine, cudaStream_t stream) const {
    if (view.table.own == 0) return;
    const unsigned warps = kernel_.threads() / 32;
    const Real inverse_density = static_cast<Real>(law_.inverse_density());
    kernel_((static_cast<unsigned>(view.table.own) + warps - 1) / warps, stream,
            {view, asleep, wave, law_.argument(), inverse_density, material_of, mine},
            "Asking for the waves of sleepers");
}

template class WaveKernel<float, 2>;
template class WaveKernel<float, 3>;
template class WaveKernel<double, 2>;
template class WaveKernel<double, 3>;

}  // namespace moraine::gpu
