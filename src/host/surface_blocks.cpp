// Blocks near surfaces, and how their sums travel.

#include "host/surface_blocks.hpp"

#include <algorithm>

#include "core/surfaces/element_rule.hpp"

namespace moraine {

namespace {

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
void SurfaceBlocks<Real, Dim>::find(const ContactField<Dim>& of, bool moves) {
    if (made.in_epoch && !moves) return;
    scene.field = of;
    this->make(patch.tables(), of, moves, method.context.walls, method.capacity);
    index_nodes();
    tile_index.assign(bed_of.size(), -1);
    tiles.resize((ghosts + blocks.size()) * tile_nodes * node_reals);
    std::fill_n(tiles.data(), tiles.size(), Real(0));
    const std::size_t near = near_nodes.size() * cells;
    sums.known.assign(near_nodes.size(), 0);
    sums.value.resize(near * node_reals);
    if (counts_energy) motions.resize(near);
    std::vector<std::uint8_t> needed(near_of.size());
    for (std::size_t c = 0; c < needed.size(); ++c) needed[c] = near_of[c] >= 0;
    patch.keep_nodes(std::move(needed));
    made.in_epoch = true;
}

template <class Real, int Dim>
void SurfaceBlocks<Real, Dim>::index_nodes() {
    const EpochTables<Dim>& tables = patch.tables();
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

template <class Real, int Dim>
void SurfaceBlocks<Real, Dim>::begin_step() {
    const TileView<Real> grid = patch.grid();
    node_values.resize(near_nodes.size());
    for (std::size_t j = 0; j < near_nodes.size(); ++j) {
        const std::int32_t block = is_occupied(near_nodes[j]) ? grid.node_of[near_nodes[j]] : -1;
        node_values[j] = block < 0 ? nullptr : grid.nodes + std::ptrdiff_t(block) * cells * node_reals;
    }
    tile_values.resize(blocks.size() * tile_nodes);
    has_soil.resize(blocks.size());
    Host::launch(static_cast<std::int64_t>(blocks.size()), [&](int k) { find_values(k); });
}

/// Whether a block gives to the nodes of a node block in this step.
template <class Real, int Dim>
bool SurfaceBlocks<Real, Dim>::is_occupied(std::int32_t node_block) const {
    const std::int32_t* source = patch.table().source + std::ptrdiff_t(node_block) * Block<Dim>::corners;
    const std::int32_t* tile_of = patch.tile_of();
    return std::any_of(source, source + Block<Dim>::corners, [&](std::int32_t b) { return b >= 0 && tile_of[b] >= 0; });
}

template <class Real, int Dim>
void SurfaceBlocks<Real, Dim>::find_values(int k) {
    Real** of_tile = tile_values.data() + static_cast<std::size_t>(k) * tile_nodes;
    std::uint8_t& soil = has_soil[static_cast<std::size_t>(k)];
    soil = 0;
    for (int corner = 0; corner < Block<Dim>::corners; ++corner) {
        int first = 0;
        for (int a = 0, stride = 1; a < Dim; ++a, stride *= side) first += Block<Dim>::corner(corner, a) * 4 * stride;
        soil = soil || node_values[static_cast<std::size_t>(node_at(k, first) / cells)];
    }
    for (int n = 0; soil && n < tile_nodes; ++n) of_tile[n] = values(node_at(k, n));
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
template <int Quads>
void SurfaceBlocks<Real, Dim>::add_tiles(int j) {
    const std::int32_t c = near_nodes[static_cast<std::size_t>(j)];
    const std::int32_t* source = patch.table().source + std::ptrdiff_t(c) * Block<Dim>::corners;
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
            for (int q = 0; q < Quads * quad; q += quad) {
                Real* sum = to + n * node_reals + q;
                (Quad<Real>::load(sum) + Quad<Real>::load(from + at * node_reals + q)).store(sum);
            }
        });
    }
}

template <class Real, int Dim>
void SurfaceBlocks<Real, Dim>::sum_nodes(int j, int quads) {
    quads == 1 ? add_tiles<1>(j) : add_tiles<2>(j);
}

template <class Real, int Dim>
std::ptrdiff_t SurfaceBlocks<Real, Dim>::stored(std::int32_t near) const {
    const std::int32_t block = patch.grid().node_of[near_nodes[static_cast<std::size_t>(near / cells)]];
    return block < 0 ? -1 : std::ptrdiff_t(block) * cells + near % cells;
}

template <class Real, int Dim>
void StructureTally<Real, Dim>::add(int structure, const Vec<double, Dim>& impulse, const Vec<double, Dim>& place,
                                    const Vec<double, Dim>& follows, const Vec<double, moments<Dim>>& couple) {
    if (structure != structure_) tell();
    structure_ = structure;
    double all[StructureSums<Dim>::count] = {};
    const Structure<Dim>& s = scene_.field.structure[structure];
    structure_values(scene_.field, s, impulse, place, follows, all);
    if (s.turns) add_couple(s, couple, all);
    for (int i = 0; i < StructureSums<Dim>::count; ++i)
        if (all[i] != 0) sums_.sum[i].add(scene_.quantum.of(all[i]));
}

template <class Real, int Dim>
void StructureTally<Real, Dim>::tell() {
    if (structure_ < 0) return;
#pragma omp critical(tell_structure)
    scene_.felt[structure_].add(sums_);
    sums_ = {};
}

template class StructureTally<float, 2>;
template class StructureTally<float, 3>;
template class StructureTally<double, 2>;
template class StructureTally<double, 3>;
template struct SurfaceBlocks<float, 2>;
template struct SurfaceBlocks<float, 3>;
template struct SurfaceBlocks<double, 2>;
template struct SurfaceBlocks<double, 3>;

}  // namespace moraine
