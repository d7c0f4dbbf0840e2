#pragma once
// The kernels that a scene's steps launch: chosen once, when the engine is made, and the same in every step.

#include <memory>
#include <vector>

#include "core/method.hpp"
#include "gpu/kernels/g2p/g2p.hpp"
#include "gpu/kernels/nodes/nodes.hpp"
#include "gpu/kernels/p2g/p2g.hpp"
#include "gpu/kernels/pressure/pressure.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
struct Kernels {
    P2g<Real, Dim> p2g = nullptr;           ///< null: p2g_mean in its place
    P2gMean<Real, Dim> p2g_mean = nullptr;  ///< where fluids take a mean from the nodes
    FindLimited<Real, Dim> find_limited = nullptr;
    std::unique_ptr<GatherKernel<Real, Dim>> gather;
    std::vector<std::unique_ptr<StressKernel<Real, Dim>>> stress;  ///< by material; none: the gather has it

    decltype(&gpu::solve_nodes<Real, Dim>) nodes = &gpu::solve_nodes<Real, Dim>;
    decltype(&gpu::solve_fluid_nodes<Real, Dim>) fluid_nodes = &gpu::solve_fluid_nodes<Real, Dim>;
    decltype(&gpu::hold_nodes<Real, Dim>) hold_nodes = &gpu::hold_nodes<Real, Dim>;
    decltype(&gpu::find_cells<Real, Dim>) find_pressures = &gpu::find_cells<Real, Dim>;
    decltype(&gpu::advance_cells<Real, Dim>) advance_pressures = &gpu::advance_cells<Real, Dim>;
    decltype(&gpu::solve_substep_nodes<Real, Dim>) substep_nodes = &gpu::solve_substep_nodes<Real, Dim>;
};

/// Fluids of this method take means from the nodes: smoothed pressures, shifts, or the grid's pressure.
template <class Real, int Dim>
bool takes_means(const Method<Host, Real, Dim>& method) {
    return method.fluid() || method.grid_bulk();
}

/// On the current device. Throws MachineError.
template <class Real, int Dim>
Kernels<Real, Dim> choose_kernels(const Scene& scene, const Method<Host, Real, Dim>& method);

}  // namespace moraine::gpu
