#include "gpu/kernels/g2p/g2p.hpp"

#include <cstring>

#include "core/material/laws.hpp"
#include "gpu/compile/kernel_store.hpp"
#include "gpu/kernels/programs.hpp"

namespace moraine::gpu {

template <class Real>
LawValue LawValue::of(const MaterialSpec& material) {
    LawValue value;
    value.inverse_density_ = 1 / material.density;
    if (const LawInfo& info = *find_law(material.law); info.of_file()) {
        value.bytes_.resize(info.file.write(sizeof(Real), material.parameters.data(), nullptr));
        info.file.write(sizeof(Real), material.parameters.data(), value.bytes_.data());
        return value;
    }
    with_law<Real>(material.law, material.parameters.data(), [&](const auto& law) {
        static_assert(std::is_trivially_copyable_v<std::decay_t<decltype(law)>>);
        value.bytes_.resize(sizeof(law));
        std::memcpy(value.bytes_.data(), &law, sizeof(law));
    });
    return value;
}

template LawValue LawValue::of<float>(const MaterialSpec&);
template LawValue LawValue::of<double>(const MaterialSpec&);

template <class Real, int Dim>
GatherKernel<Real, Dim>::GatherKernel(const KernelKey& key) : fluid_(key.fluid) {
    const std::vector<Kernel>& kernels = KernelStore::instance().kernels(split_program(key));
    kernel_ = kernels[0];
    if (kernels.size() > 1) limited_ = kernels[1];
}

template <class Real, int Dim>
GatherKernel<Real, Dim>::GatherKernel(const KernelKey& key, const MaterialSpec& material, std::size_t number)
    : fluid_(key.fluid), fused_(true), law_(LawValue::of<Real>(material)) {
    const std::vector<Kernel>& kernels = KernelStore::instance().kernels(fused_program(key, number));
    kernel_ = kernels[0];
    if (kernels.size() > 1) limited_ = kernels[1];
}

template <class Real, int Dim>
void GatherKernel<Real, Dim>::launch(const Kernel& kernel, const View<Real, Dim>& view, const Chosen& chosen,
                                     const FluidGatherArgs<Real, Dim>& args, const Launch& launch) const {
    const MeansGatherArgs<Real, Dim>& means = args;
    const GatherArgs<Real, Dim>& plain = args;
    const Argument given = fluid_ == FluidGrid::pressure ? Argument(args)
                           : fluid_ == FluidGrid::means  ? Argument(means)
                                                         : Argument(plain);
    const unsigned grid = team_grid<Dim>(launch.blocks);
    if (!fused_) return kernel(grid, launch.stream, {view, chosen, given}, "Launching the gather");
    const Real inverse_density = static_cast<Real>(law_.inverse_density());
    kernel(grid, launch.stream, {view, chosen, given, law_.argument(), inverse_density},
           "Launching the gather with stress");
}

template <class Real, int Dim>
void GatherKernel<Real, Dim>::run(const View<Real, Dim>& view, const Chosen& chosen,
                                  const FluidGatherArgs<Real, Dim>& args, const Launch& at) const {
    launch(kernel_, view, chosen, args, at);
}

template <class Real, int Dim>
void GatherKernel<Real, Dim>::run_limited(const View<Real, Dim>& view, const Chosen& limited,
                                          const FluidGatherArgs<Real, Dim>& args, const Launch& at) const {
    launch(limited_, view, limited, args, {few_blocks(at.blocks), at.stream});
}

template <class Real, int Dim>
FindLimited<Real, Dim>::FindLimited(const KernelKey& key) {
    const std::vector<Kernel>& kernels = KernelStore::instance().kernels(limited_program(key));
    list_ = kernels[0], find_ = kernels[1];
}

template <class Real, int Dim>
void FindLimited<Real, Dim>::operator()(const View<Real, Dim>& view, const Chosen& chosen,
                                        const GatherArgs<Real, Dim>& args, const LimitedBlocks& found,
                                        const Launch& launch) const {
    constexpr int teams = Dim == 3 ? 1 : 4;
    const char* what = "Looking for light nodes";
    std::uint32_t* of_marked = found.count + LimitedBlocks::of_marked;
    const int threads = static_cast<int>(list_.threads());
    list_(static_cast<unsigned>(few_blocks(launch.blocks / threads + 1)), launch.stream,
          {view, chosen, args.light, found.marked, of_marked}, what);
    find_(static_cast<unsigned>(few_blocks(launch.blocks / teams + 1)), launch.stream,
          {view, Chosen{found.marked, of_marked}, args, found.limited, found.count}, what);
}

template <class Real, int Dim>
StressKernel<Real, Dim>::StressKernel(const KernelKey& key, const MaterialSpec& material, std::size_t number)
    : kernel_(KernelStore::instance().kernels(stress_program(key, number)).front()),
      law_(LawValue::of<Real>(material)) {}

template <class Real, int Dim>
void StressKernel<Real, Dim>::run(const View<Real, Dim>& view, const Chosen& chosen, const StressArgs<Real, Dim>& args,
                                  const Launch& launch) const {
    const Real inverse_density = static_cast<Real>(law_.inverse_density());
    kernel_(team_grid<Dim>(launch.blocks), launch.stream, {view, chosen, args, law_.argument(), inverse_density},
            "Launching the stress update");
}

#define MORAINE_GATHERS(Real, Dim)          \
    template class GatherKernel<Real, Dim>; \
    template class FindLimited<Real, Dim>;  \
    template class StressKernel<Real, Dim>;
MORAINE_GATHERS(float, 2)
MORAINE_GATHERS(float, 3)
MORAINE_GATHERS(double, 2)
MORAINE_GATHERS(double, 3)

}  // namespace moraine::gpu
