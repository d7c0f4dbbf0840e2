#pragma once
// Binning: after particles moved, each block's list of slots is made anew, sorted by cell.
//
//   new list = stayers in list order, then incoming particles by source offset (the 3^d - 1 neighbour codes in
//   order), then by source order; then a stable counting sort by cell
//
// The rule does not see ranks: what came from another rank stands in the outgoing particles of a ghost block.
// Particles do not move in memory; a block in which no particle changed its cell keeps its list.

#include "core/data/grid_views.hpp"
#include "core/particles/place_step.hpp"

namespace moraine {

/// A particle that changes block: its slot, next cell and the code of its offset.
struct OutgoingParticle {
    std::uint32_t slot;
    std::uint16_t move;
};

/// Writes each own block's outgoing particles, in list order, to outgoing[outgoing_first[block]...].
template <int Dim>
struct CollectOutgoing {
    ListView<Dim> list;
    const std::uint16_t* moves;
    const std::uint32_t* outgoing_first;
    OutgoingParticle* outgoing;

    MORAINE_HD void operator()(int block) const {
        std::uint32_t at = outgoing_first[block];
        if (at == outgoing_first[block + 1]) return;
        for (std::uint32_t k = list.first[block]; k < list.first[block + 1]; ++k)
            if (move_code(moves[k]) != Block<Dim>::centre) outgoing[at++] = {list.slot[k], moves[k]};
    }
};

/// Calls f(outgoing particle) for every incoming particle of an own block, in the order of the rule.
template <int Dim, class F>
MORAINE_HD void each_incoming(const BlockTable<Dim>& table, const std::uint32_t* outgoing_first,
                              const OutgoingParticle* outgoing, int block, const F& f) {
    for (int code = 0; code < Block<Dim>::offsets; ++code) {
        const std::int32_t from = table.neighbour[block * Block<Dim>::offsets + code];
        if (code == Block<Dim>::centre || from < 0) continue;
        for (std::uint32_t k = outgoing_first[from]; k < outgoing_first[from + 1]; ++k)
            if (move_code(outgoing[k].move) == Block<Dim>::opposite(code)) f(outgoing[k]);
    }
}

/// Length of each own block's next list; incoming particles set `shuffled`.
template <int Dim>
struct CountNextList {
    BlockTable<Dim> table;
    ListView<Dim> list;
    const std::uint32_t* outgoing_count;
    const std::uint32_t* outgoing_first;
    const OutgoingParticle* outgoing;
    std::uint8_t* shuffled;
    std::uint32_t* next_count;

    MORAINE_HD void operator()(int block) const {
        std::uint32_t n = 0;
        each_incoming(table, outgoing_first, outgoing, block, [&](const OutgoingParticle&) { ++n; });
        if (n > 0) shuffled[block] = 1;
        next_count[block] = list.count(block) - outgoing_count[block] + n;
    }
};

/// Fills each own block's next list and its cells.
template <int Dim>
struct FillNextList {
    BlockTable<Dim> table;
    ListView<Dim> list;
    const std::uint16_t* moves;
    const std::uint32_t* outgoing_first;
    const OutgoingParticle* outgoing;
    const std::uint8_t* shuffled;
    const std::uint32_t* next_first;
    std::uint32_t* next_slot;
    std::uint32_t* cell_first;

    MORAINE_HD void operator()(int block) const {
        std::uint32_t* to = next_slot + next_first[block];
        const std::uint32_t begin = list.first[block];
        const std::uint32_t end = list.first[block + 1];
        if (!shuffled[block]) {
            for (std::uint32_t k = begin; k < end; ++k) to[k - begin] = list.slot[k];
            return;
        }
        std::uint32_t* first = cell_first + std::size_t(block) * (Block<Dim>::cells + 1);
        for (int c = 0; c <= Block<Dim>::cells; ++c) first[c] = 0;
        each_member(block, [&](std::uint32_t, int cell) { ++first[cell + 1]; });
        std::uint32_t at[Block<Dim>::cells];
        for (int c = 0; c < Block<Dim>::cells; ++c) {
            first[c + 1] += first[c];
            at[c] = first[c];
        }
        each_member(block, [&](std::uint32_t slot, int cell) { to[at[cell]++] = slot; });
    }

  private:
    template <class F>
    MORAINE_HD void each_member(int block, const F& f) const {
        for (std::uint32_t k = list.first[block]; k < list.first[block + 1]; ++k)
            if (move_code(moves[k]) == Block<Dim>::centre) f(list.slot[k], move_cell(moves[k]));
        each_incoming(table, outgoing_first, outgoing, block,
                      [&](const OutgoingParticle& l) { f(l.slot, move_cell(l.move)); });
    }
};

}  // namespace moraine
