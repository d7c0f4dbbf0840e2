#include "gpu/kernels/loads/loads.hpp"

#include <algorithm>
#include <utility>

#include "gpu/compile/kernel_store.hpp"
#include "gpu/kernels/programs.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
DeviceLoads<Real, Dim>::DeviceLoads(const KernelKey& key)
    : kernel_(KernelStore::instance().kernels(loads_program(key)).front()) {
    sums_.resize(1);
    check(cudaHostAlloc(&here_, sizeof(LoadSums<Dim>), 0), "Allocating pinned memory");
}

template <class Real, int Dim>
void DeviceLoads<Real, Dim>::take(std::span<const Traction<Real, Dim>> tractions) {
    work_.count = static_cast<int>(tractions.size());
    std::copy(tractions.begin(), tractions.end(), work_.traction);
}

template <class Real, int Dim>
void DeviceLoads<Real, Dim>::begin_step(std::span<const double> factors, std::size_t most, cudaStream_t stream) {
    if (most > loads_.size()) loads_.resize(most);
    work_.of = loads_.data();
    work_.loaded = loaded_.data();
    work_.sets = true;
    std::copy(factors.begin(), factors.end(), work_.factor);
    check(cudaMemsetAsync(sums_.data(), 0, sizeof(LoadSums<Dim>), stream), "Emptying sums");
}

template <class Real, int Dim>
void DeviceLoads<Real, Dim>::add(const View<Real, Dim>& view, const Chosen& chosen, int blocks,
                                 cudaStream_t stream) const {
    kernel_(static_cast<unsigned>(std::max(blocks, 1)), stream, {work_, view, chosen}, "Adding tractions");
}

template <class Real, int Dim>
void DeviceLoads<Real, Dim>::fetch(cudaStream_t stream) {
    check(cudaMemcpyAsync(here_, sums_.data(), sizeof(LoadSums<Dim>), cudaMemcpyDeviceToHost, stream),
          "Copying what tractions did");
    fetched_ = true;
}

template <class Real, int Dim>
void DeviceLoads<Real, Dim>::add_to(Budget<Dim>& budget) {
    if (!std::exchange(fetched_, false)) return;
    budget.load_work.add(here_->of[0]);
    for (std::size_t a = 0; a < Dim; ++a) budget.load_impulse[a].add(here_->of[1 + a]);
}

template class DeviceLoads<float, 2>;
template class DeviceLoads<float, 3>;
template class DeviceLoads<double, 2>;
template class DeviceLoads<double, 3>;

}  // namespace moraine::gpu
