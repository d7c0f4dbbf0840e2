#pragma once
// How cells beside surfaces are found and what they do (open_faces.hpp), a cell at a time, for hosts and devices alike.
//
// Nodes says what a cell's nodes hold, by their place `at` in the tile, from the cell's first node on: values(at) are
// (v', ..., m), null where a node holds no soil; filling(at) is v_i / h^d; distance(at) [cells] and capacity(at) are
// those of SurfaceNode.

#include "core/surfaces/cut_cell.hpp"
#include "core/surfaces/open_faces.hpp"

namespace moraine {

/// Lanes of what a child tells its root, what cells tell holes beside them, and what the root tells back.
enum ChildLane { child_pressure, child_particles, child_bulk, child_volume, child_weight, child_full_weight };
enum HoleLane { hole_volume, hole_pressure, hole_bulk };
enum RootLane { root_pressure, root_bulk, root_volume, root_source, root_soft };

/// A cell of a block near a surface, by place alone.
template <int Dim>
struct SurfaceCell {
    CellPart part;
    bool near;                 ///< it is one of ours
    bool shares;               ///< with the cell at `root` from here
    const CutFaces<Dim>* cut;  ///< null: it is whole
    int root[Dim];
    int structure;  ///< whose surface it is at
    double volume;  ///< open [cells]
};

/// |G_ic| [m^(d-1)].
template <class Real, int Dim>
MORAINE_HD Real size_of(const CellNode<Real, Dim>& node) {
    using std::sqrt;
    Real square = Real(0);
    for (int a = 0; a < Dim; ++a) square += node.gradient[a] * node.gradient[a];
    return sqrt(square);
}

/// What the cells of a run share.
template <class Real, int Dim>
struct OpenGrid {
    Walls<Real, Dim> walls;
    NodeCapacity<Real, Dim> capacity;
    Real inverse_cell;                           ///< 1 / h [1/m]
    double face;                                 ///< h^(d-1) [m^(d-1)]
    double volume;                               ///< h^d [m^d]
    const CellNode<Real, Dim>* whole = nullptr;  ///< [3^d]: F_ic away from cuts and walls; null: not kept

    /// Of the cell around a node.
    MORAINE_HD void find_basis(const Vec<std::int32_t, Dim>& node, CellBasis<Real> (&basis)[Dim]) const {
        for (int a = 0; a < Dim; ++a) basis[a] = cell_basis<Real>(walls.ghosts(a, node[a] - 1, 3));
    }
    /// F_ic [m^(d-1)] of a cell by its node; cut: null where it is whole.
    MORAINE_HD void find_faces(const Vec<std::int32_t, Dim>& node, const CutFaces<Dim>* cut,
                               CellNode<Real, Dim>* to) const {
        const Real scale = static_cast<Real>(face);
        for (int i = 0; cut && i < power<Dim>(3); ++i)
            for (int a = 0; a < Dim; ++a) to[i].gradient[a] = scale * static_cast<Real>(cut->face[i][a]);
        if (cut) return;
        const bool kept = whole && !is_at_wall(node);
        for (int i = 0; kept && i < power<Dim>(3); ++i) to[i] = whole[i];
        if (kept) return;
        Real x[Dim][cell_powers];
        CellBasis<Real> basis[Dim];
        find_basis(node, basis);
        for (int a = 0; a < Dim; ++a) full_moments(capacity, a, node[a], x[a]);
        find_faces(basis, x, to);
    }
    /// What `whole` shall have.
    void find_whole(CellNode<Real, Dim>* to) const {
        Real x[Dim][cell_powers];
        CellBasis<Real> basis[Dim];
        for (int a = 0; a < Dim; ++a) {
            basis[a] = cell_basis<Real>(0);
            x[a][0] = Real(1), x[a][1] = Real(0), x[a][2] = Real(1.0 / 12);
        }
        find_faces(basis, x, to);
    }

  private:
    MORAINE_HD bool is_at_wall(const Vec<std::int32_t, Dim>& node) const {
        bool at_wall = false;
        for (int a = 0; a < Dim; ++a) {
            at_wall = at_wall || walls.ghosts(a, node[a] - 1, 3) != 0;
            for (int s = 0; s < 2; ++s) at_wall = at_wall || node[a] == capacity.plane[a][s];
        }
        return at_wall;
    }
    MORAINE_HD void find_faces(const CellBasis<Real> (&basis)[Dim], const Real (*x)[cell_powers],
                               CellNode<Real, Dim>* to) const {
        CellMoments<Real, Dim> moments;
        moments.clear();
        moments.add_product(static_cast<Real>(volume), x);
        all_cell_nodes(moments, basis, inverse_cell, to);
    }
};

/// x.
template <class Real, int Dim, class Nodes>
MORAINE_HD Real share_of_cell(const SurfaceCell<Dim>& place, const Nodes& nodes) {
    const bool cut = place.cut != nullptr;
    double least = 1e9, soil = 0, space = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const double capacity = nodes.capacity(at);
        if (!(capacity > 0)) return;
        const double filling = nodes.filling(at);
        if (cut) soil += filling, space += capacity;
        if (!cut && nodes.distance(at) >= 1 && capacity > 0.1 && filling / capacity < least) least = filling / capacity;
    });
    if (cut) least = space > 0 ? soil / space : 0;
    return share_of_integral(static_cast<Real>(least < 1e8 ? least : 0));
}

/// G_ic, S_c and V_c of a cell whose `share` and `particles` are known.
template <class Real, int Dim, class Nodes>
MORAINE_HD void make_rows(const OpenGrid<Real, Dim>& grid, const SurfaceCell<Dim>& place,
                          const Vec<std::int32_t, Dim>& node, const CellMoments<Real, Dim>& moments, const Nodes& nodes,
                          OpenCell<Real, Dim>& cell) {
    CellBasis<Real> basis[Dim];
    grid.find_basis(node, basis);
    if (cell.share < Real(1))
        all_cell_nodes(moments, basis, grid.inverse_cell, cell.factor);
    else
        for (CellNode<Real, Dim>& of : cell.factor) of = {};
    CellNode<Real, Dim> face[OpenCell<Real, Dim>::nodes]{};
    if (cell.share > Real(0)) grid.find_faces(node, place.cut, face);
    Real share[OpenCell<Real, Dim>::nodes];
    bool light = false;
    int n = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const double capacity = nodes.capacity(at);
        const double of_row = node_share(nodes.distance(at), capacity, nodes.filling(at));
        share[n++] = nodes.values(at) ? static_cast<Real>(of_row) : Real(-1);
        light = light || capacity < light_capacity;
    });
    const Real scale = static_cast<Real>(grid.face);
    open_rows(
        static_cast<Real>(place.volume * grid.volume), [&](int i, int a) { return face[i].gradient[a]; },
        [&](int i, int a) { return place.cut ? scale * static_cast<Real>(place.cut->bed[i][a]) : Real(0); },
        [&](int i) { return share[i]; }, cell);
    cell.whole = !place.cut && cell.share == Real(1) && !light;
}

/// tr(L L).
template <class Real, int Dim, class Nodes>
MORAINE_HD Real source_of(const OpenCell<Real, Dim>& cell, const Nodes& nodes) {
    Mat<Real, Dim> L = zero_mat<Real, Dim>();
    int n = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const CellNode<Real, Dim>& g = cell.factor[n++];
        const Real* v = nodes.values(at);
        if (!v) return;
        for (int b = 0; b < Dim; ++b)
            for (int a = 0; a < Dim; ++a) L(a, b) += g.gradient[b] * v[a];
    });
    Real source = Real(0);
    for (int a = 0; a < Dim; ++a)
        for (int b = 0; b < Dim; ++b) source += L(a, b) * L(b, a);
    return source / (cell.state.volume * cell.state.volume);
}

/// M_i of a node among full cells [cells^(d-1)].
template <int Dim>
inline constexpr double full_push = Dim == 2 ? 1.8047 : 2.4686;

/// R_c. push(at): M_i of the cells beside surfaces, to which all belong that have a node that surfaces leave light. Of
/// other nodes' cells some do not: those nodes have at least what they have among full cells, by their filling.
template <class Real, int Dim, class Nodes, class Push>
MORAINE_HD void weigh_open_cell(const OpenGrid<Real, Dim>& grid, const Nodes& nodes, const Push& push,
                                OpenCell<Real, Dim>& cell) {
    const Real full = Real(full_push<Dim>) * static_cast<Real>(grid.face);
    int n = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const Real size = size_of(cell.factor[n++]);
        const Real* v = nodes.values(at);
        if (!v) return;
        const double filling = nodes.filling(at), capacity = nodes.capacity(at);
        const Real among = capacity < light_capacity ? Real(0) : full * Real(filling < 1 ? filling : 1);
        const Real row = size * (push(at) > among ? push(at) : among) / v[quad - 1];
        cell.weight += row;
        cell.full_weight += static_cast<Real>(share_of_full(capacity, filling)) * row;
    });
}

/// Of a cell by itself, whose particles have been summed: pressure and bulk are sums over them yet.
template <class Real, int Dim, class Nodes>
MORAINE_HD void find_open_cell(const OpenGrid<Real, Dim>& grid, const SurfaceCell<Dim>& place,
                               const Vec<std::int32_t, Dim>& node, const CellMoments<Real, Dim>& moments,
                               const Nodes& nodes, OpenCell<Real, Dim>& cell) {
    cell.share = share_of_cell<Real>(place, nodes);
    const bool shares = place.shares && (place.volume < small_cell || !(cell.particles > Real(0)));
    if (!(cell.particles > Real(0)) && !(cell.share > Real(0))) return;
    make_rows(grid, place, node, moments, nodes, cell);
    if (!(cell.state.volume > Real(1e-7) * Real(grid.volume))) return;
    cell.on = true;
    cell.child = shares;
    cell.state.source = source_of(cell, nodes);
}

/// Lane n of what a child tells its root.
template <class Real, int Dim>
MORAINE_HD Real told_by_child(const OpenCell<Real, Dim>& cell, int n) {
    const Real told[] = {cell.state.pressure, cell.particles, cell.state.bulk,
                         cell.state.volume,   cell.weight,    cell.full_weight};
    return told[n];
}
inline constexpr int child_lanes = 6;

/// Of a root or a cell alone, with its children: means and the bounded modulus. told: sums of the node in its middle.
template <class Real, int Dim>
MORAINE_HD void close_open_cell(const Real* told, double dt, double damping, OpenCell<Real, Dim>& cell) {
    CellPressure<Real>& state = cell.state;
    const Real particles = cell.particles + told[sum_lane<Dim>(child_particles)];
    cell.mixed = told[sum_lane<Dim>(child_volume)] > Real(0);
    if (particles > Real(0)) {
        state.pressure = (state.pressure + told[sum_lane<Dim>(child_pressure)]) / particles;
        state.bulk = (state.bulk + told[sum_lane<Dim>(child_bulk)]) / particles;
    }
    cell.particles = particles;
    state.volume += told[sum_lane<Dim>(child_volume)];
    cell.weight += told[sum_lane<Dim>(child_weight)], cell.full_weight += told[sum_lane<Dim>(child_full_weight)];
    if (!(particles > Real(0)) || (cell.whole && !cell.mixed) || !(cell.full_weight > Real(0))) return;
    const Real softer = bulk_below(state.bulk, state.volume, cell.full_weight, dt, damping);
    cell.soft = softer < state.bulk ? softer : Real(0);
    const Real bulk = bulk_below(softer, state.volume, cell.weight, dt, damping);
    state.loose = bulk < softer;
    state.pressure *= bulk / softer;
    state.bulk = bulk;
}

/// A cell without particles takes what the cells around it have, by volume. around: sums of the node in its middle.
template <class Real, int Dim>
MORAINE_HD void fill_open_hole(const Real* around, OpenCell<Real, Dim>& hole) {
    const Real volume = around[sum_lane<Dim>(hole_volume)];
    hole.on = volume > Real(0);
    if (!hole.on) return;
    hole.state.pressure = around[sum_lane<Dim>(hole_pressure)] / volume;
    hole.state.bulk = around[sum_lane<Dim>(hole_bulk)] / volume;
}

/// Lane n of what a root tells its children.
template <class Real, int Dim>
MORAINE_HD Real told_by_root(const OpenCell<Real, Dim>& root, int n) {
    const CellPressure<Real>& state = root.state;
    const Real told[] = {state.pressure, state.loose ? -state.bulk : state.bulk, state.volume, state.source, root.soft};
    return told[n];
}
inline constexpr int root_lanes = 5;

/// What a root has become, to a child. root: sums of the node in the root's middle.
template <class Real, int Dim>
MORAINE_HD void take_root(const Real* root, OpenCell<Real, Dim>& child) {
    const Real bulk = root[sum_lane<Dim>(root_bulk)];
    child.on = root[sum_lane<Dim>(root_volume)] > Real(0);
    child.state.pressure = root[sum_lane<Dim>(root_pressure)], child.state.bulk = bulk < Real(0) ? -bulk : bulk;
    child.state.volume = root[sum_lane<Dim>(root_volume)], child.state.source = root[sum_lane<Dim>(root_source)];
    child.state.loose = bulk < Real(0);
    child.soft = root[sum_lane<Dim>(root_soft)];
}

/// sum_i G_ic . v_i - S_c . V.
template <class Real, int Dim, class Nodes>
MORAINE_HD Real flux_into(const OpenCell<Real, Dim>& cell, const Structure<Dim>& s, const Nodes& nodes) {
    Real flux = Real(0);
    for (int a = 0; a < Dim; ++a) flux -= cell.bed[a] * static_cast<Real>(s.velocity[a]);
    int n = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const CellNode<Real, Dim>& g = cell.factor[n++];
        const Real* v = nodes.values(at);
        for (int a = 0; v && a < Dim; ++a) flux += g.gradient[a] * v[a];
    });
    return flux;
}

/// The moment of G_ic about a place [m^d]: it differs from that of their sum there where some nodes lack soil, or give
/// another share. arm: from there to the node in the middle of the cell's stencil; h [m].
template <class Real, int Dim>
MORAINE_HD Vec<double, moments<Dim>> couple_of(const OpenCell<Real, Dim>& cell, const Vec<double, Dim>& arm, double h) {
    Vec<double, moments<Dim>> sum = zero_vec<double, moments<Dim>>();
    int n = 0;
    each_node<Dim, 3>([&](int, int i, int j, int l) {
        const int offset[3] = {i - 1, j - 1, l - 1};
        const CellNode<Real, Dim>& g = cell.factor[n++];
        Vec<double, Dim> own = arm, row;
        for (int a = 0; a < Dim; ++a) own[a] += h * offset[a], row[a] = double(g.gradient[a]);
        sum = sum - (-1.0) * moment_of(own, row);
    });
    return sum;
}

/// What a substep's flux makes of a cell. time: half of that from the start of the step to the middle of it [s].
template <class Real, int Dim>
MORAINE_HD void advance_open_cell(Real flux, Real dt, Real time, OpenCell<Real, Dim>& cell) {
    const Real step = dt * (flux / cell.state.volume - time * cell.state.source);
    cell.state.change = cell.state.bulk * step;
    cell.state.pressure += cell.state.change;
    cell.state.increment += step;
}

/// As the gather takes a cell at the end. head: of its smoothing.
template <class Real, int Dim>
MORAINE_HD CellPressure<Real> finished_cell(const OpenCell<Real, Dim>& cell, Real head) {
    CellPressure<Real> state = cell.state;
    state.head = head;
    state.soft = cell.soft > Real(0);
    if (state.soft) state.source = cell.soft;
    return state;
}

/// N_e: what a cell presses on its surface [Pa].
template <class Real, int Dim>
MORAINE_HD double pressure_on_surface(const OpenCell<Real, Dim>& cell, double damping) {
    return cell.on ? -double(cell.bears) * (double(cell.state.pressure) + damping * double(cell.state.change)) : 0.0;
}

}  // namespace moraine
