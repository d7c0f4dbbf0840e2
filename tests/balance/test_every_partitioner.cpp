// On 1 and more ranks: what all partitioners promise, whatever the loads.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "balance/load.hpp"
#include "balance/one_rank.hpp"
#include "balance/partitioner.hpp"
#include "balance/relabel.hpp"
#include "balance/run_loads.hpp"
#include "core/data/error.hpp"

using namespace moraine;
using Owners = std::vector<std::int32_t>;

namespace {

BalanceSpec spec_of(const std::string& name) {
    BalanceSpec spec;
    spec.partitioner = name;
    return spec;
}

const Layout flat{2, {20, 6, 1}, {true, false, false}, 3};
const Layout solid{3, {9, 7, 5}, {false, true, false}, 2};

/// A random part of the domain; now and then a block without load, or one that outweighs all others.
std::vector<BlockLoad> random_loads(std::mt19937_64& random, const Layout& layout) {
    const std::uint64_t share = 1 + random() % 8;
    std::vector<BlockLoad> blocks;
    for (std::int32_t z = 0; z < layout.blocks[2]; ++z)
        for (std::int32_t y = 0; y < layout.blocks[1]; ++y)
            for (std::int32_t x = 0; x < layout.blocks[0]; ++x) {
                if (random() % 8 >= share) continue;
                const auto load = static_cast<std::int64_t>(random() % 512);
                const Key key = layout.dimensions == 2 ? Morton<2>::encode({x, y}) : Morton<3>::encode({x, y, z});
                blocks.push_back({key, load, load, -1});
            }
    if (!blocks.empty() && random() % 4 == 0) blocks[random() % blocks.size()].weight = 10000000;
    std::sort(blocks.begin(), blocks.end(), [](const BlockLoad& a, const BlockLoad& b) { return a.key < b.key; });
    return blocks;
}

bool all_owned(const Owners& owners, std::size_t blocks, int ranks) {
    return owners.size() == blocks &&
           std::all_of(owners.begin(), owners.end(), [&](std::int32_t r) { return r >= 0 && r < ranks; });
}

void give(std::vector<BlockLoad>& blocks, const Owners& owners) {
    for (std::size_t b = 0; b < blocks.size(); ++b) blocks[b].owner = owners[b];
}

/// The same as on every other rank?
bool is_agreed(const Comm& comm, const Owners& owners) {
    std::uint64_t hash = 14695981039346656037ULL;
    for (std::int32_t r : owners) hash = (hash ^ static_cast<std::uint64_t>(r)) * 1099511628211ULL;
    const auto mine = static_cast<std::int64_t>(hash >> 1);
    return comm.max(mine) == -comm.max(-mine);
}

double imbalance_of(const std::vector<BlockLoad>& blocks, const Owners& owners, int ranks) {
    return summary_of(loads_of_ranks(blocks, owners, ranks)).imbalance();
}

}  // namespace

TEST_CASE("every partitioner gives each block to a rank, for 1 to 7 ranks, and the same when asked again") {
    std::mt19937_64 random(1);
    for (int round = 0; round < 6; ++round)
        for (const Layout& layout : {flat, solid}) {
            std::vector<BlockLoad> blocks = random_loads(random, layout);
            for (const std::string& name : partitioner_names()) {
                if (!is_built(name)) continue;
                for (int ranks = 1; ranks <= 7; ++ranks) {
                    CAPTURE(name);
                    CAPTURE(ranks);
                    const auto partitioner = make_partitioner(spec_of(name), layout, ranks);
                    for (BlockLoad& block : blocks) block.owner = -1;
                    partitioner->start(blocks);
                    for (int turn = 0; turn < 2; ++turn) {  // nobody's blocks, then those of the first turn
                        const Owners owners = partitioner->owners(blocks, turn);
                        REQUIRE(all_owned(owners, blocks.size(), ranks));
                        REQUIRE(partitioner->owners(blocks, turn) == owners);
                        for (const Option& option : partitioner->options(blocks, turn))
                            REQUIRE(all_owned(option.owners, blocks.size(), ranks));
                        give(blocks, owners);
                    }
                }
            }
        }
}

TEST_CASE("no blocks, fewer blocks than ranks and one huge block are owned too") {
    std::vector<BlockLoad> few;
    for (std::int32_t x = 0; x < 4; ++x) few.push_back({Morton<2>::encode({x, 0}), 5, 5, -1});
    std::vector<BlockLoad> huge;
    for (std::int32_t x = 0; x < 20; ++x) huge.push_back({Morton<2>::encode({x, 0}), 5, 5, -1});
    huge[3].weight = std::int64_t(1) << 50;
    const std::vector<BlockLoad> weightless{few[0], {Morton<2>::encode({1, 0}), 0, 0, -1}};
    for (const std::string& name : partitioner_names()) {
        if (!is_built(name)) continue;
        for (int ranks : {1, 2, 3, 7, 100}) {
            CAPTURE(name);
            CAPTURE(ranks);
            const auto partitioner = make_partitioner(spec_of(name), flat, ranks);
            partitioner->start(huge);
            CHECK(partitioner->owners({}, 0).empty());
            CHECK(all_owned(partitioner->owners(few, 0), few.size(), ranks));
            CHECK(all_owned(partitioner->owners(huge, 0), huge.size(), ranks));
            CHECK(all_owned(partitioner->owners(weightless, 0), 2, ranks));
            CHECK(all_owned(partitioner->owners(std::span(weightless).last(1), 0), 1, ranks));
        }
    }
}

TEST_CASE("the partitioners that follow the load balance a run's blocks, each as well as it can") {
    const std::map<std::string, double> at_most{{"morton", 1.03}, {"hilbert", 1.03}, {"equal-slabs", 1.5},
                                                {"rcb", 1.05},    {"hsfc", 1.05},    {"phg", 1.05},
                                                {"metis", 1.05}};
    for (const auto& [step, blocks] : loads_of_run())
        for (const auto& [name, limit] : at_most) {
            if (!is_built(name)) continue;
            for (int ranks : {2, 4, 7}) {
                CAPTURE(name);
                CAPTURE(ranks);
                CAPTURE(step);
                const auto owners = make_partitioner(spec_of(name), run_layout, ranks)->owners(blocks, 0);
                CHECK(imbalance_of(blocks, owners, ranks) < limit);
            }
        }
}

TEST_CASE("all ranks of a run get the same owners, and again when they hold the blocks") {
    const Comm comm(MPI_COMM_WORLD);
    std::vector<BlockLoad> blocks = loads_of_run().rbegin()->second;
    for (const std::string& name : partitioner_names()) {
        if (!is_built(name)) continue;
        CAPTURE(name);
        const auto partitioner = make_partitioner(spec_of(name), run_layout, comm);
        for (BlockLoad& block : blocks) block.owner = -1;
        partitioner->start(blocks);
        for (int turn = 0; turn < 2; ++turn) {
            const Owners owners = partitioner->owners(blocks, turn);
            REQUIRE(all_owned(owners, blocks.size(), comm.size()));
            CHECK(is_agreed(comm, owners));
            for (const Option& option : partitioner->options(blocks, turn)) CHECK(is_agreed(comm, option.owners));
            give(blocks, owners);
        }
        CHECK(partitioner->name() == name);
    }
}

TEST_CASE("what one rank alone computes is what all get, and its refusal is everybody's") {
    const Comm comm(MPI_COMM_WORLD);
    class Moody final : public Partitioner {
      public:
        explicit Moody(int rank) : rank_(rank) {}
        const char* name() const override { return "moody"; }
        std::vector<std::int32_t> owners(std::span<const BlockLoad> blocks, std::int64_t round) const override {
            if (round == 1) throw InputError("no (why). How?");
            if (round == 2) throw MachineError("broken (why). How?");
            return std::vector<std::int32_t>(blocks.size(), rank_);
        }

      private:
        int rank_;
    };
    const OneRank one(std::make_unique<Moody>(comm.rank()), comm);
    const std::vector<BlockLoad> blocks(5, BlockLoad{0, 1, 1, -1});
    CHECK(one.owners(blocks, 0) == Owners(5, 0));
    CHECK_THROWS_WITH_AS(one.owners(blocks, 1), "no (why). How?", InputError);
    CHECK_THROWS_WITH_AS(one.options(blocks, 2), "broken (why). How?", MachineError);
}

TEST_CASE("blocks that stay balanced stay where they are, and phg moves few for a smaller halo") {
    for (const std::string name : {"morton", "hilbert", "equal-slabs", "rcb", "hsfc", "metis", "phg"}) {
        if (!is_built(name)) continue;
        CAPTURE(name);
        std::vector<BlockLoad> blocks = loads_of_run().begin()->second;
        const auto partitioner = make_partitioner(spec_of(name), run_layout, 4);
        give(blocks, partitioner->owners(blocks, 0));
        const std::int64_t most = name == "phg" ? static_cast<std::int64_t>(blocks.size()) / 20 : 0;
        CHECK(moved(blocks, partitioner->owners(blocks, 1)).blocks <= most);
    }
}
