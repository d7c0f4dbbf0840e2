#pragma once
// The last kernel of binning (gpu/kernels/binning/binning.hpp): a warp fills one block's next list and makes its cell
// bounds anew.
//
// A cell's part of the list is: who came up from lower cells, who stayed, who came down, incoming particles. Those that
// stayed keep their order, so each one's place is its old one, plus a shift of its cell, minus the changed entries
// before it, and no lane waits for another; only the others are sorted. A block in which nothing changed is copied.

#include "gpu/kernels/binning/binning.cuh"

namespace moraine::gpu {

template <int Dim>
class BlockFill {
    static constexpr int cells = Block<Dim>::cells;
    static constexpr int offsets = Block<Dim>::offsets;
    static constexpr int per_lane = (cells + 31) / 32;

  public:
    /// Shared memory of one warp.
    struct Scratch {
        std::uint32_t old[cells + 1];  ///< bounds of the cells in the old list
        std::uint32_t in[2 * cells];   ///< who came up into a cell; who came down or from other blocks: counts, places
        std::uint32_t shift[cells];    ///< next place - old place + changed entries before, of one that stayed
        std::uint32_t upto[32];        ///< incoming particles by neighbour code, added up
        std::uint32_t start[32];       ///< where the incoming particles of a code are, less those of the codes below
        std::uint16_t gathered[ChangedEntries::span];
    };

    __device__ BlockFill(const Binning<Dim>& binning, Scratch& scratch, int block)
        : BlockFill(binning, scratch, block, binning.list.first[block]) {}

    __device__ void run() {
        fill();
        check_guard_layer();
    }

  private:
    static constexpr int batch = 8;  ///< loads in flight per lane

    /// One that comes from another block.
    struct IncomingParticle {
        std::uint32_t slot;
        int cell;
    };

    __device__ void fill() {
        const bool neighbour = lane_id() < offsets && lane_id() != Block<Dim>::centre;
        const int from = neighbour ? f.table.neighbour[std::size_t(b) * offsets + lane()] : -1;
        fetch(slot);
        if (count == next_count && !changed.any()) {
            copy();
            return;
        }
        fetch(moves);
        __syncwarp();  // the block before is done with the scratch
        look_around(from);
        count_members();
        place_cells();
        place_unchanged();
        place_changed();
        place_incoming();
    }

    /// Few blocks have a guard layer, and fewer of them hold particles.
    __device__ void check_guard_layer() const {
        const std::uint64_t guard_layer = f.guard_layer[b];
        if (guard_layer == 0) return;
        __syncwarp();  // the bounds are there
        const std::uint32_t* bounds = f.cell_first + std::size_t(b) * (cells + 1);
        for (std::uint32_t c = lane(); c < cells; c += 32)
            if ((guard_layer >> c & 1) && bounds[c + 1] > bounds[c]) *f.occupied.in_guard_layer = 1;
    }

    __device__ BlockFill(const Binning<Dim>& binning, Scratch& scratch, int block, std::uint32_t begin)
        : f(binning),
          s(scratch),
          b(block),
          count(binning.list.first[block + 1] - begin),
          slot(binning.list.slot + begin),
          moves(binning.moves + begin),
          to(binning.next_slot + binning.next_first[block]),
          next_count(binning.next_first[block + 1] - binning.next_first[block]),
          changed(binning.changed + begin / 32 + static_cast<std::uint32_t>(block), count, scratch.gathered) {}

    __device__ std::uint32_t lane() const { return static_cast<std::uint32_t>(lane_id()); }

    /// Asks for the list's part of a column, so that it comes while the neighbours are looked at.
    template <class T>
    __device__ void fetch(const T* column) const {
        constexpr std::uint32_t line = 128 / sizeof(T);
        for (std::uint32_t e = line * lane(); e < count; e += 32 * line)
            asm volatile("prefetch.global.L2 [%0];" ::"l"(column + e));
    }

    __device__ void copy() const {
        for (std::uint32_t base = lane(); base < count; base += 32 * batch) {
            std::uint32_t old[batch];
#pragma unroll
            for (int i = 0; i < batch; ++i) old[i] = base + 32 * i < count ? slot[base + 32 * i] : 0;
#pragma unroll
            for (int i = 0; i < batch; ++i)
                if (base + 32 * i < count) to[base + 32 * i] = old[i];
        }
    }

    /// Cells and incoming particles; from: the neighbour at the lane's code, or -1. All loads first, then what waits
    /// for them.
    __device__ void look_around(int from) {
        constexpr int rows = cells / 32 + 1;
        const std::uint32_t* bounds = f.cell_first + std::size_t(b) * (cells + 1);
        std::uint32_t old[rows], n = 0, start = 0;
#pragma unroll
        for (int i = 0; i < rows; ++i) {
            const std::uint32_t c = lane() + 32 * i;
            old[i] = count > 0 && c <= cells ? bounds[c] : 0;
        }
        if (from >= 0) {
            const std::uint32_t* exit = exit_towards(f, from, lane_id());
            n = f.outgoing.count[from] > 0 ? exit[1] - exit[0] : 0;
            start = (from < f.table.own ? f.list.first[from] : f.outgoing.ghost_start[from - f.table.own]) + exit[0];
        }
#pragma unroll
        for (int i = 0; i < rows; ++i)
            if (lane() + 32 * i <= cells) s.old[lane() + 32 * i] = old[i];
#pragma unroll
        for (int i = 0; i < 2 * cells / 32; ++i) s.in[lane() + 32 * i] = 0;
        const std::uint32_t upto = scan_inclusive(n);
        s.upto[lane()] = upto;
        s.start[lane()] = start - (upto - n);
        incoming = __shfl_sync(all_lanes, upto, 31);
        __syncwarp();
    }

    __device__ IncomingParticle incoming_at(std::uint32_t k) const {
        int code = 0;
#pragma unroll
        for (int step = 16; step > 0; step /= 2)
            if (s.upto[code + step - 1] <= k) code += step;
        const std::uint32_t at = s.start[code] + k;
        return {f.outgoing.slot[at], f.outgoing.cell[at]};
    }

    /// Which of `in` takes a changed entry that stays in the block: it is not in its next cell now.
    __device__ int key(std::uint32_t e, int cell) const {
        return cell + (e >= s.old[cell + 1] ? cells : 0);
    }

    __device__ std::uint32_t own_cell(int i) const {
        return min(lane() * per_lane + static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(cells));
    }

    __device__ void count_members() {
#pragma unroll
        for (int i = 0; i <= per_lane; ++i) changed_before[i] = 0;
        for (std::uint32_t base = 0; base < count; base += ChangedEntries::span) {
            changed.gather(base);
#pragma unroll
            for (int i = 0; i <= per_lane; ++i) changed_before[i] += changed.rank(s.old[own_cell(i)]);
            changed.each_held([&](std::uint32_t e, bool active) {
                const std::uint16_t m = active ? moves[e] : encode_move(Block<Dim>::gone, 0);
                if (move_code(m) == Block<Dim>::centre) atomicAdd(&s.in[key(e, move_cell(m))], 1u);
            });
        }
        if (lane() < incoming) first_incoming = incoming_at(lane());
        for (std::uint32_t k = lane(); k < incoming; k += 32)
            atomicAdd(&s.in[cells + (k < 32 ? first_incoming : incoming_at(k)).cell], 1u);
        __syncwarp();
    }

    /// From counts to places; writes the new bounds.
    __device__ void place_cells() {
        std::uint32_t stay[per_lane], up[per_lane], total[per_lane], sum = 0;
#pragma unroll
        for (int i = 0; i < per_lane; ++i) {
            const std::uint32_t c = own_cell(i);
            stay[i] = s.old[own_cell(i + 1)] - s.old[c] - (changed_before[i + 1] - changed_before[i]);
            up[i] = c < cells ? s.in[c] : 0;
            total[i] = c < cells ? up[i] + stay[i] + s.in[cells + c] : 0;
            sum += total[i];
        }
        std::uint32_t* bounds = f.cell_first + std::size_t(b) * (cells + 1);
        std::uint32_t at = scan_inclusive(sum) - sum;
#pragma unroll
        for (int i = 0; i < per_lane; ++i) {
            const std::uint32_t c = own_cell(i);
            if (c < cells) {
                s.in[c] = at, s.in[cells + c] = at + up[i] + stay[i];
                s.shift[c] = at + up[i] - s.old[c] + changed_before[i];
                bounds[c] = at;
            }
            at += total[i];
        }
        if (lane() == 31) bounds[cells] = at;
        __syncwarp();
    }

    /// Entries base ... base + 32 batch; Full: all of them are in the list. words: bits of the changed ones of the
    /// span; before: how many of them come before. Offsets are added in 64 bits: then they are constants of the loads.
    template <bool Full>
    __device__ void place_rows(std::uint32_t base, std::uint32_t words, std::uint32_t& before) const {
        const std::uint32_t e = base + lane();
        std::uint32_t old[batch];
        std::uint16_t m[batch];
#pragma unroll
        for (int i = 0; i < batch; ++i) {
            const bool in = Full || e + 32 * i < count;
            m[i] = in ? moves[e + std::size_t(32 * i)] : std::uint16_t(0);
            old[i] = in ? slot[e + std::size_t(32 * i)] : 0;
        }
#pragma unroll
        for (int i = 0; i < batch; ++i) {
            if (!Full && base + 32 * i >= count) return;
            const std::uint32_t bits = __shfl_sync(all_lanes, words, static_cast<int>(base / 32) + i);
            const auto below = static_cast<std::uint32_t>(__popc(bits & ((1u << lane()) - 1)));
            const std::uint32_t place = e + 32 * i + s.shift[move_cell(m[i])] - before - below;
            const bool stayed = !((bits >> lane()) & 1) && (Full || e + 32 * i < count);
            if (stayed) to[place] = old[i];
            before += static_cast<std::uint32_t>(__popc(bits));
        }
    }

    __device__ void place_unchanged() const {
        std::uint32_t before = 0;
        std::uint32_t words = 0;
        for (std::uint32_t base = 0; base < count; base += 32 * batch) {
            if (base % ChangedEntries::span == 0) words = changed.bits_from(base);
            if (base + 32 * batch <= count)
                place_rows<true>(base, words, before);
            else
                place_rows<false>(base, words, before);
        }
    }

    __device__ void place_changed() {
        changed.each([&](std::uint32_t e, bool active) {
            const std::uint16_t m = active ? moves[e] : encode_move(Block<Dim>::gone, 0);
            const bool stays = move_code(m) == Block<Dim>::centre;
            const std::uint32_t place = take_place(stays, key(e, stays ? move_cell(m) : 0), s.in);
            if (stays) to[place] = slot[e];
        });
    }

    __device__ void place_incoming() const {
        for (std::uint32_t k = lane(); k - lane() < incoming; k += 32) {
            const bool in = k < incoming;
            const IncomingParticle a = k >= 32 && in ? incoming_at(k) : first_incoming;
            const std::uint32_t place = take_place(in, cells + a.cell, s.in);
            if (in) to[place] = a.slot;
        }
    }

    const Binning<Dim>& f;
    Scratch& s;
    int b;
    std::uint32_t count;
    const std::uint32_t* slot;   ///< the block's old list
    const std::uint16_t* moves;  ///< and its moves
    std::uint32_t* to;           ///< its next list
    std::uint32_t next_count;
    ChangedEntries changed;
    std::uint32_t incoming = 0;
    IncomingParticle first_incoming{0, 0};       ///< that of the lane's number
    std::uint32_t changed_before[per_lane + 1];  ///< changed entries before the bounds of the lane's cells
};

template <int Dim>
__global__ void __launch_bounds__(32 * binning_warps, 8) fill_kernel(const __grid_constant__ Binning<Dim> f) {
    __shared__ typename BlockFill<Dim>::Scratch scratch[binning_warps];
    const OccupiedItems items(f.occupied);
    std::uint32_t item = items.first();
    for (int b = items.block(item); b >= 0;) {
        const int next = items.block(item += OccupiedItems::step());
        BlockFill<Dim>(f, scratch[binning_warp()], b).run();
        b = next;
    }
}

}  // namespace moraine::gpu
