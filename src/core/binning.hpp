#pragma once
// Binning: after particles moved, each block's list of slots is made anew, sorted by cell.
//
//   new list = stayers in list order, then arrivals by source offset (the 3^d - 1 neighbour codes in
//   order), then by source order; then a stable counting sort by cell
//
// The rule does not see ranks: what came from another rank stands in the leavers of a ghost block.
// Particles do not move in memory; a block in which no particle changed its cell keeps its list.

#include "core/grid_views.hpp"
#include "core/place_step.hpp"

namespace moraine {

/// A particle that changes block: its slot, next cell and the code of its offset.
struct Leaver {
    std::uint32_t slot;
    std::uint16_t move;
};

/// Writes each own block's leavers, in list order, to leaver[leaver_first[block]...].
template <int Dim>
struct CollectLeavers {
    ListView<Dim> list;
    const std::uint16_t* moves;
    const std::uint32_t* leaver_first;
    Leaver* leaver;

    MORAINE_HD void operator()(int block) const {
        std::uint32_t at = leaver_first[block];
        if (at == leaver_first[block + 1]) return;
        for (std::uint32_t k = list.first[block]; k < list.first[block + 1]; ++k)
            if (move_code(moves[k]) != Block<Dim>::centre) leaver[at++] = {list.slot[k], moves[k]};
    }
};

/// Calls f(leaver) for every arrival of an own block, in the order of the rule.
template <int Dim, class F>
MORAINE_HD void each_arrival(const BlockTable<Dim>& table, const std::uint32_t* leaver_first, const Leaver* leaver,
                             int block, const F& f) {
    for (int code = 0; code < Block<Dim>::offsets; ++code) {
        const std::int32_t from = table.neighbour[block * Block<Dim>::offsets + code];
        if (code == Block<Dim>::centre || from < 0) continue;
        for (std::uint32_t k = leaver_first[from]; k < leaver_first[from + 1]; ++k)
            if (move_code(leaver[k].move) == Block<Dim>::opposite(code)) f(leaver[k]);
    }
}

/// Length of each own block's next list; arrivals set `shuffled`.
template <int Dim>
struct CountNextList {
    BlockTable<Dim> table;
    ListView<Dim> list;
    const std::uint32_t* leavers;
    const std::uint32_t* leaver_first;
    const Leaver* leaver;
    std::uint8_t* shuffled;
    std::uint32_t* next_count;

    MORAINE_HD void operator()(int block) const {
        std::uint32_t n = 0;
        each_arrival(table, leaver_first, leaver, block, [&](const Leaver&) { ++n; });
        if (n > 0) shuffled[block] = 1;
        next_count[block] = list.count(block) - leavers[block] + n;
    }
};

/// Fills each own block's next list and its cells.
template <int Dim>
struct FillNextList {
    BlockTable<Dim> table;
    ListView<Dim> list;
    const std::uint16_t* moves;
    const std::uint32_t* leaver_first;
    const Leaver* leaver;
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
        each_arrival(table, leaver_first, leaver, block, [&](const Leaver& l) { f(l.slot, move_cell(l.move)); });
    }
};

}  // namespace moraine
