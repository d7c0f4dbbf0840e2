// The engine's parts of a step and of a row that concern fluids: which mean the nodes sum besides, what the gather
// makes of it, and over-filling.

#include <cmath>

#include "gpu/engine.hpp"
#include "gpu/kernels/volumes/volumes.hpp"

namespace moraine::gpu {

/// Where the pressure is the grid's and nothing is smoothed or shifted, terms are zero.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::take_fluids() {
    const std::size_t bodies = scene_.bodies.size();
    if (method_.grid_bulk()) pressure_.start(method_.grid_bulk(), bodies);
    if (!takes_means()) return;
    std::vector<FluidTerms<Real>> terms(bodies);
    if (method_.fluid()) terms.assign(method_.fluid(), method_.fluid() + bodies);
    first_fluid_ = terms.front();
    fluid_.assign(terms);
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::sum_part(int part, cudaStream_t stream) {
    const int grid = p2g_grid<Dim>(blocks_of(part));
    const Chosen chosen = sleepers_ ? sleepers_->to_sum(view(), particles_.rest(), part, chosen_of(part), mean_,
                                                        {blocks_of(part), stream})
                                    : chosen_of(part);
    p2g_(view(), chosen, grid, {method_.cell, mean_ == NodeMean::volume, method_.grid_bulk() != nullptr}, stream);
}

/// contact: of this step's structures; null where there are none.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::run_nodes(const NodeRound<Real, Dim>& round, const Quantum& quantum,
                                        const LightMarks<Real>& marks, const NodeContact<Dim>* contact) {
    if (!method_.fluid()) return nodes_kernel_.solve(view(), method_.stencil, round, quantum, marks, stream_, contact);
    const NodeFluid<Real, Dim> fluid{mean_ == NodeMean::volume, method_.capacity,
                                     static_cast<Real>(std::pow(scene_.cell, -Dim))};
    nodes_kernel_.solve_fluid(view(), method_.stencil, round, quantum, marks, fluid, stream_, contact);
}

template <class Real, int Dim>
FluidArgs<Real> DeviceEngine<Real, Dim>::fluid_args() const {
    if (!takes_means()) return {};
    return {scene_.materials.size() > 1 ? fluid_.data() : nullptr, first_fluid_, mean_ == NodeMean::volume};
}

/// The sums of a step with volumes in place of masses; the next step makes all tiles anew.
template <class Real, int Dim>
std::optional<NodeVolumes> DeviceEngine<Real, Dim>::node_volumes() {
    if (sleepers_) sleepers_->forget_tiles();
    if (exchange_) sum_volumes(view(), scene_.shape, lists_.boundary(), boundary_blocks_, stream_);
    sum_volumes(view(), scene_.shape, lists_.interior(), interior_blocks(), stream_);
    if (exchange_) {
        exchange_->binned.record(stream_);
        exchange_->stream.wait_for(exchange_->binned);
    }
    send_halo();
    sum_interior();
    receive_halo();
    volumes_.resize(2);
    check(cudaMemsetAsync(volumes_.data(), 0, 2 * sizeof(ExactSum), stream_), "Emptying sums");
    count_volumes(view(), method_.stencil, method_.capacity, std::pow(scene_.cell, -Dim), volumes_.data(), stream_);
    stream_.wait();
    const std::vector<ExactSum> sums = volumes_.host(reading_);
    return NodeVolumes{sums[0], sums[1]};
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
