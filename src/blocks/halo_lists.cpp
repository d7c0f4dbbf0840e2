#include "blocks/halo_lists.hpp"

#include <atomic>

#include "blocks/in_order.hpp"
#include "core/grid/shape.hpp"

namespace moraine {

namespace {

/// Nodes of a tile of the widest stencil.
constexpr auto largest_tile = static_cast<std::size_t>(power<3>(tile_side(Cubic::width)));

/// A tile that some rank needs, and at which offsets from it that rank's blocks (or, sent, the needing ones) lie.
struct Exchanged {
    std::size_t peer;
    std::int32_t block;
    std::uint32_t offsets;
};

/// For each node of a tile the offsets of the blocks whose tiles cover it too.
template <int Dim>
std::vector<std::uint32_t> covering_offsets(int width) {
    const int side = tile_side(width);
    std::vector<std::uint32_t> covering(static_cast<std::size_t>(power<Dim>(side)), 0);
    for (int n = 0; n < power<Dim>(side); ++n) {
        const int at[3] = {n % side, n / side % side, n / (side * side)};
        for (int code = 0; code < Block<Dim>::offsets; ++code) {
            bool inside = true;
            for (int a = 0; a < Dim; ++a) {
                const int eta = Block<Dim>::offset(code, a);
                inside = inside && (eta == 0 || (eta > 0 ? at[a] >= 4 : at[a] < width - 1));
            }
            if (inside) covering[static_cast<std::size_t>(n)] |= 1u << code;
        }
    }
    return covering;
}

/// n tiles; tile(k) is the k-th.
template <class Tile>
TileList tile_list(std::size_t n, const Tile& tile, const std::vector<std::uint32_t>& covering) {
    TileList list;
    list.block.resize(n);
    list.first.resize(n + 1);
    std::vector<std::uint32_t> nodes(n, 0);
#pragma omp parallel for schedule(static) if (n > 64)
    for (std::size_t k = 0; k < n; ++k) {
        const std::uint32_t offsets = tile(k).offsets;
        for (std::uint32_t by : covering) nodes[k] += (by & offsets) != 0;
    }
    place_in_order(
        n, [&](std::size_t k) { return nodes[k]; },
        [&](std::size_t size) {
            list.node.resize(size);
            list.first[n] = static_cast<std::uint32_t>(size);
        },
        [&](std::size_t k, std::size_t at) {
            const Exchanged tile_k = tile(k);
            list.block[k] = tile_k.block;
            list.first[k] = static_cast<std::uint32_t>(at);
            std::array<std::uint16_t, largest_tile> covered;  // without branches: which nodes is hard to predict
            std::size_t size = 0;
            for (std::size_t node = 0; node < covering.size(); ++node) {
                covered[size] = static_cast<std::uint16_t>(node);
                size += (covering[node] & tile_k.offsets) != 0;
            }
            std::copy_n(covered.begin(), size, list.node.begin() + static_cast<std::ptrdiff_t>(at));
        });
    return list;
}

/// What one own block sends: an entry per peer.
template <int Dim>
struct Sent {
    std::array<Exchanged, Block<Dim>::offsets> tile;
    std::size_t count = 0;

    Sent(const EpochTables<Dim>& t, const std::vector<std::size_t>& peer_of_ghost, std::int32_t block) {
        const auto own = static_cast<std::int32_t>(t.own.size());
        const std::int32_t* neighbour = &t.neighbour[static_cast<std::size_t>(block) * Block<Dim>::offsets];
        for (int code = 0; code < Block<Dim>::offsets; ++code) {
            if (neighbour[code] < own) continue;
            const std::size_t peer = peer_of_ghost[static_cast<std::size_t>(neighbour[code] - own)];
            std::size_t k = 0;
            while (k < count && tile[k].peer != peer) ++k;
            if (k == count) tile[count++] = {peer, block, 0};
            tile[k].offsets |= 1u << code;
        }
    }
};

/// One entry per ghost.
template <int Dim>
std::vector<Exchanged> received(const EpochTables<Dim>& t, const std::vector<std::size_t>& peer_of_ghost) {
    std::vector<Exchanged> tiles(t.ghost.size());
    const auto own = static_cast<std::int32_t>(t.own.size());
#pragma omp parallel
    {
#pragma omp for schedule(static)
        for (std::size_t g = 0; g < tiles.size(); ++g) tiles[g] = {peer_of_ghost[g], static_cast<std::int32_t>(g), 0};
#pragma omp for schedule(static)
        for (std::int32_t block : t.boundary)
            for (int code = 0; code < Block<Dim>::offsets; ++code) {
                const std::int32_t n = t.neighbour[static_cast<std::size_t>(block * Block<Dim>::offsets + code)];
                if (n >= own)
                    std::atomic_ref(tiles[static_cast<std::size_t>(n - own)].offsets)
                        .fetch_or(1u << Block<Dim>::opposite(code), std::memory_order_relaxed);
            }
    }
    return tiles;
}

/// By block, and a block's in the order of its neighbours.
template <int Dim>
std::vector<Exchanged> sent(const EpochTables<Dim>& t, const std::vector<std::size_t>& peer_of_ghost) {
    std::vector<Exchanged> tiles;
    std::vector<std::size_t> peers(t.boundary.size());
#pragma omp parallel for schedule(static)
    for (std::size_t k = 0; k < peers.size(); ++k) peers[k] = Sent<Dim>(t, peer_of_ghost, t.boundary[k]).count;
    place_in_order(
        peers.size(), [&](std::size_t k) { return peers[k]; }, [&](std::size_t size) { tiles.resize(size); },
        [&](std::size_t k, std::size_t at) {
            const Sent<Dim> of_block(t, peer_of_ghost, t.boundary[k]);
            std::copy_n(of_block.tile.begin(), of_block.count, tiles.begin() + static_cast<std::ptrdiff_t>(at));
        });
    return tiles;
}

}  // namespace

template <int Dim>
std::vector<PeerHalo> halo_lists(const EpochTables<Dim>& t, int width) {
    std::vector<PeerHalo> peers;
    std::vector<std::size_t> peer_of_ghost(t.ghost.size());
    for (std::size_t g = 0; g < t.ghost.size(); ++g) {  // grouped by owner
        const auto here = static_cast<std::int32_t>(g);
        if (peers.empty() || peers.back().rank != t.ghost_owner[g])
            peers.push_back({t.ghost_owner[g], {}, {}, here, here});
        peers.back().ghost_end = here + 1;
        peer_of_ghost[g] = peers.size() - 1;
    }
    const std::vector<Exchanged> in = received(t, peer_of_ghost), out = sent(t, peer_of_ghost);
    const Grouped by_peer = grouped_in_order(out.size(), peers.size(), [&](std::size_t i) { return out[i].peer; });
    const std::vector<std::uint32_t> covering = covering_offsets<Dim>(width);
    for (std::size_t p = 0; p < peers.size(); ++p) {
        const std::size_t first = by_peer.first[p];
        const auto begin = static_cast<std::size_t>(peers[p].ghost_begin);
        peers[p].send = tile_list(
            by_peer.first[p + 1] - first, [&](std::size_t k) { return out[by_peer.item[first + k]]; }, covering);
        peers[p].receive = tile_list(
            static_cast<std::size_t>(peers[p].ghost_end) - begin, [&](std::size_t k) { return in[begin + k]; },
            covering);
    }
    return peers;
}

template std::vector<PeerHalo> halo_lists<2>(const EpochTables<2>&, int);
template std::vector<PeerHalo> halo_lists<3>(const EpochTables<3>&, int);

}  // namespace moraine
