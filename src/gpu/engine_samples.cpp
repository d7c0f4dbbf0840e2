// The engine's answers to hazard maps, sections and changing gravity (core/data/plan_samples.hpp): sums of columns and
// the particles near a line go to the host, not the share.

#include <algorithm>
#include <bit>

#include "gpu/engine.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::find(LayerQuery& query) {
    if constexpr (Dim == 3) {
        const PlanColumns& columns = query.columns;
        samples_.floor.assign(columns.floor, columns.all());
        samples_.layers.resize(columns.all());
        samples_.tiles.assign(columns.tile, columns.all_tiles());
        PlanColumns there = columns;
        there.tile = samples_.tiles.data();
        there.floor = samples_.floor.data();
        check(cudaMemsetAsync(samples_.layers.data(), 0, columns.all() * sizeof(Layers), stream_), "Emptying layers");
        gpu::find_layers(view(), there, samples_.layers.data(), stream_);
        stream_.wait();
        query.layers = samples_.layers.host(reading_);
    }
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::find(ColumnQuery& query) {
    if constexpr (Dim == 3) {
        const PlanColumns& columns = query.columns;
        samples_.sums.resize(columns.all_sums());
        samples_.fastest.resize(1);
        check(cudaMemsetAsync(samples_.sums.data(), 0, columns.all_sums() * sizeof(std::int64_t), stream_),
              "Emptying sums");
        check(cudaMemsetAsync(samples_.fastest.data(), 0, sizeof(std::uint64_t), stream_), "Emptying sums");
        samples_.tiles.assign(columns.tile, columns.all_tiles());
        PlanColumns there = columns;
        there.tile = samples_.tiles.data();
        if (columns.resting) {
            samples_.floor.assign(columns.floor, columns.all());
            samples_.layers.assign(columns.resting, columns.all());
            there.floor = samples_.floor.data(), there.resting = samples_.layers.data();
        }
        gpu::sum_columns(view(), there, samples_.sums.data(), samples_.fastest.data(), stream_);
        stream_.wait();
        query.sums = samples_.sums.host(reading_);
        query.square_speed = std::bit_cast<double>(samples_.fastest.host(reading_).front());
    }
}

/// Where more particles are near than the list holds, it grows and they are found again.
template <class Real, int Dim>
void DeviceEngine<Real, Dim>::find(LineQuery& query) {
    if constexpr (Dim == 3) {
        const PlanLines& lines = query.lines;
        if (samples_.segments.size() == 0) {
            samples_.segments.assign(lines.segment, static_cast<std::size_t>(lines.count));
            samples_.near.resize(256);
            samples_.count.resize(1);
        }
        PlanLines there = lines;
        there.segment = samples_.segments.data();
        for (;;) {
            check(cudaMemsetAsync(samples_.count.data(), 0, sizeof(std::uint32_t), stream_), "Emptying a list");
            find_near(view(), there, samples_.near.data(), static_cast<std::uint32_t>(samples_.near.capacity()),
                      samples_.count.data(), stream_);
            stream_.wait();
            const std::size_t n = samples_.count.host(reading_).front();
            const bool fits = n <= samples_.near.capacity();
            samples_.near.resize(n);
            if (!fits) continue;
            query.near = samples_.near.host(reading_);
            return;
        }
    }
}

template <class Real, int Dim>
void DeviceEngine<Real, Dim>::find(GravityQuery<Dim>& query) {
    double change[Dim];
    std::copy_n(query.change.begin(), Dim, change);
    samples_.work.resize(1);
    check(cudaMemsetAsync(samples_.work.data(), 0, sizeof(ExactSum), stream_), "Emptying sums");
    sum_gravity_work(view(), query.places, change, query.quantum, samples_.work.data(), stream_);
    stream_.wait();
    query.work = samples_.work.host(reading_).front();
}

/// Of one precision and dimension.
#define MORAINE_SAMPLES(Real, Dim)                             \
    template void DeviceEngine<Real, Dim>::find(LayerQuery&);  \
    template void DeviceEngine<Real, Dim>::find(ColumnQuery&); \
    template void DeviceEngine<Real, Dim>::find(LineQuery&);   \
    template void DeviceEngine<Real, Dim>::find(GravityQuery<Dim>&);
MORAINE_SAMPLES(float, 2)
MORAINE_SAMPLES(float, 3)
MORAINE_SAMPLES(double, 2)
MORAINE_SAMPLES(double, 3)

}  // namespace moraine::gpu
