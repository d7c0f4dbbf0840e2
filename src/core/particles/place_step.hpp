#pragma once
// One particle's motion: its new place, the cell and block where it is to be binned next, and whether it left the
// domain.
//
//   x <- x + dt v,  in fixed point: the cell is the top bits, a change of block is a carry (core/data/position.hpp)

#include <cstdint>

#include "core/data/block.hpp"
#include "core/data/position.hpp"
#include "core/particles/stress.hpp"

namespace moraine {

/// Faces of the domain in binning coordinates, where a particle leaves it.
template <class Real, int Dim>
struct DomainEnds {
    std::int32_t cell[Dim][2];
    Real fraction[Dim][2];
    bool open[Dim][2];
    bool still[Dim][2];  ///< a folded wall (Walls::fold) of a method that limits light nodes
};

/// A particle's next cell and the code of its next block's offset, in one number.
constexpr MORAINE_HD std::uint16_t encode_move(int code, int cell) {
    return static_cast<std::uint16_t>(code * 64 + cell);
}
constexpr MORAINE_HD int move_code(std::uint16_t m) {
    return m >> 6;
}
constexpr MORAINE_HD int move_cell(std::uint16_t m) {
    return m & 63;
}

/// Whether a particle that moves so leaves the cell `from` of its block.
template <int Dim>
constexpr MORAINE_HD bool changes_cell(std::uint16_t move, int from) {
    return move != encode_move(Block<Dim>::centre, from);
}

/// What a motion tells besides the new place.
template <class Real>
struct PlaceStep {
    std::uint16_t move;    ///< encode_move of the next block's offset and cell; Block::gone: out by an open wall
    std::uint32_t faults;  ///< bits of Fault
    Real moved;            ///< largest displacement along an axis [cells]
};

/// A place exactly on an upper face where that is the edge of a binning cell (linear, cubic) is binned below it: the
/// cell above has a node beyond the domain, which has no mass, and yet a hat's full slope. Returns the change of block.
template <class Real>
MORAINE_HD int bin_below(std::int32_t end_cell, Real end_fraction, std::int32_t block, Coordinate<Real>& u) {
    if (end_fraction != Real(0) || 4 * block + cell_of<Real>(u) != end_cell || (u & (one_cell<Real> - 1)) != 0)
        return 0;
    return u-- == 0 ? -1 : 0;
}

enum class End { none, open, closed };

/// The end of the domain that a place in block + carry has passed.
template <class Real, int Dim>
MORAINE_HD End end_passed(const DomainEnds<Real, Dim>& ends, const Vec<std::int32_t, Dim>& block, const int* carry,
                          const Vec<Coordinate<Real>, Dim>& u) {
    End passed = End::none;
    for (int a = 0; a < Dim; ++a) {
        const std::int32_t cell = 4 * (block[a] + carry[a]) + cell_of<Real>(u[a]);
        const Real f = fraction_of<Real>(u[a]);
        const bool below = cell < ends.cell[a][0] || (cell == ends.cell[a][0] && f < ends.fraction[a][0]);
        const bool above = cell > ends.cell[a][1] || (cell == ends.cell[a][1] && f > ends.fraction[a][1]);
        if (below || above) {
            if (!ends.open[a][below ? 0 : 1])
                passed = End::closed;
            else if (passed == End::none)
                passed = End::open;
        }
    }
    return passed;
}

/// Nearest that a motion brings a particle to a folded wall [cells]. The weight of the first node inside is its height:
/// of less than that a node's mass is rounding, or below the cutoff, and the force on it is lost.
template <class Real>
inline constexpr Real least_height = Real(1) / Real(sizeof(Real) == 8 ? 1 << 20 : 1 << 12);

/// How far a place in block + carry is beyond a face [cells].
template <class Real, int Dim>
MORAINE_HD Real beyond(const DomainEnds<Real, Dim>& ends, int a, int s, std::int32_t block, Coordinate<Real> u) {
    const Real from =
        Real(4 * block + cell_of<Real>(u) - ends.cell[a][s]) + (fraction_of<Real>(u) - ends.fraction[a][s]);
    return s == 0 ? -from : from;
}

/// Whether a place is nearer to a folded wall than a motion may bring it.
template <class Real, int Dim>
MORAINE_HD bool is_too_near(const DomainEnds<Real, Dim>& ends, const Vec<std::int32_t, Dim>& block, const int* carry,
                            const Vec<Coordinate<Real>, Dim>& u) {
    bool near = false;
    for (int a = 0; a < Dim; ++a)
        for (int s = 0; s < 2; ++s)
            near = near || (ends.still[a][s] && beyond(ends, a, s, block[a] + carry[a], u[a]) > -least_height<Real>);
    return near;
}

/// Takes a particle that would cross a folded wall half of its way there, from its place before the step, and none
/// nearer than the least height. The velocity across such a wall falls to zero on it, so no motion crosses it: a step
/// does where a node next to the wall hardly holds mass and is fast. Returns whether there was such a wall. u, carry:
/// after the step.
template <class Real, int Dim>
MORAINE_HD_RARE bool stop_at_walls(const DomainEnds<Real, Dim>& ends, const Vec<std::int32_t, Dim>& block,
                                   Vec<Coordinate<Real>, Dim> old, Vec<Coordinate<Real>, Dim>& u, int (&carry)[Dim]) {
    bool stopped = false;
    for (int a = 0; a < Dim; ++a)
        for (int s = 0; s < 2; ++s) {
            if (!ends.still[a][s]) continue;
            const Real past = beyond(ends, a, s, block[a] + carry[a], u[a]);
            const Real left = -beyond(ends, a, s, block[a], old[a]);
            if (!(past > -least_height<Real>) || -past >= left) continue;
            Real way = left > least_height<Real> ? left - least_height<Real> : Real(0);
            if (past > Real(0) && Real(0.5) * left < way) way = Real(0.5) * left;
            u[a] = old[a];
            carry[a] = advance<Real>(u[a], s == 0 ? -way : way);
            carry[a] += bin_below(ends.cell[a][1], ends.fraction[a][1], block[a] + carry[a], u[a]);
            stopped = true;
        }
    return stopped;
}

/// Moves u by dt v. One that would leave a closed domain stays where it was: the run ends, and the last state must
/// be whole; but for walls that stop_at_walls() knows, if it Stops there. `border`: the block may touch an end.
/// velocity[a]: [m/s].
template <bool Stops = true, class Real, int Dim, class Velocity>
MORAINE_HD PlaceStep<Real> advance_place(const DomainEnds<Real, Dim>& ends, const Vec<std::int32_t, Dim>& block,
                                         bool border, const Velocity& velocity, Real dt, Real inverse_cell,
                                         Vec<Coordinate<Real>, Dim>& u) {
    const Vec<Coordinate<Real>, Dim> old = u;
    PlaceStep<Real> step{0, fault_none, Real(0)};
    int code = 0;
    int cell = 0;
    int carry[Dim];
    for (int a = Dim - 1; a >= 0; --a) {
        Real move = dt * velocity[a] * inverse_cell;
        const Real size = move < Real(0) ? -move : move;
        if (!(size < Real(1))) {
            step.faults |= size >= Real(1) ? fault_far : fault_nan;
            move = Real(0);
        } else if (size > step.moved) {
            step.moved = size;
        }
        carry[a] = advance<Real>(u[a], move);
        if (border) carry[a] += bin_below(ends.cell[a][1], ends.fraction[a][1], block[a] + carry[a], u[a]);
        code = 3 * code + carry[a] + 1;
        cell = 4 * cell + cell_of<Real>(u[a]);
    }
    End end = border ? end_passed(ends, block, carry, u) : End::none;
    if (end == End::closed || (Stops && border && is_too_near(ends, block, carry, u))) {
        bool stays = end == End::closed;
        if constexpr (Stops) {
            Vec<Coordinate<Real>, Dim> at = u;
            int carried[Dim];
            for (int a = 0; a < Dim; ++a) carried[a] = carry[a];
            if (stop_at_walls(ends, block, old, at, carried)) {
                end = end_passed(ends, block, carried, at);
                stays = end == End::closed;
                u = at;
                for (int a = 0; a < Dim; ++a) carry[a] = carried[a];
            }
        }
        if (stays) step.faults |= fault_left, u = old;
        code = stays ? Block<Dim>::centre : 0;
        cell = 0;
        for (int a = Dim - 1; a >= 0; --a) {
            if (!stays) code = 3 * code + carry[a] + 1;
            cell = 4 * cell + cell_of<Real>(u[a]);
        }
    }
    if (end == End::open) code = Block<Dim>::gone;
    step.move = encode_move(code, cell);
    return step;
}

}  // namespace moraine
