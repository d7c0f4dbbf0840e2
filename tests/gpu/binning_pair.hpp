#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <memory>
#include <random>

#include "blocks/patch.hpp"
#include "core/data/host.hpp"
#include "gpu/device_lists.hpp"

namespace moraine::test {

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
    int crammed = 0;     ///< particles of one more block, all in one cell
};

/// A host's share and its copy on the device, binned side by side.
template <int Dim>
class BinningPair {
    using B = Block<Dim>;

  public:
    Patch<Host, float, Dim> patch{{}, 3};

    explicit BinningPair(const Plan<Dim>& plan) : plan_(plan) {
        Scene scene;
        scene.dimensions = Dim, scene.cell = 1;
        for (std::size_t a = 0; a < Dim; ++a) scene.periodic[a] = plan.periodic, scene.max[a] = 4 * plan.count[a];
        const DomainBlocks<Dim> domain(scene);
        BinnedBlocks binned;
        std::vector<OccupiedBlock> occupied;
        for (Key key : every_key()) {
            const int n = particles_of(occupied.empty());
            if (n == 0) continue;
            occupied.push_back({key, owner_of(key)});
            if (owner_of(key) != 0) continue;
            binned.key.push_back(key);
            binned.count.push_back(static_cast<std::uint32_t>(n));
        }
        fill(binned);
        const auto owner_at = [this](const BlockPosition<Dim>& at) { return owner_of(Morton<Dim>::encode(at)); };
        patch.install(make_epoch<Dim>(make_topology<Dim>(domain, occupied, owner_at), domain, {3, 1, 0.5}, 0), binned);
        std::vector<std::uint8_t> boundary(static_cast<std::size_t>(patch.own()), 0);
        for (std::int32_t b : patch.boundary()) boundary[static_cast<std::size_t>(b)] = 1;
        capacity_ = static_cast<std::size_t>(patch.count()) + 4096;
        fresh_slot_ = static_cast<std::uint32_t>(patch.count());
        device_ = std::make_unique<DeviceLists<Dim>>(patch.table(), patch.list(), boundary, patch.tables().guard_layer,
                                                     capacity_);
        compare_blocks();
    }

    DeviceLists<Dim>& device() { return *device_; }

    /// Makes up moves, in the patch and on the device.
    void move(const Chances& chances) {
        const ListView<Dim> list = patch.list();
        const auto n = static_cast<std::size_t>(patch.count());
        std::vector<std::uint32_t> changed(n / 32 + static_cast<std::size_t>(patch.own()) + 1, 0);
        for (int b = 0; b < patch.own(); ++b) {
            patch.outgoing_count()[b] = 0, patch.shuffled()[b] = 0;
            const std::uint32_t* cell_first = list.cell_first + b * (B::cells + 1);
            int cell = 0;
            for (std::uint32_t k = 0; k < list.count(b); ++k) {
                while (cell_first[cell + 1] <= k) ++cell;
                const std::uint16_t m = random_move(b, cell, chances);
                patch.moves()[list.first[b] + k] = m;
                if (move_code(m) != B::centre) ++patch.outgoing_count()[b];
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
        patch.collect_outgoing();
        patch.make_lists(ghost_outgoing_, ghost_first_);
        device_->set_ghosts(GhostOutgoing::of<Dim>(ghost_outgoing_, ghost_first_));
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
        REQUIRE(device_->is_in_guard_layer() == patch.is_in_guard_layer());
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
        if (first && plan_.crammed > 0) return plan_.crammed;
        if (!chance(plan_.filled)) return 0;
        return plan_.even ? plan_.particles : 1 + below(2 * plan_.particles);
    }

    /// Random cells, in order, for slots that are mixed up within their block.
    void fill(BinnedBlocks& binned) {
        std::size_t total = 0;
        for (std::uint32_t n : binned.count) total += n;
        binned.slot = patch.take_slots(total);
        const auto p = patch.particles.view();
        auto begin = binned.slot.begin();
        for (std::uint32_t n : binned.count) {
            std::shuffle(begin, begin + n, random_);
            std::vector<int> cells(n, below(B::cells));
            if (static_cast<int>(n) != plan_.crammed)
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
        ghost_outgoing_.clear(), ghost_first_.assign(1, 0);
        for (int g = 0; g < patch.table().ghosts; ++g) {
            for (int k = below(12); k > 0 && chances.leave > 0; --k) {
                int code = below(B::offsets);
                if (code == B::centre) code = 0;
                ghost_outgoing_.push_back({fresh_slot_++, encode_move(code, below(B::cells))});
            }
            ghost_first_.push_back(static_cast<std::uint32_t>(ghost_outgoing_.size()));
        }
        REQUIRE(static_cast<std::size_t>(patch.count()) + ghost_outgoing_.size() < capacity_);
    }

    std::vector<std::int32_t> occupied_among(std::span<const std::int32_t> blocks) const {
        std::vector<std::int32_t> some;
        for (std::int32_t b : blocks)
            if (patch.list().count(b) > 0) some.push_back(b);
        return some;
    }

    Plan<Dim> plan_;
    std::mt19937_64 random_{7};
    std::size_t capacity_ = 0;
    std::uint32_t fresh_slot_ = 0;
    std::vector<OutgoingParticle> ghost_outgoing_;
    std::vector<std::uint32_t> ghost_first_;
    std::unique_ptr<DeviceLists<Dim>> device_;
};

}  // namespace moraine::test
