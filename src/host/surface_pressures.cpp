// The pressure of cells beside surfaces on the host (core/surfaces/open_faces.hpp).

#include "host/surface_pressures.hpp"

#include "core/fluid/pressure_kernels.hpp"

namespace moraine {

template <class Real, int Dim>
void SurfacePressures<Real, Dim>::find(const Substep& first) {
    hold_nodes();
    find_cells();
    weigh_cells();
    on_.list(givers_, [&](int k) { return on_cells_[static_cast<std::size_t>(k)].has_children; });
    on_.pass(givers_, 2, [&](int k, Real* tile) {
        each_on(k, [&](int c, const OpenCell<Real, Dim>& cell) {
            if (!cell.child) return;
            Real* root = tile + root_node(k, c) * node_reals;
            for (int q = 0; q < child_lanes; ++q) root[lane(q)] += told_by_child(cell, q);
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

/// What nodes hold, without cells' forces.
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::hold_nodes() {
    held_.resize(on_.near_nodes.size());
    acceleration_.resize(on_.near_nodes.size() * cells);
    Host::launch(static_cast<std::int64_t>(on_.near_nodes.size()), [&](int j) {
        const std::ptrdiff_t at = on_.stored(j * cells);
        HeldNode<Real, Dim>*& held = held_[static_cast<std::size_t>(j)];
        held = at < 0 ? nullptr : on_.scene.held + at;
        for (int n = 0; held && n < cells; ++n)
            acceleration_[static_cast<std::size_t>(j * cells + n)] = held[n].acceleration;
    });
}

template <class Real, int Dim>
void SurfacePressures<Real, Dim>::find_nodes(int k, TileNodes& tile) const {
    for (int n = 0; n < tile_nodes; ++n) {
        const std::int32_t near = on_.node_at(k, n);
        const HeldNode<Real, Dim>* held = held_[static_cast<std::size_t>(near / cells)];
        tile.place[n] = on_.surface_node(near);
        tile.filling[n] = held ? double(held[near % cells].filling) : 0.0;
    }
}

template <class Real, int Dim>
void SurfacePressures<Real, Dim>::find_cells() {
    cells_.resize(on_.blocks.size() * cells);
    on_cells_.resize(on_.blocks.size());
    if (on_.counts_energy) energy_.assign(on_.blocks.size(), {});
    each_block([&](int k) {
        OnCells& on = on_cells_[static_cast<std::size_t>(k)];
        on.cell.clear();
        on.has_children = on.has_roots = false;
        if (!on_.has_soil[static_cast<std::size_t>(k)]) return;
        TileNodes nodes_of_tile;
        if (on_.at(k).has_cells) find_nodes(k, nodes_of_tile);
        for (int c = 0; c < cells; ++c) {
            OpenCell<Real, Dim>& cell = cells_[static_cast<std::size_t>(k * cells + c)];
            cell.on = cell.child = false;
            if (!on_.cell_at(k, c).near) continue;
            cell.begin();
            find_cell(k, c, nodes_of_tile);
            if (cell.on) on.cell.push_back(c);
            on.has_children = on.has_children || cell.child;
        }
    });
}

/// M_i, and what it makes of cells.
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::weigh_cells() {
    on_.list(givers_, [&](int k) { return !on_cells_[static_cast<std::size_t>(k)].cell.empty(); });
    on_.pass(givers_, 1, [&](int k, Real* tile) {
        each_on(k, [&](int c, const OpenCell<Real, Dim>& cell) {
            int n = 0;
            each_node<Dim, 3>([&](int at, int, int, int) {
                tile[(tile_offset<Dim, 3>(c) + at) * node_reals] += size_of(cell.factor[n++]);
            });
        });
    });
    Host::launch(static_cast<std::int64_t>(givers_.size()), [&](int i) {
        const int k = givers_[static_cast<std::size_t>(i)];
        TileNodes nodes_of_tile;
        find_nodes(k, nodes_of_tile);
        each_on(k, [&](int c, OpenCell<Real, Dim>& cell) {
            const int corner = tile_offset<Dim, 3>(c);
            const auto push = [&](int at) { return on_.sum_at(k, corner + at)[0]; };
            weigh_open_cell(grid_, NodesOf{{*this, k, corner}, nodes_of_tile}, push, cell);
        });
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
            for (int q = 0; q < root_lanes; ++q) own[lane(q)] = told_by_root(cell, q);
        });
    });
    each_block([&](int k) {
        each_on(k, [&](int c, OpenCell<Real, Dim>& cell) {
            if (!cell.child) return;
            take_root(on_.sum_at(k, root_node(k, c)), cell);
        });
    });
}

/// The tile's node in the middle of the cell with which a cell has its pressure, which may be itself.
template <class Real, int Dim>
int SurfacePressures<Real, Dim>::root_node(int k, int c) const {
    const auto i = static_cast<std::size_t>(k * cells + c);
    int n = tile_offset<Dim, 3>(c) + to_middle;
    for (int a = 0, stride = 1; a < Dim && cells_[i].child; ++a, stride *= side)
        n += stride * on_.cell_at(k, c).root[a];
    return n;
}

/// Of a cell by itself.
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::find_cell(int k, int c, const TileNodes& nodes_of_tile) {
    const auto i = static_cast<std::size_t>(k * cells + c);
    const SurfaceCell<Dim>& place = on_.cell_at(k, c);
    OpenCell<Real, Dim>& cell = cells_[i];
    const std::int32_t block = on_.blocks[static_cast<std::size_t>(k)];
    if (!place.near) return;
    if (on_.patch.list().count(block) > 0) on_.scene.cells[first_cell(block) + c].volume = Real(0);
    if (place.part == CellPart::solid) return;
    CellMoments<Real, Dim> moments;
    sum_particles(block, c, moments, cell);
    find_open_cell(grid_, place, on_.at(k).cell_node(c), moments,
                   NodesOf{{*this, k, tile_offset<Dim, 3>(c)}, nodes_of_tile}, cell);
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

/// Of a cell with its children: means and the bounded modulus.
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::close_cell(int k, int c, const Substep& first) {
    OpenCell<Real, Dim>& cell = cells_[static_cast<std::size_t>(k * cells + c)];
    if (!cell.on || cell.child) return;
    close_open_cell(on_.sum_at(k, tile_offset<Dim, 3>(c) + to_middle), first.dt, first.damping(), cell);
}

/// What a cell with particles tells the cells around it, by the nodes in their middles.
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::tell_holes(int k, int c, Real* tile) const {
    const auto i = static_cast<std::size_t>(k * cells + c);
    const std::int32_t block = on_.blocks[static_cast<std::size_t>(k)];
    const OpenCell<Real, Dim>& cell = cells_[i];
    const CellPressure<Real>* from = nullptr;
    if (cell.on && !cell.child && cell.particles > Real(0)) from = &cell.state;
    if (!on_.cell_at(k, c).near && on_.patch.list().count(block) > 0)
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
    fill_open_hole(on_.sum_at(k, tile_offset<Dim, 3>(c) + to_middle), hole);
}

template <class Real, int Dim>
void SurfacePressures<Real, Dim>::press(const Substep& substep) {
    const Real damping = static_cast<Real>(substep.damping());
    on_.pass(givers_, 1, [&](int k, Real* tile) {
        StructureTally<Real, Dim> tally(on_.scene);
        each_on(k, [&](int c, const OpenCell<Real, Dim>& cell) {
            if (!cell.on) return;
            const Real force = cell.state.pressure + damping * cell.state.change;
            int n = 0;
            each_node<Dim, 3>([&](int at, int, int, int) {
                Real* to = tile + (tile_offset<Dim, 3>(c) + at) * node_reals;
                for (int a = 0; a < Dim; ++a) to[a] -= cell.factor[n].gradient[a] * force;
                ++n;
            });
            tell_pressure(k, c, double(force) * substep.dt, tally);
        });
    });
    Host::launch(static_cast<std::int64_t>(on_.near_nodes.size()), [&](int j) {
        HeldNode<Real, Dim>* of_block = held_[static_cast<std::size_t>(j)];
        if (!of_block || !on_.sums.known[static_cast<std::size_t>(j)]) return;
        for (int n = 0; n < cells; ++n) {
            const Real* node = on_.values(j * cells + n);
            const Real* sum = on_.sum_of(j * cells + n);
            Vec<Real, Dim>& held = of_block[n].acceleration;
            held = acceleration_[static_cast<std::size_t>(j * cells + n)];
            for (int a = 0; node && a < Dim; ++a) held[a] += sum[a] / node[quad - 1];
        }
    });
}

/// What the structure bears of a cell's pressure.
template <class Real, int Dim>
void SurfacePressures<Real, Dim>::tell_pressure(int k, int c, double impulse, StructureTally<Real, Dim>& tally) const {
    const OpenCell<Real, Dim>& cell = cells_[static_cast<std::size_t>(k * cells + c)];
    Vec<double, Dim> given, place;
    bool any = false;
    const Place node = on_.at(k).cell_node(c);
    for (int a = 0; a < Dim; ++a) {
        given[a] = impulse * double(cell.bed[a]);
        any = any || given[a] != 0;
        place[a] = on_.scene.field.origin[a] + on_.h * node[a];
    }
    if (!any) return;
    const int structure = on_.cell_at(k, c).structure;
    const Structure<Dim>& s = on_.scene.field.structure[structure];
    if (!s.turns) return tally.add(structure, given, place);
    place = image_near(on_.scene.field, s, place);
    tally.add(structure, given, place, zero_vec<double, Dim>(),
              impulse * couple_of(cell, on_.centre_of(k, c, s) - place, on_.h));
}

template <class Real, int Dim>
void SurfacePressures<Real, Dim>::update(const Substep& substep) {
    each_block([&](int k) {
        each_on(k, [&](int c, OpenCell<Real, Dim>& cell) {
            if (!cell.on) return;
            const int structure = on_.cell_at(k, c).structure;
            cell.flux =
                flux_into(cell, on_.scene.field.structure[structure], ValuesOf{*this, k, tile_offset<Dim, 3>(c)});
            cell.flux -= static_cast<Real>(turned_flux(k, c));
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
            advance_open_cell(flux, dt, time, cell);
        });
    });
    if (substep.is_last()) give_cells();
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
            to = finished_cell(cell, to.head);
            if (!on_.counts_energy) continue;
            energy_[k].cells.add(on_.scene.quantum.of(-given_to_particles(on_.blocks[k], c)));
        }
    }
}

template <class Real, int Dim>
double SurfacePressures<Real, Dim>::pressure_at(int k, int c, double damping) const {
    return cells_.empty() ? 0 : pressure_on_surface(cells_[static_cast<std::size_t>(k * cells + c)], damping);
}

template class SurfacePressures<float, 2>;
template class SurfacePressures<float, 3>;
template class SurfacePressures<double, 2>;
template class SurfacePressures<double, 3>;

}  // namespace moraine
