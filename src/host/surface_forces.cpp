// Contact on surfaces on the host (core/surfaces/surface_elements.hpp).

#include "host/surface_forces.hpp"

#include "core/nodes/surface_energy.hpp"
#include "core/surfaces/element_rule.hpp"

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
    touching_.resize(on_.blocks.size());
    Host::launch(static_cast<std::int64_t>(on_.blocks.size()), [&](int k) { find_touching(k, tiles, table); });
    on_.list(givers_, [&](int k) { return !touching_[static_cast<std::size_t>(k)].empty(); });
}

template <class Real, int Dim>
void SurfaceForces<Real, Dim>::find_touching(int k, const GapTiles& tiles, const BlockTable<Dim>& table) {
    std::vector<Touching>& found = touching_[static_cast<std::size_t>(k)];
    found.clear();
    if (!on_.has_soil[static_cast<std::size_t>(k)]) return;
    const double unit = std::pow(on_.h, Dim - 1);
    for (SurfaceElement<Dim>& e : on_.at(k).elements) {
        const std::int32_t near = on_.node_at(k, tile_offset<Dim, 3>(e.cell) + to_middle);
        const NodeGap gap =
            gap_at_node(tiles, table, on_.tile_index.data(), width,
                        on_.near_nodes[static_cast<std::size_t>(near / cells)], near % cells, e.structure);
        take_gap(gap, unit, on_.scene.field.structure[e.structure].law, e);
        if (e.touches) found.push_back({static_cast<std::int32_t>(&e - on_.at(k).elements.data()), 0});
    }
}

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
    const double cosine = bound ? on_.scene.field.corners[s.first_corner + 1][1] : 1;
    const double highest = bound && bound[pair.block].clear < s.radius / cosine ? bound[pair.block].clear : 0;
    MayBeNear near;
    const auto& around = on_.at(k).first_around;
    for (int c = 0; c < cells; ++c) {
        if (c % (cells / 4) == 0) tell_elements(pair, near);  // who is further off often tells nothing new
        if (around[static_cast<std::size_t>(c)] == around[static_cast<std::size_t>(c) + 1]) continue;
        for (std::uint32_t i = list.first[pair.block] + bounds[c]; i < list.first[pair.block] + bounds[c + 1]; ++i) {
            const std::uint32_t slot = list.slot[i];
            const Vec<double, Dim> place = contact_place<Real>(on_.scene.field, s, block, p.position[slot]);
            if (bound && bound[pair.block].is_clear(place)) continue;
            const double least = highest > 0 ? particle_reach * bound[pair.block].above(place) / highest : 0;
            if (is_behind(pair, k * cells + c, p.position[slot], double(p.volume[slot]), least)) continue;
            near.slot[near.count] = slot, near.cell[near.count] = k * cells + c, near.place[near.count] = place;
            if (++near.count == MayBeNear::most) tell_elements(pair, near);
        }
    }
    tell_elements(pair, near);
}

/// Whether a particle that is no nearer than `least` lies on the surface of no element, and is the nearest to none.
/// cell: of ours; least: [cells].
template <class Real, int Dim>
bool SurfaceForces<Real, Dim>::is_behind(const ContactPair& pair, int cell, const Vec<Coordinate<Real>, Dim>& u,
                                         double volume, double least) const {
    constexpr double rounding = 1e-6;
    const double size = (least - rounding) / lying_on_elements().above,
                 edge = size * on_.h;  // who is smaller does not lie on it
    return size > 0 && volume < edge * edge * (Dim == 3 ? edge : 1.0) &&
           is_behind(pair, cell, u, NodeGap::fixed(least - 0.5 * size - rounding));
}

/// Whether all elements that a particle may touch have been told of no wider a gap than its own.
template <class Real, int Dim>
bool SurfaceForces<Real, Dim>::is_behind(const ContactPair& pair, int cell, const Vec<Coordinate<Real>, Dim>& u,
                                         std::int32_t gap) const {
    constexpr double rounding = 1e-6;
    const NodeGap* tile = gap_tiles_.data() + static_cast<std::size_t>(pair.tile) * tile_nodes;
    const SurfaceBlock<Dim>& of = on_.at(cell / cells);
    const Vec<double, Dim> x = place_in_block(u);
    const auto c = static_cast<std::size_t>(cell % cells);
    for (std::size_t n = of.first_around[c]; n < of.first_around[c + 1]; ++n) {
        const RingElement<Dim>& e = of.ring[of.around[n]];
        if (e.structure != pair.structure || tile[e.node].gap <= gap) continue;
        const Vec<double, Dim> way = e.place - x;
        const double across = dot(way, e.normal);
        if (dot(way, way) - across * across < e.reach * e.reach + rounding) return false;
    }
    return true;
}

/// Of a particle, from the block's first cell [cells].
template <class Real, int Dim>
Vec<double, Dim> SurfaceForces<Real, Dim>::place_in_block(const Vec<Coordinate<Real>, Dim>& u) {
    Vec<double, Dim> x;
    for (int a = 0; a < Dim; ++a) x[a] = cell_of<Real>(u[a]) + double(fraction_of<Real>(u[a])) - 0.5;
    return x;
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
        ParticleGap own = gap_at<Real, Dim>(field, lying_on_elements(), distance[i], p.volume[slot], p.ln_J[slot]);
        if (own.gap == NodeGap::none) continue;
        own.area = bearing_area(field, field.structure[pair.structure], own.area, p.body[slot],
                                [&](int n) { return p.history[n][slot]; });
        if (!(own.area > 0) && is_behind(pair, near.cell[i], p.position[slot], own.gap)) continue;
        tell_element(pair, near.cell[i], p.position[slot], own);
    }
    near.count = 0;
}

template <class Real, int Dim>
void SurfaceForces<Real, Dim>::tell_element(const ContactPair& pair, int cell, const Vec<Coordinate<Real>, Dim>& u,
                                            const ParticleGap& own) {
    NodeGap* tile = gap_tiles_.data() + static_cast<std::size_t>(pair.tile) * tile_nodes;
    const SurfaceBlock<Dim>& of = on_.at(cell / cells);
    const Vec<double, Dim> x = place_in_block(u);
    const std::uint32_t first = of.first_around[static_cast<std::size_t>(cell % cells)],
                        end = of.first_around[static_cast<std::size_t>(cell % cells) + 1];
    tell_ring(of.ring.data(), of.around.data() + first, end - first, pair.structure, x, own,
              [&](int n, const NodeGap& gap) { tile[of.ring[static_cast<std::size_t>(n)].node].add(gap); });
}

/// W_i of the elements that the soil touches.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::weigh() {
    on_.pass(givers_, 2, [&](int k, Real* tile) {
        each_touching(k, [&](const SurfaceElement<Dim>& e, double) {
            int i = 0;
            each_node<Dim, 3>([&](int at, int, int, int) {
                Real* to = tile + (tile_offset<Dim, 3>(e.cell) + at) * node_reals;
                for (int q = 0; q <= SurfaceShares<Dim>::count; ++q)
                    to[lane(q)] += static_cast<Real>(share_lane(e, i, q));
                ++i;
            });
        });
    });
    shares_.value.resize(on_.sums.value.size());
    shares_.known.resize(on_.sums.known.size());
    std::swap(on_.sums, shares_);
    find_rows();
}

/// W_i as rows of nodes take it, and R_e across.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::find_rows() {
    rows_.resize(givers_.size());
    rows_of_.resize(on_.blocks.size());
    for (std::size_t i = 0; i < givers_.size(); ++i)
        rows_of_[static_cast<std::size_t>(givers_[i])] = static_cast<std::int32_t>(i);
    Host::launch(static_cast<std::int64_t>(givers_.size()),
                 [&](int i) { find_rows(givers_[static_cast<std::size_t>(i)], rows_[static_cast<std::size_t>(i)]); });
}

template <class Real, int Dim>
void SurfaceForces<Real, Dim>::find_rows(int k, ElementRows<Dim>& rows) {
    for (int n = 0; n < tile_nodes; ++n) {
        const Real* node = on_.values_at(k, n);
        const std::int32_t near = on_.node_at(k, n);
        const bool known = node && shares_.known[static_cast<std::size_t>(near / cells)];
        rows.set(n, known ? shares_at(near) : SurfaceShares<Dim>{},
                 node ? double(node[quad - 1]) : std::numeric_limits<double>::infinity());
    }
    rows.close();
    for (Touching& t : touching_[static_cast<std::size_t>(k)])
        t.row = rows.over_normal(on_.at(k).elements[static_cast<std::size_t>(t.element)]);
}

template <class Real, int Dim>
SurfaceShares<Dim> SurfaceForces<Real, Dim>::shares_at(std::int32_t near) const {
    return shares_of<Dim>(shares_.value.data() + static_cast<std::size_t>(near) * node_reals);
}

template <class Real, int Dim>
void SurfaceForces<Real, Dim>::act(const ContactTime& time, double damping) {
    sweep(time, damping);
    if (!on_.method.grid_bulk()) sweep(time.second(), damping);
    on_.pass(with_slaves_, 1, [&](int k, Real* tile) {
        for (const SlaveNode<Dim>& slave : followers_[static_cast<std::size_t>(k)]) close_slave(k, slave, tile);
    });
    apply(&SurfaceMotion<Real, Dim>::slaves);
}

/// Elements act on what nodes have.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::sweep(const ContactTime& time, double damping) {
    on_.pass(givers_, 1, [&](int k, Real* tile) {
        StructureTally<Real, Dim> tally(on_.scene);
        each_touching(k, [&](const SurfaceElement<Dim>& e, double row) {
            if (!on_.scene.field.structure[e.structure].turns) return act_on(k, e, row, time, damping, tile, tally);
            SurfaceElement<Dim> moved = e;
            moved.place = middle_of(e, on_.centre_of(k, e.cell, on_.scene.field.structure[e.structure]), on_.h,
                                    NodesOf{{}, *this, k, tile_offset<Dim, 3>(e.cell)});
            act_on(k, moved, row, time, damping, tile, tally);
        });
    });
    apply(&SurfaceMotion<Real, Dim>::elements);
}

template <class Real, int Dim>
void SurfaceForces<Real, Dim>::act_on(int k, const SurfaceElement<Dim>& e, double row, const ContactTime& time,
                                      double damping, Real* tile, StructureTally<Real, Dim>& tally) {
    const Structure<Dim>& s = on_.scene.field.structure[e.structure];
    const double pressure = pressures_.pressure_at(k, e.cell, damping);
    const KeptRows<Dim> rows{rows_[static_cast<std::size_t>(rows_of_[static_cast<std::size_t>(k)])], row};
    const ElementImpulse<Dim> impulse =
        act_on_element(e, s, time, pressure, on_.h, NodesOf{{}, *this, k, tile_offset<Dim, 3>(e.cell)}, rows);
    double heavy = 0;
    int i = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const double w = e.weight[i++];
        const int n = tile_offset<Dim, 3>(e.cell) + at;
        if (!on_.values_at(k, n)) return;
        heavy += w;
        for (int a = 0; a < Dim; ++a) tile[n * node_reals + a] -= static_cast<Real>(w * impulse.given[a]);
    });
    tally.add(e.structure, heavy * impulse.given, e.place, impulse.follows);
    if (s.turns) on_.tell_following(e.structure, following_of(e, s, impulse));
}

/// Who follows in this step: slaves and their masters are known by place.
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::find_slaves() {
    followers_.resize(on_.blocks.size());
    Host::launch(static_cast<std::int64_t>(on_.blocks.size()), [&](int k) {
        std::vector<SlaveNode<Dim>>& follow = followers_[static_cast<std::size_t>(k)];
        follow.clear();
        for (const SlaveNode<Dim>& slave : on_.at(k).slaves)
            if (on_.has_soil[static_cast<std::size_t>(k)] && acts(k, slave.nodes)) follow.push_back(slave);
    });
    on_.list(with_slaves_, [&](int k) { return !followers_[static_cast<std::size_t>(k)].empty(); });
}

/// Whether elements touch a slave, and all three nodes hold soil.
template <class Real, int Dim>
bool SurfaceForces<Real, Dim>::acts(int k, const Slave& slave) const {
    const std::int32_t near = on_.node_at(k, slave.own);
    if (!shares_.known[static_cast<std::size_t>(near / cells)]) return false;
    return slave_acts(on_.values_at(k, slave.own), on_.values_at(k, slave.one), on_.values_at(k, slave.two),
                      shares_at(near));
}

/// The impulse that closes f (v_o - 2 v_1 + v_2).
template <class Real, int Dim>
void SurfaceForces<Real, Dim>::close_slave(int k, const SlaveNode<Dim>& by, Real* tile) const {
    const Slave& slave = by.nodes;
    const Real *own = on_.values_at(k, slave.own), *one = on_.values_at(k, slave.one),
               *two = on_.values_at(k, slave.two);
    const Vec<double, Dim> off = slave_impulse(by, on_.scene.field.structure[by.surface.structure].law, own, one, two);
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
