// The engine's parts of a step and of a row that concern fluids: the mean that nodes sum, what the gather
// makes of it, and over-filling.

#include <cmath>

#include "gpu/engine.hpp"
#include "gpu/kernels/volumes/volumes.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::sum_part(int part, cudaStream_t stream) {
    const int grid = p2g_grid<Dim>(blocks_of(part));
    const Chosen chosen = sleepers_ ? sleepers_->to_sum(view(), store_.rows.rest(), part, chosen_of(part), fluid_.mean,
                                                        {blocks_of(part), stream})
                                    : chosen_of(part);
    kernels_.p2g(view(), chosen, grid, fluid_.mean_scale(method_), stream);
    if (added_.loads) added_.loads->add(view(), chosen, blocks_of(part), stream);
}

/// contact: of this step's structures; null where there are none.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::run_nodes(const NodeRound<Real, Dim>& round, const Quantum& quantum,
                                        const LightMarks<Real>& marks, const NodeContact<Dim>* contact) {
    if (!method_.fluid()) return kernels_.nodes.solve(view(), method_.stencil, round, quantum, marks, stream_, contact);
    kernels_.nodes.solve_fluid(view(), method_.stencil, round, quantum, marks, fluid_.at_nodes(method_, scene_.cell),
                               stream_, contact);
}

/// The sums of a step with volumes in place of masses; the next step writes all tiles again.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::find(VolumeQuery& query) {
    if (sleepers_) sleepers_->forget_tiles();
    if (exchange_) sum_volumes(view(), scene_.shape, epoch_.lists.boundary(), boundary_blocks_, stream_);
    sum_volumes(view(), scene_.shape, epoch_.lists.interior(), interior_blocks(), stream_);
    if (exchange_) {
        exchange_->binned.record(stream_);
        exchange_->stream.wait_for(exchange_->binned);
    }
    send_halo();
    sum(SharePart::interior);
    receive_halo();
    fluid_.volumes.resize(2);
    check(cudaMemsetAsync(fluid_.volumes.data(), 0, 2 * sizeof(ExactSum), stream_), "Emptying sums");
    count_volumes(view(), method_.stencil, method_.capacity, std::pow(scene_.cell, -Dim), fluid_.volumes.data(),
                  stream_);
    stream_.wait();
    const std::vector<ExactSum> sums = fluid_.volumes.host(reading_);
    query.volumes = {sums[0], sums[1]};
}

template class DeviceEngine<float, 2>;
template class DeviceEngine<float, 3>;
template class DeviceEngine<double, 2>;
template class DeviceEngine<double, 3>;

}  // namespace moraine::gpu
