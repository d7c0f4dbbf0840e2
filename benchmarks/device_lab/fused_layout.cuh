#pragma once
// What the fused step keeps: each block's particles in a region of its own, and one block's in shared memory.
//
// A region holds, in rows as everywhere, the list of the block: `stay` particles sorted by cell, then a gap in which
// those that left in the last step still stand, sorted by exit, then `incoming` at `tail`, in the order (source block,
// slot). A step reads all, and writes the block's own part anew in place; so the order is the list's own, and depends
// on blocks alone.

#include <cmath>

namespace moraine {
using ::fma;  // quads have one of their own: in the program no file has both gathers and P2G
}

#include "gpu/kernels/g2p/g2p_fused.cuh"
#include "gpu/kernels/p2g/p2g.cuh"

namespace moraine::gpu::lab {

/// Where a block's particles stand in its region.
struct alignas(16) Region {
    std::uint32_t stay;      ///< [0, stay): the list
    std::uint32_t tail;      ///< [stay, tail): who left by the last step
    std::uint32_t incoming;  ///< [tail, tail + incoming)
    std::uint32_t leaving;   ///< tail - stay

    MORAINE_HD std::uint32_t count() const { return stay + incoming; }
    /// Place in the region of list entry e.
    MORAINE_HD std::uint32_t place(std::uint32_t e) const { return e < stay ? e : tail + (e - stay); }
};

/// Keys of the sort: cells, then exits (codes of the neighbours' offsets, and `gone`).
inline constexpr int exits = Block<3>::offsets + 1;
inline constexpr int first_exit = Block<3>::cells;
inline constexpr int bins = 96;
static_assert(first_exit + exits < bins);

/// What is known of the next block while this one is worked on.
struct alignas(16) NextBlock {
    std::int32_t node_block[Block<3>::corners];
    Region region;
    std::int32_t block;       ///< or -1
    std::uint32_t border[1];  ///< the word that holds the flag
};

/// What a block's particles tell, for the next kernel to fold into an Account: to fold at once is to wait for memory.
struct BlockReport {
    double work, signal, moved;
};

template <class Real>
struct FusedStep {
    View<Real, 3> v;  ///< columns of regions, tiles; lists are not used
    GatherArgs<Real, 3> g;
    std::uint32_t capacity;        ///< of a region
    Region* region;                ///< own
    std::uint16_t* exit_at;        ///< own x (exits + 1): places in the region; means nothing where nobody leaves
    std::uint32_t* home;           ///< column: where the id and what else is seldom needed lies
    std::uint32_t* number;         ///< of the step, from 1
    std::uint32_t* claimed;        ///< own: the last step in which somebody came
    BlockReport* report;           ///< own
    std::uint32_t* ticket;         ///< thread blocks that have ended; zero between launches
    std::int32_t* overfull;        ///< blocks with more particles than a thread block holds, in any order
    std::uint32_t* overfulls;      ///< their number in this step
    std::uint32_t* overfulls_all;  ///< and in all steps before
    std::int32_t* occupied;        ///< blocks that hold or held particles
    std::uint32_t* occupieds;
    std::int32_t* tile_of;       ///< = v.grid.tile_of
    std::uint32_t* error;        ///< 1: a region was too small
    unsigned long long* clocks;  ///< by phase, of instances that count them: what their first threads took [cycles]
};

/// A launch may begin while the one before it ends (programmatic dependent launch): until then it waits here.
__device__ __forceinline__ void wait_for_launch_before() {
    asm volatile("griddepcontrol.wait;" ::: "memory");
}
__device__ __forceinline__ void let_next_launch_begin() {
    asm volatile("griddepcontrol.launch_dependents;" ::: "memory");
}

/// Shared memory of a thread block that holds `Capacity` particles. Passes, Ahead: see fused.cuh. Ahead, rows are free
/// for the next block while the tile is made, unless it is to be folded.
template <class Real, int Capacity, int Passes, bool Ahead>
struct Held {
    using Case = P2gCase<Real, 3, Quadratic, false>;
    using Tile = GatherTile<Real, 3, 3>;
    static constexpr int per_row = int(sizeof(Row<Real>)) / 16, units = core_rows<3> * per_row;
    static_assert(Capacity % 32 == 0);
    static constexpr int parts = Passes == 1 ? 2 : 1;
    static constexpr bool planes_in_rows = Passes == 1 && !Ahead, fold_in_rows = Passes == 1 && Ahead;
    static constexpr int planes_bytes = parts * Planes<Case>::bytes + (fold_in_rows ? 0 : fold_bytes<Case, parts>);
    static constexpr unsigned threads = Case::threads;
    static constexpr int warps = Case::threads / 32, rounds = (Capacity + Case::threads - 1) / Case::threads;

    union Rows {
        uint4 unit[units][Capacity];
        unsigned char planes[planes_in_rows ? planes_bytes : 1];
    } rows;
    union Nodes {
        Tile tile;
        unsigned char planes[planes_in_rows ? 1 : planes_bytes];
    } nodes;
    std::uint32_t home[Capacity];
    std::uint16_t key[Capacity];  ///< key, and above it the rank among those of the same key of the warp
    std::uint16_t order[Capacity];
    std::uint16_t bin[warps][bins];    ///< how many of a key a warp has
    std::uint16_t place[warps][bins];  ///< where its first is to go
    std::uint32_t start[bins + 1];
    double work[6];
    Real signal[6], moved[6];
    std::uint32_t neighbour[Block<3>::offsets], number[Block<3>::offsets];  ///< each for the thread that asked
    int block[1];
    bool border;
    NextBlock next;

    /// A warp has a part of the list of its own, 32 entries a round: how many, and the thread's entry of the first.
    static __device__ __forceinline__ unsigned rounds_of(std::uint32_t n) { return (n + threads - 1) / threads; }
    static __device__ __forceinline__ unsigned first_of(std::uint32_t n) {
        return thread_now() / 32 * 32 * rounds_of(n) + thread_now() % 32;
    }

    /// Which place holds entry i: lanes that read entries 8 apart, which the same particle of neighbouring cells often
    /// is, meet different banks.
    static __device__ __forceinline__ unsigned at(unsigned i) { return i ^ (i >> 3 & 7); }

    __device__ __forceinline__ Row<Real> take(unsigned at, int r) const {
        Row<Real> row;
#pragma unroll
        for (int u = 0; u < per_row; ++u) reinterpret_cast<uint4*>(&row)[u] = rows.unit[r * per_row + u][at];
        return row;
    }
    __device__ __forceinline__ void put(unsigned at, int r, const Row<Real>& row) {
#pragma unroll
        for (int u = 0; u < per_row; ++u) rows.unit[r * per_row + u][at] = reinterpret_cast<const uint4*>(&row)[u];
    }
    __device__ __forceinline__ Real* planes() {
        return reinterpret_cast<Real*>(planes_in_rows ? rows.planes : nodes.planes);
    }
    __device__ __forceinline__ Real* fold() {
        return fold_in_rows ? reinterpret_cast<Real*>(rows.unit) : planes() + parts * Planes<Case>::part;
    }
};

}  // namespace moraine::gpu::lab
