#pragma once
// Where dt is in the arguments of kernels whose work is a type of their own (gpu/lead_graph.hpp).

#include <cstddef>

namespace moraine::gpu {

struct DtPlace {
    std::size_t offset, size;  ///< of dt in the first parameter; size of that [bytes]
};

/// Of solve_nodes() without structures (gpu/kernels/nodes/nodes.hpp).
template <class Real, int Dim>
DtPlace dt_of_nodes();

}  // namespace moraine::gpu
