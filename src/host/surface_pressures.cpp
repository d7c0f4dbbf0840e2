// The pressure of cells beside surfaces on the host (core/surfaces/open_faces.hpp).

#include "host/surface_pressures.hpp"

#include "core/fluid/pressure_kernels.hpp"

namespace moraine {

/// Lanes of what a child tells its root, what cells tell holes beside them, and what the root tells back.
enum ChildLane { child_pressure, child_particles, child_bulk, child_volume, child_weight, child_cross };
enum HoleLane { hole_volume, hole_pressure, hole_bulk };
enum RootLane { root_pressure, root_bulk, root_volume, root_source };

template <class Real, int Dim>
void SurfacePressures<Real, Dim>::find(const Substep& first) {
    keep_accelerations();
    find_cells(first);
    on_.list(givers_, [&](int k) { return on_cells_[static_cast<std::size_t>(k)].has_children; });
    on_.pass(givers_, 2, [&](int k, Real* tile) {
        each_on(k, [&](int c, const OpenCell<Real, Dim>& cell) {
            if (!cell.child) return;
            Real* root = tile + root_node(k, c) * node_reals;
            root[lane(child_pressure)] += cell.state.pressure, root[lane(child_particles)] += cell.particles;
            root[lane(child_bulk)] += cell.state.bulk, root[lane(child_volume)] += cell.state.volume;
            root[lane(child_weight)] += cell.weight, root[lane(child_cross)] += cell.state.head;
        });
    });
    each_block([&](int k) { each_on(k, [&](int c, const OpenCell<Real, Dim>&) { close_cell(k, c, first); }); });
    const ListView<Dim> list = on_.patch.list();
    on_.list(givers_, [&](int k) { return list.count(on_.blocks[static_cast<std::size_t>(k)]) > 0; });
    on_.pass(givers_, 1, [&](int k, Real* tile) {
        for (int c = 0; c < cells; ++c) tell_holes(k, c, tile);
    });
    each_block([&](int k) { each_on(k, [&](int c, const OpenCell<Real, Dim>&) { fill_hole(k, c); }); });
    tell_children();
    on_.list(givers_, [&](int k) { return !on_cells_[static_cast<std::size_t>(k)].cell.empty(); });
    on_.list(sharers_, [&](int k) {
        const OnCells& on = on_cells_[static_cast<std::size_t>(k)];
        return on.has_children || on.has_roots;
    });
}

/// Those of nodes without cells' forces.
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::keep_accelerations() {
    acceleration_.resize(on_.near_nodes.size() * cells);
    Host::launch(static_cast<std::int64_t>(on_.near_nodes.size()), [&](int j) {
        const std::ptrdiff_t at = on_.stored(j * cells);
        for (int n = 0; at >= 0 && n < cells; ++n)
            acceleration_[static_cast<std::size_t>(j * cells + n)] = on_.scene.held[at + n].acceleration;
    });
}

template <class Real, int Dim>
void SurfacePressures<Real, Dim>::find_cells(const Substep& first) {
    cells_.resize(on_.blocks.size() * cells);
    on_cells_.resize(on_.blocks.size());
    if (on_.counts_energy) energy_.assign(on_.blocks.size(), {});
    each_block([&](int k) {
        OnCells& on = on_cells_[static_cast<std::size_t>(k)];
        on.cell.clear();
        on.has_children = on.has_roots = false;
        for (int c = 0; c < cells; ++c) {
            OpenCell<Real, Dim>& cell = cells_[static_cast<std::size_t>(k * cells + c)];
            cell.on = cell.child = false;
            if (!on_.place_of[static_cast<std::size_t>(k * cells + c)].near) continue;
            cell = {};
            find_cell(k, c, first);
            if (cell.on) on.cell.push_back(c);
            on.has_children = on.has_children || cell.child;
        }
    });
}

/// What roots have become, to those who share with them.
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::tell_children() {
    each_block([&](int k) {
        each_on(k, [&](int, const OpenCell<Real, Dim>& cell) {
            OnCells& on = on_cells_[static_cast<std::size_t>(k)];
            on.has_roots = on.has_roots || (cell.on && !cell.child && cell.mixed);
        });
    });
    on_.list(givers_, [&](int k) { return on_cells_[static_cast<std::size_t>(k)].has_roots; });
    on_.pass(givers_, 2, [&](int k, Real* tile) {
        each_on(k, [&](int c, const OpenCell<Real, Dim>& cell) {
            if (!cell.on || cell.child || !cell.mixed) return;
            Real* own = tile + (tile_offset<Dim, 3>(c) + to_middle) * node_reals;
            own[lane(root_pressure)] = cell.state.pressure;
            own[lane(root_bulk)] = cell.state.loose ? -cell.state.bulk : cell.state.bulk;
            own[lane(root_volume)] = cell.state.volume, own[lane(root_source)] = cell.state.source;
        });
    });
    each_block([&](int k) {
        each_on(k, [&](int c, OpenCell<Real, Dim>& cell) {
            if (!cell.child) return;
            const Real* root = on_.sum_at(k, root_node(k, c));
            const Real bulk = root[lane(root_bulk)];
            cell.on = root[lane(root_volume)] > Real(0);
            cell.state.pressure = root[lane(root_pressure)], cell.state.bulk = bulk < Real(0) ? -bulk : bulk;
            cell.state.volume = root[lane(root_volume)], cell.state.source = root[lane(root_source)];
            cell.state.loose = bulk < Real(0);
        });
    });
}

/// The tile's node in the middle of the cell with which a cell has its pressure, which may be itself.
template <class Real, int Dim>
int SurfacePressures<Real, Dim>::root_node(int k, int c) const {
    const auto i = static_cast<std::size_t>(k * cells + c);
    int n = tile_offset<Dim, 3>(c) + to_middle;
    for (int a = 0, stride = 1; a < Dim && cells_[i].child; ++a, stride *= side) n += stride * on_.place_of[i].root[a];
    return n;
}

/// x.
template <class Real, int Dim>
Real SurfacePressures<Real, Dim>::share_of(int k, int c) const {
    const bool cut = on_.place_of[static_cast<std::size_t>(k * cells + c)].cut != nullptr;
    const int corner = tile_offset<Dim, 3>(c);
    double least = 1e9, soil = 0, space = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const std::int32_t near = on_.node_at(k, corner + at);
        const SurfaceNode<Dim>& n = on_.surface_nodes[static_cast<std::size_t>(near)];
        const std::ptrdiff_t held = on_.stored(near);
        const double filling = held < 0 ? 0.0 : double(on_.scene.held[held].filling);
        if (!(n.capacity > 0)) return;
        if (cut) soil += filling, space += n.capacity;
        if (!cut && n.distance >= 1 && n.capacity > 0.1) least = std::min(least, filling / n.capacity);
    });
    if (cut) least = space > 0 ? soil / space : 0;
    return share_of_integral(static_cast<Real>(least < 1e8 ? least : 0));
}

/// Of a cell by itself: pressure and bulk are sums over its particles yet, and a child's head the sum of G_ic . G_ir.
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::find_cell(int k, int c, const Substep&) {
    const auto i = static_cast<std::size_t>(k * cells + c);
    const SurfaceCell<Dim>& place = on_.place_of[i];
    OpenCell<Real, Dim>& cell = cells_[i];
    const std::int32_t block = on_.blocks[static_cast<std::size_t>(k)];
    const ListView<Dim> list = on_.patch.list();
    if (!place.near) return;
    if (list.count(block) > 0) on_.scene.cells[first_cell(block) + c].volume = Real(0);
    if (place.part == CellPart::solid) return;
    CellMoments<Real, Dim> moments;
    sum_particles(block, c, moments, cell);
    cell.share = share_of(k, c);
    const bool shares = place.shares && (place.cut->volume < small_cell || !(cell.particles > Real(0)));
    if (!(cell.particles > Real(0)) && !(cell.share > Real(0))) return;
    make_rows(k, c, moments, cell);
    if (!(cell.state.volume > Real(1e-7) * Real(std::pow(on_.h, Dim)))) return;
    cell.on = true;
    cell.child = shares;
    weigh_cell(k, c, cell);
}

template <class Real, int Dim>
void SurfacePressures<Real, Dim>::sum_particles(std::int32_t block, int c, CellMoments<Real, Dim>& moments,
                                                OpenCell<Real, Dim>& cell) const {
    moments.clear();
    const ListView<Dim> list = on_.patch.list();
    if (list.count(block) == 0) return;
    const HostCellParticles<Real, Dim> particles{on_.patch.particles.view(), on_.method.grid_bulk()};
    const std::uint32_t* bounds = list.cell_first + std::size_t(block) * (cells + 1) + c;
    for (std::uint32_t n = list.first[block] + bounds[0]; n < list.first[block] + bounds[1]; ++n) {
        const CellParticle<Real, Dim> q = particles(list.slot[n]);
        if (!(q.bulk > Real(0))) continue;
        moments.add(q.volume, q.fraction);
        cell.particles += q.volume;
        cell.state.pressure += q.volume * q.trace * Real(1.0 / 3.0);
        cell.state.bulk += q.volume * q.bulk;
    }
}

/// F_ic of a cell, by its node [cells].
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::faces_of(const Place& node, const CutCell<Dim>* cut,
                                           CellNode<Real, Dim>* face) const {
    const Real scale = static_cast<Real>(std::pow(on_.h, Dim - 1));
    for (int i = 0; cut && i < nodes; ++i)
        for (int a = 0; a < Dim; ++a) face[i].gradient[a] = scale * static_cast<Real>(cut->face[i][a]);
    if (cut) return;
    Real x[Dim][cell_powers];
    CellBasis<Real> basis[Dim];
    for (int a = 0; a < Dim; ++a) {
        full_moments(on_.method.capacity, a, node[a], x[a]);
        basis[a] = cell_basis<Real>(on_.method.context.walls.ghosts(a, node[a] - 1, 3));
    }
    CellMoments<Real, Dim> moments;
    moments.clear();
    moments.add_product(static_cast<Real>(std::pow(on_.h, Dim)), x);
    all_cell_nodes(moments, basis, on_.method.context.inverse_cell, face);
}

template <class Real, int Dim>
void SurfacePressures<Real, Dim>::make_rows(int k, int c, const CellMoments<Real, Dim>& moments,
                                            OpenCell<Real, Dim>& cell) const {
    const SurfaceCell<Dim>& place = on_.place_of[static_cast<std::size_t>(k * cells + c)];
    const Place node = on_.cell_node(k, c);
    const CellBox<Dim> box = on_.geometry.box(node);
    CellBasis<Real> basis[Dim];
    double volume = place.cut ? place.cut->volume : 1;
    for (int a = 0; a < Dim; ++a) {
        basis[a] = cell_basis<Real>(on_.method.context.walls.ghosts(a, node[a] - 1, 3));
        if (!place.cut) volume *= box.end[a][1] - box.end[a][0];
    }
    all_cell_nodes(moments, basis, on_.method.context.inverse_cell, cell.factor);
    CellNode<Real, Dim> face[nodes];
    faces_of(node, place.cut, face);
    Real share[nodes];
    bool light = false;
    int n = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const std::int32_t near = on_.node_at(k, tile_offset<Dim, 3>(c) + at);
        const SurfaceNode<Dim>& beside = on_.surface_nodes[static_cast<std::size_t>(near)];
        const std::ptrdiff_t held = on_.stored(near);
        share[n++] = static_cast<Real>(node_share(beside, held < 0 ? 0.0 : double(on_.scene.held[held].filling)));
        light = light || beside.capacity < light_capacity;
    });
    const Real scale = static_cast<Real>(std::pow(on_.h, Dim - 1));
    open_rows(
        static_cast<Real>(volume * std::pow(on_.h, Dim)), [&](int i, int a) { return face[i].gradient[a]; },
        [&](int i, int a) { return place.cut ? scale * static_cast<Real>(place.cut->bed[i][a]) : Real(0); },
        [&](int i) { return share[i]; }, cell);
    cell.whole = !place.cut && cell.share == Real(1) && !light;
}

/// Source, weight, and of a child the part of the weight that it has together with its root.
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::weigh_cell(int k, int c, OpenCell<Real, Dim>& cell) const {
    const SurfaceCell<Dim>& place = on_.place_of[static_cast<std::size_t>(k * cells + c)];
    CellNode<Real, Dim> of_root[nodes];
    if (cell.child) {
        Place root = on_.cell_node(k, c);
        for (int a = 0; a < Dim; ++a) root[a] += place.root[a];
        faces_of(root, on_.geometry.cut_at(root), of_root);
    }
    Mat<Real, Dim> L = zero_mat<Real, Dim>();
    int n = 0;
    each_node<Dim, 3>([&](int at, int i, int j, int l) {
        const CellNode<Real, Dim>& g = cell.factor[n++];
        const std::int32_t near = on_.node_at(k, tile_offset<Dim, 3>(c) + at);
        const Real* v = on_.values(near);
        if (!v) return;
        const int offset[3] = {i, j, l};
        int there = 0;
        bool both = cell.child;
        for (int a = Dim - 1; a >= 0; --a) {
            const int o = offset[a] - place.root[a];
            both = both && o >= 0 && o < 3;
            there = 3 * there + o;
        }
        Real square = Real(0), cross = Real(0);
        for (int b = 0; b < Dim; ++b) {
            square += g.gradient[b] * g.gradient[b];
            if (both) cross += g.gradient[b] * of_root[there].gradient[b];
            for (int a = 0; a < Dim; ++a) L(a, b) += g.gradient[b] * v[a];
        }
        cell.weight += square / v[quad - 1];
        if (both) {
            const double filling = double(on_.scene.held[on_.stored(near)].filling);
            cell.state.head +=
                Real(node_share(on_.surface_nodes[static_cast<std::size_t>(near)], filling)) * cross / v[quad - 1];
        }
    });
    for (int a = 0; a < Dim; ++a)
        for (int b = 0; b < Dim; ++b) cell.state.source += L(a, b) * L(b, a);
    cell.state.source /= cell.state.volume * cell.state.volume;
}

/// Of a cell with its children: means and the bounded modulus.
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::close_cell(int k, int c, const Substep& first) {
    OpenCell<Real, Dim>& cell = cells_[static_cast<std::size_t>(k * cells + c)];
    if (!cell.on || cell.child) return;
    const Real* told = on_.sum_at(k, tile_offset<Dim, 3>(c) + to_middle);
    CellPressure<Real>& state = cell.state;
    const Real particles = cell.particles + told[lane(child_particles)];
    cell.mixed = told[lane(child_volume)] > Real(0);
    if (particles > Real(0)) {
        state.pressure = (state.pressure + told[lane(child_pressure)]) / particles;
        state.bulk = (state.bulk + told[lane(child_bulk)]) / particles;
    }
    cell.particles = particles;
    state.volume += told[lane(child_volume)];
    const Real weight = cell.weight + told[lane(child_weight)] + Real(2) * cell.share * told[lane(child_cross)];
    cell.weight = weight;
    if (particles > Real(0)) bound(cell, first);
}

template <class Real, int Dim>
void SurfacePressures<Real, Dim>::bound(OpenCell<Real, Dim>& cell, const Substep& first) const {
    CellPressure<Real>& state = cell.state;
    if ((cell.whole && !cell.mixed) || !(cell.weight > Real(0))) return;
    const Real bulk = bounded_bulk<Dim>(state.bulk, state.volume, cell.weight, first.dt, first.damping());
    state.loose = bulk < state.bulk;
    state.pressure *= bulk / state.bulk;
    state.bulk = bulk;
}

/// What a cell with particles tells the cells around it, by the nodes in their middles.
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::tell_holes(int k, int c, Real* tile) const {
    const auto i = static_cast<std::size_t>(k * cells + c);
    const std::int32_t block = on_.blocks[static_cast<std::size_t>(k)];
    const OpenCell<Real, Dim>& cell = cells_[i];
    const CellPressure<Real>* from = nullptr;
    if (cell.on && !cell.child && cell.particles > Real(0)) from = &cell.state;
    if (!on_.place_of[i].near && on_.patch.list().count(block) > 0)
        from = &on_.scene.cells[first_cell(block) + std::size_t(c)];
    if (!from || !(from->volume > Real(0)) || !(from->bulk > Real(0))) return;
    each_node<Dim, 3>([&](int at, int, int, int) {
        Real* to = tile + (tile_offset<Dim, 3>(c) + at) * node_reals;
        to[lane(hole_volume)] += from->volume;
        to[lane(hole_pressure)] += from->volume * from->pressure;
        to[lane(hole_bulk)] += from->volume * from->bulk;
    });
}

/// A cell without particles takes what the cells around it have, by volume.
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::fill_hole(int k, int c) {
    OpenCell<Real, Dim>& hole = cells_[static_cast<std::size_t>(k * cells + c)];
    if (!hole.on || hole.child || hole.particles > Real(0)) return;
    const Real* around = on_.sum_at(k, tile_offset<Dim, 3>(c) + to_middle);
    const Real volume = around[lane(hole_volume)];
    hole.on = volume > Real(0);
    if (!hole.on) return;
    hole.state.pressure = around[lane(hole_pressure)] / volume;
    hole.state.bulk = around[lane(hole_bulk)] / volume;
}

template <class Real, int Dim>
void SurfacePressures<Real, Dim>::press(const Substep& substep) {
    const Real damping = static_cast<Real>(substep.damping());
    on_.pass(givers_, 1, [&](int k, Real* tile) {
        each_on(k, [&](int c, const OpenCell<Real, Dim>& cell) {
            if (!cell.on) return;
            const Real force = cell.state.pressure + damping * cell.state.change;
            int n = 0;
            each_node<Dim, 3>([&](int at, int, int, int) {
                Real* to = tile + (tile_offset<Dim, 3>(c) + at) * node_reals;
                for (int a = 0; a < Dim; ++a) to[a] -= cell.factor[n].gradient[a] * force;
                ++n;
            });
            tell_pressure(k, c, double(force) * substep.dt);
        });
    });
    Host::launch(static_cast<std::int64_t>(on_.near_nodes.size()), [&](int j) {
        const std::ptrdiff_t at = on_.stored(j * cells);
        if (at < 0 || !on_.sums.known[static_cast<std::size_t>(j)]) return;
        for (int n = 0; n < cells; ++n) {
            const Real* node = on_.values(j * cells + n);
            const Real* sum = on_.sum_of(j * cells + n);
            Vec<Real, Dim>& held = on_.scene.held[at + n].acceleration;
            held = acceleration_[static_cast<std::size_t>(j * cells + n)];
            for (int a = 0; node && a < Dim; ++a) held[a] += sum[a] / node[quad - 1];
        }
    });
}

/// What the structure bears of a cell's pressure.
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::tell_pressure(int k, int c, double impulse) {
    const OpenCell<Real, Dim>& cell = cells_[static_cast<std::size_t>(k * cells + c)];
    Vec<double, Dim> given, place;
    bool any = false;
    const Place node = on_.cell_node(k, c);
    for (int a = 0; a < Dim; ++a) {
        given[a] = impulse * double(cell.bed[a]);
        any = any || given[a] != 0;
        place[a] = on_.scene.field.origin[a] + on_.h * node[a];
    }
    if (any) on_.tell(structure_of(k, c), given, place);
}

/// Whose surface a cell is at.
template <class Real, int Dim>
int SurfacePressures<Real, Dim>::structure_of(int k, int c) const {
    const CutCell<Dim>* cut = on_.place_of[static_cast<std::size_t>(k * cells + c)].cut;
    if (cut) return cut->structure;
    return on_.surface_nodes[static_cast<std::size_t>(on_.node_at(k, tile_offset<Dim, 3>(c) + to_middle))].structure;
}

template <class Real, int Dim>
void SurfacePressures<Real, Dim>::update(const Substep& substep) {
    each_block([&](int k) {
        each_on(k, [&](int c, OpenCell<Real, Dim>& cell) {
            if (!cell.on) return;
            cell.flux = flux_of(k, c, cell);
            if (on_.counts_energy) count_taken(k, c, substep);
        });
    });
    on_.pass(sharers_, 1, [&](int k, Real* tile) {
        each_on(k, [&](int c, const OpenCell<Real, Dim>& cell) {
            if (cell.on && (cell.child || cell.mixed)) tile[root_node(k, c) * node_reals] += cell.flux;
        });
    });
    const Real dt = static_cast<Real>(substep.dt), time = static_cast<Real>(0.5 * (substep.number + 0.5) * substep.dt);
    each_block([&](int k) {
        each_on(k, [&](int c, OpenCell<Real, Dim>& cell) {
            if (!cell.on) return;
            const Real flux = cell.child || cell.mixed ? on_.sum_at(k, root_node(k, c))[0] : cell.flux;
            const Real step = dt * (flux / cell.state.volume - time * cell.state.source);
            cell.state.change = cell.state.bulk * step;
            cell.state.pressure += cell.state.change;
            cell.state.increment += step;
        });
    });
    if (substep.is_last()) give_cells();
}

/// sum_i G_ic . v_i - S_c . V.
template <class Real, int Dim>
Real SurfacePressures<Real, Dim>::flux_of(int k, int c, const OpenCell<Real, Dim>& cell) const {
    const Structure<Dim>& s = on_.scene.field.structure[structure_of(k, c)];
    Real flux = Real(0);
    for (int a = 0; a < Dim; ++a) flux -= cell.bed[a] * static_cast<Real>(s.velocity[a]);
    int n = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const CellNode<Real, Dim>& g = cell.factor[n++];
        const Real* v = on_.values(on_.node_at(k, tile_offset<Dim, 3>(c) + at));
        for (int a = 0; v && a < Dim; ++a) flux += g.gradient[a] * v[a];
    });
    return flux;
}

/// To the gather, which knows cells of occupied blocks.
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::give_cells() {
    for (std::size_t k = 0; k < on_.blocks.size(); ++k) {
        if (on_.patch.list().count(on_.blocks[k]) == 0) continue;
        for (int c = 0; c < cells; ++c) {
            const OpenCell<Real, Dim>& cell = cells_[k * cells + static_cast<std::size_t>(c)];
            if (!cell.on) continue;
            CellPressure<Real>& to = on_.scene.cells[first_cell(on_.blocks[k]) + c];
            const Real head = to.head;
            to = cell.state;
            to.head = head;
            if (!on_.counts_energy) continue;
            energy_[k].cells.add(on_.scene.quantum.of(-given_to_particles(on_.blocks[k], c)));
        }
    }
}

template <class Real, int Dim>
double SurfacePressures<Real, Dim>::pressure_on_surface(int k, int c, double damping) const {
    if (cells_.empty()) return 0;
    const OpenCell<Real, Dim>& cell = cells_[static_cast<std::size_t>(k * cells + c)];
    return cell.on ? -double(cell.bears) * (double(cell.state.pressure) + damping * double(cell.state.change)) : 0.0;
}

template class SurfacePressures<float, 2>;
template class SurfacePressures<float, 3>;
template class SurfacePressures<double, 2>;
template class SurfacePressures<double, 3>;

}  // namespace moraine
