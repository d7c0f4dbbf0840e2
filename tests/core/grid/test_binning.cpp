#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "blocks/patch.hpp"
#include "core/data/host.hpp"
#include "core/grid/binning.hpp"

using namespace moraine;

namespace {

/// What a list holds, one entry per particle: slot and cell.
struct Entry {
    std::uint32_t slot;
    int cell;
};

/// A fully periodic domain, all blocks of which are occupied, and its lists kept by the rule in words:
/// stayers in list order, then incoming particles by source offset and source order, then stably by cell.
template <int Dim>
class Reference {
  public:
    explicit Reference(const BlockPosition<Dim>& count) : count_(count) {
        std::size_t n = 1;
        for (int c : count) n *= static_cast<std::size_t>(c);
        lists.resize(n);
    }

    std::vector<std::vector<Entry>> lists;  ///< by block, x fastest

    BlockPosition<Dim> position(std::size_t block) const {
        BlockPosition<Dim> at{};
        for (std::size_t a = 0; a < Dim; ++a) {
            at[a] = static_cast<int>(block) % count_[a];
            block /= static_cast<std::size_t>(count_[a]);
        }
        return at;
    }
    std::size_t index(BlockPosition<Dim> at) const {
        std::size_t block = 0;
        for (std::size_t a = Dim; a-- > 0;)
            block = block * static_cast<std::size_t>(count_[a]) +
                    static_cast<std::size_t>((at[a] % count_[a] + count_[a]) % count_[a]);
        return block;
    }

    /// code and cell of each list entry's next place.
    void bin(const std::vector<std::vector<std::pair<int, int>>>& moves) {
        std::vector<std::vector<Entry>> next(lists.size());
        for (std::size_t b = 0; b < lists.size(); ++b) {
            take(b, Block<Dim>::centre, moves, next[b]);
            for (int code = 0; code < Block<Dim>::offsets; ++code) {
                if (code == Block<Dim>::centre) continue;
                BlockPosition<Dim> from = position(b);
                for (int a = 0; a < Dim; ++a) from[static_cast<std::size_t>(a)] += Block<Dim>::offset(code, a);
                take(index(from), Block<Dim>::opposite(code), moves, next[b]);
            }
            std::stable_sort(next[b].begin(), next[b].end(),
                             [](const Entry& x, const Entry& y) { return x.cell < y.cell; });
        }
        lists = next;
    }

  private:
    void take(std::size_t from, int code, const std::vector<std::vector<std::pair<int, int>>>& moves,
              std::vector<Entry>& to) const {
        for (std::size_t k = 0; k < lists[from].size(); ++k)
            if (moves[from][k].first == code) to.push_back({lists[from][k].slot, moves[from][k].second});
    }

    BlockPosition<Dim> count_;
};

template <int Dim>
struct Setup {
    Scene scene;
    Reference<Dim> reference;
    Patch<Host, double, Dim> patch{{}, 3};
    std::mt19937_64 random{5};

    explicit Setup(const BlockPosition<Dim>& count, std::uint32_t particles) : scene(), reference(count) {
        scene.dimensions = Dim;
        scene.cell = 1;
        for (std::size_t a = 0; a < Dim; ++a) scene.periodic[a] = true, scene.max[a] = 4 * count[a];
        const auto position = [this] { return patch.particles.view().position; };
        for (std::uint32_t s : patch.take_slots(particles)) {
            Entry entry{s, 0};
            for (int a = Dim - 1; a >= 0; --a) {
                const auto cell = random() % 4;
                position()[s][a] = cell * one_cell<double>;
                entry.cell = 4 * entry.cell + static_cast<int>(cell);
            }
            reference.lists[random() % reference.lists.size()].push_back(entry);
        }
        std::vector<std::pair<Key, std::size_t>> order;
        for (std::size_t b = 0; b < reference.lists.size(); ++b) {
            std::stable_sort(reference.lists[b].begin(), reference.lists[b].end(),
                             [](const Entry& x, const Entry& y) { return x.cell < y.cell; });
            order.emplace_back(Morton<Dim>::encode(reference.position(b)), b);
        }
        std::sort(order.begin(), order.end());
        BinnedBlocks binned;
        std::vector<OccupiedBlock> occupied;
        for (const auto& [key, b] : order) {
            binned.key.push_back(key);
            binned.count.push_back(static_cast<std::uint32_t>(reference.lists[b].size()));
            for (const Entry& e : reference.lists[b]) binned.slot.push_back(e.slot);
            occupied.push_back({key, 0});
        }
        const DomainBlocks<Dim> domain(scene);
        const Stencil stencil = stencil_of(scene.shape);
        patch.install(
            make_epoch<Dim>(make_topology<Dim>(domain, occupied, [](const auto&) { return 0; }), domain, stencil, 0),
            binned);
    }

    /// Moves each particle with the given chances, in the patch and in the reference, and files both.
    void step(double leave, double gone, double change_cell) {
        std::uniform_real_distribution<double> chance(0, 1);
        std::vector<std::vector<std::pair<int, int>>> moves(reference.lists.size());
        const ListView<Dim> list = patch.list();
        for (int b = 0; b < patch.own(); ++b) {
            const std::size_t r = reference.index(Morton<Dim>::decode(patch.tables().own[static_cast<std::size_t>(b)]));
            patch.outgoing_count()[b] = 0;
            patch.shuffled()[b] = 0;
            for (std::uint32_t k = list.first[b]; k < list.first[b + 1]; ++k) {
                const int old = reference.lists[r][k - list.first[b]].cell;
                int code = Block<Dim>::centre;
                int cell = chance(random) < change_cell ? static_cast<int>(random() % Block<Dim>::cells) : old;
                if (chance(random) < leave) code = static_cast<int>(random() % Block<Dim>::offsets);
                if (chance(random) < gone) code = Block<Dim>::gone;
                moves[r].emplace_back(code, cell);
                patch.moves()[k] = encode_move(code, cell);
                if (code != Block<Dim>::centre) ++patch.outgoing_count()[b];
                if (code != Block<Dim>::centre || cell != old) patch.shuffled()[b] = 1;
            }
        }
        patch.collect_outgoing();
        patch.make_lists({}, {0});
        reference.bin(moves);
    }

    void check_lists() const {
        const ListView<Dim> list = patch.list();
        for (int b = 0; b < patch.own(); ++b) {
            const auto& expected =
                reference.lists[reference.index(Morton<Dim>::decode(patch.tables().own[static_cast<std::size_t>(b)]))];
            REQUIRE(list.count(b) == expected.size());
            bool same = true;
            for (std::uint32_t k = 0; k < expected.size(); ++k) {
                same = same && list.slot[list.first[b] + k] == expected[k].slot;
                const std::uint32_t* cells = list.cell_first + b * (Block<Dim>::cells + 1);
                same = same && cells[expected[k].cell] <= k && k < cells[expected[k].cell + 1];
            }
            REQUIRE(same);
        }
    }
};

template <int Dim>
void follows_the_rule(const BlockPosition<Dim>& count, double leave, double gone, double change_cell) {
    Setup<Dim> setup(count, 600);
    setup.check_lists();
    for (int n = 0; n < 20; ++n) {
        setup.step(leave, gone, change_cell);
        setup.check_lists();
    }
}

}  // namespace

TEST_CASE("lists follow the binning rule, in domains of one and more blocks that are their own neighbours") {
    for (const BlockPosition<2>& count : {BlockPosition<2>{1, 1}, {2, 1}, {1, 3}, {2, 2}, {4, 3}, {5, 5}})
        follows_the_rule<2>(count, 0.1, 0, 0.3);
    for (const BlockPosition<3>& count : {BlockPosition<3>{1, 1, 1}, {2, 1, 3}, {2, 2, 2}, {3, 4, 3}})
        follows_the_rule<3>(count, 0.1, 0, 0.3);
}

TEST_CASE("lists follow the rule when all particles leave at once and when hardly any does") {
    follows_the_rule<2>({3, 3}, 1, 0, 1);
    follows_the_rule<3>({3, 3, 3}, 1, 0, 1);
    follows_the_rule<2>({3, 3}, 0.002, 0, 0);
    follows_the_rule<2>({3, 3}, 0, 0, 0.002);
    follows_the_rule<2>({3, 3}, 0, 0, 0);
}

TEST_CASE("particles that leave through an open wall leave the lists, down to the last") {
    follows_the_rule<2>({3, 2}, 0.1, 0.1, 0.3);
    Setup<3> setup({2, 2, 2}, 300);
    setup.step(0.1, 0.5, 0.3);
    setup.check_lists();
    setup.step(0.1, 1, 0.3);
    setup.check_lists();
    CHECK(setup.patch.count() == 0);
    CHECK(setup.patch.tiles_in_use() == 0);
    setup.step(0.1, 0, 0.3);
    CHECK(setup.patch.count() == 0);
}

TEST_CASE("a memory refresh puts slots into list order and keeps the lists") {
    Setup<2> setup({3, 3}, 400);
    auto* id = setup.patch.particles.view().id;
    for (std::uint32_t s = 0; s < 400; ++s) id[s] = s;
    for (int n = 0; n < 5; ++n) setup.step(0.2, 0.05, 0.3);
    std::vector<std::uint64_t> before;
    const auto n = static_cast<std::size_t>(setup.patch.count());
    for (std::size_t k = 0; k < n; ++k) before.push_back(id[setup.patch.list().slot[k]]);
    setup.patch.refresh_memory(0.1);
    CHECK(setup.patch.particles.size() == n);
    bool same = true;
    for (std::uint32_t k = 0; k < n; ++k)
        same = same && setup.patch.list().slot[k] == k && setup.patch.particles.view().id[k] == before[k];
    CHECK(same);
}
