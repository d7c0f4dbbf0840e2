#include <doctest/doctest.h>

#include <algorithm>
#include <set>

#include "balance/cut.hpp"
#include "balance/load.hpp"
#include "balance/partitioner.hpp"
#include "balance/relabel.hpp"
#include "core/data/error.hpp"

using namespace moraine;
using Owners = std::vector<std::int32_t>;

namespace {

const Layout plain{2, {12, 4, 1}};
const Layout solid{3, {5, 4, 6}};

BalanceSpec spec_of(const std::string& name, int axis = 0) {
    BalanceSpec spec;
    spec.partitioner = name;
    spec.axis = axis;
    return spec;
}

/// Blocks of a 2-D heap that is `columns` wide: column x has particles(x) in each of its blocks.
template <class Particles>
std::vector<BlockLoad> heap(int columns, Particles particles) {
    std::vector<BlockLoad> blocks;
    for (int x = 0; x < columns; ++x)
        for (int y = 0; y < plain.blocks[1]; ++y)
            blocks.push_back({Morton<2>::encode({x, y}), particles(x), particles(x), -1});
    std::sort(blocks.begin(), blocks.end(), [](const BlockLoad& a, const BlockLoad& b) { return a.key < b.key; });
    return blocks;
}

void give(std::vector<BlockLoad>& blocks, const Owners& owners) {
    for (std::size_t b = 0; b < blocks.size(); ++b) blocks[b].owner = owners[b];
}

double imbalance_of(const std::vector<BlockLoad>& blocks, const Owners& owners, int ranks) {
    return summary_of(loads_of_ranks(blocks, owners, ranks)).imbalance();
}

std::string message_of(const BalanceSpec& spec, const Layout& layout) {
    try {
        make_partitioner(spec, layout, 2);
    } catch (const InputError& e) {
        return e.what();
    }
    return {};
}

}  // namespace

TEST_CASE("an unknown partitioner is refused with the names there are") {
    const std::string message = message_of(spec_of("mortn"), plain);
    CHECK(message.starts_with(
        "balance.partitioner = \"mortn\" (no such partitioner). Use one of morton, hilbert, slabs, "));
    CHECK(message.ends_with(", shuffle?"));
    for (const std::string& name : partitioner_names())
        CHECK((message.find(name) != std::string::npos) == is_built(name));
}

TEST_CASE("a partitioner that the program was built without is refused with the option that adds it") {
    for (const char* name : {"rcb", "hsfc", "phg"})
        if (!is_built(name))
            CHECK(message_of(spec_of(name), plain)
                      .starts_with("balance.partitioner = \"" + std::string(name) +
                                   "\" (this program was built without Zoltan, option MORAINE_ZOLTAN). Use one of "));
    if (!is_built("metis"))
        CHECK(message_of(spec_of("metis"), plain).find("built without METIS, option MORAINE_METIS)") !=
              std::string::npos);
    for (const char* name : {"morton", "hilbert", "slabs", "cartesian"}) CHECK(is_built(name));
    CHECK_FALSE(is_built("mortn"));
}

TEST_CASE("slabs along an axis that the scene has not are refused") {
    CHECK(message_of(spec_of("slabs", 2), plain) ==
          "balance.axis = 2 (a scene of 2 dimensions has the axes 0 to 1). Use 0?");
    CHECK(message_of(spec_of("slabs-initial", -1), solid).starts_with("balance.axis = -1"));
    CHECK(message_of(spec_of("slabs", 2), solid).empty());
    CHECK(message_of(spec_of("morton", 2), plain).empty());
}

TEST_CASE("morton owners are contiguous along the curve and as balanced as the blocks allow") {
    const auto blocks = heap(12, [](int x) { return 100 - 8 * x; });
    std::vector<std::int64_t> weights;
    for (const BlockLoad& b : blocks) weights.push_back(b.weight);
    for (int ranks : {2, 3, 4, 7}) {
        const Owners owners = make_partitioner(spec_of("morton"), plain, ranks)->owners(blocks, 0);
        CHECK(std::is_sorted(owners.begin(), owners.end()));
        const LoadSummary s = summary_of(loads_of_ranks(blocks, owners, ranks));
        CHECK(s.max == heaviest_part(weights, exact_cut(weights, ranks)));
        CHECK(s.imbalance() < 1.1);
    }
}

TEST_CASE("morton moves nothing while the loads stay, and less than natural order when they change") {
    auto blocks = heap(12, [](int x) { return 100 - 8 * x; });
    const auto morton = make_partitioner(spec_of("morton"), plain, 4);
    Owners owners = morton->owners(blocks, 0);
    for (auto& r : owners) r = (r + 1) % 4;  // as an earlier relabelling may have left them
    give(blocks, owners);
    CHECK(morton->owners(blocks, 1) == owners);

    const auto grown = heap(12, [](int x) { return 50 + 3 * x; });
    for (std::size_t b = 0; b < blocks.size(); ++b) blocks[b].particles = blocks[b].weight = grown[b].weight;
    const Owners natural = make_partitioner(spec_of("morton"), plain, 4)->owners(grown, 0);
    CHECK(moved(blocks, morton->owners(blocks, 2)).particles < moved(blocks, natural).particles);
}

TEST_CASE("one heavy block gets a rank of its own") {
    auto blocks = heap(12, [](int) { return 1; });
    blocks[20].weight = 1000;
    const Owners owners = make_partitioner(spec_of("morton"), plain, 3)->owners(blocks, 0);
    CHECK(std::count(owners.begin(), owners.end(), owners[20]) == 1);
}

TEST_CASE("slabs have equal width over the domain, whatever is in it") {
    const auto slabs = make_partitioner(spec_of("slabs"), plain, 4);
    CHECK(slabs->is_static());
    for (int x = 0; x < 12; ++x) CHECK(slabs->owner_at({x, 3, 0}) == x / 3);
    CHECK(slabs->owner_at({-1, 0, 0}) == 0);
    CHECK(slabs->owner_at({12, 0, 0}) == 3);
    const auto blocks = heap(3, [](int) { return 5; });  // all in the first slab
    CHECK(imbalance_of(blocks, slabs->owners(blocks, 0), 4) == doctest::Approx(4));
    CHECK(make_partitioner(spec_of("slabs", 2), solid, 3)->owner_at({0, 0, 5}) == 2);
}

TEST_CASE("more ranks than slabs leave ranks idle, and the imbalance counts them") {
    const auto slabs = make_partitioner(spec_of("slabs", 1), plain, 8);  // 4 layers
    const auto blocks = heap(12, [](int) { return 5; });
    const Owners owners = slabs->owners(blocks, 0);
    CHECK(std::set<std::int32_t>(owners.begin(), owners.end()).size() == 4);
    CHECK(imbalance_of(blocks, owners, 8) == doctest::Approx(2));
}

TEST_CASE("initial slabs hold equal numbers of particles at the start and do not follow the flow") {
    const auto slabs = make_partitioner(spec_of("slabs-initial"), plain, 2);
    const auto initial = heap(8, [](int x) { return x < 2 ? 30 : 10; });  // 60 against 60: cut at column 2
    slabs->start(initial);
    CHECK(slabs->is_static());
    CHECK(imbalance_of(initial, slabs->owners(initial, 0), 2) == doctest::Approx(1));
    const auto later = heap(12, [](int) { return 10; });
    CHECK(imbalance_of(later, slabs->owners(later, 5), 2) == doctest::Approx(10.0 / 6));
    for (int x = -1; x < 13; ++x) CHECK(slabs->owner_at({x, 0, 0}) == (x < 2 ? 0 : 1));
}

TEST_CASE("initial slabs lie across the axis of the scene") {
    const auto slabs = make_partitioner(spec_of("slabs-initial", 2), solid, 2);  // 6 layers in z
    std::vector<BlockLoad> tower;
    for (int z = 0; z < 6; ++z) tower.push_back({Morton<3>::encode({4, 0, z}), z == 0 ? 5 : 1, 1, -1});
    slabs->start(tower);
    for (int z = 0; z < 6; ++z) CHECK(slabs->owner_at({4, 0, z}) == (z == 0 ? 0 : 1));
}

TEST_CASE("restored initial slabs are those of a run begun on that number of ranks") {
    const auto initial = heap(9, [](int x) { return 7 + x * x; });
    const auto two = make_partitioner(spec_of("slabs-initial"), plain, 2);
    two->start(initial);
    for (int ranks : {1, 2, 3, 5}) {
        const auto begun = make_partitioner(spec_of("slabs-initial"), plain, ranks);
        const auto restored = make_partitioner(spec_of("slabs-initial"), plain, ranks);
        begun->start(initial);
        REQUIRE(restored->restore(two->state()));
        for (int x = -1; x < 13; ++x) CHECK(restored->owner_at({x, 0, 0}) == begun->owner_at({x, 0, 0}));
    }
}

TEST_CASE("a state of another axis, domain or partitioner is not restored") {
    const auto along_x = make_partitioner(spec_of("slabs-initial", 0), Layout{2, {4, 4, 1}}, 2);
    const auto along_y = make_partitioner(spec_of("slabs-initial", 1), Layout{2, {4, 4, 1}}, 2);
    along_x->start({});
    CHECK_FALSE(along_y->restore(along_x->state()));
    CHECK_FALSE(make_partitioner(spec_of("slabs-initial", 0), plain, 2)->restore(along_x->state()));
    CHECK_FALSE(along_x->restore({}));
    CHECK_FALSE(make_partitioner(spec_of("morton"), plain, 2)->restore(along_x->state()));
    CHECK(make_partitioner(spec_of("morton"), plain, 2)->restore({}));
}

TEST_CASE("shuffle spreads the blocks over all ranks, anew in each round, and alike for the same round") {
    const auto blocks = heap(12, [](int) { return 1; });
    const auto shuffle = make_partitioner(spec_of("shuffle"), plain, 4);
    const Owners first = shuffle->owners(blocks, 0);
    CHECK(std::set<std::int32_t>(first.begin(), first.end()).size() == 4);
    CHECK(shuffle->owners(blocks, 0) == first);
    const Owners second = shuffle->owners(blocks, 1);
    int changed = 0;
    for (std::size_t b = 0; b < first.size(); ++b) changed += first[b] != second[b];
    CHECK(changed > 24);                                                         // 36 of 48 expected
    CHECK(shuffle->owners(std::span(blocks).subspan(5, 1), 1)[0] == second[5]);  // the list does not matter
}

TEST_CASE("only static partitioners know the owner of an empty place") {
    CHECK(make_partitioner(spec_of("morton"), plain, 2)->owner_at({0, 0, 0}) == -1);
    CHECK(make_partitioner(spec_of("shuffle"), plain, 2)->owner_at({0, 0, 0}) == -1);
    CHECK_FALSE(make_partitioner(spec_of("morton"), plain, 2)->is_static());
}
