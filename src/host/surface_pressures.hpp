#pragma once
// The pressure of cells beside surfaces on the host (core/surfaces/open_faces.hpp).
//
// A cell that shares its pressure with a neighbour in another block is told of by the node in the middle of that one:
// what children give is summed there, and the root's own answer is read there, so that both sides have the same
// numbers.

#include <array>

#include "core/surfaces/open_rule.hpp"
#include "host/surface_blocks.hpp"

namespace moraine {

template <class Real, int Dim>
class SurfacePressures {
  public:
    explicit SurfacePressures(SurfaceBlocks<Real, Dim>& on)
        : on_(on),
          grid_{on.method.context.walls,
                on.method.capacity,
                on.method.context.inverse_cell,
                static_cast<double>(std::pow(on.h, Dim - 1)),
                static_cast<double>(std::pow(on.h, Dim)),
                whole_.data()} {
        grid_.find_whole(whole_.data());
    }

    /// The cells near surfaces, in place of those of find_pressures.hpp. Collective over peers, as the next two.
    void find(const Substep& first);
    /// Their forces, before the nodes of a substep are solved.
    void press(const Substep& substep);
    /// What the substep's velocities make of the cells.
    void update(const Substep& substep);
    /// N_e: what a block's cell presses on its surface [Pa]; none where pressures are the particles'.
    double pressure_at(int k, int c, double damping) const;
    /// What they took since it was last called; the scene has an energy budget.
    void take_energy(EnergyAccount& account);

  private:
    using Blocks = SurfaceBlocks<Real, Dim>;
    using Place = typename Blocks::Place;
    static constexpr int cells = Blocks::cells, nodes = Blocks::nodes, side = Blocks::side;
    static constexpr int tile_nodes = Blocks::tile_nodes, to_middle = Blocks::to_middle;
    static int lane(int n) { return Blocks::lane(n); }

    /// What the nodes of a cell hold (open_rule.hpp): of all cells, and of those that are found.
    struct ValuesOf {
        const SurfacePressures& of;
        int k, corner;
        const Real* values(int at) const { return of.on_.values_at(k, corner + at); }
    };
    struct TileNodes {
        SpaceNode place[tile_nodes];
        double filling[tile_nodes];
    };
    struct NodesOf : ValuesOf {
        const TileNodes& tile;
        double distance(int at) const { return tile.place[this->corner + at].distance; }
        double capacity(int at) const { return tile.place[this->corner + at].capacity; }
        double filling(int at) const { return tile.filling[this->corner + at]; }
    };

    /// Cells of a block that take part in this step.
    struct OnCells {
        std::vector<int> cell;
        bool has_children = false, has_roots = false;  ///< roots: with children
    };

    template <class F>
    void each_block(const F& f) const {
        Host::launch(static_cast<std::int64_t>(on_.blocks.size()), f);
    }
    /// f(c, cell) of those.
    template <class F>
    void each_on(int k, const F& f) {
        for (const int c : on_cells_[static_cast<std::size_t>(k)].cell)
            f(c, cells_[static_cast<std::size_t>(k * cells + c)]);
    }
    void hold_nodes();
    void find_cells();
    void weigh_cells();
    void tell_children();
    void find_nodes(int k, TileNodes& tile) const;
    void find_cell(int k, int c, const TileNodes& nodes);
    void sum_particles(std::int32_t block, int c, CellMoments<Real, Dim>& moments, OpenCell<Real, Dim>& cell) const;
    void close_cell(int k, int c, const Substep& first);
    void tell_pressure(int k, int c, double impulse, StructureTally<Real, Dim>& tally) const;
    /// The flux that a structure gives a cell by turning [m^d/s].
    double turned_flux(int k, int c) const {
        const Structure<Dim>& s = on_.scene.field.structure[on_.cell_at(k, c).structure];
        const OpenCell<Real, Dim>& cell = cells_[static_cast<std::size_t>(k * cells + c)];
        return s.turns ? dot(s.spin, couple_of(cell, on_.centre_of(k, c, s) - s.at, on_.h)) : 0.0;
    }
    std::size_t first_cell(std::int32_t block) const { return std::size_t(on_.patch.grid().tile_of[block]) * cells; }
    void tell_holes(int k, int c, Real* tile) const;
    void fill_hole(int k, int c);
    int root_node(int k, int c) const;
    void give_cells();
    void count_taken(int k, int c, const Substep& substep);
    double given_to_particles(int block, int c) const;

    /// Of the cells of a block [J].
    struct Energy {
        ExactSum cells, structures;  ///< taken from nodes: by the cells, and by structures that move
    };

    SurfaceBlocks<Real, Dim>& on_;
    std::array<CellNode<Real, Dim>, OpenCell<Real, Dim>::nodes> whole_;
    const OpenGrid<Real, Dim> grid_;
    std::vector<OpenCell<Real, Dim>> cells_;      ///< [block][cell]
    std::vector<OnCells> on_cells_;               ///< [block]
    std::vector<std::int32_t> givers_, sharers_;  ///< blocks with such; with children or roots
    std::vector<HeldNode<Real, Dim>*> held_;      ///< of this step [near node block]; null: none is stored
    std::vector<Vec<Real, Dim>> acceleration_;    ///< HeldNode's, without cells [near node block][node]
    std::vector<Energy> energy_;                  ///< with an energy budget [block]
};

}  // namespace moraine
