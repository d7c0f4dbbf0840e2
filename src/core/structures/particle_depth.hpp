#pragma once
// How deep particles may stand in a structure.
//
//   x_p = x_p + (-t - d(x_p)) n    where  -1 < d(x_p) < -t,  t = 0.1    [cells], within the particle's cell
//
// Contact holds nodes (core/structures/contact.hpp), and the last node that is held stands up to half a cell inside the
// surface. Soil that slides or yields is let in there, a little with each node that it passes, until its lowest row
// lies on that node. Holding nodes further out where this happens kept layers out, but made a T-bar's load 20 % too
// high, as the clay ahead of it was caught. So the place alone is corrected, as in position-based dynamics (Müller et
// al. 2007) but with no feedback: no velocity, no stress and no force on the structure changes, and soil that goes in
// no deeper than t notices nothing. The soil's weight may still squeeze the rows of its lowest cell together.
//
// A particle stays in its cell, as the lists of the step are made, and in the domain, whose ends lie within cells: one
// that the structure pushes to the end of its cell walks on with its own velocity. Soil that stands a cell deep was put
// there; in the ground it ends the run.

#include "core/particles/place_step.hpp"
#include "core/structures/particle_gaps.hpp"

namespace moraine {

inline constexpr double deepest_place = 0.1;  ///< t [cells]
inline constexpr double put_inside = 1.0;     ///< depth from which particles are left where they are [cells]

/// What is left of a cell between the ends of the domain along an axis, in parts of one_cell: nobody is put nearer to
/// an end than a motion may bring it.
template <class Real>
struct CellSpan {
    Coordinate<Real> lowest, highest;
};
template <class Real, int Dim>
MORAINE_HD CellSpan<Real> span_in_cell(const DomainEnds<Real, Dim>& ends, int a, std::int32_t cell) {
    constexpr Coordinate<Real> last = one_cell<Real> - 1;
    const auto at = [](Real fraction) { return static_cast<Coordinate<Real>>(fraction * Real(one_cell<Real>)); };
    CellSpan<Real> span{0, last};
    if (cell == ends.cell[a][0]) span.lowest = at(ends.fraction[a][0] + least_height<Real>);
    if (cell == ends.cell[a][1] && ends.fraction[a][1] > least_height<Real>)
        span.highest = at(ends.fraction[a][1] - least_height<Real>);
    return span;
}

/// Moves a particle of the block at `position` that is too deep. Returns whether it was. `buried`: whether it stands so
/// deep in the ground that it is left where it is.
template <class Real, int Dim, bool Turns = may_turn>
MORAINE_HD bool limit_depth(const ContactField<Dim>& f, const Structure<Dim>& s, const DomainEnds<Real, Dim>& ends,
                            const Vec<std::int32_t, Dim>& position, Vec<Coordinate<Real>, Dim>& u,
                            bool* buried = nullptr, const GroundBound<Dim>* bound = nullptr) {
    Vec<double, Dim> x;
    for (int a = 0; a < Dim; ++a) x[a] = f.origin[a] + f.cell * (local_of<Real>(position[a], u[a]) - f.offset);
    x = image_near(f, s, x);
    if (bound && bound->is_over(x)) return false;
    // most soil is above the ground: that takes one look at its height
    if (s.shape == StructureShape::ground && distance_bound(s, f.corners, x) > 0) return false;
    const Surface<Dim> at = surface<Turns>(s, f.corners, x);
    const double depth = -at.distance / f.cell;
    if (buried && s.shape == StructureShape::ground && depth >= put_inside) *buried = true;
    if (!(depth > deepest_place && depth < put_inside)) return false;
    for (int a = 0; a < Dim; ++a) {
        const CellSpan<Real> span = span_in_cell(ends, a, 4 * position[a] + cell_of<Real>(u[a]));
        const Coordinate<Real> within = u[a] & (one_cell<Real> - 1);
        const double to = double(within) + (depth - deepest_place) * at.normal[a] * double(one_cell<Real>);
        u[a] +=
            (to < double(span.highest) ? (to > double(span.lowest) ? static_cast<Coordinate<Real>>(to) : span.lowest)
                                       : span.highest) -
            within;
    }
    return true;
}

/// Pair k and those behind it of the same block, if k is the block's first: calls f(structure) for each in turn.
template <class F>
MORAINE_HD void each_of_block(const ContactPair* pairs, int count, int k, const F& f) {
    const std::int32_t block = pairs[k].block;
    if (k > 0 && pairs[k - 1].block == block) return;
    for (; k < count && pairs[k].block == block; ++k) f(pairs[k].structure);
}

/// Of the particles that are buried, the one with the lowest id.
template <int Dim>
struct Buried {
    std::uint64_t id = ~std::uint64_t(0);
    Vec<double, Dim> x{};
};

/// The loop of the host, over the pairs.
template <class Real, int Dim>
struct LimitDepth {
    Vec<Coordinate<Real>, Dim>* place;
    DomainEnds<Real, Dim> ends;
    BlockTable<Dim> table;
    ListView<Dim> list;
    ContactField<Dim> field;
    const ContactPair* pairs;
    int count;
    const std::uint64_t* id = nullptr;
    Buried<Dim>* buried = nullptr;
    const GroundBound<Dim>* bounds = nullptr;  ///< by block; null: there is no ground

    void operator()(int k) const {
        const std::int32_t block = pairs[k].block;
        each_of_block(pairs, count, k, [&](int structure) {
            const Structure<Dim>& felt = field.structure[structure];
            const GroundBound<Dim>* bound = bounds && felt.shape == StructureShape::ground ? bounds + block : nullptr;
            for (std::uint32_t i = list.first[block]; i < list.first[block + 1]; ++i) {
                bool deep = false;
                const std::uint32_t s = list.slot[i];
                limit_depth<Real, Dim>(field, felt, ends, table.position[block], place[s], &deep, bound);
                if (deep && buried) note(table.position[block], s);
            }
        });
    }

    void note(const Vec<std::int32_t, Dim>& block, std::uint32_t s) const {
#pragma omp critical(moraine_buried)
        if (id[s] < buried->id) {
            buried->id = id[s];
            for (int a = 0; a < Dim; ++a)
                buried->x[a] = field.origin[a] + field.cell * (local_of<Real>(block[a], place[s][a]) - field.offset);
        }
    }
};

}  // namespace moraine
