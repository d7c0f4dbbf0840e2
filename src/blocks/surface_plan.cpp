// What of surfaces holds for an epoch.

#include "blocks/surface_plan.hpp"

#include "core/data/morton.hpp"
#include "core/grid/stencil.hpp"

namespace moraine {

namespace {

/// Node of a block's cell or tile: its first cell's.
template <int Dim>
Vec<std::int32_t, Dim> first_of(const Vec<std::int32_t, Dim>& block) {
    Vec<std::int32_t, Dim> node;
    for (int a = 0; a < Dim; ++a) node[a] = first_node<Quadratic>(block[a]) + 1;
    return node;
}

}  // namespace

template <int Dim>
void SurfacePlan<Dim>::make(const EpochTables<Dim>& tables, const ContactField<Dim>& of) {
    field = of;
    list_blocks(tables);
    find_nodes(tables);
    place_of.assign(blocks.size() * cells, {});
    ring.assign(blocks.size() * tile_nodes, {});
    around.first.assign(1, 0);
    around.ring.clear();
    elements.assign(blocks.size(), {});
    slaves.assign(blocks.size(), {});
    for (int k = 0; k < static_cast<int>(blocks.size()); ++k) {
        find_block(k);
        for (int c = 0; c < cells; ++c) list_slaves(k, c);
    }
}

/// Whether a block may have a cell or a node that a surface is near: by the distance of its middle.
template <int Dim>
bool SurfacePlan<Dim>::is_near(const Place& block) const {
    constexpr double reach = 3.5 + 2 * (Dim == 2 ? 1.4143 : 1.7321);
    const Place first = first_of(block);
    for (int k = 0; k < field.count; ++k) {
        const Structure<Dim>& s = field.structure[k];
        if (distance_bound(s, field.corners, node_place(field, s, &first[0], 1.5)) < reach * h) return true;
    }
    return false;
}

template <int Dim>
void SurfacePlan<Dim>::list_blocks(const EpochTables<Dim>& tables) {
    const std::size_t own = tables.own.size();
    ghosts = tables.ghost.size();
    blocks.clear(), first_.clear();
    bed_of.assign(own + ghosts, -1);
    for (std::size_t b = 0; b < own; ++b) {
        if (!is_near(tables.position[b])) continue;
        bed_of[b] = static_cast<std::int32_t>(blocks.size());
        blocks.push_back(static_cast<std::int32_t>(b));
        first_.push_back(first_of(tables.position[b]));
    }
    for (std::size_t g = 0; g < ghosts; ++g) {
        const auto at = Morton<Dim>::decode(tables.ghost[g]);
        Place block;
        for (int a = 0; a < Dim; ++a) block[a] = static_cast<std::int32_t>(at[static_cast<std::size_t>(a)]);
        if (is_near(block)) bed_of[own + g] = 0;
    }
    near_nodes.clear();
    near_of.assign(tables.node_position.size(), -1);
    for (std::size_t c = 0; c < near_of.size(); ++c)
        for (int d = 0; d < Block<Dim>::corners; ++d) {
            const std::int32_t source = tables.source[c * Block<Dim>::corners + static_cast<std::size_t>(d)];
            if (source < 0 || bed_of[static_cast<std::size_t>(source)] < 0) continue;
            near_of[c] = static_cast<std::int32_t>(near_nodes.size());
            near_nodes.push_back(static_cast<std::int32_t>(c));
            break;
        }
}

template <int Dim>
void SurfacePlan<Dim>::find_nodes(const EpochTables<Dim>& tables) {
    surface_nodes.resize(near_nodes.size() * cells);
    for (std::size_t j = 0; j < near_nodes.size(); ++j)
        for (int n = 0; n < cells; ++n) {
            Place node = tables.node_position[static_cast<std::size_t>(near_nodes[j])];
            for (int a = 0; a < Dim; ++a) node[a] = 4 * node[a] - origin + cell_coordinate<Dim>(n, a);
            surface_nodes[j * cells + static_cast<std::size_t>(n)] = geometry.node(node);
        }
    node_index.resize(blocks.size() * tile_nodes);
    for (std::size_t k = 0; k < blocks.size(); ++k)
        for (int n = 0; n < tile_nodes; ++n) {
            int corner = 0, at = 0;
            for (int a = 0, rest = n; a < Dim; ++a, rest /= side) {
                const int x = rest % side;
                corner |= (x >> 2) << a, at |= (x & 3) << (2 * a);
            }
            const std::int32_t c =
                tables.node_block[static_cast<std::size_t>(blocks[k] * Block<Dim>::corners + corner)];
            node_index[k * tile_nodes + static_cast<std::size_t>(n)] =
                near_of[static_cast<std::size_t>(c)] * cells + at;
        }
}

/// The node of a block's cell.
template <int Dim>
typename SurfacePlan<Dim>::Place SurfacePlan<Dim>::cell_node(int k, int c) const {
    Place node = first_[static_cast<std::size_t>(k)];
    for (int a = 0; a < Dim; ++a) node[a] += cell_coordinate<Dim>(c, a);
    return node;
}

template <int Dim>
void SurfacePlan<Dim>::find_block(int k) {
    const Place first = cell_node(k, 0);
    for (int n = 0; n < tile_nodes; ++n) {
        Place node = first;
        for (int a = 0, rest = n; a < Dim; ++a, rest /= side) node[a] += rest % side - 1;
        if (geometry.part(node) != CellPart::cut) continue;
        const CutCell<Dim>& cut = geometry.cut(node);
        if (!(cut.area > 1e-7)) continue;
        RingElement<Dim>& e = ring[static_cast<std::size_t>(k * tile_nodes + n)];
        e.area = cut.area, e.normal = cut.normal, e.structure = cut.structure, e.node = n;
        e.reach = 0.25 + 0.5 * std::max(1.0, Dim == 2 ? e.area : std::sqrt(e.area));
        for (int a = 0; a < Dim; ++a) e.place[a] = node[a] - first[a] + cut.centre[a];
    }
    for (int c = 0; c < cells; ++c) {
        each_node<Dim, 3>([&](int at, int, int, int) {
            const RingElement<Dim>& e = ring[static_cast<std::size_t>(k * tile_nodes + tile_offset<Dim, 3>(c) + at)];
            if (e.area > 0) around.ring.push_back(static_cast<std::uint16_t>(tile_offset<Dim, 3>(c) + at));
        });
        around.first.push_back(static_cast<std::uint32_t>(around.ring.size()));
        SurfaceCell<Dim>& cell = place_of[static_cast<std::size_t>(k * cells + c)];
        const Place node = cell_node(k, c);
        cell = SurfaceCell<Dim>{};
        cell.part = geometry.part(node);
        cell.near = cell.part != CellPart::open;
        each_node<Dim, 3>([&](int at, int, int, int) {
            const SurfaceNode<Dim>& n =
                surface_nodes[static_cast<std::size_t>(node_at(k, tile_offset<Dim, 3>(c) + at))];
            cell.near = cell.near || n.distance < lacks_within || (n.distance < 3 && n.capacity < light_capacity);
        });
        find_space(k, c, node, cell);
        if (cell.part != CellPart::cut) continue;
        cell.cut = &geometry.cut(node);
        if (cell.cut->area > 1e-7) add_element(k, c, *cell.cut);
        find_root(node, cell);
    }
}

/// What is open of a cell, and whose surface it is at.
template <int Dim>
void SurfacePlan<Dim>::find_space(int k, int c, const Place& node, SurfaceCell<Dim>& cell) {
    if (cell.part == CellPart::cut) {
        cell.volume = geometry.cut(node).volume;
        cell.structure = geometry.cut(node).structure;
        return;
    }
    const CellBox<Dim> box = geometry.box(node);
    cell.volume = 1;
    for (int a = 0; a < Dim; ++a) cell.volume *= box.end[a][1] - box.end[a][0];
    cell.structure = surface_nodes[static_cast<std::size_t>(node_at(k, tile_offset<Dim, 3>(c) + to_middle))].structure;
}

/// With whom a cell shares if it does.
template <int Dim>
void SurfacePlan<Dim>::find_root(const Place& node, SurfaceCell<Dim>& cell) {
    const auto open_volume = [&](const Place& at) {
        const CellPart part = geometry.part(at);
        return part == CellPart::open ? 1.0 : part == CellPart::cut ? geometry.cut(at).volume : 0.0;
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
        Place root = node;
        for (int b = 0; b < Dim; ++b) root[b] += cell.root[b] = b != a ? 0 : end == 0 ? -1 : 1;
        cell.cut_of_root = geometry.cut_at(root);
    }
}

template <int Dim>
void SurfacePlan<Dim>::add_element(int k, int c, const CutCell<Dim>& cut) {
    SurfaceElement<Dim> e;
    const Structure<Dim>& s = field.structure[cut.structure];
    e.cell = c;
    e.structure = cut.structure;
    e.area = cut.area * std::pow(h, Dim - 1);
    e.normal = cut.normal;
    const Place node = cell_node(k, c);
    for (int a = 0; a < Dim; ++a) e.place[a] = field.origin[a] + h * (node[a] + cut.centre[a]);
    e.place = image_near(field, s, e.place);
    e.friction = s.friction, e.cap = s.cap;
    if (s.shape == StructureShape::ground) {
        const GroundNode<Dim> ground = ground_node(s, field.corners, e.place);
        e.friction = ground.friction, e.cap = ground.cap;
    }
    for (int i = 0; i < nodes; ++i) e.own[i] = e.weight[i] = cut.weight(i);
    int i = 0;
    each_node<Dim, 3>([&](int at, int, int, int) {
        give_away(surface_nodes[static_cast<std::size_t>(node_at(k, tile_offset<Dim, 3>(c) + at))], i++, e);
    });
    elements[static_cast<std::size_t>(k)].push_back(e);
}

/// Of a cell, the slaves that follow its middle and the node beyond.
template <int Dim>
void SurfacePlan<Dim>::list_slaves(int k, int c) {
    const int corner = tile_offset<Dim, 3>(c), middle = corner + to_middle;
    each_node<Dim, 3>([&](int at, int i, int j, int l) {
        const SurfaceNode<Dim>& n = surface_nodes[static_cast<std::size_t>(node_at(k, corner + at))];
        if (!(n.slaved > 0)) return;
        const int offset[3] = {i - 1, j - 1, l - 1};
        int beyond = middle;
        for (int a = 0, stride = 1; a < Dim; ++a, stride *= side) {
            if (n.to[a] != -offset[a]) return;
            beyond += stride * n.to[a];
        }
        slaves[static_cast<std::size_t>(k)].push_back({corner + at, middle, beyond});
    });
}

template struct SurfacePlan<2>;
template struct SurfacePlan<3>;

}  // namespace moraine
