#pragma once
// The memory of tiles and nodes on the host: tiles of occupied blocks, behind those of ghosts, and values of the node
// blocks that they touch. Sized anew at each binning; the content is that of one step.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "blocks/epoch.hpp"
#include "core/data/storage.hpp"

namespace moraine {

/// The tables of an epoch where kernels read them.
template <class Space, int Dim>
struct BlockArrays {
    template <class T>
    using Array = typename Space::template Array<T>;

    Array<Vec<std::int32_t, Dim>> position, node_position;
    Array<std::int32_t> neighbour, node_block, source;
    Array<std::uint8_t> border, node_border;

    void assign(const EpochTables<Dim>& tables) {
        position.assign(tables.position);
        neighbour.assign(tables.neighbour);
        border.assign(tables.border);
        node_block.assign(tables.node_block);
        node_position.assign(tables.node_position);
        node_border.assign(tables.node_border);
        source.assign(tables.source);
    }
    BlockTable<Dim> table(const EpochTables<Dim>& tables) const {
        BlockTable<Dim> t;
        t.own = static_cast<int>(tables.own.size());
        t.ghosts = static_cast<int>(tables.ghost.size());
        t.position = position.data();
        t.neighbour = neighbour.data();
        t.node_block = node_block.data();
        t.border = border.data();
        t.node_blocks = static_cast<int>(tables.node_key.size());
        t.node_position = node_position.data();
        t.source = source.data();
        t.node_border = node_border.data();
        return t;
    }
};

template <class Space, class Real, int Dim>
class TileStorage {
  public:
    template <class T>
    using Array = typename Space::template Array<T>;

    TileView<Real> view() { return {tile_of_.data(), tiles_.data(), node_of_.data(), nodes_.data()}; }
    std::int32_t* tile_of() { return tile_of_.data(); }
    std::int64_t tiles_in_use() const { return occupied_; }
    std::size_t stored_nodes() const { return nodes_.size() / node_reals; }
    /// Changes where the memory of tiles was lost.
    std::int64_t memory() const { return memory_; }
    void lose() { ++memory_; }

    /// Tiles go to occupied blocks, node values to the node blocks that those touch, and to those of `kept`; ghosts
    /// come first.
    void assign(const BlockTable<Dim>& t, const ListView<Dim>& list, const std::vector<std::uint8_t>& kept, int width) {
        const auto blocks = static_cast<std::size_t>(t.own);
        const auto node_blocks = static_cast<std::size_t>(t.node_blocks);
        tile_of_.resize(blocks + static_cast<std::size_t>(t.ghosts));
        node_of_.resize(node_blocks);
        used_.resize(std::max(blocks, node_blocks));
        place_.resize(used_.size() + 1);

        Space::launch(t.own, MarkOccupied<Dim>{list, used_.data()});
        occupied_ = Space::scan(blocks, used_.data(), place_.data());
        Space::launch(t.own + t.ghosts, PlaceTiles{t.own, t.ghosts, used_.data(), place_.data(), tile_of_.data()});
        Space::launch(t.node_blocks, MarkNeeded<Dim>{t, tile_of_.data(), used_.data()});
        for (std::size_t c = 0; c < kept.size(); ++c) used_[c] |= kept[c];
        const std::int64_t needed = Space::scan(node_blocks, used_.data(), place_.data());
        Space::launch(t.node_blocks, PlaceTiles{t.node_blocks, 0, used_.data(), place_.data(), node_of_.data()});

        const int tile_reals = power<Dim>(tile_side(width)) * node_reals;
        if (renew(tiles_, static_cast<std::size_t>((occupied_ + t.ghosts) * tile_reals))) ++memory_;
        renew(nodes_, static_cast<std::size_t>(needed * Block<Dim>::cells * node_reals));
    }
    /// Calls f while the memory is given back.
    template <class F>
    void lend(const F& f) {
        const std::size_t tiles = tiles_.size(), nodes = nodes_.size();
        ++memory_;
        tiles_.release();
        nodes_.release();
        f();
        tiles_.resize(tiles);
        nodes_.resize(nodes);
    }

  private:
    /// Capacity for n elements whose content does not matter: the old ones are given back before new ones are taken.
    /// Returns whether that was so.
    static bool renew(Array<Real>& array, std::size_t n) {
        const bool grows = n > array.capacity();
        if (grows) {
            array.release();
            array.reserve(n + n / 16);
        }
        array.resize(n);
        return grows;
    }

    Array<std::int32_t> tile_of_, node_of_;
    Array<std::uint32_t> used_, place_;
    Array<Real> tiles_, nodes_;
    std::int64_t occupied_ = 0;
    std::int64_t memory_ = 0;
};

}  // namespace moraine
