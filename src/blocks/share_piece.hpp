#pragma once
// A part of a rank's share in the memory of the host: whole blocks, in list order. Of the host's own share there is one
// piece, the whole; of a device's there are as many as keep the host's memory small.

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "blocks/patch.hpp"
#include "core/data/host.hpp"

namespace moraine {

template <class Real, int Dim>
struct SharePiece {
    const EpochTables<Dim>& tables;
    int begin, end;                    ///< own blocks
    const std::uint32_t* first;        ///< own + 1: start of each block's list in the share
    const std::uint32_t* slot;         ///< of the piece's particles, in list order
    ParticleView<Real, Dim> p;         ///< by slot; columns that were not asked for hold anything
    std::vector<ColumnBytes> columns;  ///< those that were asked for

    std::span<const std::uint32_t> slots() const { return slots_of(begin, end); }
    /// Of one of its blocks.
    std::span<const std::uint32_t> slots(int block) const { return slots_of(block, block + 1); }

  private:
    std::span<const std::uint32_t> slots_of(int from, int to) const {
        return {slot + (first[from] - first[begin]), first[to] - first[from]};
    }
};

/// Those of the columns that are named; all if none is.
inline std::vector<ColumnBytes> named(const std::vector<ColumnBytes>& columns, const std::vector<std::string>& only) {
    std::vector<ColumnBytes> chosen;
    for (const ColumnBytes& c : columns)
        if (only.empty() || std::find(only.begin(), only.end(), c.name) != only.end()) chosen.push_back(c);
    return chosen;
}

template <class Real, int Dim>
SharePiece<Real, Dim> whole_of(Patch<Host, Real, Dim>& share, const std::vector<std::string>& only) {
    const ListView<Dim> list = share.list();
    return {share.tables(),
            0,
            share.own(),
            list.first,
            list.slot,
            share.particles.view(),
            named(share.particles.columns(), only)};
}

}  // namespace moraine
