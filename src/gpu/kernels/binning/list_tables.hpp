#pragma once
// What the lists need of an epoch's tables, on the device: whom peers need, the guard layer, and where each block was
// before.

#include <algorithm>
#include <vector>

#include "blocks/epoch.hpp"
#include "gpu/memory/pool_array.hpp"

namespace moraine::gpu {

struct ListTables {
    PoolArray<std::uint8_t> is_boundary;   ///< own: 1 where some peer needs the block
    PoolArray<std::uint64_t> guard_layer;  ///< own: bit per cell (blocks/guard_layer.hpp)
    PoolArray<std::int32_t> from;          ///< own + 1: how many own blocks of the tables before have smaller keys
    PoolArray<std::int32_t> same;          ///< own: the same block in the tables before; -1: it was not there

    /// There when the stream has been waited for; before: own blocks of the tables before.
    template <int Dim>
    void upload(const EpochTables<Dim>& tables, const std::vector<Key>& before, cudaStream_t stream) {
        std::vector<std::uint8_t> boundary(tables.own.size(), 0);
        for (std::int32_t b : tables.boundary) boundary[static_cast<std::size_t>(b)] = 1;
        std::vector<std::int32_t> smaller, same_as;
        std::size_t at = 0;
        for (Key key : tables.own) {
            while (at < before.size() && before[at] < key) ++at;
            const auto i = static_cast<std::int32_t>(at);
            smaller.push_back(i);
            same_as.push_back(at < before.size() && before[at] == key ? i : -1);
        }
        smaller.push_back(static_cast<std::int32_t>(before.size()));
        is_boundary.assign(boundary, stream), guard_layer.assign(tables.guard_layer, stream);
        from.assign(smaller, stream), same.assign(same_as, stream);
    }

    void swap(ListTables& other) {
        is_boundary.swap(other.is_boundary), guard_layer.swap(other.guard_layer);
        from.swap(other.from), same.swap(other.same);
    }
};

}  // namespace moraine::gpu
