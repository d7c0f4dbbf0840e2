#include "gpu/binning_pair.hpp"
#include "gpu/exchange/migration.hpp"
#include "gpu/memory/device_tables.hpp"

using namespace moraine;

namespace {

/// By the definition, from the host's lists: who stands where less than a cell leads to a block of the peer.
template <int Dim>
MigrationBound migration_bound_of(const EpochTables<Dim>& tables, const ListView<Dim>& list) {
    using B = Block<Dim>;
    const auto own = static_cast<std::int32_t>(tables.own.size());
    MigrationBound migration_bound;
    for (const PeerHalo& peer : tables.peers) {
        std::int64_t pair = 0;
        for (std::int32_t b : peer.send.block) {
            const std::int32_t* neighbour = &tables.neighbour[static_cast<std::size_t>(b * B::offsets)];
            const auto leads_to_peer = [&](int cell) {
                for (int code = 0; code < B::offsets; ++code)
                    if ((B::reach(cell) >> code & 1) && neighbour[code] >= own &&
                        tables.ghost_owner[static_cast<std::size_t>(neighbour[code] - own)] == peer.rank)
                        return true;
                return false;
            };
            std::int64_t block = 0;
            const std::uint32_t* bound = list.cell_first + b * (B::cells + 1);
            for (int c = 0; c < B::cells && list.count(b) > 0; ++c)
                if (leads_to_peer(c)) block += bound[c + 1] - bound[c];
            migration_bound.take_most({block, 0});
            pair += block;
        }
        migration_bound.take_most({0, pair});
    }
    return migration_bound;
}

template <int Dim>
void compare(const test::Plan<Dim>& plan) {
    const test::BinningPair<Dim> pair(plan);
    const EpochTables<Dim>& epoch = pair.patch.tables();
    const ListView<Dim> host = pair.patch.list();
    gpu::Tables<Dim> tables;
    gpu::Routes routes;
    gpu::Array<std::uint32_t> first, cell_first;
    gpu::Array<gpu::Counters> counters;
    tables.upload(epoch, nullptr);
    routes.upload(epoch, nullptr);
    first.assign(host.first, epoch.own.size() + 1);
    cell_first.assign(host.cell_first, epoch.own.size() * (Block<Dim>::cells + 1));
    counters.assign({gpu::Counters{}});
    gpu::DeviceMigration<Dim> migration(nullptr);
    for (int twice = 0; twice < 2; ++twice) {  // an epoch begins with sums of zero
        migration.begin_epoch(epoch, nullptr);
        migration.count_migration_bound(routes.send(), tables.view(), {first.data(), cell_first.data(), nullptr},
                                        counters.data(), nullptr);
    }
    const MigrationBound expected = migration_bound_of(epoch, host);
    const gpu::Counters found = counters.host().front();
    CHECK(epoch.peers.size() == static_cast<std::size_t>(plan.ranks - 1));
    CHECK(found.migration_bound[0] == expected.block);
    CHECK(found.migration_bound[1] == expected.pair);
    CHECK(expected.block > 0);
    CHECK(expected.pair > expected.block);
}

}  // namespace

TEST_CASE(
    "the migration bound is who stands where less than a cell leads to the peer, of a block and of all of a pair") {
    compare<2>({.count = {9, 8}, .ranks = 4, .filled = 0.8});
    compare<3>({.count = {5, 4, 6}, .ranks = 3, .filled = 0.7});
    compare<3>({.count = {4, 4, 4}, .periodic = false, .ranks = 2});
    compare<3>({.count = {3, 2, 2}, .ranks = 2, .crammed = 70001});
}
