#pragma once
// What acts along surfaces on the host (core/surface_elements.hpp).

#include "comm/surface_cells.hpp"

namespace moraine {

template <class Real, int Dim>
class SurfaceForces {
  public:
    SurfaceForces(SurfaceBlocks<Real, Dim>& on, const SurfaceCells<Real, Dim>& pressures)
        : on_(on), pressures_(pressures) {}

    /// Which elements the soil touches in this step, and their W_i. Collective over peers.
    void begin_step();
    /// Acts on the velocities of the nodes. dt: in which it does [s]. Collective over peers.
    void act(double dt, double damping);

  private:
    using Blocks = SurfaceBlocks<Real, Dim>;
    using Place = typename Blocks::Place;
    static constexpr int cells = Blocks::cells, nodes = Blocks::nodes, side = Blocks::side, width = Blocks::width;
    static constexpr int tile_nodes = Blocks::tile_nodes, to_middle = Blocks::to_middle;
    static int lane(int n) { return Blocks::lane(n); }

    void find_gaps(const ContactPairs<Dim>& pairs);
    void tell_elements(const ContactPair& pair);
    void weigh();
    Pressing pressing(int k, const SurfaceElement<Dim>& e, double dt, double damping) const;
    void slow_element(int k, const SurfaceElement<Dim>& e, double dt, double damping, Real* tile);
    void close_slave(int k, int c, Real* tile);
    double row_of(const SurfaceElement<Dim>& e, int k, const Vec<double, Dim>& along) const;
    void apply();
    void count_walls(std::int32_t c, int n, double mass, const Vec<Real, Dim>& before, const Vec<Real, Dim>& after);
    SurfaceShares<Dim> shares_at(std::int32_t near) const;

    SurfaceBlocks<Real, Dim>& on_;
    const SurfaceCells<Real, Dim>& pressures_;
    Host::Array<Real> shares_;
    Host::Array<NodeGap> gap_tiles_;
};

}  // namespace moraine
