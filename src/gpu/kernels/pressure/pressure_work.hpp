#pragma once
// What the kernels of the grid's pressure are told (gpu/kernels/pressure/pressure.hpp). Plain data, for kernels and
// their launches alike.

#include "core/fluid/find_pressures.hpp"
#include "core/fluid/grid_pressure.hpp"
#include "gpu/kernels/nodes/node_work.hpp"

namespace moraine::gpu {

/// Nodes of a block's tile.
template <int Dim>
inline constexpr int pressure_tile = power<Dim>(tile_side(3));

/// G_ic [m^(d-1)] of cells of a block, of each by axis and node, in whole units of 16 bytes. In memory those of the
/// cells that are not whole, in their order; in the kernel that uses them those of all, 0 where a cell is whole.
template <class Real, int Dim>
struct alignas(16) CutFactors {
    static constexpr int nodes = power<Dim>(3), unit = 16 / int(sizeof(Real));
    static constexpr int each = (Dim * nodes + unit - 1) / unit * unit;
    Real of[Block<Dim>::cells * each];
};

/// A bit per cell of a block.
template <int Dim>
struct CellBits {
    static constexpr int words = (Block<Dim>::cells + 31) / 32;
    std::uint32_t word[words];

    MORAINE_HD int count() const { return before(Block<Dim>::cells); }
    MORAINE_HD bool has(int c) const { return ((word[c / 32] >> c % 32) & 1) != 0; }
    /// Set bits before that of cell c.
    MORAINE_HD int before(int c) const {
        int count = 0;
        for (int i = 0; i < words; ++i) {
            const int upto = c - 32 * i;
            const std::uint32_t mask = upto >= 32 ? ~0u : upto > 0 ? (1u << upto) - 1 : 0u;
            count += count_bits(word[i] & mask);
        }
        return count;
    }

  private:
    static MORAINE_HD int count_bits(std::uint32_t bits) {
#if defined(__CUDA_ARCH__)
        return __popc(bits);
#else
        return __builtin_popcount(bits);
#endif
    }
};

/// A block in the substeps of a step.
template <int Dim>
struct CellBlock {
    std::int32_t tile;
    std::int32_t node_block[Block<Dim>::corners];
    CellBits<Dim> cut;  ///< cells that are not whole
};
template <int Dim>
struct CellBlocks {
    CellBlock<Dim>* list;  ///< in any order
    std::uint32_t* count;
};

/// Pointers to it.
template <class Real, int Dim>
struct PressureView {
    CellPressure<Real>* cell;        ///< [tile][cell]
    CutFactors<Real, Dim>* factors;  ///< [tile]
    HeldNode<Real, Dim>* held;       ///< [node block][node]
    Quad<Real>* velocity;            ///< [node block][node]: v, m; null: where surfaces act, at the nodes themselves
    Real* whole;                     ///< [tile][cell]: P_c + d dP_c of this substep; 0: not whole [Pa]
    Real* cut;                       ///< [tile][axis][node of tile]: sum_c G_ic (P_c + d dP_c) of the others [N]
    std::uint8_t* has_cut;           ///< [tile]: there are such
    CellBlocks<Dim> blocks[2][2];    ///< of the boundary and of the interior: those of whole cells, and the others
    const Real* bulk;                ///< by body: K [Pa]
};

/// The velocity of a node in substeps. at: as nodes are stored.
template <class Real, int Dim>
MORAINE_HD Quad<Real>* velocity_of(const View<Real, Dim>& v, const PressureView<Real, Dim>& pressure, std::size_t at) {
    return pressure.velocity ? pressure.velocity + at : reinterpret_cast<Quad<Real>*>(v.grid.nodes) + 2 * at;
}

/// Of the cells and nodes of a block [bytes].
template <class Real, int Dim>
constexpr double pressure_bytes() {
    return Block<Dim>::cells * double(sizeof(CellPressure<Real>) + sizeof(Real) +
                                      1.3 * (sizeof(HeldNode<Real, Dim>) + sizeof(Quad<Real>))) +
           double(sizeof(CutFactors<Real, Dim>) + pressure_tile<Dim> * Dim * sizeof(Real) + 4 * sizeof(CellBlock<Dim>) +
                  1);
}

/// Nodes from the sums of particles: velocities, masses, what is held, e_i of the shifts in the last lane, light marks.
template <class Real, int Dim>
struct HoldWork {
    View<Real, Dim> view;
    PressureView<Real, Dim> pressure;
    int origin;           ///< of the stencil
    Real mass_cutoff;     ///< [kg]
    Real inverse_volume;  ///< 1 / h^d [1/m3]
    bool shifts;          ///< in this step
    NodeCapacity<Real, Dim> capacity;
    LightMarks<Real> marks;
    NodeContact<Dim> contact;  ///< near.mark null: there is no structure
};

/// What a launch over cells does.
template <class Real>
struct PressureTask {
    bool updates;  ///< takes the velocities of the substep before
    Real dt;       ///< of it [s]
    Real time;     ///< half of the time from the start of the step to its middle [s]
    bool sums;     ///< writes what nodes take in this substep
    bool tells;    ///< and what travels to other ranks, into tiles (advance_pressures.cuh)
    Real damping;  ///< d [-]
};

/// Of the kernels over cells.
template <class Real, int Dim>
struct AdvanceWork {
    View<Real, Dim> view;
    PressureView<Real, Dim> pressure;
    CellBlocks<Dim> blocks[2];  ///< of whole cells, and the others
    PressureTask<Real> task;
};

template <class Real, int Dim>
struct SubstepWork : NodeWork<Real, Dim> {
    PressureView<Real, Dim> pressure;
    Real area;     ///< h^(d - 1) [m^(d - 1)]
    bool is_last;  ///< substep of its step
};

/// Of the kernel that finds cells.
template <class Real, int Dim>
struct FindWork {
    View<Real, Dim> view;
    PressureFinder<Real, Dim> finder;
    PressureView<Real, Dim> pressure;
    CellBlocks<Dim> blocks[2];  ///< where they go: of whole cells, and the others
};

}  // namespace moraine::gpu
