#pragma once
// What a scene makes of its walls: how they act on nodes (core/grid/walls.hpp), and what nodes beside them hold
// (core/fluid/over_filling.hpp). Apart from both, because kernels know no scene.

#include <cmath>
#include <cstddef>

#include "core/fluid/over_filling.hpp"
#include "core/grid/walls.hpp"
#include "core/scene_spec.hpp"

namespace moraine {

/// Whether soil may lie against it.
inline bool is_closed(WallKind kind) {
    return kind == WallKind::no_slip || kind == WallKind::free_slip || kind == WallKind::friction ||
           kind == WallKind::law;
}

template <class Real, int Dim>
Walls<Real, Dim> make_walls(const Scene& scene) {
    Walls<Real, Dim> walls{};
    for (int a = 0; a < Dim; ++a)
        for (int s = 0; s < 2; ++s) {
            const WallSpec& spec = scene.walls[static_cast<std::size_t>(a)][static_cast<std::size_t>(s)];
            const auto axis = static_cast<std::size_t>(a);
            walls.plane[a][s] =
                s == 0 ? 0 : static_cast<int>(std::lround((scene.max[axis] - scene.min[axis]) / scene.cell));
            walls.kind[a][s] = spec.kind;
            walls.friction[a][s] = static_cast<Real>(spec.friction);
            walls.fold[a][s] = scene.boundary_spline && scene.shape != Shape::linear && is_closed(spec.kind);
        }
    return walls;
}

template <class Real, int Dim>
NodeCapacity<Real, Dim> node_capacity(const Scene& scene, const Walls<Real, Dim>& walls) {
    NodeCapacity<Real, Dim> capacity{};
    for (int a = 0; a < Dim; ++a)
        for (int s = 0; s < 2; ++s) {
            const WallKind kind = walls.kind[a][s];
            const bool closed = is_closed(kind);
            const EndCapacity end = end_capacity(scene.shape, walls.fold[a][s]);
            capacity.plane[a][s] = walls.plane[a][s];
            capacity.on[a][s] = closed ? static_cast<Real>(end.on) : Real(1);
            capacity.next[a][s] = closed ? static_cast<Real>(end.next) : Real(1);
            const double pressing = scene.gravity[static_cast<std::size_t>(a)] * (s == 0 ? -1 : 1);
            if (closed && pressing > 0) capacity.beds |= 1u << (2 * a + s);
        }
    return capacity;
}

}  // namespace moraine
