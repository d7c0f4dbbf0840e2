// What acts along surfaces on the host (core/surface_elements.hpp).

#include "comm/surface_forces.hpp"

namespace moraine {

template <class Real, int Dim>
void SurfaceForces<Real, Dim>::begin_step() {
    find_gaps(*on_.pairs);
    weigh();
}

/// Who is near to each element, and how much of it soil lies on: whole numbers, in the gap tiles of the node in the
/// middle of its cell.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::find_gaps(const ContactPairs<Dim>& pairs) {
    gap_tiles_.assign(pairs.tiles() * tile_nodes, NodeGap{});
    for (const auto* list : {&pairs.boundary(), &pairs.interior()})
        Host::launch(static_cast<std::int64_t>(list->size()),
                     [&](int i) { tell_elements((*list)[static_cast<std::size_t>(i)]); });
    const GapShare<Dim> share{&pairs, gap_tiles_.data()};
    on_.pass([](int, Real*) {}, &share);
    const GapTiles tiles{pairs.structures(), pairs.tile_of().data(), gap_tiles_.data()};
    const BlockTable<Dim> table = on_.patch.table();
    Host::launch(static_cast<std::int64_t>(on_.blocks.size()), [&](int k) {
        for (SurfaceElement<Dim>& e : on_.elements[static_cast<std::size_t>(k)]) {
            const std::int32_t near = on_.node_at(k, tile_offset<Dim, 3>(e.cell) + to_middle);
            const NodeGap gap =
                gap_at_node(tiles, table, on_.tile_index.data(), width,
                            on_.near_nodes[static_cast<std::size_t>(near / cells)], near % cells, e.structure);
            const double unit = std::pow(on_.h, Dim - 1);
            e.gap = gap.is_none() ? 1e9 : gap.cells();
            e.covered = gap.faces() * unit / e.area;
            const InterfaceLaw law = on_.scene.field.structure[e.structure].law;
            e.touches =
                law != InterfaceLaw::smooth && (e.gap < touches_below || (acts_where_it_touches(law) && e.covered > 0));
        }
    });
}

/// A particle is near to an element whose middle is within 0.75 h of it along the surface, and lies on those within 1
/// h, on each by its area times 1 - s / h: all of the particle's area, and no more.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::tell_elements(const ContactPair& pair) {
    const std::int32_t k = on_.bed_of[static_cast<std::size_t>(pair.block)];
    const ListView<Dim> list = on_.patch.list();
    if (k < 0 || list.count(pair.block) == 0) return;
    const ParticleView<Real, Dim> p = on_.patch.particles.view();
    const Structure<Dim>& s = on_.scene.field.structure[pair.structure];
    const Place& block = on_.patch.tables().position[static_cast<std::size_t>(pair.block)];
    NodeGap* tile = gap_tiles_.data() + static_cast<std::size_t>(pair.tile) * tile_nodes;
    const RingElement<Dim>* ring = on_.ring.data() + static_cast<std::size_t>(k) * tile_nodes;
    for (std::uint32_t i = list.first[pair.block]; i < list.first[pair.block + 1]; ++i) {
        const std::uint32_t slot = list.slot[i];
        const ParticleGap own = gap_of<Real>(on_.scene.field, s, block, p.position[slot], p.volume[slot], p.ln_J[slot]);
        if (own.gap == NodeGap::none) continue;
        Vec<double, Dim> x;
        int cell = 0;
        for (int a = 0, stride = 1; a < Dim; ++a, stride *= side) {
            const int c = cell_of<Real>(p.position[slot][a]);
            x[a] = c + double(fraction_of<Real>(p.position[slot][a])) - 0.5;
            cell += stride * (c + 1);
        }
        int at[nodes], count = 0;
        double share[nodes], all = 0;
        each_node<Dim, 3>([&](int o, int, int, int) {
            const int n = cell - to_middle + o;
            const RingElement<Dim>& e = ring[n];
            if (!(e.area > 0) || e.structure != pair.structure) return;
            const Vec<double, Dim> way = e.place - x;
            const double along = magnitude(way - dot(way, e.normal) * e.normal);
            if (along < 0.75) tile[n].add({own.gap, 0});
            if (!(along < 1)) return;
            share[count] = e.area * (1 - along);
            all += share[count];
            at[count++] = n;
        });
        for (int q = 0; q < count && own.area > 0; ++q)
            tile[at[q]].add({NodeGap::none, NodeGap::fixed_area(own.area * share[q] / all)});
    }
}

/// W_i of the elements that the soil touches.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::weigh() {
    on_.pass([&](int k, Real* tile) {
        for (const SurfaceElement<Dim>& e : on_.elements[static_cast<std::size_t>(k)]) {
            if (!e.touches) continue;
            int i = 0;
            each_node<Dim, 3>([&](int at, int, int, int) {
                Real* to = tile + (tile_offset<Dim, 3>(e.cell) + at) * node_reals;
                for (int q = 0; q < SurfaceShares<Dim>::count; ++q)
                    to[lane(q)] += static_cast<Real>(e.area * e.weight[i] * tensor_lane(e.normal, q));
                to[lane(SurfaceShares<Dim>::count)] += static_cast<Real>(e.area * e.own[i]);
                ++i;
            });
        }
    });
    shares_.resize(on_.sums.size());
    on_.sums.swap(shares_);
}

template <class Real, int Dim>
SurfaceShares<Dim> SurfaceForces<Real, Dim>::shares_at(std::int32_t near) const {
    const Real* from = shares_.data() + static_cast<std::size_t>(near) * node_reals;
    SurfaceShares<Dim> s;
    for (int q = 0; q < SurfaceShares<Dim>::count; ++q) s.across[q] = double(from[lane(q)]);
    s.own = double(from[lane(SurfaceShares<Dim>::count)]);
    return s;
}

template <class Real, int Dim>
void SurfaceForces<Real, Dim>::act(double dt, double damping) {
    on_.pass([&](int k, Real* tile) {
        for (const SurfaceElement<Dim>& e : on_.elements[static_cast<std::size_t>(k)])
            if (e.touches) slow_element(k, e, dt, damping, tile);
    });
    apply();
    on_.pass([&](int k, Real* tile) {
        for (int c = 0; c < cells; ++c) close_slave(k, c, tile);
    });
    apply();
}

/// What presses an element.
template <class Real, int Dim>
Pressing SurfaceForces<Real, Dim>::pressing(int k, const SurfaceElement<Dim>& e, double dt, double damping) const {
    Pressing by{0, 0};
    int i = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const std::int32_t near = on_.node_at(k, tile_offset<Dim, 3>(e.cell) + at);
        const std::ptrdiff_t node = on_.stored(near);
        const double own = e.own[i++];
        if (node < 0 || !(own > 0)) return;
        const double pressed = -dot(on_.scene.pressed[node], e.normal);
        if (!(pressed > 0)) return;
        const SurfaceShares<Dim> shares = shares_at(near);
        const double all = shares.all(), across = all > 0 ? shares.along_normal(e.normal) / all : 1.0;
        if (shares.own * across > 0) by.contact += own * pressed / (shares.own * across);
    });
    const double pressure = pressures_.pressure_on_surface(k, e.cell, damping);
    if (pressure > 0) by.pressure = pressure * dt;
    return by;
}

template <class Real, int Dim>
void SurfaceForces<Real, Dim>::slow_element(int k, const SurfaceElement<Dim>& e, double dt, double damping,
                                            Real* tile) {
    const Structure<Dim>& s = on_.scene.field.structure[e.structure];
    Vec<double, Dim> slip = zero_vec<double, Dim>();
    const int corner = tile_offset<Dim, 3>(e.cell);
    int i = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const double w = e.weight[i++];
        const Real* v = on_.values(on_.node_at(k, corner + at));
        for (int a = 0; v && a < Dim; ++a) slip[a] += w * (double(v[a]) - s.velocity[a]);
    });
    const double approach = dot(slip, e.normal);
    slip = slip - approach * e.normal;
    const double speed = magnitude(slip);
    if (!(speed > 0)) return;
    const double row = row_of(e, k, (1 / speed) * slip);
    if (!(row > 0)) return;
    const double most = most_along(s.law, e, pressing(k, e, dt, damping), approach, speed, row, dt);
    const double taken = std::min(most, speed / row);
    if (!(taken > 0)) return;
    const Vec<double, Dim> impulse = (e.area * taken / speed) * slip;  // to the structure, if all nodes hold soil
    double heavy = 0;
    i = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const double w = e.weight[i++];
        const std::int32_t near = on_.node_at(k, corner + at);
        if (!on_.values(near)) return;
        heavy += w;
        Real* to = tile + (corner + at) * node_reals;
        for (int a = 0; a < Dim; ++a) to[a] -= static_cast<Real>(w * impulse[a]);
    });
    on_.tell(e.structure, heavy * impulse, e.place);
}

/// R_e along a direction.
template <class Real, int Dim>
double SurfaceForces<Real, Dim>::row_of(const SurfaceElement<Dim>& e, int k, const Vec<double, Dim>& along) const {
    double row = 0;
    int i = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const double w = e.weight[i++];
        const std::int32_t near = on_.node_at(k, tile_offset<Dim, 3>(e.cell) + at);
        const Real* v = on_.values(near);
        if (!v || w == 0) return;
        const SurfaceShares<Dim> shares = shares_at(near);
        row += w * (shares.all() - shares.along_normal(along)) / double(v[quad - 1]);
    });
    return row;
}

/// The slaves that follow the middle of a cell and the node beyond: the impulse that closes f (v_o - 2 v_1 + v_2).
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::close_slave(int k, int c, Real* tile) {
    const int corner = tile_offset<Dim, 3>(c), middle = corner + to_middle;
    const GapTiles tiles{on_.pairs->structures(), on_.pairs->tile_of().data(), on_.scene.gaps};
    each_node<Dim, 3>([&](int at, int i, int j, int l) {
        const std::int32_t near = on_.node_at(k, corner + at);
        const SurfaceNode<Dim>& n = on_.surface_nodes[static_cast<std::size_t>(near)];
        if (!(n.slaved > 0)) return;
        const int offset[3] = {i - 1, j - 1, l - 1};
        int beyond = middle;
        for (int a = 0, stride = 1; a < Dim; ++a, stride *= side) {
            if (n.to[a] != -offset[a]) return;
            beyond += stride * n.to[a];
        }
        if (on_.scene.field.structure[n.structure].law == InterfaceLaw::smooth) return;
        const Real *slave = on_.values(near), *one = on_.values(on_.node_at(k, middle)),
                   *two = on_.values(on_.node_at(k, beyond));
        if (!slave || !one || !two) return;
        const double m = slave[quad - 1], m1 = one[quad - 1], m2 = two[quad - 1];
        if (m > 0.5 * m1) return;
        const NodeGap gap =
            gap_at_node(tiles, on_.patch.table(), on_.patch.tile_of(), width,
                        on_.near_nodes[static_cast<std::size_t>(near / cells)], near % cells, n.structure);
        if (gap.is_none() || !(gap.cells() < touches_below)) return;
        Vec<double, Dim> off;
        for (int a = 0; a < Dim; ++a) off[a] = 2 * double(one[a]) - double(two[a]) - double(slave[a]);
        off = (n.slaved / (1 / m + 4 / m1 + 1 / m2)) * (off - dot(off, n.normal) * n.normal);
        for (int a = 0; a < Dim; ++a) {
            tile[(corner + at) * node_reals + a] += static_cast<Real>(off[a]);
            tile[middle * node_reals + a] -= static_cast<Real>(2 * off[a]);
            tile[beyond * node_reals + a] += static_cast<Real>(off[a]);
        }
    });
}

/// Impulses to velocities, and walls again.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::apply() {
    const BlockTable<Dim> table = on_.patch.table();
    Host::launch(static_cast<std::int64_t>(on_.near_nodes.size()), [&](int j) {
        const std::int32_t c = on_.near_nodes[static_cast<std::size_t>(j)];
        for (int n = 0; n < cells; ++n) {
            Real* node = on_.values(j * cells + n);
            if (!node) continue;
            const Real* impulse = on_.sums.data() + static_cast<std::size_t>(j * cells + n) * node_reals;
            Vec<Real, Dim> v;
            for (int a = 0; a < Dim; ++a) v[a] = node[a] + impulse[a] / node[quad - 1];
            Vec<Real, Dim> end = v;
            if (table.node_border[c]) {
                int at[Dim];
                for (int a = 0; a < Dim; ++a)
                    at[a] = 4 * table.node_position[c][a] - on_.method.stencil.origin + cell_coordinate<Dim>(n, a);
                on_.method.context.walls.constrain(at, end);
                count_walls(c, n, double(node[quad - 1]), v, end);
            }
            for (int a = 0; a < Dim; ++a) {
                node[quad + a] += end[a] - node[a];
                node[a] = end[a];
            }
        }
    });
}

/// What walls gave a node that this rank counts.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::count_walls(std::int32_t c, int n, double mass, const Vec<Real, Dim>& before,
                                           const Vec<Real, Dim>& after) {
    const BlockTable<Dim> table = on_.patch.table();
    for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
        const std::int32_t source = table.source[c * Block<Dim>::corners + delta];
        if (source < 0 || on_.patch.tile_of()[source] < 0 || tile_node<Dim>(n, delta, width) < 0) continue;
        for (int a = 0; source < table.own && a < Dim; ++a)
            on_.scene.impulse[c * Dim + a].add(on_.scene.quantum.of(mass * (double(after[a]) - double(before[a]))));
        return;
    }
}

template class SurfaceForces<float, 2>;
template class SurfaceForces<float, 3>;
template class SurfaceForces<double, 2>;
template class SurfaceForces<double, 3>;

}  // namespace moraine
