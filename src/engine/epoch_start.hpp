#pragma once
// The particles that an epoch begins with.

#include <span>
#include <variant>

#include "comm/block_move.hpp"
#include "core/data/lattice.hpp"

namespace moraine {

/// Those of now: every block keeps its owner.
struct KeptBlocks {};

/// Those of now: this rank's occupied block i goes to owner[i].
struct MovedBlocks {
    std::span<const std::int32_t> owner;
};

/// What the host's share holds; `binned` are blocks of the tables' own ones.
struct HostShare {
    const BinnedBlocks& binned;
};

/// What a lattice has in the tables' own blocks.
template <class Real, int Dim>
struct LatticeShare {
    const LatticeTables<Real, Dim>& lattice;
};

template <class Real, int Dim>
using EpochStart = std::variant<KeptBlocks, MovedBlocks, HostShare, LatticeShare<Real, Dim>>;

}  // namespace moraine
