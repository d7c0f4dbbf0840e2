#pragma once
// An epoch's tables on the device, and which blocks are occupied in its first binned state.

#include <cuda_runtime.h>

#include <utility>

#include "blocks/epoch.hpp"
#include "core/data/grid_views.hpp"
#include "gpu/memory/pool_array.hpp"

namespace moraine::gpu {

template <int Dim>
class Tables {
  public:
    /// Copies what the kernels read; there when the stream has been waited for.
    void upload(const EpochTables<Dim>& t, cudaStream_t stream) {
        own_ = static_cast<int>(t.own.size());
        ghosts_ = static_cast<int>(t.ghost.size());
        node_blocks_ = static_cast<int>(t.node_key.size());
        position_.assign(t.position, stream);
        neighbour_.assign(t.neighbour, stream);
        node_block_.assign(t.node_block, stream);
        border_.assign(t.border, stream);
        node_position_.assign(t.node_position, stream);
        source_.assign(t.source, stream);
        node_border_.assign(t.node_border, stream);
    }

    void swap(Tables& other) {
        std::swap(own_, other.own_);
        std::swap(ghosts_, other.ghosts_);
        std::swap(node_blocks_, other.node_blocks_);
        position_.swap(other.position_);
        node_position_.swap(other.node_position_);
        neighbour_.swap(other.neighbour_);
        node_block_.swap(other.node_block_);
        source_.swap(other.source_);
        border_.swap(other.border_);
        node_border_.swap(other.node_border_);
    }

    BlockTable<Dim> view() const {
        BlockTable<Dim> t;
        t.own = own_;
        t.ghosts = ghosts_;
        t.position = position_.data();
        t.neighbour = neighbour_.data();
        t.node_block = node_block_.data();
        t.border = border_.data();
        t.node_blocks = node_blocks_;
        t.node_position = node_position_.data();
        t.source = source_.data();
        t.node_border = node_border_.data();
        return t;
    }

  private:
    int own_ = 0, ghosts_ = 0, node_blocks_ = 0;
    PoolArray<Vec<std::int32_t, Dim>> position_, node_position_;
    PoolArray<std::int32_t> neighbour_, node_block_, source_;
    PoolArray<std::uint8_t> border_, node_border_;
};

}  // namespace moraine::gpu
