#pragma once
// Whole blocks travel between devices when the partition changes: their particles as records
// (gpu/exchange/particle_record.hpp), in list order, in rounds of bounded size. A block is a range of the lists here,
// and of the slots of the incoming particles there.

#include <span>

#include "blocks/patch.hpp"
#include "gpu/exchange/particle_record.hpp"
#include "gpu/memory/array.hpp"
#include "gpu/memory/stream.hpp"
#include "gpu/transport/transport.hpp"

namespace moraine::gpu {

/// Particles of a block: `count` entries of the lists from `start`, or, of one that arrived, as many slots.
struct ListRange {
    Key key;
    std::uint32_t start;
    std::uint32_t count;
    bool arrived = false;
};

/// A range on the device, and where its slots are listed.
struct ListCopy {
    std::uint32_t start, count, to, arrived;
};

/// What a rank keeps, sends and gets, told between the hosts before anything travels.
struct BlockPlan {
    struct Partner {
        int rank;
        std::vector<ListRange> leaving;
        std::vector<ListRange> coming;  ///< start: where they will be, counted from the first incoming particle
        std::size_t out, in;            ///< particles
    };
    std::vector<ListRange> kept;
    std::vector<Partner> partners;
    std::size_t incoming = 0;
};

/// mine: this rank's occupied blocks, keys ascending; owner: who gets them. Collective.
BlockPlan plan_block_moves(const Comm& comm, const std::vector<ListRange>& mine, std::span<const std::int32_t> owner);

/// Moves particles, and keeps memory and boxes for the next time.
class BlockMoves {
  public:
    BlockMoves(const Comm& comm, std::unique_ptr<Transport> transport)
        : comm_(comm), transport_(std::move(transport)) {}

    /// lists: slots of this rank's particles, in list order. Incoming particles take the slots from `first_free` on,
    /// which must be there. Synchronous. Collective.
    void move(const BlockPlan& plan, const std::uint32_t* lists, const RecordLayout& layout, std::uint32_t first_free,
              const Stream& stream);

  private:
    using Partner = BlockPlan::Partner;
    /// A partner for each peer of the transport, which has capacity for all that travels in a round of at most `chunk`
    /// records.
    std::vector<Partner> open(const BlockPlan& plan, std::size_t chunk, std::size_t record);

    const Comm& comm_;
    std::unique_ptr<Transport> transport_;
    std::vector<TransportPeer> peers_;  ///< all with whom there was ever something to share
    Array<ListCopy> copies_;
    Array<std::uint32_t> slots_;
};

/// The slots of ranges, one after the other from to[0] on; `copies` keeps what the device reads. Asynchronous.
void list_ranges(const std::vector<ListRange>& ranges, const std::uint32_t* lists, Array<ListCopy>& copies,
                 std::uint32_t* to, cudaStream_t stream);

/// Bounds of the cells of each block whose list is sorted by cell. Asynchronous.
template <class Real, int Dim>
void bound_cells(int own, const std::uint32_t* first, const std::uint32_t* slot, const Row<Real>* place,
                 std::uint32_t* cell_first, cudaStream_t stream);

}  // namespace moraine::gpu
