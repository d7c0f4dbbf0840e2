#pragma once
// What records, checkpoints and tests ask of a simulation in the binned state: totals, hashes, particles one by one.
//
// All are over the pieces of the shares, block by block in list order, and their sums over blocks and ranks are exact:
// the same on any number of ranks and threads.

#include <array>
#include <type_traits>

#include "core/transfer/totals.hpp"
#include "simulation/simulation.hpp"

namespace moraine {

/// Place of a particle of a piece [m]. Not collective.
template <class Real, int Dim>
std::array<double, Dim> place_of(const Simulation<Real, Dim>& sim, const SharePiece<Real, Dim>& piece, int block,
                                 std::uint32_t slot) {
    return place_in<Real, Dim>(sim.scene(), sim.method().stencil,
                               piece.tables.position[static_cast<std::size_t>(block)], piece.p.position[slot]);
}

/// Calls f(slot, x [m]) for the particles of this rank's share on the host, in list order. Not collective.
template <class Real, int Dim, class F>
void each_particle(Simulation<Real, Dim>& sim, const F& f) {
    const SharePiece<Real, Dim> share = whole_of(sim.patch(), {"position"});
    for (int b = share.begin; b < share.end; ++b)
        for (std::uint32_t s : share.slots(b)) f(s, place_of(sim, share, b, s));
}

/// Of this rank's share. Not collective.
template <class Real, int Dim>
TotalSums<Dim> share_totals(const Simulation<Real, Dim>& sim);

/// Of the whole run. Collective.
template <class Real, int Dim>
Totals<Dim> totals_of(const Simulation<Real, Dim>& sim) {
    return sim.comm().exact_sum(share_totals(sim)).value(sim.quantum());
}

/// -sum m g . (x - domain.min) [J]. Not collective.
template <int Dim>
double potential_energy(const Scene& scene, const std::type_identity_t<std::array<double, Dim>>& gravity,
                        const Totals<Dim>& totals);

/// A sum of the run's budget over all ranks. Collective.
template <class Real, int Dim>
double sum_of(const Simulation<Real, Dim>& sim, const ExactSum& mine) {
    return sim.quantum().value(sim.comm().exact_sum(mine));
}

/// Volume per column of cells along x, over the domain [m3]. Collective.
template <class Real, int Dim>
std::vector<double> column_volumes(const Simulation<Real, Dim>& sim);

/// A particle's part of the hash of the state: of a block, and of its row of all columns; `place`: in its list.
std::uint64_t row_hash(Key key, const std::vector<ColumnBytes>& columns, std::uint32_t slot,
                       std::optional<std::uint64_t> place = {});

/// Hash of the state; `with_lists` includes each particle's block and place in its list. Collective.
template <class Real, int Dim>
std::uint64_t state_hash(const Simulation<Real, Dim>& sim, bool with_lists = false);

}  // namespace moraine
