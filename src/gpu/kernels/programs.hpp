#pragma once
// The programs of a scene's heavy kernels (gpu/compile/program.hpp), from its KernelKey alone: the list of what is
// compiled. A program has the kernels of one family that one scene wants.

#include <vector>

#include "core/transfer/kernel_key.hpp"
#include "gpu/compile/program.hpp"

namespace moraine::gpu {

/// One kernel; mean: with the nodes' s_i.
Program p2g_program(const KernelKey& key, bool mean);

/// Gather, and where light nodes are limited the gather of limited blocks.
Program split_program(const KernelKey& key);
Program fused_program(const KernelKey& key, std::size_t material);
/// list_marked and find_limited.
Program limited_program(const KernelKey& key);
Program stress_program(const KernelKey& key, std::size_t material);

/// Nodes that no structure is near, and those near one where there are any. marks: light nodes are marked; fluid: with
/// what fluids want.
Program nodes_program(const KernelKey& key, bool marks, bool fluid);

/// hold_nodes, substep (each: no structure near, and where there are any near one), find_pressures, advance_pressures.
Program pressure_program(const KernelKey& key);

/// Gaps of elements, weighing, sums of shares, acting, closing slaves, applying (gpu/kernels/surfaces);
/// with the grid's pressure the cells beside surfaces, too.
Program surfaces_program(const KernelKey& key);

/// One kernel, of tractions.
Program loads_program(const KernelKey& key);

Program waves_program(const KernelKey& key, std::size_t material);

/// The scene's key in this precision and dimension.
template <class Real, int Dim>
KernelKey device_kernel_key(const Scene& scene) {
    KernelKey key = kernel_key(scene);
    key.real = sizeof(Real) == 4 ? Precision::single_ : Precision::double_;
    key.dimension = Dim;
    return key;
}

/// All that a run of the scene wants.
std::vector<Program> programs_of(const KernelKey& key);

}  // namespace moraine::gpu
