#include "gpu/device_sleepers.hpp"

#include <utility>

#include "core/sleep/scene_sleep.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
DeviceSleepers<Real, Dim>::DeviceSleepers(const Scene& scene, const KernelKey& key,
                                          const Method<Host, Real, Dim>& method, const std::uint16_t* material_of)
    : method_(method), material_of_(scene.materials.size() > 1 ? material_of : nullptr), rule_(sleep_rule(scene)) {
    for (std::size_t m = 0; m < scene.materials.size(); ++m) waves_.emplace_back(key, scene.materials[m], m);
    accounts_.assign(std::vector<SleepAccount<Dim>>(account_parts));
    counts_.resize(4);
    gpu::check(cudaMemset(report_.device(), 0, sizeof(SleepAccount<Dim>)), "Making sleepers");
    gpu::check(cudaDeviceSynchronize(), "Making sleepers");
}

template <class Real, int Dim>
void DeviceSleepers<Real, Dim>::open(std::size_t own, std::size_t ghosts, cudaStream_t stream) {
    own_ = own;
    asleep_.resize(own + ghosts, stream), activity_.resize(own + ghosts, stream);
    binned_.resize(own, stream), kept_.resize(own, stream), wave_.resize(own, stream), marks_.resize(own, stream);
    lists_.resize(4 * own, stream);
    if (own + ghosts > 0) gpu::check(cudaMemsetAsync(asleep_.data(), 0, own + ghosts, stream), "Clearing sleepers");
    if (own > 0) gpu::check(cudaMemsetAsync(marks_.data(), 0xff, own * sizeof(TileMark), stream), "Clearing sleepers");
    forget_tiles();
    waves_known_ = false;
}

template <class Real, int Dim>
void DeviceSleepers<Real, Dim>::resize_tiles(std::size_t tiles, cudaStream_t stream) {
    if (method_.grid_bulk())
        masses_.resize(tiles * static_cast<std::size_t>(power<Dim>(tile_side(method_.stencil.width))), stream);
    forget_tiles();
}

template <class Real, int Dim>
SleepView<Dim> DeviceSleepers<Real, Dim>::state(const RestWords& rest) const {
    SleepView<Dim> s{};
    s.rest = rest, s.rule = rule_;
    s.asleep = asleep_.data(), s.binned = binned_.data(), s.kept = kept_.data();
    s.activity = activity_.data(), s.wave = wave_.data();
    s.made = marks_.data();
    s.kept_awake = kept_awake_.size() > 0 ? kept_awake_.data() : nullptr;
    s.accounts = accounts_.data();
    return s;
}

/// Sleeping blocks keep their wave speed from binning to binning; it is found again when an epoch begins.
template <class Real, int Dim>
void DeviceSleepers<Real, Dim>::find(const V& view, const RestWords& rest, const std::uint32_t* former_first,
                                     cudaStream_t stream) {
    find_sleepers(view, state(rest), former_first, stream);
    if (!waves_known_) find_waves(view, stream);
}

template <class Real, int Dim>
void DeviceSleepers<Real, Dim>::keep_awake(const V& view, const ContactField<Dim>& structures, cudaStream_t stream) {
    kept_awake_.resize(own_, stream);
    find_kept_awake(view.table, structures, rule_.interval, kept_awake_.data(), stream);
}

template <class Real, int Dim>
void DeviceSleepers<Real, Dim>::find_waves(const V& view, cudaStream_t stream) {
    for (std::size_t k = 0; k < waves_.size(); ++k)
        waves_[k].run(view, asleep_.data(), wave_.data(), material_of_, static_cast<int>(k), stream);
    waves_known_ = true;
}

template <class Real, int Dim>
void DeviceSleepers<Real, Dim>::change(const V& view, const RestWords& rest, bool first, const Quantum& quantum,
                                       cudaStream_t stream) {
    change_sleepers(view, state(rest), first, quantum, stream);
    find_waves(view, stream);
    SleepView<Dim> counted = state(rest);
    counted.binned = nullptr;
    find_sleepers(view, counted, nullptr, stream);
    count(stream);
}

template <class Real, int Dim>
ListToMake DeviceSleepers<Real, Dim>::list(int number) const {
    return {lists_.data() + static_cast<std::size_t>(number) * own_, counts_.data() + number,
            counts_.data() + (number ^ 2)};
}

template <class Real, int Dim>
Chosen DeviceSleepers<Real, Dim>::chosen(int number) const {
    return {list(number).block, list(number).count};
}

/// Substeps write to all tiles. A tile with another mean is another one. hold() empties the list, unless the sums are
/// made twice in a step.
template <class Real, int Dim>
Chosen DeviceSleepers<Real, Dim>::to_sum(const V& view, const RestWords& rest, int part, const Chosen& from,
                                         NodeMean mean, const Launch& launch) {
    constexpr std::int32_t means = 4;
    summed_ = made_;
    if (!std::exchange(empty_[part], false))
        gpu::check(cudaMemsetAsync(counts_.data() + part, 0, sizeof(std::uint32_t), launch.stream), "Emptying a list");
    choose_sums(view, state(rest), from, means * made_ + static_cast<std::int32_t>(mean),
                method_.grid_bulk() != nullptr, list(part), launch);
    return chosen(part);
}

template <class Real, int Dim>
void DeviceSleepers<Real, Dim>::summed(const V& view, const RestWords& rest, cudaStream_t stream) {
    if (method_.grid_bulk()) keep_masses(view, state(rest), method_.stencil.width, masses_.data(), stream);
}

/// Where substeps are, all nodes wake.
template <class Real, int Dim>
void DeviceSleepers<Real, Dim>::hold(const V& view, const RestWords& rest, const std::uint8_t* near,
                                     const Quantum& quantum, const std::uint8_t* boundary, cudaStream_t stream) {
    const bool substeps = method_.grid_bulk() != nullptr;
    hold_sleepers<Real, Dim>(view, state(rest),
                             {method_.stencil.width, !substeps, near, substeps ? masses_.data() : nullptr, quantum},
                             {boundary, {list(2), list(3)}}, stream);
    empty_[0] = empty_[1] = true;
}

template <class Real, int Dim>
void DeviceSleepers<Real, Dim>::add_taken(Budget<Dim>& budget) const {
    budget.slept_kinetic.add(report_->taken[0]);
    for (std::size_t a = 0; a < Dim; ++a) budget.slept_momentum[a].add(report_->taken[1 + a]);
}

template class DeviceSleepers<float, 2>;
template class DeviceSleepers<float, 3>;
template class DeviceSleepers<double, 2>;
template class DeviceSleepers<double, 3>;

}  // namespace moraine::gpu
