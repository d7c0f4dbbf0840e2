#include <doctest/doctest.h>

#include <set>

#include "blocks/random_world.hpp"
#include "replay/halo_forecast.hpp"

using namespace moraine;
using moraine::test::World;

namespace {

template <int Dim>
Layout layout_of(const World<Dim>& world) {
    Layout layout;
    layout.dimensions = Dim;
    layout.width = world.stencil.width;
    std::copy(world.domain.count.begin(), world.domain.count.end(), layout.blocks.begin());
    std::copy(world.domain.periodic.begin(), world.domain.periodic.end(), layout.periodic.begin());
    return layout;
}

/// From the tables that the ranks of a run would have: of tiles that hold particles.
template <int Dim>
HaloForecast halo_of_tables(const World<Dim>& world, const HostOfRank& hosts) {
    HaloForecast halo;
    halo.sent.resize(static_cast<std::size_t>(world.ranks));
    for (int r = 0; r < world.ranks; ++r) {
        const EpochTables<Dim> t = make_epoch<Dim>(world.topology(), world.domain, world.stencil, r);
        std::int64_t sent = 0;
        std::int32_t neighbours = 0;
        for (const PeerHalo& peer : t.peers) {
            bool any = false;
            const bool within = hosts[r] == hosts[peer.rank];
            const std::int64_t before = sent;
            for (std::size_t k = 0; k < peer.send.block.size(); ++k) {
                if (!world.is_occupied(t.own[static_cast<std::size_t>(peer.send.block[k])])) continue;
                any = true;
                ++halo.tiles;
                halo.tiles_between += !within;
                sent += 1 + (peer.send.first[k + 1] - peer.send.first[k]) * node_sums<Dim> * 8;
            }
            neighbours += any;
            HaloForecast::Sent& mine = halo.sent[r];
            (within ? mine.neighbours_within : mine.neighbours_between) += any;
            (within ? mine.bytes_within : mine.bytes_between) += sent - before;
        }
        halo.bytes += sent;
        halo.busiest_bytes = std::max(halo.busiest_bytes, sent);
        halo.neighbours_mean += static_cast<double>(neighbours) / world.ranks;
        halo.neighbours_max = std::max(halo.neighbours_max, neighbours);
    }
    return halo;
}

template <int Dim>
void forecast_is_what_tables_say() {
    for (std::uint64_t seed = 0; seed < (Dim == 2 ? 60 : 24); ++seed) {
        CAPTURE(seed);
        const World<Dim> world(seed, 1 + static_cast<int>(seed / 3 % 5));
        const Layout layout = layout_of(world);
        std::vector<BlockLoad> blocks;
        for (const OccupiedBlock& b : world.occupied) blocks.push_back({b.key, 1, 1, b.owner});
        const auto partitioner = make_partitioner(BalanceSpec{}, layout, world.ranks);
        const HostOfRank hosts = hosts_of(world.ranks, 1 + static_cast<int>(seed % 3));
        const HaloForecast found =
            HaloSurroundings(layout, blocks)
                .halo(present_owners(blocks), *partitioner, world.ranks, node_sums<Dim> * 8, hosts);
        const HaloForecast expected = halo_of_tables(world, hosts);
        CHECK(found.tiles == expected.tiles);
        CHECK(found.bytes == expected.bytes);
        CHECK(found.busiest_bytes == expected.busiest_bytes);
        CHECK(found.neighbours_max == expected.neighbours_max);
        CHECK(found.neighbours_mean == doctest::Approx(expected.neighbours_mean));
        CHECK(found.tiles_between == expected.tiles_between);
        REQUIRE(found.sent.size() == expected.sent.size());
        for (std::size_t r = 0; r < found.sent.size(); ++r) {
            CHECK(found.sent[r].neighbours_within == expected.sent[r].neighbours_within);
            CHECK(found.sent[r].neighbours_between == expected.sent[r].neighbours_between);
            CHECK(found.sent[r].bytes_within == expected.sent[r].bytes_within);
            CHECK(found.sent[r].bytes_between == expected.sent[r].bytes_between);
        }
    }
}

}  // namespace

TEST_CASE("the halo forecast of all ranks is what the tables of an epoch say") {
    forecast_is_what_tables_say<2>();
    forecast_is_what_tables_say<3>();
}

TEST_CASE("a face between two ranks is cut once, an edge or a corner is not a face") {
    Layout layout;
    layout.blocks = {4, 4, 4};
    std::vector<BlockLoad> blocks;
    for (std::int32_t y = 0; y < 2; ++y)
        for (std::int32_t x = 0; x < 2; ++x) blocks.push_back({Morton<3>::encode({x, y, 0}), 1, 1, x});
    const auto partitioner = make_partitioner(BalanceSpec{}, layout, 2);
    const HaloSurroundings around(layout, blocks);
    CHECK(around.halo(present_owners(blocks), *partitioner, 2, 40).face_cut == 2);
    const std::vector<std::int32_t> alone(4, 0);
    CHECK(around.halo(alone, *partitioner, 2, 40).tiles == 0);
}
