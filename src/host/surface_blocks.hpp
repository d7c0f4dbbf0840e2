#pragma once
// Blocks near surfaces, and how what is given there travels (Bed::surface).
//
// Blocks near a surface have a tile of their own each, empty ones too, as a cut cell may lie in a block beside its
// soil. What cells and elements give goes to those tiles, travels in the halo, and is summed by the nodes by offset: a
// pass. All of it follows from places, the same on both sides of a message, so that one answer holds on any ranks.
//
// Most of these blocks give nothing in most passes: they have no surface that soil touches. A pass is of those that
// give; an absent tile and one of zeros are the same, so that no answer knows which there are.

#include <span>

#include "blocks/contact_pairs.hpp"
#include "blocks/patch.hpp"
#include "blocks/surface_plan.hpp"
#include "comm/halo.hpp"
#include "core/data/quad.hpp"
#include "core/nodes/node_energy.hpp"
#include "core/transfer/method.hpp"

namespace moraine {

/// What surfaces act on, in a step.
template <class Real, int Dim>
struct SurfaceScene {
    ContactField<Dim> field;  ///< as it moves in this step
    Quantum quantum;
    Real mass_cutoff;           ///< [kg]
    HeldNode<Real, Dim>* held;  ///< null: pressures are the particles'
    CellPressure<Real>* cells;  ///< of occupied blocks, as PressureContext's
    StructureSums<Dim>* felt;   ///< by structure
    TurningSums<Dim>* turning;  ///< likewise; null: none turns
};

/// What a block gives to structures in a pass: added up, and told to all at its end. Whole numbers, so in any order.
template <class Real, int Dim>
class StructureTally {
  public:
    explicit StructureTally(const SurfaceScene<Real, Dim>& scene) : scene_(scene) {}
    StructureTally(const StructureTally&) = delete;
    StructureTally& operator=(const StructureTally&) = delete;
    ~StructureTally() { tell(); }
    /// What a structure gets [kg m/s], and where [m]. follows: the mass that moves with it, by axis [kg]; couple: what
    /// one that turns gets besides [kg m2/s].
    void add(int structure, const Vec<double, Dim>& impulse, const Vec<double, Dim>& place,
             const Vec<double, Dim>& follows = zero_vec<double, Dim>(),
             const Vec<double, moments<Dim>>& couple = zero_vec<double, moments<Dim>>());

  private:
    void tell();

    const SurfaceScene<Real, Dim>& scene_;
    int structure_ = -1;
    StructureSums<Dim> sums_;  ///< of that one
};

/// What a pass gave to the nodes near surfaces.
template <class Real>
struct NodeSums {
    Host::Array<Real> value;          ///< [near node block][node][real]; nothing where nobody gave
    std::vector<std::uint8_t> known;  ///< [near node block] somebody gave
};

template <class Real, int Dim>
struct SurfaceBlocks : SurfacePlan<Dim> {
    using Plan = SurfacePlan<Dim>;
    using Place = typename Plan::Place;
    using Plan::bed_of, Plan::block_at, Plan::blocks, Plan::cells, Plan::ghosts, Plan::near_nodes, Plan::near_of;
    using Plan::nodes, Plan::nodes_at, Plan::side, Plan::tile_nodes, Plan::to_middle, Plan::width;

    const Method<Host, Real, Dim>& method;
    Patch<Host, Real, Dim>& patch;
    bool counts_energy;  ///< the scene has an energy budget
    SurfaceScene<Real, Dim> scene{};
    Halo<Real, Dim>* halo = nullptr;
    const ContactPairs<Dim>* pairs = nullptr;
    struct {
        bool in_epoch = false;
    } made{};
    std::vector<std::int32_t> node_index{};  ///< among near ones [block][node of tile]
    std::vector<std::int32_t> tile_index{};  ///< by own and ghost block
    std::vector<Real*> node_values{};        ///< of this step [near node block]; null: no soil is near
    std::vector<Real*> tile_values{};        ///< the same [block][node of tile]; null: it holds no soil
    std::vector<std::uint8_t> has_soil{};    ///< [block]: some node of its tile holds soil
    Host::Array<Real> tiles{};
    NodeSums<Real> sums{};                            ///< of the last pass
    Host::Array<SurfaceMotion<Real, Dim>> motions{};  ///< with an energy budget: of this round [near node block][node]

    SurfaceBlocks(const Method<Host, Real, Dim>& of, Patch<Host, Real, Dim>& on, double cell, bool counts)
        : Plan{cell, of.stencil.origin, of.grid_bulk() != nullptr}, method(of), patch(on), counts_energy(counts) {}

    /// Where surfaces are, and which nodes they want to know. Binned state. Not collective.
    void find(const ContactField<Dim>& field, bool moves);
    /// The step's nodes are known. Not collective.
    void begin_step();
    /// write(k, tile): what block k of `givers`, ascending, gives to the nodes in the first `quads` of a node's two;
    /// their sums are then in `sums`. Collective over peers.
    template <class Write>
    void pass(std::span<const std::int32_t> givers, int quads, const Write& write);
    /// Brings the gap tiles of those. Collective over peers.
    void share(std::span<const std::int32_t> givers, const GapShare<Dim>& gaps);
    /// Of those of our blocks for which it holds.
    template <class Gives>
    void list(std::vector<std::int32_t>& givers, const Gives& gives) const {
        givers.clear();
        for (int k = 0; k < static_cast<int>(blocks.size()); ++k)
            if (gives(k)) givers.push_back(k);
    }

    static int lane(int n) { return sum_lane<Dim>(n); }
    SurfaceBlock<Dim>& at(int k) const { return *block_at[static_cast<std::size_t>(k)]; }
    const SurfaceCell<Dim>& cell_at(int k, int c) const { return at(k).cell[static_cast<std::size_t>(c)]; }
    std::int32_t node_at(int k, int n) const { return node_index[static_cast<std::size_t>(k * tile_nodes + n)]; }
    const SpaceNode& surface_node(std::int32_t near) const {
        return nodes_at[static_cast<std::size_t>(near / cells)]->node[near % cells];
    }
    const Real* sum_of(std::int32_t near) const {
        static constexpr Real nothing[node_reals] = {};
        return sums.known[std::size_t(near) / cells] ? sums.value.data() + std::size_t(near) * node_reals : nothing;
    }
    const Real* sum_at(int k, int n) const { return sum_of(node_at(k, n)); }
    /// Values of a node; null: it holds no soil.
    Real* values(std::int32_t near) const {
        Real* node = node_values[std::size_t(near) / cells];
        if (!node) return nullptr;
        node += std::size_t(near) % cells * node_reals;
        return node[quad - 1] > scene.mass_cutoff ? node : nullptr;
    }
    /// The same of a block's tile.
    Real* values_at(int k, int n) const { return tile_values[static_cast<std::size_t>(k * tile_nodes + n)]; }
    std::ptrdiff_t stored(std::int32_t near) const;
    /// What follows a structure that turns.
    void tell_following(int structure, const Following<Dim>& by) const {
        add_following(by, scene.quantum, scene.turning[structure]);
    }
    /// Of the node in the middle of cell c of block k, beside a structure [m].
    Vec<double, Dim> centre_of(int k, int c, const Structure<Dim>& s) const {
        const Place node = at(k).cell_node(c);
        return node_place(scene.field, s, &node[0], 0.0);
    }

  private:
    void index_nodes();
    void find_values(int k);
    bool is_occupied(std::int32_t node_block) const;
    void travel(std::span<const std::int32_t> givers, const GapShare<Dim>* gaps);
    void sum_nodes(int j, int quads);
    template <int Quads>
    void add_tiles(int j);
};

template <class Real, int Dim>
template <class Write>
void SurfaceBlocks<Real, Dim>::pass(std::span<const std::int32_t> givers, int quads, const Write& write) {
    Host::launch(static_cast<std::int64_t>(givers.size()), [&](int i) {
        const std::int32_t k = givers[static_cast<std::size_t>(i)];
        Real* tile = tiles.data() + (ghosts + static_cast<std::size_t>(k)) * tile_nodes * node_reals;
        for (int n = 0; n < tile_nodes; ++n) std::fill_n(tile + n * node_reals, quads * quad, Real(0));
        write(k, tile);
    });
    travel(givers, nullptr);
    Host::launch(static_cast<std::int64_t>(near_nodes.size()), [&](int j) { sum_nodes(j, quads); });
}

}  // namespace moraine
