#pragma once
// What nodes and cells find of the surfaces, as values (surface_geometry.hpp finds it).

#include "core/data/vec.hpp"

namespace moraine {

inline constexpr double slave_capacity = 0.03;  ///< c*
inline constexpr double free_depth = 3.0;       ///< nodes below that are nobody's slaves [cells]

enum class CellPart { open, cut, solid };

/// What a node finds of the surfaces.
template <int Dim>
struct SurfaceNode {
    double distance;          ///< of the nearest [cells]
    Vec<double, Dim> normal;  ///< of the nearest
    int structure;            ///< the nearest; -1: there is none
    double capacity;          ///< c_i
    double slaved;            ///< f; 0: it is free
    int to[Dim];              ///< to the first of the two that it follows
};

}  // namespace moraine
