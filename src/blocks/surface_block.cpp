// What surfaces cut in a block near them.

#include "blocks/surface_block.hpp"

#include <algorithm>
#include <cmath>

#include "core/grid/stencil.hpp"

namespace moraine {

namespace {

template <int Dim>
struct BlockMaker {
    using Found = SurfaceBlock<Dim>;
    using Place = typename Found::Place;
    static constexpr int cells = Found::cells, side = Found::side, tile_nodes = Found::tile_nodes;
    static constexpr int to_middle = Found::to_middle;

    const ContactField<Dim>& field;
    const double h;
    SurfaceGeometry<Dim>& geometry;
    SurfaceBlock<Dim>& block;
    SurfaceNode<Dim> nodes[tile_nodes]{};

    /// Of the tile.
    Place tile_place(int n) const {
        Place node = block.first;
        for (int a = 0, rest = n; a < Dim; ++a, rest /= side) node[a] += rest % side - 1;
        return node;
    }
    const SurfaceNode<Dim>& node_at(int n) const { return nodes[n]; }

    void make();
    void find_ring();
    void find_element(int c);
    void find_cell(int c);
    void find_space(int c, const Place& node, SurfaceCell<Dim>& cell);
    void find_root(const Place& node, const CutCell<Dim>& cut, SurfaceCell<Dim>& cell);
    void add_element(int c, const CutCell<Dim>& cut);
    void list_slaves(int c);
};

template <int Dim>
void BlockMaker<Dim>::make() {
    for (int n = 0; n < tile_nodes; ++n) nodes[n] = geometry.node(tile_place(n));
    find_ring();
    for (int c = 0; c < cells; ++c) find_element(c);
    if (geometry.has_pressures()) block.cell.assign(cells, {});
    for (int c = 0; c < static_cast<int>(block.cell.size()); ++c) find_cell(c);
    for (int c = 0; c < cells; ++c) list_slaves(c);
}

template <int Dim>
void BlockMaker<Dim>::find_ring() {
    int of_tile[tile_nodes];
    for (int n = 0; n < tile_nodes; ++n) {
        of_tile[n] = -1;
        const Place node = tile_place(n);
        if (geometry.part(node) != CellPart::cut) continue;
        const CutCell<Dim>& cut = geometry.cut(node);
        if (!(cut.area > 1e-7)) continue;
        RingElement<Dim> e;
        e.area = cut.area, e.normal = cut.normal, e.structure = cut.structure, e.node = n;
        e.reach = 0.25 + 0.5 * std::max(1.0, Dim == 2 ? e.area : std::sqrt(e.area));
        for (int a = 0; a < Dim; ++a) e.place[a] = node[a] - block.first[a] + cut.centre[a];
        of_tile[n] = static_cast<int>(block.ring.size());
        block.ring.push_back(e);
    }
    for (int c = 0; c < cells; ++c) {
        each_node<Dim, 3>([&](int at, int, int, int) {
            const int n = of_tile[tile_offset<Dim, 3>(c) + at];
            if (n >= 0) block.around.push_back(static_cast<std::uint16_t>(n));
        });
        block.first_around[static_cast<std::size_t>(c) + 1] = static_cast<std::uint16_t>(block.around.size());
    }
}

template <int Dim>
void BlockMaker<Dim>::find_element(int c) {
    const Place node = block.cell_node(c);
    if (geometry.part(node) != CellPart::cut) return;
    const CutCell<Dim>& cut = geometry.cut(node);
    if (cut.area > 1e-7) add_element(c, cut);
}

/// As pressures see it.
template <int Dim>
void BlockMaker<Dim>::find_cell(int c) {
    SurfaceCell<Dim>& cell = block.cell[static_cast<std::size_t>(c)];
    const Place node = block.cell_node(c);
    cell.part = geometry.part(node);
    cell.near = cell.part != CellPart::open;
    each_node<Dim, 3>([&](int at, int, int, int) {
        const SurfaceNode<Dim>& n = node_at(tile_offset<Dim, 3>(c) + at);
        cell.near = cell.near || n.distance < lacks_within || (n.distance < 3 && n.capacity < light_capacity);
    });
    block.has_cells = block.has_cells || cell.near;
    find_space(c, node, cell);
    if (cell.part != CellPart::cut) return;
    cell.cut = geometry.faces(node);
    find_root(node, geometry.cut(node), cell);
}

/// What is open of a cell, and whose surface it is at.
template <int Dim>
void BlockMaker<Dim>::find_space(int c, const Place& node, SurfaceCell<Dim>& cell) {
    if (cell.part == CellPart::cut) {
        cell.volume = geometry.cut(node).volume;
        cell.structure = geometry.cut(node).structure;
        return;
    }
    const CellBox<Dim> box = geometry.box(node);
    cell.volume = 1;
    for (int a = 0; a < Dim; ++a) cell.volume *= box.end[a][1] - box.end[a][0];
    cell.structure = node_at(tile_offset<Dim, 3>(c) + to_middle).structure;
}

/// With whom a cell shares if it does.
template <int Dim>
void BlockMaker<Dim>::find_root(const Place& node, const CutCell<Dim>& cut, SurfaceCell<Dim>& cell) {
    const auto open_volume = [&](const Place& at) {
        const CellPart part = geometry.part(at);
        return part == CellPart::open ? 1.0 : part == CellPart::cut ? geometry.cut(at).volume : 0.0;
    };
    constexpr double same = 1e-6;  // what differs by less does so by rounding
    int axis = 0;
    for (int a = 1; a < Dim; ++a)
        if (std::fabs(cut.normal[a]) > std::fabs(cut.normal[axis]) - same) axis = a;
    double widest = 0.02;
    for (int a = 0; a < Dim; ++a) {
        double open[2];
        for (int end = 0; end < 2; ++end) {
            Place at = node;
            at[a] += end == 0 ? -1 : 1;
            const bool ahead = a == axis && (end == 0) == (cut.normal[a] < 0);
            open[end] = !(open_volume(at) > small_cell) ? 0.0 : ahead ? 2.0 : cut.open[2 * a + end];
        }
        const int end = open[1] > open[0];
        if (std::fabs(open[1] - open[0]) < same || open[end] < widest - same) continue;  // alike: with neither
        widest = open[end];
        cell.shares = true;
        for (int b = 0; b < Dim; ++b) cell.root[b] = b != a ? 0 : end == 0 ? -1 : 1;
    }
}

template <int Dim>
void BlockMaker<Dim>::add_element(int c, const CutCell<Dim>& cut) {
    SurfaceElement<Dim> e;
    const Structure<Dim>& s = field.structure[cut.structure];
    e.cell = c;
    e.structure = cut.structure;
    e.area = cut.area * std::pow(h, Dim - 1);
    e.normal = cut.normal;
    const Place node = block.cell_node(c);
    for (int a = 0; a < Dim; ++a) e.place[a] = field.origin[a] + h * (node[a] + cut.centre[a]);
    e.place = image_near(field, s, e.place);
    e.friction = s.friction, e.cap = s.cap;
    if (s.shape == StructureShape::ground) {
        const GroundNode<Dim> ground = ground_node(s, field.corners, e.place);
        e.friction = ground.friction, e.cap = ground.cap;
    }
    for (int i = 0; i < e.nodes; ++i) e.own[i] = e.weight[i] = cut.weight[i];
    int i = 0;
    each_node<Dim, 3>([&](int at, int, int, int) { give_away(node_at(tile_offset<Dim, 3>(c) + at), i++, e); });
    block.elements.push_back(e);
}

/// Of a cell, the slaves that follow its middle and the node beyond.
template <int Dim>
void BlockMaker<Dim>::list_slaves(int c) {
    const int corner = tile_offset<Dim, 3>(c), middle = corner + to_middle;
    each_node<Dim, 3>([&](int at, int i, int j, int l) {
        const SurfaceNode<Dim>& n = node_at(corner + at);
        if (!(n.slaved > 0)) return;
        const int offset[3] = {i - 1, j - 1, l - 1};
        int beyond = middle;
        Place own = block.cell_node(c), two = own;
        for (int a = 0, stride = 1; a < Dim; ++a, stride *= side) {
            if (n.to[a] != -offset[a]) return;
            beyond += stride * n.to[a];
            own[a] -= n.to[a], two[a] += n.to[a];
        }
        block.slaves.push_back({{corner + at, middle, beyond},
                                n,
                                {geometry.followed_beside(own, own), geometry.followed_beside(block.cell_node(c), own),
                                 geometry.followed_beside(two, own)}});
    });
}

}  // namespace

template <int Dim>
SurfaceBlock<Dim> make_surface_block(const Vec<std::int32_t, Dim>& first, const ContactField<Dim>& field, double h,
                                     SurfaceGeometry<Dim>& geometry) {
    SurfaceBlock<Dim> block;
    block.first = first;
    BlockMaker<Dim>{field, h, geometry, block}.make();
    return block;
}

template SurfaceBlock<2> make_surface_block(const Vec<std::int32_t, 2>&, const ContactField<2>&, double,
                                            SurfaceGeometry<2>&);
template SurfaceBlock<3> make_surface_block(const Vec<std::int32_t, 3>&, const ContactField<3>&, double,
                                            SurfaceGeometry<3>&);

}  // namespace moraine
