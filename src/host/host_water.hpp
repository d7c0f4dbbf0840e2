#pragma once
// Water in the pores of the ground on the host (core/fluid/water_cells.hpp): what nodes hold of its flux through a
// step, and what cells hold besides their pressures. Not collective.

#include <array>
#include <span>
#include <vector>

#include "core/fluid/water_kernels.hpp"
#include "core/terms/water_term.hpp"
#include "host/host_pressures.hpp"

namespace moraine {

template <class Real, int Dim>
class HostWater {
  public:
    /// All must outlive it.
    HostWater(const Scene& scene, const Method<Host, Real, Dim>& method, Patch<Host, Real, Dim>& patch,
              HostPressures<Real, Dim>& pressures);

    /// Gives particles the weight of water that came or went since the start, or takes that of all where pressures are
    /// in excess of still water: their mass stays. gravity [m/s2].
    void set_weight(const std::array<double, Dim>& gravity);
    /// Adds the flux of `blocks` to their tiles.
    void sum_flow(std::span<const std::int32_t> blocks, const Substep& substep);
    void hold_flow();
    void find(const Substep& first);
    /// Adds the forces of the cells of `blocks` to their tiles.
    void sum(std::span<const std::int32_t> blocks);
    void update(const Substep& substep);

    /// As nodes are to see them under a gravity [m/s2]; solved: node blocks whose accounts are kept.
    WaterNodes<Real, Dim> nodes(const std::array<double, Dim>& gravity, std::size_t solved = 0);
    /// Adds what the nodes of the step did.
    void count(WaterAccount<Dim>& account) const;
    WaterTerm<Real, Dim> term() const;

  private:
    const Scene& scene_;
    const Method<Host, Real, Dim>& method_;
    Patch<Host, Real, Dim>& patch_;
    HostPressures<Real, Dim>& pressures_;
    Host::Array<WaterNode<Real, Dim>> nodes_;
    Host::Array<WaterCell<Real>> cells_;
    Host::Array<WaterAccount<Dim>> accounts_;  ///< by node block that is solved
};

}  // namespace moraine
