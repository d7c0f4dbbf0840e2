#pragma once
// Structures that move, and the blocks that they keep awake (core/sleep/sleep.hpp).
//
//   d(middle of the block) < 1.5 h + half of the block's diagonal + |V| T
//
// In such a block particles may touch the structure, or may before the next sleep check. From places and velocities
// alone, which all ranks know. At a sleep check its activity is without bound, so the ring around it is awake, too; in
// every other step sleepers in it wake. A structure that stands, if only for a while, keeps nobody awake.

#include "core/sleep/sleep.hpp"
#include "core/structures/contact.hpp"
#include "core/structures/particle_gaps.hpp"

namespace moraine {

/// Whether a structure on the move is near the block at `position`. window: T [s].
template <int Dim>
MORAINE_HD bool is_kept_awake(const ContactField<Dim>& f, double window, const Vec<std::int32_t, Dim>& position) {
    int lowest[Dim];
    for (int a = 0; a < Dim; ++a) lowest[a] = 4 * position[a];
    const double reach = f.cell * (particle_reach + 2 * (Dim == 2 ? 1.4143 : 1.7321));  // as is_near_block()
    for (int k = 0; k < f.count; ++k) {
        const Structure<Dim>& s = f.structure[k];
        const double speed = magnitude(s.velocity);
        if (!(speed > 0)) continue;
        const Vec<double, Dim> middle = node_place(f, s, lowest, 2 - f.offset);
        if (surface_of_body(s, f.corners, middle).distance < reach + speed * window) return true;
    }
    return false;
}

/// Whether the node block at `position` is near none of the structures: its nodes do not feel them.
template <int Dim>
MORAINE_HD bool is_free_of_structures(const ContactField<Dim>& f, int origin, const Vec<std::int32_t, Dim>& position) {
    int lowest[Dim];
    for (int a = 0; a < Dim; ++a) lowest[a] = 4 * position[a] - origin;
    for (int k = 0; k < f.count; ++k)
        if (is_near(f, f.structure[k], lowest)) return false;
    return true;
}

}  // namespace moraine
