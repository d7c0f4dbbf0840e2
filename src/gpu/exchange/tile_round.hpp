#pragma once
// A round of the halo in the midst of a step, for tiles that are not the sums of particles (gpu/surface_state.hpp):
// what other ranks need of them goes, and what they have comes, before the stream of the steps goes on.

#include "gpu/exchange/exchange.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
struct TileRound {
    Exchange<Real, Dim>* exchange = nullptr;  ///< null: one rank alone
    Counters* counters = nullptr;
    const Stream* steps = nullptr;

    bool travels() const { return exchange != nullptr; }
    /// tiles: those of ghosts first; tile_of is written for ghosts. own: blocks; side: of a tile [nodes]. Collective
    /// over peers; asynchronous but for what the transport waits for.
    void send(const TileView<Real>& tiles, std::int32_t* tile_of, int own, int side) const {
        if (!exchange) return;
        Exchange<Real, Dim>& e = *exchange;
        e.solved.record(*steps);
        e.stream.wait_for(e.solved);
        e.halo.start(e.routes.send(), tiles, nullptr, {}, side, counters, e.stream);
        e.halo.post();
        e.halo.finish(e.routes.receive(), tiles, nullptr, {}, tile_of, own, side, e.stream);
        e.halo_here.record(e.stream);
        steps->wait_for(e.halo_here);
    }
};

}  // namespace moraine::gpu
