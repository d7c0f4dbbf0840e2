#include <omp.h>

#include <map>

#include "blocks/epoch.hpp"
#include "blocks/random_world.hpp"

using namespace moraine;
using moraine::test::World;

namespace {

template <int Dim>
std::vector<EpochTables<Dim>> tables_of_all(const World<Dim>& world) {
    std::vector<EpochTables<Dim>> all;
    for (int r = 0; r < world.ranks; ++r)
        all.push_back(make_epoch<Dim>(world.topology(), world.domain, world.stencil, r));
    return all;
}

/// Key of own or ghost block `i`; -1 has none.
template <int Dim>
Key key_of(const EpochTables<Dim>& t, std::int32_t i) {
    const auto own = static_cast<std::int32_t>(t.own.size());
    return i < own ? t.own[static_cast<std::size_t>(i)] : t.ghost[static_cast<std::size_t>(i - own)];
}

template <int Dim, class F>
void each_world(const F& f) {
    for (std::uint64_t seed = 0; seed < (Dim == 2 ? 60 : 24); ++seed) {
        CAPTURE(seed);
        f(World<Dim>(seed, 1 + static_cast<int>(seed / 3 % 5)));
    }
}

/// Tiles of a list as key -> nodes.
template <int Dim>
std::map<Key, std::vector<std::uint16_t>> named(const EpochTables<Dim>& t, const TileList& list, bool ghosts) {
    std::map<Key, std::vector<std::uint16_t>> tiles;
    for (std::size_t k = 0; k < list.block.size(); ++k) {
        const auto block = static_cast<std::size_t>(list.block[k]);
        tiles[ghosts ? t.ghost[block] : t.own[block]] = {list.node.begin() + list.first[k],
                                                         list.node.begin() + list.first[k + 1]};
    }
    return tiles;
}

template <int Dim>
void every_block_has_one_owner() {
    each_world<Dim>([](const World<Dim>& world) {
        const Topology<Dim> topology = world.topology();
        std::map<Key, int> owner;
        for (int r = 0; r < world.ranks; ++r) {
            const EpochTables<Dim> t = make_epoch<Dim>(topology, world.domain, world.stencil, r);
            REQUIRE(std::is_sorted(t.own.begin(), t.own.end()));
            for (std::size_t i = 0; i < t.own.size(); ++i) {
                REQUIRE(owner.emplace(t.own[i], r).second);
                REQUIRE(t.find_own(t.own[i]) == static_cast<std::int32_t>(i));
                const BlockPosition<Dim> at = Morton<Dim>::decode(t.own[i]);
                for (int a = 0; a < Dim; ++a) REQUIRE(t.position[i][a] == at[static_cast<std::size_t>(a)]);
            }
            std::vector<std::int32_t> both = t.boundary;
            both.insert(both.end(), t.interior.begin(), t.interior.end());
            std::sort(both.begin(), both.end());
            REQUIRE(both.size() == t.own.size());
            for (std::size_t i = 0; i < both.size(); ++i) REQUIRE(both[i] == static_cast<std::int32_t>(i));
        }
        REQUIRE(owner.size() == topology.keys.size());
        for (std::size_t i = 0; i < topology.keys.size(); ++i) REQUIRE(owner.at(topology.keys[i]) == topology.owner[i]);
    });
}

template <int Dim>
void neighbours_are_own_or_ghosts() {
    each_world<Dim>([](const World<Dim>& world) {
        const Topology<Dim> topology = world.topology();
        for (int r = 0; r < world.ranks; ++r) {
            const EpochTables<Dim> t = make_epoch<Dim>(topology, world.domain, world.stencil, r);
            std::set<Key> ghosts;
            BlockPosition<Dim> near{};
            for (std::size_t i = 0; i < t.own.size(); ++i)
                for (int code = 0; code < Block<Dim>::offsets; ++code) {
                    const std::int32_t n = t.neighbour[i * Block<Dim>::offsets + static_cast<std::size_t>(code)];
                    const bool inside = world.neighbour(Morton<Dim>::decode(t.own[i]), code, near);
                    const Key key = Morton<Dim>::encode(near);
                    const bool there = inside && topology.find(key) >= 0;
                    REQUIRE((n >= 0) == there);
                    if (!there) continue;
                    REQUIRE(key_of(t, n) == key);
                    if (n >= static_cast<std::int32_t>(t.own.size())) ghosts.insert(key);
                    if (world.is_occupied(t.own[i])) REQUIRE(there == inside);  // space to walk
                }
            REQUIRE(ghosts.size() == t.ghost.size());
            for (std::size_t g = 0; g < t.ghost.size(); ++g) {
                REQUIRE(ghosts.contains(t.ghost[g]));
                REQUIRE(topology.owner[static_cast<std::size_t>(topology.find(t.ghost[g]))] == t.ghost_owner[g]);
            }
            for (const PeerHalo& peer : t.peers)
                for (std::int32_t g = peer.ghost_begin; g < peer.ghost_end; ++g)
                    REQUIRE(t.ghost_owner[static_cast<std::size_t>(g)] == peer.rank);
        }
    });
}

template <int Dim>
void both_sides_derive_the_same_lists() {
    each_world<Dim>([](const World<Dim>& world) {
        const std::vector<EpochTables<Dim>> all = tables_of_all(world);
        for (int a = 0; a < world.ranks; ++a)
            for (const PeerHalo& to : all[static_cast<std::size_t>(a)].peers) {
                REQUIRE(to.rank != a);
                const EpochTables<Dim>& other = all[static_cast<std::size_t>(to.rank)];
                const auto back = std::find_if(other.peers.begin(), other.peers.end(),
                                               [a](const PeerHalo& p) { return p.rank == a; });
                REQUIRE(back != other.peers.end());
                const auto sent = named(all[static_cast<std::size_t>(a)], to.send, false);
                REQUIRE(sent == named(other, back->receive, true));
                // The order counts too: it is that of the bytes.
                for (std::size_t k = 0; k < to.send.block.size(); ++k)
                    REQUIRE(key_of(all[static_cast<std::size_t>(a)], to.send.block[k]) ==
                            other.ghost[static_cast<std::size_t>(back->receive.block[k])]);
            }
    });
}

/// Every node that a particle of an own block can touch gets every tile that covers it: brute force over
/// all pairs of blocks and the global index of every node.
template <int Dim>
void own_nodes_get_every_tile() {
    each_world<Dim>([](const World<Dim>& world) {
        const Topology<Dim> topology = world.topology();
        const int width = world.stencil.width;
        const int nodes = power<Dim>(tile_side(width));
        for (int r = 0; r < world.ranks; ++r) {
            const EpochTables<Dim> t = make_epoch<Dim>(topology, world.domain, world.stencil, r);
            std::map<Key, std::vector<std::uint16_t>> received;
            for (const PeerHalo& peer : t.peers) received.merge(named(t, peer.receive, true));
            std::set<std::array<int, Dim>> touched;
            for (Key key : t.own)
                for (int n = 0; n < nodes; ++n) touched.insert(world.tile_node(Morton<Dim>::decode(key), n));
            for (std::size_t i = 0; i < topology.keys.size(); ++i) {
                if (topology.owner[i] == r) continue;
                const BlockPosition<Dim> at = Morton<Dim>::decode(topology.keys[i]);
                std::vector<std::uint16_t> needed;
                for (int n = 0; n < nodes; ++n)
                    if (touched.contains(world.tile_node(at, n))) needed.push_back(static_cast<std::uint16_t>(n));
                if (needed.empty())
                    REQUIRE(!received.contains(topology.keys[i]));
                else
                    REQUIRE(received.at(topology.keys[i]) == needed);
            }
        }
    });
}

/// The tables of node blocks: each node of an own block's tile finds every tile that covers it, once for
/// each of its places there, at the place that the offset says.
template <int Dim>
void node_blocks_find_their_tiles() {
    each_world<Dim>([](const World<Dim>& world) {
        for (int r = 0; r < world.ranks; ++r) {
            const EpochTables<Dim> t = make_epoch<Dim>(world.topology(), world.domain, world.stencil, r);
            BlockPosition<Dim> near{};
            for (std::size_t b = 0; b < t.own.size(); ++b)
                for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
                    const auto c = static_cast<std::size_t>(
                        t.node_block[b * Block<Dim>::corners + static_cast<std::size_t>(delta)]);
                    near = Morton<Dim>::decode(t.own[b]);
                    for (int a = 0; a < Dim; ++a) near[static_cast<std::size_t>(a)] += Block<Dim>::corner(delta, a);
                    world.domain.wrap(near);
                    REQUIRE(t.node_key[c] == Morton<Dim>::encode(near));
                    REQUIRE(t.source[c * Block<Dim>::corners + static_cast<std::size_t>(delta)] ==
                            static_cast<std::int32_t>(b));
                }
        }
    });
}

/// Which blocks the border flags must name: those whose stencils or nodes reach a face.
template <int Dim>
void borders_are_flagged() {
    each_world<Dim>([](const World<Dim>& world) {
        const int side = tile_side(world.stencil.width);
        const auto reaches = [&](const Vec<std::int32_t, Dim>& at, int last) {
            bool face = false;
            for (int a = 0; a < Dim; ++a) {
                const auto i = static_cast<std::size_t>(a);
                const int first = 4 * at[a] - world.stencil.origin;
                face = face || (!world.domain.periodic[i] && (first <= 0 || first + last >= world.domain.nodes[i]));
            }
            return face;
        };
        for (int r = 0; r < world.ranks; ++r) {
            const EpochTables<Dim> t = make_epoch<Dim>(world.topology(), world.domain, world.stencil, r);
            for (std::size_t b = 0; b < t.own.size(); ++b)
                if (reaches(t.position[b], side - 1)) REQUIRE(t.border[b]);
            for (std::size_t c = 0; c < t.node_key.size(); ++c)
                REQUIRE(bool(t.node_border[c]) == reaches(t.node_position[c], 3));
        }
    });
}

bool same(const TileList& a, const TileList& b) {
    return a.block == b.block && a.first == b.first && a.node == b.node;
}

template <int Dim>
bool same(const EpochTables<Dim>& a, const EpochTables<Dim>& b) {
    const auto same_peer = [](const PeerHalo& p, const PeerHalo& q) {
        return p.rank == q.rank && p.ghost_begin == q.ghost_begin && p.ghost_end == q.ghost_end &&
               same(p.send, q.send) && same(p.receive, q.receive);
    };
    return a.own == b.own && a.ghost == b.ghost && a.ghost_owner == b.ghost_owner && a.neighbour == b.neighbour &&
           a.border == b.border && a.node_key == b.node_key && a.node_border == b.node_border &&
           a.node_block == b.node_block && a.source == b.source && a.boundary == b.boundary &&
           a.interior == b.interior &&
           std::equal(a.peers.begin(), a.peers.end(), b.peers.begin(), b.peers.end(), same_peer);
}

/// Of a world large enough that threads share each list.
template <int Dim>
void threads_build_what_one_builds(std::uint64_t seed) {
    World<Dim> world(seed, 3);
    for (std::size_t a = 0; a < Dim; ++a) world.domain.count[a] = Dim == 2 ? 61 : 17;
    for (std::size_t a = 0; a < Dim; ++a) world.domain.nodes[a] = 4 * world.domain.count[a];
    world.occupied.clear();
    world.each_position([&](const BlockPosition<Dim>& at) {
        if (mix(seed + mix(Morton<Dim>::encode(at))) % 3 == 0) world.occupied.push_back({Morton<Dim>::encode(at), 0});
    });
    std::sort(world.occupied.begin(), world.occupied.end(), [](const auto& a, const auto& b) { return a.key < b.key; });
    world.shuffle_owners(seed);
    const int before = omp_get_max_threads();
    omp_set_num_threads(1);
    const std::vector<EpochTables<Dim>> by_one = tables_of_all(world);
    for (int threads : {2, 5}) {
        omp_set_num_threads(threads);
        const std::vector<EpochTables<Dim>> all = tables_of_all(world);
        for (std::size_t r = 0; r < all.size(); ++r) CHECK(same(all[r], by_one[r]));
    }
    omp_set_num_threads(before);
}

}  // namespace

TEST_CASE("the tables do not depend on the number of threads") {
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
        threads_build_what_one_builds<2>(seed);
        threads_build_what_one_builds<3>(seed);
    }
}

TEST_CASE("every block of the topology belongs to one rank and is boundary or interior there") {
    every_block_has_one_owner<2>();
    every_block_has_one_owner<3>();
}

TEST_CASE("the neighbours of own blocks are own or ghosts, and no other block is a ghost") {
    neighbours_are_own_or_ghosts<2>();
    neighbours_are_own_or_ghosts<3>();
}

TEST_CASE("what a rank sends to another is what that one expects, tile by tile and node by node") {
    both_sides_derive_the_same_lists<2>();
    both_sides_derive_the_same_lists<3>();
}

TEST_CASE("every node that a particle of an own block can touch gets every tile that covers it, and no other comes") {
    own_nodes_get_every_tile<2>();
    own_nodes_get_every_tile<3>();
}

TEST_CASE("node blocks know the blocks whose tiles cover them") {
    node_blocks_find_their_tiles<2>();
    node_blocks_find_their_tiles<3>();
}

TEST_CASE("blocks at the faces of the domain are flagged") {
    borders_are_flagged<2>();
    borders_are_flagged<3>();
}
