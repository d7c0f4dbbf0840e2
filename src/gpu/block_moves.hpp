#pragma once
// Whole blocks travel between devices when the partition changes: their particles as records (gpu/records.hpp), in
// list order, in rounds of bounded size.
//
// Memory must be in list order before: then a block is a stretch of slots, on either side.

#include <span>

#include "comm/patch.hpp"
#include "gpu/records.hpp"
#include "gpu/stream.hpp"
#include "gpu/wire.hpp"

namespace moraine::gpu {

/// Particles of a block: `count` slots from `start`.
struct Stretch {
    Key key;
    std::uint32_t start;
    std::uint32_t count;
};

/// What a rank keeps, sends and gets, told between the hosts before anything travels.
struct BlockPlan {
    struct Partner {
        int rank;
        std::vector<Stretch> leaving;
        std::vector<Stretch> coming;  ///< start: where they will be, counted from the first arrival
        std::size_t out, in;          ///< particles
    };
    std::vector<Stretch> kept;
    std::vector<Partner> partners;
    std::size_t arrivals = 0;
};

/// mine: this rank's occupied blocks, keys ascending; owner: who gets them. Collective.
BlockPlan plan_block_moves(const Comm& comm, const std::vector<Stretch>& mine, std::span<const std::int32_t> owner);

/// Moves the particles: arrivals take the slots from `first_free` on, which must be there. Synchronous. Collective.
void move_records(const Comm& comm, Wire& wire, const BlockPlan& plan, const RecordLayout& layout,
                  std::uint32_t first_free, const Stream& stream);

/// slot[to + i] = start + i for i < count; stretches one after the other from to = 0. Asynchronous but for the copy of
/// the stretches.
void list_stretches(const std::vector<Stretch>& stretches, std::uint32_t* slot, cudaStream_t stream);

/// Bounds of the cells of each block whose list is sorted by cell. Asynchronous.
template <class Real, int Dim>
void bound_cells(int own, const std::uint32_t* first, const std::uint32_t* slot, const Row<Real>* place,
                 std::uint32_t* cell_first, cudaStream_t stream);

}  // namespace moraine::gpu
