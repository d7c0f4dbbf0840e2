#include "blocks/patch.hpp"
#include "blocks/random_world.hpp"
#include "comm/halo.hpp"
#include "core/data/host.hpp"
#include "core/nodes/nodes.hpp"
#include "core/structures/structure_set.hpp"
#include "core/transfer/scene_walls.hpp"
#include "every_case.hpp"

using namespace moraine;
using moraine::test::Case;
using moraine::test::World;

namespace {

/// A rank's patch in a world: one particle in those occupied blocks that hold any in this run.
template <class Real, int Dim>
struct Share {
    const World<Dim>& world;
    Patch<Host, Real, Dim> patch;

    Share(const World<Dim>& w, int rank) : world(w), patch({}, w.stencil.width) {
        BinnedBlocks binned;
        for (const OccupiedBlock& b : w.occupied) {
            if (b.owner != rank || mix(b.key) % 4 == 0) continue;
            binned.key.push_back(b.key);
            binned.count.push_back(1);
            binned.slot.push_back(patch.take_slots(1)[0]);
            for (int a = 0; a < Dim; ++a) patch.particles.view().position[binned.slot.back()][a] = 0;
        }
        patch.install(make_epoch<Dim>(w.topology(), w.domain, w.stencil, rank), binned);
    }

    /// Tiles with numbers that depend on block, node and round alone; whatever else there is, is not a number.
    void fill_tiles(std::uint64_t round) {
        const TileView<Real> grid = patch.grid();
        const int nodes = power<Dim>(tile_side(world.stencil.width));
        const auto tiles = static_cast<std::int64_t>(patch.tables().ghost.size()) + patch.tiles_in_use();
        std::fill_n(grid.tiles, tiles * nodes * node_reals, std::numeric_limits<Real>::quiet_NaN());
        for (int b = 0; b < patch.own(); ++b) {
            if (grid.tile_of[b] < 0) continue;
            Real* to = grid.tiles + grid.tile_of[b] * nodes * node_reals;
            const std::uint64_t salt = mix(round ^ mix(patch.tables().own[static_cast<std::size_t>(b)]));
            for (int k = 0; k < nodes * node_reals; ++k) {
                const int q = k % node_reals;
                const double number = static_cast<double>(mix(salt + static_cast<unsigned>(k)) >> 11) * 0x1p-53;
                const bool used = q <= Dim || (q >= quad && q < quad + Dim);
                to[k] = used ? static_cast<Real>(q == 0 ? number + 0.5 : number - 0.5) : Real(0);
            }
        }
    }

    std::array<ExactSum, Dim> solve() {
        std::vector<ExactSum> impulse(patch.node_blocks().size() * Dim);
        const SolveNodes<Real, Dim> kernel{make_walls<Real, Dim>(world.scene),
                                           patch.table(),
                                           patch.grid(),
                                           patch.node_blocks().data(),
                                           world.stencil.width,
                                           world.stencil.origin,
                                           {NodeTask::solve, Real(0.1), {}, Real(0.2), Real(0.01)},
                                           Quantum::for_largest(1),
                                           impulse.data()};
        Host::launch_teams(static_cast<std::int64_t>(patch.node_blocks().size()), kernel);
        std::array<ExactSum, Dim> all{};
        for (std::size_t k = 0; k < impulse.size(); ++k) all[k % Dim].add(impulse[k]);
        return all;
    }

    /// The values at node n of the tile of own block b.
    const Real* node(int b, int n) {
        const int side = tile_side(world.stencil.width);
        int corner = 0, at = 0;
        for (int a = 0; a < Dim; ++a, n /= side) {
            corner |= (n % side / 4) << a;
            at |= (n % side % 4) << (2 * a);
        }
        const std::int32_t c = patch.table().node_block[b * Block<Dim>::corners + corner];
        return patch.grid().nodes + (patch.grid().node_of[c] * Block<Dim>::cells + at) * node_reals;
    }
};

template <class Real, int Dim>
void same_nodes_as_one_rank(const Comm& comm, std::uint64_t seed) {
    const World<Dim> world(seed, comm.size()), alone(seed, 1);
    Share<Real, Dim> share(world, comm.rank()), whole(alone, 0);
    PointToPoint messages(comm, 1);
    Halo<Real, Dim> halo(share.patch.tables(), messages, world.stencil.width);
    for (std::uint64_t round = 0; round < 2; ++round) {
        share.fill_tiles(round);
        whole.fill_tiles(round);
        halo.start(share.patch.grid());
        halo.finish(share.patch.grid(), share.patch.tile_of());
        const std::array<ExactSum, Dim> mine = share.solve(), all = whole.solve();
        int different = 0;
        for (int b = 0; b < share.patch.own(); ++b) {
            if (share.patch.grid().tile_of[b] < 0) continue;
            const int other = whole.patch.tables().find_own(share.patch.tables().own[static_cast<std::size_t>(b)]);
            for (int n = 0; n < power<Dim>(tile_side(world.stencil.width)); ++n)
                different += std::memcmp(share.node(b, n), whole.node(other, n), node_reals * sizeof(Real)) != 0;
        }
        CHECK(different == 0);
        // Each node is counted by one rank only, or the impulses of all ranks would not add up to the bit.
        for (std::size_t a = 0; a < Dim; ++a) {
            ExactSum sum;
            for (const ExactSum& s : comm.all_gather(std::vector<ExactSum>{mine[a]})) sum.add(s);
            CHECK(sum.high == all[a].high);
            CHECK(sum.low == all[a].low);
        }
    }
    if (comm.size() == 1) CHECK(halo.bytes() == 0);
}

/// The gap tiles of a share, with numbers that depend on block, structure and node alone.
template <class Real, int Dim>
struct GapsOf {
    Share<Real, Dim>& share;
    ContactPairs<Dim> pairs;
    std::vector<NodeGap> tiles;

    GapsOf(Share<Real, Dim>& s, const ContactField<Dim>& field) : share(s) {
        const int nodes = power<Dim>(tile_side(s.world.stencil.width));
        pairs.make(s.patch.tables(), field, false);
        tiles.assign(pairs.tiles() * static_cast<std::size_t>(nodes), NodeGap{-1 << 30, 1u << 30});  // stale
        for (const auto* list : {&pairs.boundary(), &pairs.interior()})
            for (const ContactPair& pair : *list) {
                const Key key = s.patch.tables().own[static_cast<std::size_t>(pair.block)];
                for (int n = 0; n < nodes; ++n) {
                    const std::uint64_t number = mix(mix(key) + static_cast<unsigned>(pair.structure * 1000 + n));
                    tiles[static_cast<std::size_t>(pair.tile * nodes + n)] = {static_cast<std::int32_t>(number % 1000),
                                                                              static_cast<std::uint32_t>(number >> 50)};
                }
            }
    }

    NodeGap at(int c, int n, int k) {
        const GapTiles view{pairs.structures(), pairs.tile_of().data(), tiles.data()};
        return gap_at_node(view, share.patch.table(), share.patch.tile_of(), share.world.stencil.width, c, n, k);
    }
};

/// Whether an occupied own block's tile covers node n of node block c.
template <class Real, int Dim>
bool needs_node(Share<Real, Dim>& share, int c, int n) {
    const BlockTable<Dim> table = share.patch.table();
    for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
        const std::int32_t source = table.source[c * Block<Dim>::corners + delta];
        bool covers = source >= 0 && source < share.patch.own() && share.patch.tile_of()[source] >= 0;
        for (int a = 0; a < Dim; ++a)
            covers = covers && !(Block<Dim>::corner(delta, a) && ((n >> (2 * a)) & 3) >= share.world.stencil.width - 1);
        if (covers) return true;
    }
    return false;
}

/// Two structures of a world: a slope and a ball.
template <int Dim>
Scene with_structures(Scene scene) {
    StructureSpec slope, ball;
    for (std::size_t a = 0; a < Dim; ++a)
        slope.point[a] = ball.center[a] = scene.min[a] + 0.4 * (scene.max[a] - scene.min[a]);
    slope.normal = {0.3, 1, 0.2};
    ball.shape = StructureShape::sphere, ball.radius = 3 * scene.cell;
    scene.structures = {slope, ball};
    return scene;
}

template <class Real, int Dim>
void same_gaps_as_one_rank(const Comm& comm, std::uint64_t seed) {
    const World<Dim> world(seed, comm.size()), alone(seed, 1);
    const Scene scene = with_structures<Dim>(world.scene);
    const StructureSet<Dim> structures(scene);
    Share<Real, Dim> share(world, comm.rank()), whole(alone, 0);
    GapsOf<Real, Dim> mine(share, structures.field()), all(whole, structures.field());
    PointToPoint messages(comm, 1);
    Halo<Real, Dim> halo(share.patch.tables(), messages, world.stencil.width);
    halo.reserve(mine.pairs);
    const GapShare<Dim> gaps{&mine.pairs, mine.tiles.data()};
    share.fill_tiles(0);
    for (bool with : {true, false, true}) {
        halo.start(share.patch.grid(), with ? &gaps : nullptr);
        halo.finish(share.patch.grid(), share.patch.tile_of(), with ? &gaps : nullptr);
    }
    int different = 0;
    const EpochTables<Dim>& here = share.patch.tables();
    for (std::size_t c = 0; c < here.node_key.size(); ++c) {
        const auto& keys = whole.patch.tables().node_key;
        const auto there = std::find(keys.begin(), keys.end(), here.node_key[c]) - keys.begin();
        for (int n = 0; n < Block<Dim>::cells; ++n)
            for (int k = 0; needs_node(share, static_cast<int>(c), n) && k < 2; ++k) {
                const NodeGap a = mine.at(static_cast<int>(c), n, k), b = all.at(static_cast<int>(there), n, k);
                different += a.gap != b.gap || a.area != b.area;
            }
    }
    CHECK(different == 0);
}

}  // namespace

TEST_CASE_TEMPLATE("nodes are the same to the bit on any number of ranks, and each is counted once", C, Case<float, 2>,
                   Case<double, 2>, Case<float, 3>, Case<double, 3>) {
    const Comm comm(MPI_COMM_WORLD);
    for (std::uint64_t seed = 0; seed < (C::dim == 2 ? 40 : 16); ++seed) {
        CAPTURE(seed);
        same_nodes_as_one_rank<typename C::Real, C::dim>(comm, seed);
    }
}

TEST_CASE_TEMPLATE("gaps to structures are the same on any number of ranks", C, Case<float, 2>, Case<double, 3>) {
    const Comm comm(MPI_COMM_WORLD);
    for (std::uint64_t seed = 0; seed < (C::dim == 2 ? 40 : 16); ++seed) {
        CAPTURE(seed);
        same_gaps_as_one_rank<typename C::Real, C::dim>(comm, seed);
    }
}

TEST_CASE("a halo message holds an occupancy byte per tile and the shared nodes of those that exist") {
    const Comm comm(MPI_COMM_WORLD);
    const World<2> world(4, comm.size());
    Share<double, 2> share(world, comm.rank());
    PointToPoint messages(comm, 1);
    Halo<double, 2> halo(share.patch.tables(), messages, world.stencil.width);
    share.fill_tiles(0);
    halo.start(share.patch.grid());
    halo.finish(share.patch.grid(), share.patch.tile_of());
    std::int64_t expected = 0;
    for (const PeerHalo& peer : share.patch.tables().peers) {
        expected += static_cast<std::int64_t>(padded(peer.send.block.size()));
        for (std::size_t t = 0; t < peer.send.block.size(); ++t)
            if (share.patch.grid().tile_of[peer.send.block[t]] >= 0)
                expected += (peer.send.first[t + 1] - peer.send.first[t]) * 5 * 8;
    }
    CHECK(halo.bytes() == expected);
}
