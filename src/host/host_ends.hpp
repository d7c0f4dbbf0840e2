#pragma once
// Absorbing ends (core/nodes/absorbing_ends.hpp) at the nodes of an epoch on the host.

#include <vector>

#include "blocks/patch.hpp"
#include "core/nodes/absorbing_ends.hpp"
#include "core/transfer/method.hpp"
#include "core/transfer/totals.hpp"

namespace moraine {

template <class Real, int Dim>
class HostEnds {
  public:
    /// measured: must outlive it.
    explicit HostEnds(const EndNodes<Dim>& measured) : measured_(measured) {}

    void begin_epoch() { laid_ = false; }
    /// Adds forces to the tiles of a round that has forces, between the halo and the nodes.
    void act(const Method<Host, Real, Dim>& method, Patch<Host, Real, Dim>& patch, const NodeRound<Real, Dim>& round);
    /// Adds what the last round gave to the budget.
    void count(const Quantum& quantum, bool with_energy, Budget<Dim>& budget) const;

  private:
    const EndNodes<Dim>& measured_;
    bool laid_ = false;  ///< in this epoch
    std::vector<EndSite<Real, Dim>> sites_;
    std::vector<EndGift<Dim>> gifts_;
};

}  // namespace moraine
