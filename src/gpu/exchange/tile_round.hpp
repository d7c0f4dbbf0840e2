#pragma once
// A round of the halo in the midst of a step, for tiles that are not the sums of particles (gpu/surface_state.hpp):
// what other ranks need of them goes, and what they have comes, before the stream of the steps goes on.

#include "gpu/exchange/exchange.hpp"

namespace moraine::gpu {

template <class Real, int Dim>
class TileRound {
  public:
    /// Of one rank alone.
    TileRound() = default;
    /// own: blocks; side: of a tile [nodes]. All must outlive it.
    TileRound(Exchange<Real, Dim>& exchange, int own, int side, Counters* counters, const Stream& steps)
        : exchange_(&exchange), own_(own), side_(side), counters_(counters), steps_(&steps) {}

    bool travels() const { return exchange_ != nullptr; }
    /// tiles: those of ghosts first; tile_of is written for ghosts. Collective over peers; asynchronous but for what
    /// the transport waits for.
    void send(const TileView<Real>& tiles, std::int32_t* tile_of) const {
        if (!exchange_) return;
        Exchange<Real, Dim>& e = *exchange_;
        e.solved.record(*steps_);
        e.stream.wait_for(e.solved);
        e.halo.start(e.routes.send(), tiles, nullptr, {}, side_, counters_, e.stream);
        e.halo.post();
        e.halo.finish(e.routes.receive(), tiles, nullptr, {}, tile_of, own_, side_, e.stream);
        e.halo_here.record(e.stream);
        steps_->wait_for(e.halo_here);
    }

  private:
    Exchange<Real, Dim>* exchange_ = nullptr;
    int own_ = 0, side_ = 0;
    Counters* counters_ = nullptr;
    const Stream* steps_ = nullptr;
};

}  // namespace moraine::gpu
