#pragma once
// Walls on the faces of the domain: what they do to nodes and to splines.
//
// Nodes: no-slip sets the velocity to zero, free-slip its normal part; friction does so while the
// wall is pressed, and takes at most mu |dv_n| from the tangential part (Coulomb on the impulse), less what pore water
// bears of dv_n (nodes/water_nodes.hpp).
//
// Splines: a stencil of three or four nodes reaches one ghost node behind a closed wall. The ghost
// follows by linear extrapolation, and what it is given goes to the two nodes it follows (the transpose):
//   v_-1 = 2 v_0 - v_1;     sums_0 += 2 sums_-1,  sums_1 -= sums_-1,  sums_-1 = 0
// Constants and straight lines stay exact, all weights in effect are >= 0 (quadratic: the hat function
// in the last half cell), v_0 = 0 holds the wall exactly, and it is local to one tile, so it is
// the same on any rank. docs/adr/0002 compares it with unconstrained ghosts. Only the affine momentum m (v + C (x_i -
// x_p)) must not be given to a ghost first: C would be taken at the wrong distance, and APIC gains energy at the wall
// (75 % in 100 periods of a bar). There the weights themselves are folded, w_0 += 2 w_-1, w_1 -= w_-1, before anything
// is given.

#include <cmath>
#include <cstddef>

#include "core/data/block.hpp"
#include "core/data/scene_choices.hpp"
#include "core/data/vec.hpp"

namespace moraine {

template <class Real, int Dim>
struct Walls {
    int plane[Dim][2];  ///< node index of the face: 0 and N
    WallKind kind[Dim][2];
    Real friction[Dim][2];
    bool fold[Dim][2];  ///< extrapolate the ghost node behind this face

    /// Applies the walls to a node's velocity. borne: what else than the soil bears of the impulse that stops it along
    /// each axis, and no friction sees; over m, in the direction of the axis [m/s].
    MORAINE_HD void constrain(const int* node, Vec<Real, Dim>& v, const Vec<Real, Dim>& borne = {}) const {
        for (int a = 0; a < Dim; ++a) {
            if (node[a] <= plane[a][0]) constrain_at(a, 0, borne[a], v);
            if (node[a] >= plane[a][1]) constrain_at(a, 1, -borne[a], v);
        }
    }

    /// A second velocity of a node, mapped from the particles after the forces (MUSL), stays at a wall with friction
    /// where the first was pressed against it, and sticks where that stuck: stresses follow a motion that the forces
    /// saw.
    MORAINE_HD void hold(const int* node, const Vec<Real, Dim>& first, Vec<Real, Dim>& v) const {
        for (int a = 0; a < Dim; ++a) {
            const bool lower = node[a] <= plane[a][0] && kind[a][0] == WallKind::friction;
            const bool upper = node[a] >= plane[a][1] && kind[a][1] == WallKind::friction;
            if (!(lower || upper) || first[a] != Real(0)) continue;
            bool stuck = true;
            for (int c = 0; c < Dim; ++c) stuck = stuck && first[c] == Real(0);
            for (int c = 0; c < Dim; ++c)
                if (c == a || stuck) v[c] = Real(0);
        }
    }

    /// Ghosts that a stencil of `width` nodes from `base` on reaches along axis a: bit 0 for the lower one, which is
    /// its first node, above it the place of the upper one, or 0. At most 3 bits.
    MORAINE_HD unsigned ghosts(int a, int base, int width) const {
        const int above = plane[a][1] + 1 - base;
        const unsigned upper = fold[a][1] && above < width ? unsigned(above) : 0;
        return (fold[a][0] && base < plane[a][0] ? 1u : 0u) | upper << 1;
    }

  private:
    MORAINE_HD void constrain_at(int a, int side, Real borne, Vec<Real, Dim>& v) const {
        const WallKind k = kind[a][side];
        if (k == WallKind::no_slip) {
            for (int c = 0; c < Dim; ++c) v[c] = Real(0);
        } else if (k == WallKind::free_slip) {
            v[a] = Real(0);
        } else if (k == WallKind::friction) {
            const Real inward = side == 0 ? v[a] : -v[a];
            if (inward < Real(0)) {
                const Real pressed = -inward - borne;
                v[a] = Real(0);
                slow_down(a, (pressed > Real(0) ? pressed : Real(0)) * friction[a][side], v);
            }
        }
    }

    /// Takes `most` [m/s] from the speed along the wall, or all of it.
    MORAINE_HD static void slow_down(int a, Real most, Vec<Real, Dim>& v) {
        using std::sqrt;
        Real square = Real(0);
        for (int c = 0; c < Dim; ++c)
            if (c != a) square += v[c] * v[c];
        const Real speed = sqrt(square);
        const Real keep = speed > most ? (speed - most) / speed : Real(0);
        for (int c = 0; c < Dim; ++c)
            if (c != a) v[c] *= keep;
    }
};

/// Folds the ghosts' weights of one axis: bit 0 for the lower one, above it the place of the upper one, or 0
/// (Walls::ghosts).
template <int Width, class Real>
MORAINE_HD void fold_weights(unsigned ghosts, Real* w, Real* dw) {
    if (ghosts & 1) {
        w[1] += Real(2) * w[0], dw[1] += Real(2) * dw[0];
        w[2] -= w[0], dw[2] -= dw[0];
        w[0] = dw[0] = Real(0);
    }
    for (int g = 2; g < Width; ++g)
        if (int(ghosts >> 1) == g) {
            w[g - 1] += Real(2) * w[g], dw[g - 1] += Real(2) * dw[g];
            w[g - 2] -= w[g], dw[g - 2] -= dw[g];
            w[g] = dw[g] = Real(0);
        }
}

/// Calls f(at, step) for the ghost nodes behind closed walls in a tile of `side` nodes per axis that begins at node
/// base[], axis after axis: `at` is the ghost's place in the tile, at + step its first inner neighbour.
template <class Real, int Dim, class F>
MORAINE_HD void each_ghost(const Walls<Real, Dim>& walls, const int* base, int side, const F& f) {
    int stride = 1;
    for (int a = 0; a < Dim; ++a, stride *= side)
        for (int s = 0; s < 2; ++s) {
            const int inward = s == 0 ? 1 : -1;
            const int ghost = walls.plane[a][s] - inward - base[a];
            const int second = ghost + 2 * inward;
            if (!walls.fold[a][s] || ghost < 0 || ghost >= side || second < 0 || second >= side) continue;
            for (int rest = 0; rest < power<Dim>(side) / side; ++rest) {
                const int low = rest % stride;
                f((rest - low) * side + low + ghost * stride, inward * stride);
            }
        }
}

}  // namespace moraine
