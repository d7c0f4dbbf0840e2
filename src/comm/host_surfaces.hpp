#pragma once
// What acts on surfaces where they are, on the host (Bed::surface): the pressure of cells that they cut, by what is
// open of their faces (core/open_faces.hpp), and what acts along them, by elements (core/surface_elements.hpp).
//
// Blocks near a surface have a tile of their own each, empty ones too, as a cut cell may lie in a block beside its
// soil. What cells and elements give goes to those tiles, travels in the halo, and is summed by the nodes by offset: a
// pass. A cell that shares its pressure with a neighbour in another block is told by the node in the middle of that
// one. All of it follows from places and from what particles give, so that one answer holds on any ranks.

#include "comm/contact_pairs.hpp"
#include "comm/halo.hpp"
#include "comm/patch.hpp"
#include "core/method.hpp"
#include "core/open_faces.hpp"
#include "core/surface_elements.hpp"

namespace moraine {

/// What surfaces act on, in a step.
template <class Real, int Dim>
struct SurfaceScene {
    ContactField<Dim> field;  ///< as it moves in this step
    Quantum quantum;
    Real mass_cutoff;           ///< [kg]
    Vec<double, Dim>* pressed;  ///< SolveNodes::pressed
    HeldNode<Real, Dim>* held;  ///< null: pressures are the particles'
    CellPressure<Real>* cells;  ///< of occupied blocks, as CellContext's
    const NodeGap* gaps;        ///< of nodes
    StructureSums<Dim>* felt;   ///< by structure
    ExactSum* impulse;          ///< of walls, by node block and axis
};

template <class Real, int Dim>
class HostSurfaces {
  public:
    HostSurfaces(const Method<Host, Real, Dim>& method, Patch<Host, Real, Dim>& patch, double cell)
        : method_(method), patch_(patch), h_(cell) {}

    /// The epoch ended.
    void forget() { made_ = false; }
    /// Where surfaces are, and which nodes they want to know. Binned state. Not collective.
    void place(const ContactField<Dim>& field, bool moves);
    /// The gaps to surfaces are those of now; the step's masses are at the nodes. Collective over peers.
    void begin_step(const SurfaceScene<Real, Dim>& scene, Halo<Real, Dim>& halo, const ContactPairs<Dim>& pairs);
    /// The cells near surfaces, in place of those of find_cells.hpp. Collective over peers.
    void find_cells(const Substep& first);
    /// Their forces, before the nodes of a substep are solved. Collective over peers.
    void press(const Substep& substep);
    /// What acts along surfaces, on velocities of the nodes. dt: in which it acts [s]. Collective over peers.
    void slow(double dt, double damping);
    /// What the substep's velocities make of the cells. Collective over peers.
    void update_cells(const Substep& substep);
    /// Of occupied blocks, as CellContext's: what find_cells() finds near surfaces takes no part there.
    void take_cells(CellPressure<Real>* of_tiles) { scene_.cells = of_tiles; }

  private:
    static constexpr int width = 3, cells = Block<Dim>::cells, nodes = power<Dim>(3);
    static constexpr int side = tile_side(width), tile_nodes = power<Dim>(side);
    static constexpr int tile_nodes_to_middle = Dim == 2 ? 1 + side : 1 + side + side * side;
    using Place = Vec<std::int32_t, Dim>;

    /// A cell of a block near a surface, by place alone.
    struct SurfaceCell {
        CellPart part;
        bool near;                ///< it is one of ours
        const CutCell<Dim>* cut;  ///< null: it is whole
        bool shares;              ///< with the cell at `root` from here
        int root[Dim];
    };
    /// An element as particles of the block look at it.
    struct RingElement {
        double area = 0;  ///< [cells]; 0: there is none
        int structure = -1;
        Vec<double, Dim> normal, place;  ///< [cells, from the block's first cell]
    };

    // of an epoch
    void make(const EpochTables<Dim>& tables);
    void list_blocks(const EpochTables<Dim>& tables);
    void find_nodes(const EpochTables<Dim>& tables);
    void find_block(int k);
    void find_root(const Place& node, SurfaceCell& cell);
    void add_element(int k, int c, const CutCell<Dim>& cut);
    bool is_near(const Place& block) const;
    Place cell_node(int k, int c) const;

    // passes
    template <class Write>
    void pass(const Write& write, const GapShare<Dim>* gaps = nullptr);
    void sum_nodes(int j);
    Real* tile_of(int k) { return tiles_.data() + (ghosts_ + static_cast<std::size_t>(k)) * tile_nodes * node_reals; }
    static int lane(int n) { return Dim == 2 ? (n < 3 ? n : n < 5 ? n + 1 : 7) : n; }
    std::int32_t node_at(int k, int n) const { return node_at_[static_cast<std::size_t>(k * tile_nodes + n)]; }
    const Real* sum_at(int k, int n) const { return sums_.data() + std::size_t(node_at(k, n)) * node_reals; }
    /// Values of a node; null: nobody touches it.
    Real* values(std::int32_t near) const;
    std::ptrdiff_t stored(std::int32_t near) const;

    // elements
    void find_gaps(const ContactPairs<Dim>& pairs);
    void tell_elements(const ContactPair& pair);
    void weigh();
    Pressing pressing(int k, const SurfaceElement<Dim>& e, double dt, double damping) const;
    void slow_element(int k, const SurfaceElement<Dim>& e, double dt, double damping, Real* tile);
    void close_slave(int k, int c, Real* tile);
    double row_of(const SurfaceElement<Dim>& e, int k, const Vec<double, Dim>& along) const;
    void apply();
    void count_walls(std::int32_t c, int n, double mass, const Vec<Real, Dim>& before, const Vec<Real, Dim>& after);
    void tell(int structure, const Vec<double, Dim>& impulse, const Vec<double, Dim>& place);
    SurfaceShares<Dim> shares_at(std::int32_t near) const;

    // cells
    void find_cell(int k, int c, const Substep& first);
    void sum_particles(std::int32_t block, int c, CellMoments<Real, Dim>& moments, OpenCell<Real, Dim>& cell) const;
    void faces_of(const Place& node, const CutCell<Dim>* cut, CellNode<Real, Dim>* face) const;
    void make_rows(int k, int c, const CellMoments<Real, Dim>& moments, OpenCell<Real, Dim>& cell) const;
    void weigh_cell(int k, int c, OpenCell<Real, Dim>& cell) const;
    Real share_of(int k, int c) const;
    void close_cell(int k, int c, const Substep& first);
    void bound(OpenCell<Real, Dim>& cell, const Substep& first) const;
    int structure_of(int k, int c) const;
    void tell_pressure(int k, int c, double impulse);
    std::size_t first_cell(std::int32_t block) const { return std::size_t(patch_.grid().tile_of[block]) * cells; }
    void tell_holes(int k, int c, Real* tile) const;
    void fill_hole(int k, int c);
    int root_node(int k, int c) const;
    void give_cells();

    const Method<Host, Real, Dim>& method_;
    Patch<Host, Real, Dim>& patch_;
    const double h_;
    SurfaceScene<Real, Dim> scene_{};
    Halo<Real, Dim>* halo_ = nullptr;
    const ContactPairs<Dim>* pairs_ = nullptr;
    bool made_ = false;

    SurfaceGeometry<Dim> geometry_;
    std::size_t ghosts_ = 0;
    std::vector<std::int32_t> blocks_, bed_of_, tile_index_, near_nodes_, near_of_, node_at_;
    std::vector<SurfaceNode<Dim>> surface_nodes_;             ///< [near node block][node]
    std::vector<SurfaceCell> place_;                          ///< [block][cell]
    std::vector<std::vector<SurfaceElement<Dim>>> elements_;  ///< [block]
    std::vector<RingElement> ring_;                           ///< [block][cell of the ring]
    Host::Array<Real> tiles_, sums_, shares_;
    Host::Array<NodeGap> gap_tiles_;
    std::vector<OpenCell<Real, Dim>> cells_;    ///< [block][cell]
    std::vector<Vec<Real, Dim>> acceleration_;  ///< HeldNode's, without cells [near node block][node]
};

/// write(k, tile): what block k gives to the nodes; their sums are then in sums_.
template <class Real, int Dim>
template <class Write>
void HostSurfaces<Real, Dim>::pass(const Write& write, const GapShare<Dim>* gaps) {
    Host::launch(static_cast<std::int64_t>(blocks_.size()), [&](int k) {
        Real* tile = tile_of(k);
        std::fill_n(tile, tile_nodes * node_reals, Real(0));
        write(k, tile);
    });
    const TileView<Real> view{tile_index_.data(), tiles_.data(), nullptr, nullptr};
    halo_->start(view, gaps);
    halo_->finish(view, tile_index_.data(), gaps);
    Host::launch(static_cast<std::int64_t>(near_nodes_.size()), [&](int j) { sum_nodes(j); });
}

}  // namespace moraine
