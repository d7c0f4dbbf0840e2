#include "gpu/material_gathers.hpp"

#include <algorithm>
#include <cstring>

namespace moraine::gpu {

namespace {

constexpr std::uint32_t not_known = ~0u;

void wait_for(cudaStream_t stream, cudaEvent_t event) {
    check(cudaStreamWaitEvent(stream, event), "Ordering streams");
}

}  // namespace

template <class Real, int Dim>
MaterialGathers<Real, Dim>::MaterialGathers(const Scene& scene, const KernelKey& key, const std::uint16_t* material_of)
    : material_of_(material_of) {
    for (std::size_t k = 0; k < scene.materials.size(); ++k) gather_.emplace_back(key, scene.materials[k], k);
    const std::size_t lists = lists_of_part();
    counts_.assign(std::vector<std::uint32_t>(2 * (2 * lists + 1), 0));
    grid_.resize(2 * lists);
    told_.resize(grid_.size() * sizeof(std::uint32_t));
    const std::vector<std::uint32_t> none(grid_.size(), not_known);
    std::memcpy(told_.data(), none.data(), none.size() * sizeof(std::uint32_t));
    tells_ = reinterpret_cast<std::uint32_t*>(told_.device());
}

template <class Real, int Dim>
void MaterialGathers<Real, Dim>::open(std::size_t own, int parts, cudaStream_t stream) {
    capacity_ = own;
    parts_ = parts;
    blocks_.resize(own * lists_of_part() * static_cast<std::size_t>(parts), stream);
    list_of_.resize(own, stream);
}

/// An eighth more than there were, for flows; fewer only where it is worth while, because graphs hold them.
template <class Real, int Dim>
bool MaterialGathers<Real, Dim>::choose_grids() {
    bool other = false;
    const auto* told = reinterpret_cast<const std::uint32_t*>(told_.data());
    for (std::size_t k = 0; k < grid_.size(); ++k) {
        const std::uint32_t length = __atomic_load_n(told + k, __ATOMIC_RELAXED);
        if (length == not_known || (grid_[k] > 0 && length <= grid_[k] && grid_[k] <= 2 * length + 64)) continue;
        grid_[k] = length + length / 8 + 16;
        other = true;
    }
    return other;
}

template <class Real, int Dim>
int MaterialGathers<Real, Dim>::grid(int part, int list, const Launch& launch) const {
    const std::uint32_t known = grid_[place_of(part) * lists_of_part() + static_cast<std::size_t>(list)];
    return known == 0 ? launch.blocks : std::min(launch.blocks, static_cast<int>(known));
}

template <class Real, int Dim>
SortedBlocks MaterialGathers<Real, Dim>::lists(int part) const {
    const std::size_t lists = lists_of_part(), place = place_of(part);
    std::uint32_t* counts = counts_.data() + place * (2 * lists + 1);
    return {static_cast<int>(gather_.size()),
            blocks_.data() + place * lists * capacity_,
            capacity_,
            counts,
            counts + lists,
            list_of_.data(),
            tells_ + place * lists};
}

template <class Real, int Dim>
void MaterialGathers<Real, Dim>::sort(int part, const V& view, const Chosen& chosen, bool concurrently,
                                      const Launch& launch) {
    const cudaStream_t stream = concurrently ? static_cast<cudaStream_t>(sorting_) : launch.stream;
    if (concurrently) {
        begun_.record(launch.stream);
        sorting_.wait_for(begun_);
    }
    sort_blocks({chosen, view.list.first, view.list.slot, view.p.body, material_of_}, lists(part),
                {launch.blocks, stream});
    sorted_.record(stream);
}

template <class Real, int Dim>
typename MaterialGathers<Real, Dim>::Rest MaterialGathers<Real, Dim>::gather(int part, const V& view,
                                                                             const FluidGatherArgs<Real, Dim>& args,
                                                                             const Chosen* limited,
                                                                             const Launch& launch) {
    wait_for(launch.stream, sorted_);
    ready_.record(launch.stream);
    for (const Stream& stream : of_material_[part]) stream.wait_for(ready_);
    limited_.wait_for(ready_);
    const SortedBlocks from = lists(part);
    for (int m = 0; m < from.materials; ++m)
        gather_[static_cast<std::size_t>(m)].run(view, from.list(m), args,
                                                 {grid(part, m, launch), of_material_[part][m % 2]});
    const Launch rest{grid(part, from.materials, launch), launch.stream};
    if (limited) add_to_rest(*limited, from, rest);
    return {from.list(from.materials), {rest, Launch{rest.blocks, limited_}}};
}

template <class Real, int Dim>
void MaterialGathers<Real, Dim>::meet(const Lanes& lanes) {
    met_.record(lanes[1].stream);
    wait_for(lanes[0].stream, met_);
}

template <class Real, int Dim>
void MaterialGathers<Real, Dim>::finish(int part, cudaStream_t stream) {
    for (int k = 0; k < 2; ++k) {
        done_[k].record(of_material_[part][k]);
        wait_for(stream, done_[k]);
    }
}

template class MaterialGathers<float, 2>;
template class MaterialGathers<float, 3>;
template class MaterialGathers<double, 2>;
template class MaterialGathers<double, 3>;

}  // namespace moraine::gpu
