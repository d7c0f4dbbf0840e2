#pragma once
// Contact on surfaces on the host (core/surfaces/surface_elements.hpp).

#include <array>

#include "host/element_rows.hpp"
#include "host/surface_pressures.hpp"

namespace moraine {

template <class Real, int Dim>
class SurfaceForces {
  public:
    SurfaceForces(SurfaceBlocks<Real, Dim>& on, const SurfacePressures<Real, Dim>& pressures)
        : on_(on), pressures_(pressures) {}

    /// Which elements the soil touches in this step, and their W_i. Collective over peers.
    void begin_step();
    /// Acts on the velocities of the nodes. Collective over peers.
    void act(const ContactTime& time, double damping);
    /// What walls gave besides, in this step.
    void take_impulse(std::array<ExactSum, Dim>& impulse);
    /// What the round and they did to the energy of nodes [node block]; the scene has an energy budget.
    void count_energy(const NodeRound<Real, Dim>& round, NodeEnergy* energy);

  private:
    using Blocks = SurfaceBlocks<Real, Dim>;
    using Place = typename Blocks::Place;
    static constexpr int cells = Blocks::cells, nodes = Blocks::nodes, side = Blocks::side, width = Blocks::width;
    static constexpr int tile_nodes = Blocks::tile_nodes, to_middle = Blocks::to_middle;
    static int lane(int n) { return Blocks::lane(n); }
    /// What the nodes of an element hold (element_rule.hpp).
    struct NodesOf : NodesInTurn<Dim> {
        const SurfaceForces& of;
        int k, corner;
        const Real* values(int at) const { return of.on_.values_at(k, corner + at); }
    };

    /// An element that acts in this step.
    struct Touching {
        std::int32_t element;
        double row;  ///< its R_e across
    };

    void find_gaps(const ContactPairs<Dim>& pairs);
    void find_touching(int k, const GapTiles& tiles, const BlockTable<Dim>& table);
    bool is_behind(const ContactPair& pair, int cell, const Vec<Coordinate<Real>, Dim>& u, double volume,
                   double least) const;
    bool is_behind(const ContactPair& pair, int cell, const Vec<Coordinate<Real>, Dim>& u, std::int32_t gap) const;
    static Vec<double, Dim> place_in_block(const Vec<Coordinate<Real>, Dim>& u);
    void tell_elements(const ContactPair& pair);
    /// Particles that may be near a surface, before it is known how near.
    struct MayBeNear {
        static constexpr int most = 64;
        std::uint32_t slot[most];
        int cell[most], count = 0;  ///< cell: of ours
        Vec<double, Dim> place[most];
    };
    void tell_elements(const ContactPair& pair, MayBeNear& near);
    void tell_element(const ContactPair& pair, int cell, const Vec<Coordinate<Real>, Dim>& u, const ParticleGap& own);
    /// f(element, its R_e across).
    template <class F>
    void each_touching(int k, const F& f) const {
        const auto i = static_cast<std::size_t>(k);
        for (const Touching& t : touching_[i]) f(on_.at(k).elements[static_cast<std::size_t>(t.element)], t.row);
    }
    void weigh();
    void find_rows();
    void find_rows(int k, ElementRows<Dim>& rows);
    void find_slaves();
    void sweep(const ContactTime& time, double damping);
    void act_on(int k, const SurfaceElement<Dim>& e, double row, const ContactTime& time, double damping, Real* tile,
                StructureTally<Real, Dim>& tally);
    bool acts(int k, const Slave& slave) const;
    void close_slave(int k, const SlaveNode<Dim>& by, Real* tile) const;
    using Taken = Vec<Real, Dim> SurfaceMotion<Real, Dim>::*;
    void apply(Taken by);
    void note(std::size_t near, Taken by, const Real* node, const Vec<Real, Dim>& v, const Vec<Real, Dim>& end);
    void count_walls(int j, int n, double mass, const Vec<Real, Dim>& before, const Vec<Real, Dim>& after);
    SurfaceShares<Dim> shares_at(std::int32_t near) const;

    SurfaceBlocks<Real, Dim>& on_;
    const SurfacePressures<Real, Dim>& pressures_;
    std::vector<std::array<ExactSum, Dim>> impulse_;  ///< of walls [near node block]
    NodeSums<Real> shares_;                           ///< W_i
    Host::Array<NodeGap> gap_tiles_;
    std::vector<std::vector<SlaveNode<Dim>>> followers_;         ///< slaves who act in this step [block]
    std::vector<std::vector<Touching>> touching_;                ///< [block]
    std::vector<ElementRows<Dim>> rows_;                         ///< of blocks with such [their number in givers_]
    std::vector<std::int32_t> rows_of_;                          ///< [block] of those
    std::vector<std::int32_t> givers_, occupied_, with_slaves_;  ///< blocks: with such, with soil, with followers
};

}  // namespace moraine
