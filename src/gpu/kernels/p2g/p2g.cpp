#include "gpu/kernels/p2g/p2g.hpp"

#include "gpu/compile/kernel_store.hpp"
#include "gpu/kernels/programs.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
P2g<Real, Dim>::P2g(const KernelKey& key, bool mean)
    : kernel_(KernelStore::instance().kernels(p2g_program(key, mean)).front()), mean_(mean) {}

template <class Real, int Dim>
void P2g<Real, Dim>::operator()(const View<Real, Dim>& view, const Chosen& chosen, int grid_blocks,
                                const MeanScale<Real>& scale, cudaStream_t stream) const {
    const Argument with = mean_ ? Argument(scale) : Argument(scale.cell);
    kernel_(static_cast<unsigned>(grid_blocks), stream, {view, chosen, with}, "Launching particle to grid");
}

template class P2g<float, 2>;
template class P2g<float, 3>;
template class P2g<double, 2>;
template class P2g<double, 3>;

}  // namespace moraine::gpu
