#pragma once
// Walkers in a periodic domain: particles that move by a hash of their id and the step, spread over the
// ranks of a communicator. A swarm on MPI_COMM_SELF is what the one on all ranks must equal.

#include <doctest/doctest.h>

#include <algorithm>
#include <memory>
#include <tuple>
#include <vector>

#include "comm/block_move.hpp"
#include "comm/migration.hpp"
#include "core/data/hash.hpp"
#include "core/data/host.hpp"

namespace moraine::test {

/// A number in [0, 1).
inline double fraction(std::uint64_t h) {
    return static_cast<double>(h >> 11) * 0x1p-53;
}

template <class Real, int Dim>
class Swarm {
  public:
    using Share = Patch<Host, Real, Dim>;

    Swarm(MPI_Comm parent, const Scene& scene)
        : comm(parent),
          patch({true, true, false, 1, false}, stencil_of(scene.shape).width),
          domain_(scene),
          stencil_(stencil_of(scene.shape)),
          messages_(comm, 2) {}

    Comm comm;
    Share patch;
    std::int64_t gone = 0;
    std::unique_ptr<Migration<Host, Real, Dim>> migration;

    /// Puts walkers 0..n at place(id, axis) [cells]; each rank makes those of the blocks that it owns.
    template <class F>
    void settle(std::uint64_t n, const F& at) {
        std::vector<std::tuple<Key, int, std::uint32_t>> mine;
        for (std::uint64_t id = 0; id < n; ++id) {
            BlockPosition<Dim> block{};
            Vec<Coordinate<Real>, Dim> u;
            int cell = 0;
            for (int a = Dim - 1; a >= 0; --a) {
                const Place<Real> p = place<Real>(at(id, a));
                block[static_cast<std::size_t>(a)] = p.block;
                u[a] = p.u;
                cell = 4 * cell + cell_of<Real>(p.u);
            }
            domain_.wrap(block);
            const Key key = Morton<Dim>::encode(block);
            if (owner_of(key, 0) != comm.rank()) continue;
            const std::uint32_t slot = patch.take_slots(1)[0];
            fill(slot, id);
            patch.particles.view().position[slot] = u;
            mine.emplace_back(key, cell, slot);
        }
        std::stable_sort(mine.begin(), mine.end(), [](const auto& x, const auto& y) {
            return std::tie(std::get<0>(x), std::get<1>(x)) < std::tie(std::get<0>(y), std::get<1>(y));
        });
        BinnedBlocks binned;
        for (const auto& [key, cell, slot] : mine) {
            if (binned.key.empty() || binned.key.back() != key) {
                binned.key.push_back(key);
                binned.count.push_back(0);
            }
            ++binned.count.back();
            binned.slot.push_back(slot);
        }
        begin_epoch(binned);
    }

    void begin_epoch(const BinnedBlocks& binned) {
        std::vector<OccupiedBlock> occupied;
        for (Key key : binned.key) occupied.push_back({key, comm.rank()});
        occupied = comm.all_gather(occupied);
        std::sort(occupied.begin(), occupied.end(), [](const auto& a, const auto& b) { return a.key < b.key; });
        const auto topology = make_topology<Dim>(domain_, occupied, [](const BlockPosition<Dim>&) { return -1; });
        patch.install(make_epoch<Dim>(topology, domain_, stencil_, comm.rank()), binned);
        patch.refresh_memory(0.1);
        migration = std::make_unique<Migration<Host, Real, Dim>>(patch, messages_);
    }

    /// A pseudo-random owner per block, new each round.
    BlockMoveCount shuffle(std::uint64_t round) {
        const BinnedBlocks binned = patch.binned();
        std::vector<std::int32_t> owner;
        for (Key key : binned.key) owner.push_back(owner_of(key, round));
        BlockMoveCount moved;
        begin_epoch(move_blocks(comm, patch, binned, owner, moved));
        return moved;
    }

    /// Moves each walker by displacement(id, axis) [cells]; leaves(id): through an open wall.
    template <class D, class L>
    void step(const D& displacement, const L& leaves) {
        const ListView<Dim> list = patch.list();
        const ParticleView<Real, Dim> p = patch.particles.view();
        for (int b = 0; b < patch.own(); ++b) {
            patch.outgoing_count()[b] = 0;
            patch.shuffled()[b] = 0;
            for (std::uint32_t k = list.first[b]; k < list.first[b + 1]; ++k) {
                const std::uint32_t s = list.slot[k];
                int code = 0, cell = 0, old = 0;
                for (int a = Dim - 1; a >= 0; --a) {
                    old = 4 * old + cell_of<Real>(p.position[s][a]);
                    const auto cells = static_cast<Real>(displacement(p.id[s], a));
                    code = 3 * code + advance<Real>(p.position[s][a], cells) + 1;
                    cell = 4 * cell + cell_of<Real>(p.position[s][a]);
                }
                if (leaves(p.id[s])) code = Block<Dim>::gone;
                patch.moves()[k] = encode_move(code, cell);
                if (code != Block<Dim>::centre) ++patch.outgoing_count()[b];
                if (code != Block<Dim>::centre || cell != old) patch.shuffled()[b] = 1;
            }
        }
        migration->start([this](std::uint32_t) { ++gone; });
        migration->finish();
    }

    /// One row per walker: block, place in its list, and a hash of all its columns; of all ranks, sorted.
    struct Row {
        Key key;
        std::uint64_t place;
        std::uint64_t state;
        bool operator==(const Row&) const = default;
        auto operator<=>(const Row&) const = default;
    };
    std::vector<Row> rows() {
        std::vector<Row> mine;
        const ListView<Dim> list = patch.list();
        const std::vector<ColumnBytes> columns = patch.particles.columns();
        for (int b = 0; b < patch.own(); ++b)
            for (std::uint32_t k = list.first[b]; k < list.first[b + 1]; ++k) {
                std::uint64_t h = 0;
                for (const ColumnBytes& c : columns) h = mix_bytes(h, c.data + list.slot[k] * c.row_bytes, c.row_bytes);
                mine.push_back({patch.tables().own[static_cast<std::size_t>(b)], k - list.first[b], h});
            }
        std::vector<Row> all = comm.all_gather(mine);
        std::sort(all.begin(), all.end());
        return all;
    }

    std::int32_t owner_of(Key key, std::uint64_t round) const {
        return static_cast<std::int32_t>(mix(round ^ mix(key)) % static_cast<unsigned>(comm.size()));
    }

    /// Every column but the position holds bytes that follow from the id.
    void fill(std::uint32_t slot, std::uint64_t id) {
        for (const ColumnBytes& c : patch.particles.columns())
            for (std::size_t k = 0; k < c.row_bytes; ++k)
                c.data[slot * c.row_bytes + k] = static_cast<std::byte>(mix(mix(id) + k + 64 * c.name.size()));
        patch.particles.view().id[slot] = id;
    }

  private:
    DomainBlocks<Dim> domain_;
    Stencil stencil_;
    PointToPoint messages_;
};

inline Scene periodic_scene(int dim, int blocks_x, int blocks_y, int blocks_z) {
    Scene scene;
    scene.transfer = Transfer::flip;
    scene.dimensions = dim;
    scene.cell = 1;
    scene.periodic = {true, true, dim == 3};
    scene.max = {4.0 * blocks_x, 4.0 * blocks_y, dim == 3 ? 4.0 * blocks_z : 0};
    return scene;
}

}  // namespace moraine::test
