// Contact on surfaces on the host (core/surfaces/surface_elements.hpp).

#include "host/surface_forces.hpp"

#include "core/nodes/surface_energy.hpp"

namespace moraine {

template <class Real, int Dim>
void SurfaceForces<Real, Dim>::begin_step() {
    impulse_.assign(on_.near_nodes.size(), {});
    find_gaps(*on_.pairs);
    weigh();
    find_slaves();
}

/// Who is near to each element, and how much of it soil lies on: whole numbers, in the gap tiles of the node in the
/// middle of its cell.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::find_gaps(const ContactPairs<Dim>& pairs) {
    if (gap_tiles_.size() != pairs.tiles() * tile_nodes) gap_tiles_.assign(pairs.tiles() * tile_nodes, NodeGap{});
    const ListView<Dim> list = on_.patch.list();
    on_.list(occupied_, [&](int k) { return list.count(on_.blocks[static_cast<std::size_t>(k)]) > 0; });
    for (const auto* part : {&pairs.boundary(), &pairs.interior()})
        Host::launch(static_cast<std::int64_t>(part->size()),
                     [&](int i) { tell_elements((*part)[static_cast<std::size_t>(i)]); });
    on_.share(occupied_, {&pairs, gap_tiles_.data()});
    const GapTiles tiles{pairs.structures(), pairs.tile_of().data(), gap_tiles_.data()};
    const BlockTable<Dim> table = on_.patch.table();
    const double unit = std::pow(on_.h, Dim - 1);
    touching_.resize(on_.blocks.size());
    Host::launch(static_cast<std::int64_t>(on_.blocks.size()), [&](int k) {
        touching_[static_cast<std::size_t>(k)].clear();
        for (SurfaceElement<Dim>& e : on_.elements[static_cast<std::size_t>(k)]) {
            const std::int32_t near = on_.node_at(k, tile_offset<Dim, 3>(e.cell) + to_middle);
            const NodeGap gap =
                gap_at_node(tiles, table, on_.tile_index.data(), width,
                            on_.near_nodes[static_cast<std::size_t>(near / cells)], near % cells, e.structure);
            e.gap = gap.is_none() ? 1e9 : gap.cells();
            e.covered = gap.faces() * unit / e.area;
            const InterfaceLaw law = on_.scene.field.structure[e.structure].law;
            e.touches = e.gap < touches_below || (acts_where_it_touches(law) && e.covered > 0);
            if (!e.touches) continue;
            const std::ptrdiff_t at = &e - on_.elements[static_cast<std::size_t>(k)].data();
            touching_[static_cast<std::size_t>(k)].push_back(static_cast<std::int32_t>(at));
        }
    });
    on_.list(givers_, [&](int k) { return !touching_[static_cast<std::size_t>(k)].empty(); });
}

/// A particle is near to an element whose middle is within its reach along the surface, and lies on those within 1 h, on each by its area times 1 - s / h: all of the particle's area, and no more.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::tell_elements(const ContactPair& pair) {
    const std::int32_t k = on_.bed_of[static_cast<std::size_t>(pair.block)];
    const ListView<Dim> list = on_.patch.list();
    if (k < 0 || list.count(pair.block) == 0) return;
    std::fill_n(gap_tiles_.data() + static_cast<std::size_t>(pair.tile) * tile_nodes, tile_nodes, NodeGap{});
    const ParticleView<Real, Dim> p = on_.patch.particles.view();
    const Structure<Dim>& s = on_.scene.field.structure[pair.structure];
    const Place& block = on_.patch.tables().position[static_cast<std::size_t>(pair.block)];
    const GroundBound<Dim>* bound = s.shape == StructureShape::ground ? on_.pairs->bounds() : nullptr;
    const std::uint32_t* bounds = list.cell_first + std::size_t(pair.block) * (cells + 1);
    MayBeNear near;
    for (int c = 0; c < cells; ++c) {
        const auto cell = static_cast<std::size_t>(k * cells + c);
        if (on_.around.first[cell] == on_.around.first[cell + 1]) continue;
        for (std::uint32_t i = list.first[pair.block] + bounds[c]; i < list.first[pair.block] + bounds[c + 1]; ++i) {
            near.slot[near.count] = list.slot[i], near.cell[near.count] = static_cast<int>(cell);
            near.place[near.count] = contact_place<Real>(on_.scene.field, s, block, p.position[list.slot[i]]);
            near.count += !(bound && bound[pair.block].is_clear(near.place[near.count]));
            if (near.count == MayBeNear::most) tell_elements(pair, near);
        }
    }
    tell_elements(pair, near);
}

/// Distances do not wait for one another.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::tell_elements(const ContactPair& pair, MayBeNear& near) {
    const ContactField<Dim>& field = on_.scene.field;
    const ParticleView<Real, Dim> p = on_.patch.particles.view();
    double distance[MayBeNear::most];
    for (int i = 0; i < near.count; ++i)
        distance[i] = surface(field.structure[pair.structure], field.corners, near.place[i]).distance / field.cell;
    for (int i = 0; i < near.count; ++i) {
        const std::uint32_t slot = near.slot[i];
        const ParticleGap own = gap_at<Real, Dim>(field, distance[i], p.volume[slot], p.ln_J[slot]);
        if (own.gap != NodeGap::none) tell_element(pair, near.cell[i], slot, own);
    }
    near.count = 0;
}

template <class Real, int Dim>
void SurfaceForces<Real, Dim>::tell_element(const ContactPair& pair, int cell, std::uint32_t slot,
                                            const ParticleGap& own) {
    NodeGap* tile = gap_tiles_.data() + static_cast<std::size_t>(pair.tile) * tile_nodes;
    const RingElement<Dim>* ring = on_.ring.data() + static_cast<std::size_t>(cell / cells) * tile_nodes;
    const Vec<Coordinate<Real>, Dim>& u = on_.patch.particles.view().position[slot];
    Vec<double, Dim> x;
    for (int a = 0; a < Dim; ++a) x[a] = cell_of<Real>(u[a]) + double(fraction_of<Real>(u[a])) - 0.5;
    int at[nodes], count = 0;
    double share[nodes], all = 0;
    for (std::uint32_t i = on_.around.first[static_cast<std::size_t>(cell)];
         i < on_.around.first[static_cast<std::size_t>(cell) + 1]; ++i) {
        const int n = on_.around.ring[i];
        const RingElement<Dim>& e = ring[n];
        if (e.structure != pair.structure) continue;
        const Vec<double, Dim> way = e.place - x;
        const Vec<double, Dim> off = way - dot(way, e.normal) * e.normal;
        const double square = dot(off, off);
        if (!(square < 1)) continue;  // most, who want no root
        const double along = std::sqrt(square);
        if (along < e.reach) tile[n].add({own.gap, 0});
        if (!(along < 1)) continue;
        share[count] = e.area * (1 - along);
        all += share[count];
        at[count++] = n;
    }
    for (int q = 0; q < count && own.area > 0; ++q)
        tile[at[q]].add({NodeGap::none, NodeGap::fixed_area(own.area * share[q] / all)});
}

/// W_i of the elements that the soil touches.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::weigh() {
    on_.pass(givers_, 2, [&](int k, Real* tile) {
        each_touching(k, [&](const SurfaceElement<Dim>& e) {
            int i = 0;
            each_node<Dim, 3>([&](int at, int, int, int) {
                Real* to = tile + (tile_offset<Dim, 3>(e.cell) + at) * node_reals;
                for (int q = 0; q < SurfaceShares<Dim>::count; ++q)
                    to[lane(q)] += static_cast<Real>(e.area * e.weight[i] * tensor_lane(e.normal, q));
                to[lane(SurfaceShares<Dim>::count)] += static_cast<Real>(e.area * e.own[i]);
                ++i;
            });
        });
    });
    shares_.value.resize(on_.sums.value.size());
    shares_.known.resize(on_.sums.known.size());
    std::swap(on_.sums, shares_);
}

template <class Real, int Dim>
SurfaceShares<Dim> SurfaceForces<Real, Dim>::shares_at(std::int32_t near) const {
    const Real* from = shares_.value.data() + static_cast<std::size_t>(near) * node_reals;
    SurfaceShares<Dim> s;
    for (int q = 0; q < SurfaceShares<Dim>::count; ++q) s.across[q] = double(from[lane(q)]);
    s.own = double(from[lane(SurfaceShares<Dim>::count)]);
    return s;
}

template <class Real, int Dim>
void SurfaceForces<Real, Dim>::act(const ContactTime& time, double damping) {
    on_.pass(givers_, 1, [&](int k, Real* tile) {
        each_touching(k, [&](const SurfaceElement<Dim>& e) { act_on(k, e, time, damping, tile); });
    });
    apply(&SurfaceMotion<Real, Dim>::elements);
    on_.pass(with_slaves_, 1, [&](int k, Real* tile) {
        for (const Slave& slave : followers_[static_cast<std::size_t>(k)]) close_slave(k, slave, tile);
    });
    apply(&SurfaceMotion<Real, Dim>::slaves);
}

template <class Real, int Dim>
void SurfaceForces<Real, Dim>::act_on(int k, const SurfaceElement<Dim>& e, const ContactTime& time, double damping,
                                      Real* tile) {
    const Slip slip = slip_of(k, e);
    Vec<double, Dim> follows = zero_vec<double, Dim>();
    const double pushed = push(k, e, slip, time.closing, follows);
    const double pressure = pressures_.pressure_on_surface(k, e.cell, damping);
    const Vec<double, Dim> taken = slow(k, e, slip, {pushed, pressure > 0 ? pressure * time.dt : 0.0}, time.dt);
    const Vec<double, Dim> impulse = e.area * (taken - pushed * e.normal);  // to the structure, if all nodes hold soil
    double heavy = 0;
    int i = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const double w = e.weight[i++];
        const int n = tile_offset<Dim, 3>(e.cell) + at;
        if (!on_.values(on_.node_at(k, n))) return;
        heavy += w;
        for (int a = 0; a < Dim; ++a) tile[n * node_reals + a] -= static_cast<Real>(w * impulse[a]);
    });
    on_.tell(e.structure, heavy * impulse, e.place, follows);
}

template <class Real, int Dim>
typename SurfaceForces<Real, Dim>::Slip SurfaceForces<Real, Dim>::slip_of(int k, const SurfaceElement<Dim>& e) const {
    const Structure<Dim>& s = on_.scene.field.structure[e.structure];
    Vec<double, Dim> slip = zero_vec<double, Dim>();
    int i = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const double w = e.weight[i++];
        const Real* v = on_.values(on_.node_at(k, tile_offset<Dim, 3>(e.cell) + at));
        for (int a = 0; v && a < Dim; ++a) slip[a] += w * (double(v[a]) - s.velocity[a]);
    });
    const double leaves = dot(slip, e.normal);
    return {leaves, slip - leaves * e.normal};
}

/// What holds the soil out of the structure, per area. follows: the mass that it moves with the structure [kg].
template <class Real, int Dim>
double SurfaceForces<Real, Dim>::push(int k, const SurfaceElement<Dim>& e, const Slip& slip, double closing,
                                      Vec<double, Dim>& follows) const {
    const double too_fast = -(e.gap > 0 ? e.gap * on_.h : 0.0) / closing - slip.leaves;
    if (!(too_fast > 0)) return 0;
    const double row = row_of(e, k, [&](const SurfaceShares<Dim>& shares) { return shares.along_normal(e.normal); });
    if (!(row > 0)) return 0;
    const bool rough = on_.scene.field.structure[e.structure].law == InterfaceLaw::rough;
    for (int a = 0; a < Dim; ++a) follows[a] = e.area / row * (rough ? 1 : e.normal[a] * e.normal[a]);
    return (1 + comes_back(e.gap)) * too_fast / row;
}

/// What the law takes of the slip, per area.
template <class Real, int Dim>
Vec<double, Dim> SurfaceForces<Real, Dim>::slow(int k, const SurfaceElement<Dim>& e, const Slip& slip,
                                                const Pressing& by, double dt) const {
    const InterfaceLaw law = on_.scene.field.structure[e.structure].law;
    const double speed = magnitude(slip.along);
    if (law == InterfaceLaw::smooth || !(speed > 0)) return zero_vec<double, Dim>();
    const Vec<double, Dim> along = (1 / speed) * slip.along;
    const double row =
        row_of(e, k, [&](const SurfaceShares<Dim>& shares) { return shares.all() - shares.along_normal(along); });
    if (!(row > 0)) return zero_vec<double, Dim>();
    const double taken = std::min(most_along(law, e, by, slip.leaves, speed, row, dt), speed / row);
    return (taken > 0 ? taken : 0.0) * along;
}

/// R_e, of what share(W_i) takes of a node's W.
template <class Real, int Dim>
template <class Share>
double SurfaceForces<Real, Dim>::row_of(const SurfaceElement<Dim>& e, int k, const Share& share) const {
    double row = 0;
    int i = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const double w = e.weight[i++];
        const std::int32_t near = on_.node_at(k, tile_offset<Dim, 3>(e.cell) + at);
        const Real* v = on_.values(near);
        if (v && w != 0) row += w * share(shares_at(near)) / double(v[quad - 1]);
    });
    return row;
}

/// Who follows in this step: slaves and their masters are known by place.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::find_slaves() {
    if (known_ != on_.made.times) {
        known_ = on_.made.times;
        slaves_.assign(on_.blocks.size(), {});
        followers_.assign(on_.blocks.size(), {});
        Host::launch(static_cast<std::int64_t>(on_.blocks.size()), [&](int k) {
            for (int c = 0; c < cells; ++c) list_slaves(k, c);
        });
    }
    Host::launch(static_cast<std::int64_t>(on_.blocks.size()), [&](int k) {
        std::vector<Slave>& follow = followers_[static_cast<std::size_t>(k)];
        follow.clear();
        for (const Slave& slave : slaves_[static_cast<std::size_t>(k)])
            if (acts(k, slave)) follow.push_back(slave);
    });
    on_.list(with_slaves_, [&](int k) { return !followers_[static_cast<std::size_t>(k)].empty(); });
}

/// Of a cell, the slaves that follow its middle and the node beyond.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::list_slaves(int k, int c) {
    const int corner = tile_offset<Dim, 3>(c), middle = corner + to_middle;
    each_node<Dim, 3>([&](int at, int i, int j, int l) {
        const SurfaceNode<Dim>& n = on_.surface_nodes[static_cast<std::size_t>(on_.node_at(k, corner + at))];
        if (!(n.slaved > 0)) return;
        const int offset[3] = {i - 1, j - 1, l - 1};
        int beyond = middle;
        for (int a = 0, stride = 1; a < Dim; ++a, stride *= side) {
            if (n.to[a] != -offset[a]) return;
            beyond += stride * n.to[a];
        }
        slaves_[static_cast<std::size_t>(k)].push_back({corner + at, middle, beyond});
    });
}

/// Whether elements touch a slave, and all three nodes hold soil.
template <class Real, int Dim>
bool SurfaceForces<Real, Dim>::acts(int k, const Slave& slave) const {
    const std::int32_t near = on_.node_at(k, slave.own);
    if (!shares_.known[static_cast<std::size_t>(near / cells)]) return false;
    const Real *own = on_.values(near), *one = on_.values(on_.node_at(k, slave.one));
    if (!own || !one || !on_.values(on_.node_at(k, slave.two)) || !(shares_at(near).own > 0)) return false;
    return !(double(own[quad - 1]) > 0.5 * double(one[quad - 1]));
}

/// The impulse that closes f (v_o - 2 v_1 + v_2).
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::close_slave(int k, const Slave& slave, Real* tile) const {
    const std::int32_t near = on_.node_at(k, slave.own);
    const SurfaceNode<Dim>& n = on_.surface_nodes[static_cast<std::size_t>(near)];
    const Real *own = on_.values(near), *one = on_.values(on_.node_at(k, slave.one)),
               *two = on_.values(on_.node_at(k, slave.two));
    const double m = own[quad - 1], m1 = one[quad - 1], m2 = two[quad - 1];
    Vec<double, Dim> off;
    for (int a = 0; a < Dim; ++a) off[a] = 2 * double(one[a]) - double(two[a]) - double(own[a]);
    if (on_.scene.field.structure[n.structure].law == InterfaceLaw::smooth) off = dot(off, n.normal) * n.normal;
    off = (n.slaved / (1 / m + 4 / m1 + 1 / m2)) * off;
    for (int a = 0; a < Dim; ++a) {
        tile[slave.own * node_reals + a] += static_cast<Real>(off[a]);
        tile[slave.one * node_reals + a] -= static_cast<Real>(2 * off[a]);
        tile[slave.two * node_reals + a] += static_cast<Real>(off[a]);
    }
}

/// Impulses to velocities, and walls again. by: who gave them.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::apply(Taken by) {
    const BlockTable<Dim> table = on_.patch.table();
    Host::launch(static_cast<std::int64_t>(on_.near_nodes.size()), [&](int j) {
        if (!on_.sums.known[static_cast<std::size_t>(j)]) return;
        const std::int32_t c = on_.near_nodes[static_cast<std::size_t>(j)];
        for (int n = 0; n < cells; ++n) {
            Real* node = on_.values(j * cells + n);
            if (!node) continue;
            const Real* impulse = on_.sum_of(j * cells + n);
            Vec<Real, Dim> v;
            for (int a = 0; a < Dim; ++a) v[a] = node[a] + impulse[a] / node[quad - 1];
            Vec<Real, Dim> end = v;
            if (table.node_border[c]) {
                int at[Dim];
                for (int a = 0; a < Dim; ++a)
                    at[a] = 4 * table.node_position[c][a] - on_.method.stencil.origin + cell_coordinate<Dim>(n, a);
                on_.method.context.walls.constrain(at, end);
                count_walls(j, n, double(node[quad - 1]), v, end);
            }
            if (on_.counts_energy) note(static_cast<std::size_t>(j * cells + n), by, node, v, end);
            for (int a = 0; a < Dim; ++a) {
                node[quad + a] += end[a] - node[a];
                node[a] = end[a];
            }
        }
    });
}

template <class Real, int Dim>
void SurfaceForces<Real, Dim>::take_impulse(std::array<ExactSum, Dim>& impulse) {
    for (const auto& sums : impulse_)
        for (std::size_t a = 0; a < Dim; ++a) impulse[a].add(sums[a]);
}

template <class Real, int Dim>
void SurfaceForces<Real, Dim>::note(std::size_t near, Taken by, const Real* node, const Vec<Real, Dim>& v,
                                    const Vec<Real, Dim>& end) {
    SurfaceMotion<Real, Dim>& motion = on_.motions[near];
    motion.end = end;
    for (int a = 0; a < Dim; ++a) (motion.*by)[a] += node[a] - v[a], motion.walls[a] += v[a] - end[a];
}

template <class Real, int Dim>
void SurfaceForces<Real, Dim>::count_energy(const NodeRound<Real, Dim>& round, NodeEnergy* energy) {
    const BlockTable<Dim> table = on_.patch.table();
    Host::launch(static_cast<std::int64_t>(on_.near_nodes.size()), [&](int j) {
        const std::int32_t c = on_.near_nodes[static_cast<std::size_t>(j)];
        for (int n = 0; on_.stored(j * cells) >= 0 && n < cells; ++n) {
            int at[Dim];
            for (int a = 0; a < Dim; ++a)
                at[a] = 4 * table.node_position[c][a] - on_.method.stencil.origin + cell_coordinate<Dim>(n, a);
            add_surface_energy(round, on_.method.context.walls, table.node_border[c] ? at : nullptr,
                               on_.motions[static_cast<std::size_t>(j * cells + n)], on_.scene.quantum, energy[c]);
        }
    });
}

/// What walls gave a node that this rank counts.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::count_walls(int j, int n, double mass, const Vec<Real, Dim>& before,
                                           const Vec<Real, Dim>& after) {
    const BlockTable<Dim> table = on_.patch.table();
    const std::int32_t c = on_.near_nodes[static_cast<std::size_t>(j)];
    for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
        const std::int32_t source = table.source[c * Block<Dim>::corners + delta];
        if (source < 0 || on_.patch.tile_of()[source] < 0 || tile_node<Dim>(n, delta, width) < 0) continue;
        for (int a = 0; source < table.own && a < Dim; ++a)
            impulse_[static_cast<std::size_t>(j)][static_cast<std::size_t>(a)].add(
                on_.scene.quantum.of(mass * (double(after[a]) - double(before[a]))));
        return;
    }
}

template class SurfaceForces<float, 2>;
template class SurfaceForces<float, 3>;
template class SurfaceForces<double, 2>;
template class SurfaceForces<double, 3>;

}  // namespace moraine
