#pragma once
// The kernels that a scene's steps launch: those of its KernelKey, compiled or found when the engine is made, and the
// same in every step.

#include <optional>
#include <vector>

#include "core/transfer/kernel_key.hpp"
#include "core/transfer/method.hpp"
#include "gpu/kernels/g2p/g2p.hpp"
#include "gpu/kernels/nodes/nodes.hpp"
#include "gpu/kernels/p2g/p2g.hpp"
#include "gpu/kernels/pressure/pressure.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
struct Kernels {
    /// On the current device. Throws MachineError.
    explicit Kernels(const Scene& scene);
    /// Of a stage that begins.
    void take_strengths(const std::vector<MaterialSpec>& materials);

    KernelKey key;
    P2g<Real, Dim> p2g;
    Nodes<Real, Dim> nodes;
    Pressure<Real, Dim> pressure;                   ///< where it is the grid's
    FindLimited<Real, Dim> find_limited;            ///< where light nodes are limited
    std::optional<GatherKernel<Real, Dim>> gather;  ///< always there
    std::vector<StressKernel<Real, Dim>> stress;    ///< by material; none: the gather has it
};

/// Fluids of this method take means from the nodes: smoothed pressures, shifts, or the grid's pressure.
template <class Real, int Dim>
bool takes_means(const Method<Host, Real, Dim>& method) {
    return method.fluid() || method.grid_bulk();
}

}  // namespace moraine::gpu
