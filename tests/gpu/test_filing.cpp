#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <random>

#include "comm/patch.hpp"
#include "core/host.hpp"
#include "gpu/device_lists.hpp"
#include "gpu/stopwatch.hpp"

using namespace moraine;

namespace {

/// Chances of what a particle does in a step.
struct Chances {
    double leave = 0, gone = 0, change = 0;
    bool near = false;  ///< moves to neighbouring cells and through faces only
};

template <int Dim>
struct Plan {
    BlockPosition<Dim> count{};
    bool periodic = true;
    int ranks = 1;       ///< blocks belong to random ones; the share is that of rank 0
    double filled = 1;   ///< share of the blocks that hold particles
    int particles = 30;  ///< of a filled block, at most twice that
    bool even = false;   ///< just as many in each
    int crowd = 0;       ///< particles of one more block, all in one cell
};

/// A host's share and its copy on the device, filed side by side.
template <int Dim>
class Pair {
    using B = Block<Dim>;

  public:
    Patch<Host, float, Dim> patch{{}, 3};

    explicit Pair(const Plan<Dim>& plan) : plan_(plan) {
        Scene scene;
        scene.dimensions = Dim, scene.cell = 1;
        for (std::size_t a = 0; a < Dim; ++a) scene.periodic[a] = plan.periodic, scene.max[a] = 4 * plan.count[a];
        const DomainBlocks<Dim> domain(scene);
        FiledBlocks filed;
        std::vector<OccupiedBlock> occupied;
        for (Key key : every_key()) {
            const int n = particles_of(occupied.empty());
            if (n == 0) continue;
            occupied.push_back({key, owner_of(key)});
            if (owner_of(key) != 0) continue;
            filed.key.push_back(key);
            filed.count.push_back(static_cast<std::uint32_t>(n));
        }
        fill(filed);
        const auto owner_at = [this](const BlockPosition<Dim>& at) { return owner_of(Morton<Dim>::encode(at)); };
        patch.install(make_epoch<Dim>(make_topology<Dim>(domain, occupied, owner_at), domain, {3, 1, 0.5}, 0), filed);
        std::vector<std::uint8_t> boundary(static_cast<std::size_t>(patch.own()), 0);
        for (std::int32_t b : patch.boundary()) boundary[static_cast<std::size_t>(b)] = 1;
        room_ = static_cast<std::size_t>(patch.count()) + 4096;
        fresh_slot_ = static_cast<std::uint32_t>(patch.count());
        device_ =
            std::make_unique<test::DeviceLists<Dim>>(patch.table(), patch.list(), boundary, patch.tables().rim, room_);
        compare_blocks();
    }

    test::DeviceLists<Dim>& device() { return *device_; }

    /// Makes up moves, in the patch and on the device.
    void move(const Chances& chances) {
        const ListView<Dim> list = patch.list();
        const auto n = static_cast<std::size_t>(patch.count());
        std::vector<std::uint32_t> changed(n / 32 + static_cast<std::size_t>(patch.own()) + 1, 0);
        for (int b = 0; b < patch.own(); ++b) {
            patch.leavers()[b] = 0, patch.shuffled()[b] = 0;
            const std::uint32_t* cell_first = list.cell_first + b * (B::cells + 1);
            int cell = 0;
            for (std::uint32_t k = 0; k < list.count(b); ++k) {
                while (cell_first[cell + 1] <= k) ++cell;
                const std::uint16_t m = random_move(b, cell, chances);
                patch.moves()[list.first[b] + k] = m;
                if (move_code(m) != B::centre) ++patch.leavers()[b];
                if (m == encode_move(B::centre, cell)) continue;
                patch.shuffled()[b] = 1;
                changed[list.first[b] / 32 + static_cast<std::uint32_t>(b) + k / 32] |= 1u << k % 32;
            }
        }
        device_->set_moves({patch.moves(), patch.moves() + n}, changed);
    }

    void step(const Chances& chances) {
        move(chances);
        make_ghosts(chances);
        patch.collect_leavers();
        patch.make_lists(ghost_leaver_, ghost_first_);
        device_->set_ghosts(test::GhostLeavers::of<Dim>(ghost_leaver_, ghost_first_));
        device_->launch();
        device_->advance();
        compare();
    }

    void compare() const {
        const auto own = static_cast<std::size_t>(patch.own());
        const ListView<Dim> list = patch.list();
        REQUIRE(device_->first() == std::vector<std::uint32_t>(list.first, list.first + own + 1));
        REQUIRE(device_->slot() == std::vector<std::uint32_t>(list.slot, list.slot + patch.count()));
        compare_cells(list);
        compare_blocks();
        REQUIRE(device_->is_at_rim() == patch.is_at_rim());
    }

    void compare_blocks() const {
        const std::int32_t* tile_of = const_cast<Patch<Host, float, Dim>&>(patch).tile_of();
        REQUIRE(device_->tile_of() == std::vector<std::int32_t>(tile_of, tile_of + patch.own()));
        REQUIRE(device_->boundary() == occupied_among(patch.boundary()));
        REQUIRE(device_->interior() == occupied_among(patch.interior()));
    }

  private:
    /// Of occupied blocks: those of empty ones mean nothing.
    void compare_cells(const ListView<Dim>& list) const {
        const std::vector<std::uint32_t> found = device_->cell_first();
        for (int b = 0; b < patch.own(); ++b) {
            const auto first = static_cast<std::ptrdiff_t>(b * (B::cells + 1));
            if (list.count(b) > 0)
                REQUIRE(
                    std::equal(found.begin() + first, found.begin() + first + B::cells + 1, list.cell_first + first));
        }
    }
    std::vector<Key> every_key() const {
        std::vector<Key> keys;
        std::size_t n = 1;
        for (int c : plan_.count) n *= static_cast<std::size_t>(c);
        for (std::size_t i = 0; i < n; ++i) {
            BlockPosition<Dim> at{};
            std::size_t rest = i;
            for (std::size_t a = 0; a < Dim; ++a) {
                at[a] = static_cast<int>(rest % static_cast<std::size_t>(plan_.count[a]));
                rest /= static_cast<std::size_t>(plan_.count[a]);
            }
            keys.push_back(Morton<Dim>::encode(at));
        }
        std::sort(keys.begin(), keys.end());
        return keys;
    }
    int owner_of(Key key) const {
        return plan_.ranks == 1 ? 0 : static_cast<int>((key * 0x9e3779b97f4a7c15ull >> 33) % unsigned(plan_.ranks));
    }
    bool chance(double p) { return std::uniform_real_distribution<double>(0, 1)(random_) < p; }
    int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
    int particles_of(bool first) {
        if (first && plan_.crowd > 0) return plan_.crowd;
        if (!chance(plan_.filled)) return 0;
        return plan_.even ? plan_.particles : 1 + below(2 * plan_.particles);
    }

    /// Random cells, in order, for slots that are mixed up within their block.
    void fill(FiledBlocks& filed) {
        std::size_t total = 0;
        for (std::uint32_t n : filed.count) total += n;
        filed.slot = patch.take_slots(total);
        const auto p = patch.particles.view();
        auto begin = filed.slot.begin();
        for (std::uint32_t n : filed.count) {
            std::shuffle(begin, begin + n, random_);
            std::vector<int> cells(n, below(B::cells));
            if (static_cast<int>(n) != plan_.crowd)
                for (int& c : cells) c = below(B::cells);
            std::sort(cells.begin(), cells.end());
            for (std::size_t k = 0; k < n; ++k)
                for (int a = 0; a < Dim; ++a)
                    p.position[begin[static_cast<std::ptrdiff_t>(k)]][a] =
                        static_cast<std::uint32_t>(cells[k] >> (2 * a) & 3) * one_cell<float>;
            begin += n;
        }
    }

    std::uint16_t random_move(int b, int cell, const Chances& chances) {
        if (chance(chances.gone)) return encode_move(B::gone, below(B::cells));
        int code = B::centre;
        if (chance(chances.leave)) code = chances.near ? B::centre + (below(2) ? 1 : -1) : below(B::offsets);
        if (patch.table().neighbour[b * B::offsets + code] < 0) code = B::centre;
        if (code == B::centre && !chance(chances.change)) return encode_move(code, cell);
        return encode_move(code, chances.near ? cell ^ (1 << below(2 * Dim)) : below(B::cells));
    }

    void make_ghosts(const Chances& chances) {
        ghost_leaver_.clear(), ghost_first_.assign(1, 0);
        for (int g = 0; g < patch.table().ghosts; ++g) {
            for (int k = below(12); k > 0 && chances.leave > 0; --k) {
                int code = below(B::offsets);
                if (code == B::centre) code = 0;
                ghost_leaver_.push_back({fresh_slot_++, encode_move(code, below(B::cells))});
            }
            ghost_first_.push_back(static_cast<std::uint32_t>(ghost_leaver_.size()));
        }
        REQUIRE(static_cast<std::size_t>(patch.count()) + ghost_leaver_.size() < room_);
    }

    std::vector<std::int32_t> occupied_among(std::span<const std::int32_t> blocks) const {
        std::vector<std::int32_t> some;
        for (std::int32_t b : blocks)
            if (patch.list().count(b) > 0) some.push_back(b);
        return some;
    }

    Plan<Dim> plan_;
    std::mt19937_64 random_{7};
    std::size_t room_ = 0;
    std::uint32_t fresh_slot_ = 0;
    std::vector<Leaver> ghost_leaver_;
    std::vector<std::uint32_t> ghost_first_;
    std::unique_ptr<test::DeviceLists<Dim>> device_;
};

template <int Dim>
void same_lists(const Plan<Dim>& plan, const Chances& chances, int steps = 6) {
    CAPTURE(plan.count[0]);
    CAPTURE(chances.leave);
    Pair<Dim> pair(plan);
    for (int n = 0; n < steps; ++n) pair.step(chances);
}

}  // namespace

TEST_CASE("the device files as the host does, in domains of one and more blocks that are their own neighbours") {
    for (const BlockPosition<2>& count : {BlockPosition<2>{1, 1}, {2, 1}, {3, 5}})
        same_lists<2>({.count = count}, {0.1, 0, 0.3});
    for (const BlockPosition<3>& count : {BlockPosition<3>{1, 1, 1}, {2, 1, 3}, {3, 4, 3}})
        same_lists<3>({.count = count, .particles = 100}, {0.1, 0, 0.3});
}

TEST_CASE("device and host lists agree where most blocks are empty and the domain has ends") {
    same_lists<2>({.count = {9, 7}, .periodic = false, .filled = 0.3}, {0.1, 0.02, 0.2});
    same_lists<3>({.count = {5, 6, 4}, .periodic = false, .filled = 0.3, .particles = 200}, {0.05, 0.02, 0.1});
}

TEST_CASE("device and host lists agree when all particles leave at once, when hardly any does, and when none does") {
    for (const Chances& chances : {Chances{1, 0, 1}, {0.002, 0, 0}, {0, 0, 0.002}, {0, 0, 0}}) {
        same_lists<2>({.count = {4, 4}}, chances);
        same_lists<3>({.count = {3, 3, 3}, .particles = 200}, chances);
    }
}

TEST_CASE("device and host lists agree in blocks of tens of thousands of particles, at first all in one cell") {
    same_lists<2>({.count = {3, 2}, .crowd = 70001}, {0.02, 0.001, 0.1}, 4);
    same_lists<3>({.count = {3, 2, 2}, .crowd = 70001}, {0.02, 0.001, 0.1}, 4);
    same_lists<3>({.count = {2, 2, 2}, .crowd = 40000}, {1, 0, 1}, 3);
}

TEST_CASE("particles that leave through an open wall leave the device's lists, down to the last") {
    Pair<3> pair({.count = {2, 3, 2}});
    for (double gone : {0.5, 1.0, 0.5}) pair.step({0.1, gone, 0.3});
    CHECK(pair.patch.count() == 0);
    CHECK(pair.device().boundary().empty());
    CHECK(pair.device().interior().empty());
}

TEST_CASE("arrivals from ghost blocks merge by the same rule, and boundary blocks are told from interior ones") {
    same_lists<2>({.count = {6, 5}, .ranks = 2, .filled = 0.7}, {0.1, 0.01, 0.2});
    same_lists<3>({.count = {4, 4, 3}, .ranks = 2, .filled = 0.7, .particles = 60}, {0.1, 0.01, 0.2});
    same_lists<3>({.count = {7, 7, 7}, .ranks = 40, .filled = 0.9, .particles = 60}, {0.1, 0, 0.2});
}

TEST_CASE("places add up over many chunks of blocks") {
    same_lists<2>({.count = {41, 37}, .filled = 0.6, .particles = 4}, {0.1, 0.01, 0.2}, 3);
    same_lists<3>({.count = {12, 11, 13}, .filled = 0.6, .particles = 4}, {0.1, 0.01, 0.2}, 3);
}

TEST_CASE("a share without blocks has empty lists") {
    test::DeviceLists<3> device(BlockTable<3>{}, {std::vector<std::uint32_t>{0}.data(), nullptr, nullptr}, {}, {}, 1);
    device.set_moves({}, {0});
    device.launch();
    device.advance();
    CHECK(device.first() == std::vector<std::uint32_t>{0});
    CHECK(device.boundary().empty());
    CHECK(device.interior().empty());
}

TEST_CASE("with fewer tiles than occupied blocks the lists serve no block, and all again once there are enough") {
    Pair<3> pair({.count = {3, 4, 3}, .filled = 0.6});
    test::DeviceLists<3>& lists = pair.device();
    const std::uint32_t occupied = lists.counts()[1];
    REQUIRE(occupied > 1);
    for (std::uint32_t tiles : {occupied - 1, occupied}) {
        lists.filing.occupied.tiles = tiles;
        gpu::number_blocks(lists.filing, nullptr);
        const std::vector<std::uint32_t> counts = lists.counts();
        CHECK(counts[1] == occupied);
        CHECK(counts[3] == (tiles < occupied ? 0 : occupied));
    }
}

TEST_CASE("timing of filing, where MORAINE_TIMING asks for it") {
    if (!std::getenv("MORAINE_TIMING")) return;
    const auto time = [](auto& pair, const char* what, const Chances& chances) {
        pair.move(chances);
        const std::vector<std::uint32_t> cells = pair.device().cell_first();
        const double ms = test::median_ms(
            20, [&] { pair.device().set_cell_first(cells.data()); }, [&] { pair.device().launch(); });
        std::printf("filing %s: %.2f M particles, %d blocks, %.4f ms\n", what, double(pair.patch.count()) * 1e-6,
                    pair.patch.own(), ms);
    };
    Pair<3> box({.count = {32, 32, 32}, .particles = 512, .even = true});
    time(box, "3-D, 10 % change cell, 1 % block", {0.01, 0, 0.09, true});
    time(box, "3-D, 1 % change cell, 0.1 % block", {0.001, 0, 0.009, true});
    time(box, "3-D, none moves", {0, 0, 0, true});
    Pair<3> sparse({.count = {64, 64, 64}, .filled = 0.02, .particles = 512, .even = true});
    time(sparse, "3-D, 2 % of the blocks filled", {0.01, 0, 0.09, true});
    Pair<2> plane({.count = {512, 512}, .particles = 64, .even = true});
    time(plane, "2-D, 10 % change cell, 1 % block", {0.01, 0, 0.09, true});
}
