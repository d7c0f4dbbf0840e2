// What of surfaces holds for an epoch, and how its sums travel.

#include "host/surface_blocks.hpp"

#include "core/data/morton.hpp"
#include "core/surfaces/open_faces.hpp"

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

/// f(n, tile_node(n, delta, width)) of the nodes that a tile has.
template <int Dim, class F>
void each_tile_node(int delta, int width, const F& f) {
    int count[3] = {1, 1, 1}, first = 0;
    for (int a = 0, stride = 1; a < Dim; ++a, stride *= tile_side(width)) {
        const bool upper = Block<Dim>::corner(delta, a) != 0;
        count[a] = upper ? width - 1 : 4;
        first += upper ? 4 * stride : 0;
    }
    const int side = tile_side(width);
    for (int z = 0; z < count[2]; ++z)
        for (int y = 0; y < count[1]; ++y)
            for (int x = 0; x < count[0]; ++x) f(x + 4 * (y + 4 * z), first + x + side * (y + side * z));
}

}  // namespace

template <class Real, int Dim>
void SurfaceBlocks<Real, Dim>::find(const ContactField<Dim>& field, bool moves) {
    if (made.in_epoch && !moves) return;
    scene.field = field;
    geometry.begin(field, doubled(method.context.walls), doubled(method.capacity));
    if (moves) geometry.forget();
    make(patch.tables());
    std::vector<std::uint8_t> needed(near_of.size());
    for (std::size_t c = 0; c < needed.size(); ++c) needed[c] = near_of[c] >= 0;
    patch.keep_nodes(std::move(needed));
    made.in_epoch = true, ++made.times;
}

template <class Real, int Dim>
void SurfaceBlocks<Real, Dim>::make(const EpochTables<Dim>& tables) {
    list_blocks(tables);
    find_nodes(tables);
    place_of.assign(blocks.size() * cells, {});
    ring.assign(blocks.size() * tile_nodes, {});
    around.first.assign(1, 0);
    around.ring.clear();
    elements.assign(blocks.size(), {});
    for (int k = 0; k < static_cast<int>(blocks.size()); ++k) find_block(k);
    tiles.resize((ghosts + blocks.size()) * tile_nodes * node_reals);
    std::fill_n(tiles.data(), tiles.size(), Real(0));
    const std::size_t near = near_nodes.size() * cells;
    sums.known.assign(near_nodes.size(), 0);
    sums.value.resize(near * node_reals);
    if (counts_energy) motions.resize(near);
}

/// Whether a block may have a cell or a node that a surface is near: by the distance of its middle.
template <class Real, int Dim>
bool SurfaceBlocks<Real, Dim>::is_near(const Place& block) const {
    constexpr double reach = 3.5 + 2 * (Dim == 2 ? 1.4143 : 1.7321);
    const Place first = first_of(block);
    for (int k = 0; k < scene.field.count; ++k) {
        const Structure<Dim>& s = scene.field.structure[k];
        if (distance_bound(s, scene.field.corners, node_place(scene.field, s, &first[0], 1.5)) < reach * h) return true;
    }
    return false;
}

template <class Real, int Dim>
void SurfaceBlocks<Real, Dim>::list_blocks(const EpochTables<Dim>& tables) {
    const std::size_t own = tables.own.size();
    ghosts = tables.ghost.size();
    blocks.clear();
    bed_of.assign(own + ghosts, -1);
    tile_index.assign(own + ghosts, -1);
    for (std::size_t b = 0; b < own; ++b) {
        if (!is_near(tables.position[b])) continue;
        bed_of[b] = static_cast<std::int32_t>(blocks.size());
        blocks.push_back(static_cast<std::int32_t>(b));
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

template <class Real, int Dim>
void SurfaceBlocks<Real, Dim>::find_nodes(const EpochTables<Dim>& tables) {
    surface_nodes.resize(near_nodes.size() * cells);
    for (std::size_t j = 0; j < near_nodes.size(); ++j)
        for (int n = 0; n < cells; ++n) {
            Place node = tables.node_position[static_cast<std::size_t>(near_nodes[j])];
            for (int a = 0; a < Dim; ++a) node[a] = 4 * node[a] - method.stencil.origin + cell_coordinate<Dim>(n, a);
            surface_nodes[j * cells + static_cast<std::size_t>(n)] = geometry.node(node);
        }
    node_index.resize(blocks.size() * tile_nodes);
    const BlockTable<Dim> table = patch.table();
    for (std::size_t k = 0; k < blocks.size(); ++k)
        for (int n = 0; n < tile_nodes; ++n) {
            int corner = 0, at = 0;
            for (int a = 0, rest = n; a < Dim; ++a, rest /= side) {
                const int x = rest % side;
                corner |= (x >> 2) << a, at |= (x & 3) << (2 * a);
            }
            const std::int32_t c = table.node_block[blocks[k] * Block<Dim>::corners + corner];
            node_index[k * tile_nodes + static_cast<std::size_t>(n)] =
                near_of[static_cast<std::size_t>(c)] * cells + at;
        }
}

/// The node of a block's cell.
template <class Real, int Dim>
typename SurfaceBlocks<Real, Dim>::Place SurfaceBlocks<Real, Dim>::cell_node(int k, int c) const {
    Place node = first_of(patch.tables().position[static_cast<std::size_t>(blocks[static_cast<std::size_t>(k)])]);
    for (int a = 0; a < Dim; ++a) node[a] += cell_coordinate<Dim>(c, a);
    return node;
}

template <class Real, int Dim>
void SurfaceBlocks<Real, Dim>::find_block(int k) {
    const Place first = cell_node(k, 0);
    for (int n = 0; n < tile_nodes; ++n) {
        Place node = first;
        for (int a = 0, rest = n; a < Dim; ++a, rest /= side) node[a] += rest % side - 1;
        if (geometry.part(node) != CellPart::cut) continue;
        const CutCell<Dim>& cut = geometry.cut(node);
        if (!(cut.area > 1e-7)) continue;
        RingElement<Dim>& e = ring[static_cast<std::size_t>(k * tile_nodes + n)];
        e.area = cut.area, e.normal = cut.normal, e.structure = cut.structure;
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
        cell = {geometry.part(node), false, nullptr, false, {}};
        cell.near = cell.part != CellPart::open;
        each_node<Dim, 3>([&](int at, int, int, int) {
            const SurfaceNode<Dim>& n =
                surface_nodes[static_cast<std::size_t>(node_at(k, tile_offset<Dim, 3>(c) + at))];
            cell.near = cell.near || n.distance < lacks_within || (n.distance < 3 && n.capacity < light_capacity);
        });
        if (cell.part != CellPart::cut) continue;
        cell.cut = &geometry.cut(node);
        if (cell.cut->area > 1e-7) add_element(k, c, *cell.cut);
        find_root(node, cell);
    }
}

/// With whom a cell shares if it does.
template <class Real, int Dim>
void SurfaceBlocks<Real, Dim>::find_root(const Place& node, SurfaceCell<Dim>& cell) {
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
        for (int b = 0; b < Dim; ++b) cell.root[b] = b != a ? 0 : end == 0 ? -1 : 1;
    }
}

template <class Real, int Dim>
void SurfaceBlocks<Real, Dim>::add_element(int k, int c, const CutCell<Dim>& cut) {
    SurfaceElement<Dim> e;
    const ContactField<Dim>& field = scene.field;
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

template <class Real, int Dim>
void SurfaceBlocks<Real, Dim>::begin_step() {
    const TileView<Real> grid = patch.grid();
    node_values.resize(near_nodes.size());
    for (std::size_t j = 0; j < near_nodes.size(); ++j) {
        const std::int32_t block = grid.node_of[near_nodes[j]];
        node_values[j] = block < 0 ? nullptr : grid.nodes + std::ptrdiff_t(block) * cells * node_reals;
    }
}

template <class Real, int Dim>
void SurfaceBlocks<Real, Dim>::share(std::span<const std::int32_t> givers, const GapShare<Dim>& gaps) {
    travel(givers, &gaps);
}

template <class Real, int Dim>
void SurfaceBlocks<Real, Dim>::travel(std::span<const std::int32_t> givers, const GapShare<Dim>* gaps) {
    std::fill(tile_index.begin(), tile_index.end(), -1);
    for (const std::int32_t k : givers)
        tile_index[static_cast<std::size_t>(blocks[static_cast<std::size_t>(k)])] =
            static_cast<std::int32_t>(ghosts) + k;
    const TileView<Real> view{tile_index.data(), tiles.data(), nullptr, nullptr};
    halo->start(view, gaps);
    halo->finish(view, tile_index.data(), gaps);
}

/// A node is +0 plus its tiles by offset, as in tile_sums.hpp; where no block gives there are no sums.
template <class Real, int Dim>
void SurfaceBlocks<Real, Dim>::sum_nodes(int j, int quads) {
    const std::int32_t c = near_nodes[static_cast<std::size_t>(j)];
    const std::int32_t* source = patch.table().source + std::ptrdiff_t(c) * Block<Dim>::corners;
    const int reals = quads * quad;
    Real* to = sums.value.data() + static_cast<std::size_t>(j) * cells * node_reals;
    std::uint8_t& known = sums.known[static_cast<std::size_t>(j)];
    known = 0;
    for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
        const std::int32_t tile = source[delta] < 0 ? -1 : tile_index[static_cast<std::size_t>(source[delta])];
        if (tile < 0) continue;
        if (!known) std::fill_n(to, cells * node_reals, Real(0));
        known = 1;
        const Real* from = tiles.data() + static_cast<std::size_t>(tile) * tile_nodes * node_reals;
        each_tile_node<Dim>(delta, width, [&](int n, int at) {
            for (int q = 0; q < reals; ++q) to[n * node_reals + q] += from[at * node_reals + q];
        });
    }
}

template <class Real, int Dim>
std::ptrdiff_t SurfaceBlocks<Real, Dim>::stored(std::int32_t near) const {
    const std::int32_t block = patch.grid().node_of[near_nodes[static_cast<std::size_t>(near / cells)]];
    return block < 0 ? -1 : std::ptrdiff_t(block) * cells + near % cells;
}

template <class Real, int Dim>
void SurfaceBlocks<Real, Dim>::tell(int structure, const Vec<double, Dim>& impulse, const Vec<double, Dim>& place,
                                    const Vec<double, Dim>& follows) const {
    const Structure<Dim>& s = scene.field.structure[structure];
    const Vec<double, Dim> arm = image_near(scene.field, s, place) - s.at;
    double all[StructureSums<Dim>::count] = {};
    for (int a = 0; a < Dim; ++a) all[a] = impulse[a], all[StructureSums<Dim>::first_mass + a] = follows[a];
    if constexpr (Dim == 2)
        all[2] = arm[0] * impulse[1] - arm[1] * impulse[0];
    else
        for (int a = 0; a < 3; ++a)
            all[3 + a] = arm[(a + 1) % 3] * impulse[(a + 2) % 3] - arm[(a + 2) % 3] * impulse[(a + 1) % 3];
    all[StructureSums<Dim>::work] = dot(impulse, s.velocity);
    add_shared(scene.felt[structure].sum, scene.quantum, all);
}

template struct SurfaceBlocks<float, 2>;
template struct SurfaceBlocks<float, 3>;
template struct SurfaceBlocks<double, 2>;
template struct SurfaceBlocks<double, 3>;

}  // namespace moraine
