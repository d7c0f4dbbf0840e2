// What of surfaces holds for an epoch, and how its sums travel.

#include "comm/host_surfaces.hpp"

#include "core/morton.hpp"

namespace moraine {

namespace {

template <class Real, int Dim>
Walls<double, Dim> doubled(const Walls<Real, Dim>& walls) {
    Walls<double, Dim> w{};
    for (int a = 0; a < Dim; ++a)
        for (int s = 0; s < 2; ++s)
            w.plane[a][s] = walls.plane[a][s], w.kind[a][s] = walls.kind[a][s], w.fold[a][s] = walls.fold[a][s];
    return w;
}

template <class Real, int Dim>
NodeCapacity<double, Dim> doubled(const NodeCapacity<Real, Dim>& ends) {
    NodeCapacity<double, Dim> e{};
    for (int a = 0; a < Dim; ++a)
        for (int s = 0; s < 2; ++s)
            e.plane[a][s] = ends.plane[a][s], e.on[a][s] = double(ends.on[a][s]),
            e.next[a][s] = double(ends.next[a][s]);
    return e;
}

/// Node of a block's cell or tile: its first cell's.
template <int Dim>
Vec<std::int32_t, Dim> first_of(const Vec<std::int32_t, Dim>& block) {
    Vec<std::int32_t, Dim> node;
    for (int a = 0; a < Dim; ++a) node[a] = first_node<Quadratic>(block[a]) + 1;
    return node;
}

}  // namespace

template <class Real, int Dim>
void HostSurfaces<Real, Dim>::place(const ContactField<Dim>& field, bool moves) {
    if (made_ && !moves) return;
    scene_.field = field;
    geometry_.begin(field, doubled(method_.context.walls), doubled(method_.capacity));
    if (moves) geometry_.forget();
    make(patch_.tables());
    std::vector<std::uint8_t> needed(near_of_.size());
    for (std::size_t c = 0; c < needed.size(); ++c) needed[c] = near_of_[c] >= 0;
    patch_.keep_nodes(std::move(needed));
    made_ = true;
}

template <class Real, int Dim>
void HostSurfaces<Real, Dim>::begin_step(const SurfaceScene<Real, Dim>& scene, Halo<Real, Dim>& halo,
                                         const ContactPairs<Dim>& pairs) {
    scene_ = scene;
    halo_ = &halo;
    pairs_ = &pairs;
    find_gaps(pairs);
    weigh();
}

template <class Real, int Dim>
void HostSurfaces<Real, Dim>::make(const EpochTables<Dim>& tables) {
    list_blocks(tables);
    find_nodes(tables);
    place_.assign(blocks_.size() * cells, {});
    ring_.assign(blocks_.size() * tile_nodes, {});
    elements_.assign(blocks_.size(), {});
    for (int k = 0; k < static_cast<int>(blocks_.size()); ++k) find_block(k);
    tiles_.resize((ghosts_ + blocks_.size()) * tile_nodes * node_reals);
    const std::size_t near = near_nodes_.size() * cells;
    sums_.resize(near * node_reals);
    shares_.resize(near * node_reals);
}

/// Whether a block may have a cell or a node that a surface is near: by the distance of its middle.
template <class Real, int Dim>
bool HostSurfaces<Real, Dim>::is_near(const Place& block) const {
    constexpr double reach = 3.5 + 2 * (Dim == 2 ? 1.4143 : 1.7321);
    const Place first = first_of(block);
    for (int k = 0; k < scene_.field.count; ++k) {
        const Structure<Dim>& s = scene_.field.structure[k];
        if (distance_bound(s, scene_.field.corners, node_place(scene_.field, s, &first[0], 1.5)) < reach * h_)
            return true;
    }
    return false;
}

template <class Real, int Dim>
void HostSurfaces<Real, Dim>::list_blocks(const EpochTables<Dim>& tables) {
    const std::size_t own = tables.own.size();
    ghosts_ = tables.ghost.size();
    blocks_.clear();
    bed_of_.assign(own + ghosts_, -1);
    tile_index_.assign(own + ghosts_, -1);
    for (std::size_t b = 0; b < own; ++b) {
        if (!is_near(tables.position[b])) continue;
        bed_of_[b] = static_cast<std::int32_t>(blocks_.size());
        tile_index_[b] = static_cast<std::int32_t>(ghosts_ + blocks_.size());
        blocks_.push_back(static_cast<std::int32_t>(b));
    }
    for (std::size_t g = 0; g < ghosts_; ++g) {
        const auto at = Morton<Dim>::decode(tables.ghost[g]);
        Place block;
        for (int a = 0; a < Dim; ++a) block[a] = static_cast<std::int32_t>(at[static_cast<std::size_t>(a)]);
        if (is_near(block)) bed_of_[own + g] = 0;
    }
    near_nodes_.clear();
    near_of_.assign(tables.node_position.size(), -1);
    for (std::size_t c = 0; c < near_of_.size(); ++c)
        for (int d = 0; d < Block<Dim>::corners; ++d) {
            const std::int32_t source = tables.source[c * Block<Dim>::corners + static_cast<std::size_t>(d)];
            if (source < 0 || bed_of_[static_cast<std::size_t>(source)] < 0) continue;
            near_of_[c] = static_cast<std::int32_t>(near_nodes_.size());
            near_nodes_.push_back(static_cast<std::int32_t>(c));
            break;
        }
}

template <class Real, int Dim>
void HostSurfaces<Real, Dim>::find_nodes(const EpochTables<Dim>& tables) {
    surface_nodes_.resize(near_nodes_.size() * cells);
    for (std::size_t j = 0; j < near_nodes_.size(); ++j)
        for (int n = 0; n < cells; ++n) {
            Place node = tables.node_position[static_cast<std::size_t>(near_nodes_[j])];
            for (int a = 0; a < Dim; ++a) node[a] = 4 * node[a] - method_.stencil.origin + cell_coordinate<Dim>(n, a);
            surface_nodes_[j * cells + static_cast<std::size_t>(n)] = geometry_.node(node);
        }
    node_at_.resize(blocks_.size() * tile_nodes);
    const BlockTable<Dim> table = patch_.table();
    for (std::size_t k = 0; k < blocks_.size(); ++k)
        for (int n = 0; n < tile_nodes; ++n) {
            int corner = 0, at = 0;
            for (int a = 0, rest = n; a < Dim; ++a, rest /= side) {
                const int x = rest % side;
                corner |= (x >> 2) << a, at |= (x & 3) << (2 * a);
            }
            const std::int32_t c = table.node_block[blocks_[k] * Block<Dim>::corners + corner];
            node_at_[k * tile_nodes + static_cast<std::size_t>(n)] = near_of_[static_cast<std::size_t>(c)] * cells + at;
        }
}

/// The node of a block's cell.
template <class Real, int Dim>
typename HostSurfaces<Real, Dim>::Place HostSurfaces<Real, Dim>::cell_node(int k, int c) const {
    Place node = first_of(patch_.tables().position[static_cast<std::size_t>(blocks_[static_cast<std::size_t>(k)])]);
    for (int a = 0; a < Dim; ++a) node[a] += cell_coordinate<Dim>(c, a);
    return node;
}

template <class Real, int Dim>
void HostSurfaces<Real, Dim>::find_block(int k) {
    const Place first = cell_node(k, 0);
    for (int n = 0; n < tile_nodes; ++n) {
        Place node = first;
        for (int a = 0, rest = n; a < Dim; ++a, rest /= side) node[a] += rest % side - 1;
        if (geometry_.part(node) != CellPart::cut) continue;
        const CutCell<Dim>& cut = geometry_.cut(node);
        if (!(cut.area > 1e-7)) continue;
        RingElement& e = ring_[static_cast<std::size_t>(k * tile_nodes + n)];
        e.area = cut.area, e.normal = cut.normal, e.structure = cut.structure;
        for (int a = 0; a < Dim; ++a) e.place[a] = node[a] - first[a] + cut.centre[a];
    }
    for (int c = 0; c < cells; ++c) {
        SurfaceCell& cell = place_[static_cast<std::size_t>(k * cells + c)];
        const Place node = cell_node(k, c);
        cell = {geometry_.part(node), false, nullptr, false, {}};
        cell.near = cell.part != CellPart::open;
        each_node<Dim, 3>([&](int at, int, int, int) {
            const SurfaceNode<Dim>& n =
                surface_nodes_[static_cast<std::size_t>(node_at(k, tile_offset<Dim, 3>(c) + at))];
            cell.near = cell.near || n.distance < lacks_within || (n.distance < 3 && n.capacity < light_capacity);
        });
        if (cell.part != CellPart::cut) continue;
        cell.cut = &geometry_.cut(node);
        if (cell.cut->area > 1e-7) add_element(k, c, *cell.cut);
        find_root(node, cell);
    }
}

/// With whom a cell shares if it does.
template <class Real, int Dim>
void HostSurfaces<Real, Dim>::find_root(const Place& node, SurfaceCell& cell) {
    const auto open_volume = [&](const Place& at) {
        const CellPart part = geometry_.part(at);
        return part == CellPart::open ? 1.0 : part == CellPart::cut ? geometry_.cut(at).volume : 0.0;
    };
    constexpr double same = 1e-6;  // what differs by less does so by rounding
    int axis = 0;
    for (int a = 1; a < Dim; ++a)
        if (std::fabs(cell.cut->normal[a]) > std::fabs(cell.cut->normal[axis]) - same) axis = a;
    double widest = 0.02;
    for (int a = 0; a < Dim; ++a) {
        double open[2];
        for (int end = 0; end < 2; ++end) {
            Place at = node;
            at[a] += end == 0 ? -1 : 1;
            const bool ahead = a == axis && (end == 0) == (cell.cut->normal[a] < 0);
            open[end] = !(open_volume(at) > small_cell) ? 0.0 : ahead ? 2.0 : cell.cut->open[2 * a + end];
        }
        const int end = open[1] > open[0];
        if (std::fabs(open[1] - open[0]) < same || open[end] < widest - same) continue;  // alike: with neither
        widest = open[end];
        cell.shares = true;
        for (int b = 0; b < Dim; ++b) cell.root[b] = b != a ? 0 : end == 0 ? -1 : 1;
    }
}

template <class Real, int Dim>
void HostSurfaces<Real, Dim>::add_element(int k, int c, const CutCell<Dim>& cut) {
    SurfaceElement<Dim> e;
    const ContactField<Dim>& field = scene_.field;
    const Structure<Dim>& s = field.structure[cut.structure];
    e.cell = c;
    e.structure = cut.structure;
    e.area = cut.area * std::pow(h_, Dim - 1);
    e.normal = cut.normal;
    const Place node = cell_node(k, c);
    for (int a = 0; a < Dim; ++a) e.place[a] = field.origin[a] + h_ * (node[a] + cut.centre[a]);
    e.place = image_near(field, s, e.place);
    e.friction = s.friction, e.cap = s.cap;
    if (s.shape == StructureShape::ground) {
        const GroundNode<Dim> ground = ground_node(s, field.corners, e.place);
        e.friction = ground.friction, e.cap = ground.cap;
    }
    for (int i = 0; i < nodes; ++i) e.own[i] = e.weight[i] = cut.weight(i);
    int i = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        give_away(surface_nodes_[static_cast<std::size_t>(node_at(k, tile_offset<Dim, 3>(c) + at))], i++, e);
    });
    elements_[static_cast<std::size_t>(k)].push_back(e);
}

/// A node is +0 plus its tiles by offset, as in tile_sums.hpp.
template <class Real, int Dim>
void HostSurfaces<Real, Dim>::sum_nodes(int j) {
    const BlockTable<Dim> table = patch_.table();
    const std::int32_t c = near_nodes_[static_cast<std::size_t>(j)];
    Real* sums = sums_.data() + static_cast<std::size_t>(j) * cells * node_reals;
    std::fill_n(sums, cells * node_reals, Real(0));
    for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
        const std::int32_t source = table.source[c * Block<Dim>::corners + delta];
        const std::int32_t tile = source < 0 ? -1 : tile_index_[static_cast<std::size_t>(source)];
        for (int n = 0; tile >= 0 && n < cells; ++n) {
            const int at = tile_node<Dim>(n, delta, width);
            if (at < 0) continue;
            const Real* from =
                tiles_.data() + (static_cast<std::size_t>(tile) * tile_nodes + std::size_t(at)) * node_reals;
            for (int q = 0; q < node_reals; ++q) sums[n * node_reals + q] += from[q];
        }
    }
}

template <class Real, int Dim>
std::ptrdiff_t HostSurfaces<Real, Dim>::stored(std::int32_t near) const {
    const std::int32_t block = patch_.grid().node_of[near_nodes_[static_cast<std::size_t>(near / cells)]];
    return block < 0 ? -1 : std::ptrdiff_t(block) * cells + near % cells;
}

template <class Real, int Dim>
Real* HostSurfaces<Real, Dim>::values(std::int32_t near) const {
    const std::ptrdiff_t at = stored(near);
    Real* node = at < 0 ? nullptr : patch_.grid().nodes + at * node_reals;
    return node && node[quad - 1] > scene_.mass_cutoff ? node : nullptr;
}

template class HostSurfaces<float, 2>;
template class HostSurfaces<float, 3>;
template class HostSurfaces<double, 2>;
template class HostSurfaces<double, 3>;

}  // namespace moraine
