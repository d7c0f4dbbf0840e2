#pragma once
// Samples for hazard maps and sections on the device, by the formulas of core/data/plan_samples.hpp; and the work of
// gravity that changes.
//
// A thread block per own block. The few columns over a block are summed in shared memory and added to those of the map
// by one atomic each; whole numbers are the same in any order. Particles near lines go into a list in any order: who
// asks sorts them.

#include <cuda_runtime.h>

#include "core/data/exact_sum.hpp"
#include "core/data/plan_samples.hpp"
#include "gpu/kernels/view.hpp"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

/// What the samples of a run are made in.
struct DeviceSamples {
    Array<std::int64_t> sums;
    Array<std::int32_t> tiles;
    Array<double> floor;  ///< of columns [m]
    Array<Layers> layers;
    Array<std::uint64_t> fastest;  ///< bits of a square speed, not negative [m2/s2]
    Array<PlanSegment> segments;
    Array<NearParticle> near;
    Array<std::uint32_t> count;
    Array<ExactSum> work;  ///< of gravity [J]
};

/// Adds the layers in which the share has particles. columns: with `tile` and `floor` on the device. Asynchronous.
template <class Real>
void find_layers(const View<Real, 3>& view, const PlanColumns& columns, Layers* layers, cudaStream_t stream);

/// Adds the particles of the share to sums, and raises *fastest to the bits of the largest |v|^2. Asynchronous.
template <class Real>
void sum_columns(const View<Real, 3>& view, const PlanColumns& columns, std::int64_t* sums, std::uint64_t* fastest,
                 cudaStream_t stream);

/// Appends the particles near the lines while there is capacity, and counts all of them. lines: segments on the device.
/// Asynchronous.
template <class Real>
void find_near(const View<Real, 3>& view, const PlanLines& lines, NearParticle* near, std::uint32_t capacity,
               std::uint32_t* count, cudaStream_t stream);

/// Adds to *work what a change of gravity [m/s2] works on the share (core/data/gravity_work.hpp). Asynchronous.
template <class Real, int Dim>
void sum_gravity_work(const View<Real, Dim>& view, const PlanPlaces& places, const double (&change)[Dim],
                      const Quantum& quantum, ExactSum* work, cudaStream_t stream);

}  // namespace moraine::gpu
