#pragma once
// What an element does to the nodes of its cell in a (sub)step (surface_elements.hpp), and what slaves are given: for
// hosts and devices alike.
//
// Nodes says what an element's nodes hold, by their place `at` in the tile, from the cell's first node on: values(at)
// are (v', ..., m), null where a node holds no soil; shares(at) is W_i; sum<N>(f) is the sum of N numbers over them, of
// which f(i, at, sum) adds what node i of the element gives.

#include "core/grid/stencil.hpp"
#include "core/structures/gap_tiles.hpp"
#include "core/structures/particle_gaps.hpp"
#include "core/surfaces/surface_elements.hpp"

namespace moraine {

/// Sums over nodes, one after the other.
template <int Dim>
struct NodesInTurn {
    template <int N, class F>
    MORAINE_HD static Vec<double, N> sum(const F& f) {
        Vec<double, N> all = zero_vec<double, N>();
        int i = 0;
        each_node<Dim, 3>([&](int at, int, int, int) { f(i++, at, all); });
        return all;
    }
};

/// Of soil over an element [m/s]: away from the structure, and along it.
template <int Dim>
struct ElementSlip {
    double leaves;
    Vec<double, Dim> along;
};

/// What an element gives [kg m/s].
template <int Dim>
struct ElementImpulse {
    Vec<double, Dim> given;    ///< to the structure, if all nodes hold soil
    Vec<double, Dim> follows;  ///< the mass that it moves with the structure, by axis [kg]
    double along;              ///< what it takes along the surface, over the slip [kg]
};

/// The gap of the soil over an element, and whether it acts in this step. gap: of the node in the middle of its cell;
/// face: h^(d-1) [m^(d-1)].
template <int Dim>
MORAINE_HD void take_gap(const NodeGap& gap, double face, InterfaceLaw law, SurfaceElement<Dim>& e) {
    e.gap = gap.is_none() ? 1e9 : gap.cells();
    const double faces = gap.faces() * face / e.area;
    e.covered = law == InterfaceLaw::undrained || faces < 1 ? faces : 1;  // shares of strength may be above 1
    e.touches = e.gap < touches_below || (acts_where_it_touches(law) && e.covered > 0);
}

/// Lane q of what an element gives to W_i of node i of its cell, as SurfaceShares has them: by |w_ie|, as a second
/// master has less than nothing, and a row sum bounds nothing where its terms cancel.
template <int Dim>
MORAINE_HD double share_lane(const SurfaceElement<Dim>& e, int i, int q) {
    if (q == SurfaceShares<Dim>::count) return e.area * e.own[i];
    using std::fabs;
    return e.area * fabs(e.weight[i]) * tensor_lane(e.normal, q);
}

/// W_i from the lanes of a node's sums.
template <int Dim, class Real>
MORAINE_HD SurfaceShares<Dim> shares_of(const Real* from) {
    SurfaceShares<Dim> s;
    for (int q = 0; q < SurfaceShares<Dim>::count; ++q) s.across[q] = double(from[sum_lane<Dim>(q)]);
    s.own = double(from[sum_lane<Dim>(SurfaceShares<Dim>::count)]);
    return s;
}

template <int Dim, class Nodes>
MORAINE_HD ElementSlip<Dim> slip_over(const SurfaceElement<Dim>& e, const Structure<Dim>& s, const Nodes& nodes) {
    const Vec<double, Dim> of_structure = velocity_at(s, e.place);
    const Vec<double, Dim> slip = nodes.template sum<Dim>([&](int i, int at, Vec<double, Dim>& sum) {
        const auto* v = nodes.values(at);
        for (int a = 0; v && a < Dim; ++a) sum[a] += e.weight[i] * (double(v[a]) - of_structure[a]);
    });
    const double leaves = dot(slip, e.normal);
    return {leaves, slip - leaves * e.normal};
}

/// R_e, of what share(W_i) takes of a node's W, by |w_ie|.
template <int Dim, class Nodes, class Share>
MORAINE_HD double row_over(const SurfaceElement<Dim>& e, const Nodes& nodes, const Share& share) {
    using std::fabs;
    return nodes.template sum<1>([&](int i, int at, Vec<double, 1>& row) {
        const auto* v = nodes.values(at);
        if (v && e.weight[i] != 0) row[0] += fabs(e.weight[i]) * share(nodes.shares(at)) / double(v[quad - 1]);
    })[0];
}

/// R_e across the surface, which a step leaves as it is, and along a way in it.
struct RowSums {
    template <int Dim, class Nodes>
    MORAINE_HD double across(const SurfaceElement<Dim>& e, const Nodes& nodes) const {
        return row_over(e, nodes, [&](const SurfaceShares<Dim>& shares) { return shares.along_normal(e.normal); });
    }
    template <int Dim, class Nodes>
    MORAINE_HD double along(const SurfaceElement<Dim>& e, const Nodes& nodes, const Vec<double, Dim>& way) const {
        return row_over(e, nodes,
                        [&](const SurfaceShares<Dim>& shares) { return shares.all() - shares.along_normal(way); });
    }
};

/// l_n: what holds the soil out of the structure, per area. cell: h [m]; follows: as ElementImpulse's, of a first
/// sweep.
template <int Dim, class Nodes, class Rows>
MORAINE_HD double push_off(const SurfaceElement<Dim>& e, InterfaceLaw law, const ElementSlip<Dim>& slip, double cell,
                           const ContactTime& time, const Nodes& nodes, const Rows& rows, Vec<double, Dim>& follows) {
    const double too_fast = -(e.gap > 0 ? e.gap * cell : 0.0) / time.closing - slip.leaves;
    if (!(too_fast > 0)) return 0;
    const double row = rows.across(e, nodes);
    if (!(row > 0)) return 0;
    if (time.is_second()) return (1 + comes_back(e.gap)) * too_fast / row;
    for (int a = 0; a < Dim; ++a)
        follows[a] = e.area / row * (law == InterfaceLaw::rough ? 1 : e.normal[a] * e.normal[a]);
    return too_fast / row;
}

/// l_t t_e: what the law takes of the slip, per area.
template <int Dim, class Nodes, class Rows>
MORAINE_HD Vec<double, Dim> slow_along(const SurfaceElement<Dim>& e, InterfaceLaw law, const ElementSlip<Dim>& slip,
                                       const Pressing& by, double dt, const Nodes& nodes, const Rows& rows) {
    const double speed = magnitude(slip.along);
    if (law == InterfaceLaw::smooth || !(speed > 0)) return zero_vec<double, Dim>();
    const Vec<double, Dim> along = (1 / speed) * slip.along;
    const double row = rows.along(e, nodes, along);
    if (!(row > 0)) return zero_vec<double, Dim>();
    const double most = most_along(law, e, by, slip.leaves, speed, row, dt);
    const double taken = speed / row < most ? speed / row : most;
    return (taken > 0 ? taken : 0.0) * along;
}

/// pressure: of the cell on the surface, N_e [Pa]; cell: h [m]; rows: as RowSums, which may have been kept.
template <int Dim, class Nodes, class Rows = RowSums>
MORAINE_HD ElementImpulse<Dim> act_on_element(const SurfaceElement<Dim>& e, const Structure<Dim>& s,
                                              const ContactTime& time, double pressure, double cell, const Nodes& nodes,
                                              const Rows& rows = {}) {
    ElementImpulse<Dim> impulse{zero_vec<double, Dim>(), zero_vec<double, Dim>(), 0};
    const ElementSlip<Dim> slip = slip_over(e, s, nodes);
    const double pushed = push_off(e, s.law, slip, cell, time, nodes, rows, impulse.follows);
    const Pressing by{pushed, pressure > 0 ? pressure * time.dt : 0.0};
    const Vec<double, Dim> taken = slow_along(e, s.law, slip, by, time.dt, nodes, rows);
    impulse.given = e.area * (taken - pushed * e.normal);
    if (const double speed = magnitude(slip.along); speed > 0 && !time.is_second())
        impulse.along = e.area * magnitude(taken) / speed;
    return impulse;
}

/// The values that a structure's sums get for an impulse [kg m/s] at a place [m]. follows: as ElementImpulse's.
template <int Dim>
MORAINE_HD void structure_values(const ContactField<Dim>& field, const Structure<Dim>& s,
                                 const Vec<double, Dim>& impulse, const Vec<double, Dim>& place,
                                 const Vec<double, Dim>& follows, double (&all)[StructureSums<Dim>::count]) {
    const Vec<double, Dim> beside = image_near(field, s, place);
    const Vec<double, moments<Dim>> moment = moment_of(beside - s.at, impulse);
    for (int a = 0; a < Dim; ++a) all[a] = impulse[a], all[StructureSums<Dim>::first_mass + a] = follows[a];
    for (int a = 0; a < moments<Dim>; ++a) all[Dim + a] = moment[a];
    all[StructureSums<Dim>::work] = dot(impulse, velocity_at(s, beside));
}

/// And of a couple besides [kg m2/s].
template <int Dim>
MORAINE_HD void add_couple(const Structure<Dim>& s, const Vec<double, moments<Dim>>& couple,
                           double (&all)[StructureSums<Dim>::count]) {
    for (int a = 0; a < moments<Dim>; ++a) all[Dim + a] += couple[a];
    all[StructureSums<Dim>::work] += dot(couple, s.spin);
}

/// Of an element on a structure that turns: the middle of its nodes with soil, by their weights. There it meets the
/// soil that it acts on, so that what nodes lose in moments is what it gets, and its work theirs. centre: the node in
/// the middle of its cell, beside the structure [m]; cell: h [m].
template <int Dim, class Nodes>
MORAINE_HD Vec<double, Dim> middle_of(const SurfaceElement<Dim>& e, const Vec<double, Dim>& centre, double cell,
                                      const Nodes& nodes) {
    const Vec<double, Dim + 1> all = nodes.template sum<Dim + 1>([&](int i, int at, Vec<double, Dim + 1>& sum) {
        const double w = nodes.values(at) ? e.weight[i] : 0.0;
        for (int a = 0, rest = i; a < Dim; ++a, rest /= 3) sum[a] += w * cell * (rest % 3 - 1);
        sum[Dim] += w;
    });
    if (!(all[Dim] > 0)) return e.place;
    Vec<double, Dim> middle = centre;
    for (int a = 0; a < Dim; ++a) middle[a] += all[a] / all[Dim];
    return middle;
}

/// What of the soil at an element follows a structure that turns.
template <int Dim>
MORAINE_HD Following<Dim> following_of(const SurfaceElement<Dim>& e, const Structure<Dim>& s,
                                       const ElementImpulse<Dim>& impulse) {
    double across = 0;
    for (int a = 0; a < Dim; ++a) across += impulse.follows[a];
    if (s.law == InterfaceLaw::rough) across /= Dim;
    return {across, impulse.along, e.normal, e.place - s.at};
}

/// Whether elements touch a slave, and all three nodes hold soil. own, one, two: their values, null without soil.
template <int Dim, class Real>
MORAINE_HD bool slave_acts(const Real* own, const Real* one, const Real* two, const SurfaceShares<Dim>& shares) {
    if (!own || !one || !two || !(shares.own > 0)) return false;
    return !(double(own[quad - 1]) > 0.5 * double(one[quad - 1]));
}

/// The impulse that closes f c . v = f (v_o - 2 v_1 + v_2): c of it for each node [kg m/s]. By the row sum of the
/// slaves' answer to each other, sum_i |c_i| (|c_i| + sum over others of f |c_i| (C / C_own)^(1/2)) / m_i, C: what a
/// slave can hold: where surfaces bend many follow one node, and by their own answers alone they gave energy.
template <int Dim, class Real>
MORAINE_HD Vec<double, Dim> slave_impulse(const SlaveNode<Dim>& slave, InterfaceLaw law, const Real* own,
                                          const Real* one, const Real* two) {
    const SurfaceNode<Dim>& n = slave.surface;
    const double row = (1 + slave.beside[0]) / double(own[quad - 1]) +
                       (4 + 2 * slave.beside[1]) / double(one[quad - 1]) +
                       (1 + slave.beside[2]) / double(two[quad - 1]);
    Vec<double, Dim> off;
    for (int a = 0; a < Dim; ++a) off[a] = 2 * double(one[a]) - double(two[a]) - double(own[a]);
    if (law == InterfaceLaw::smooth) off = dot(off, n.normal) * n.normal;
    return (n.slaved / row) * off;
}

/// What a particle tells the elements around it. A particle is near to an element whose middle is within its reach
/// along the surface, and lies on those within 1 h, on each by its area times 1 - s / h: all of the particle's area,
/// and no more. ring: of the block; near: those of it that are elements and beside the particle's cell; x: from the
/// block's first cell [cells]; tell(n, gap): of the ring's element n.
template <int Dim, class Tell>
MORAINE_HD void tell_ring(const RingElement<Dim>* ring, const std::uint16_t* near, std::uint32_t count, int structure,
                          const Vec<double, Dim>& x, const ParticleGap& own, const Tell& tell) {
    constexpr int most = power<Dim>(3);
    int at[most], told = 0;
    double share[most], all = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        const int n = near[i];
        const RingElement<Dim>& e = ring[n];
        if (e.structure != structure) continue;
        const Vec<double, Dim> way = e.place - x;
        const Vec<double, Dim> off = way - dot(way, e.normal) * e.normal;
        const double square = dot(off, off);
        if (!(square < 1)) continue;  // most, who want no root
        using std::sqrt;
        const double along = sqrt(square);
        if (along < e.reach) tell(n, NodeGap{own.gap, 0});
        if (!(along < 1)) continue;
        share[told] = e.area * (1 - along);
        all += share[told];
        at[told++] = n;
    }
    for (int q = 0; q < told && own.area > 0; ++q)
        tell(at[q], NodeGap{NodeGap::none, NodeGap::fixed_area(own.area * share[q] / all)});
}

}  // namespace moraine
