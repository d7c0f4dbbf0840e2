#pragma once
// The pressure of cells beside surfaces (grid_pressure.hpp), by what flows through the open part of their faces.
//
//   G_ic = (1 - x) (sum_p V_p grad w_ip + phi S_ic) + x s_i F_ic        phi = min(1, sum V_p / V_c)
//   S_c = sum_i G_ic                                                     what the structure bears: P_c S_c
//   D_c = (sum_i G_ic . v_i - S_c . V) / V_c,   f_i = - sum_c G_ic P_c
//
// F_ic, S_ic and V_c are those of cut_cell.hpp: a uniform pressure gives nothing at any node, held or free. A cell that
// is not full, x < 1, keeps the sums of its particles, and the surface bears what they press. A node beside the surface
// that lacks soil takes s_i = min(1, fill_i / 0.8) of its row, and the structure the rest: the pressure of a cell that
// hangs on a light node alone would run away. x is by the least filling of the cell's nodes that stand a cell or more
// over the surface; of a cell that is cut by the filling of all its nodes together.
//
// A cell of which less than 0.3 is open, or that is cut and holds no particle, has its pressure, modulus and volume
// together with a neighbour: that to which its normal points, or the one with the widest open face between them. Each
// keeps its own G, so that all faces stay open and what flows along a plane changes no volume.
//
// The modulus is bounded for the substep by the row sum of what all cells do to the cell's nodes, which no eigenvalue
// exceeds: many cells share a node that the surface leaves light.
//
//   M_i = sum_c |G_ic|,   R_c = sum_i |G_ic| M_i / m_i,   K_c <= 1.8^2 V_c / ((1 + 2 d) dts^2 R_c)
//
// A cell beside a surface is soft: K_s is the bound with nodes as heavy as if what is open of them were full, m_i /
// min(1, fill_i). Its pressure is its particles', and its particles take K_s dl_c, too: a secant K_s / K would have
// them bear many times the pressure of their cell. What nodes lack besides makes it loose (grid_pressure.hpp), by K_c /
// K_s.

#include "core/fluid/find_pressures.hpp"
#include "core/surfaces/surface_node.hpp"

namespace moraine {

inline constexpr double small_cell = 0.3;      ///< open part below which a cell shares
inline constexpr double lacks_below = 0.95;    ///< capacity of nodes that may lack soil
inline constexpr double lacks_within = 1.5;    ///< and their distance [cells]
inline constexpr double light_capacity = 0.9;  ///< of nodes whose cells have a bounded modulus

/// A cell beside a surface, in a step, but for its rows.
template <class Real, int Dim>
struct OpenState {
    bool on = false;     ///< it takes part
    bool child = false;  ///< its pressure is the root's
    bool whole = false;  ///< no light node
    bool mixed = false;  ///< children have their pressure with it
    CellPressure<Real> state{};
    Real share = Real(0);        ///< x
    Real bears = Real(0);        ///< of the surface: (1 - x) phi + x
    Real particles = Real(0);    ///< sum V_p [m^d]
    Real flux = Real(0);         ///< of this substep, without children's [m^d/s]
    Real weight = Real(0);       ///< R_c [m^(2d-2)/kg]
    Real full_weight = Real(0);  ///< the same with nodes as if full
    Real soft = Real(0);         ///< K_s [Pa]; 0: it is not soft
    Vec<Real, Dim> bed{};        ///< S_c [m^(d-1)]
};

/// And with them; a cell that does not take part may have any.
template <class Real, int Dim>
struct OpenCell : OpenState<Real, Dim> {
    static constexpr int nodes = power<Dim>(3);
    CellNode<Real, Dim> factor[nodes]{};  ///< G_ic

    MORAINE_HD void begin() { static_cast<OpenState<Real, Dim>&>(*this) = {}; }
};

/// min(1, fill_i / 0.8), fill_i = v_i / (h^d c_i). filling: v_i / h^d.
MORAINE_HD double share_of_full(double capacity, double filling) {
    const double share = capacity > 1e-9 ? filling / capacity / 0.8 : 1;
    return share < 1 ? share : 1;
}

/// s_i. distance [cells], capacity: of SurfaceNode.
MORAINE_HD double node_share(double distance, double capacity, double filling) {
    return distance < lacks_within && capacity < lacks_below ? share_of_full(capacity, filling) : 1;
}

/// Makes a cell's rows of the sums of its particles, which are in `factor`. face, bed: F_ic and S_ic [m^(d-1)]; share
/// of node i: s_i; negative: it holds no soil, and neither it nor the structure bears anything. open: V_c [m^d].
template <class Real, int Dim, class Face, class BedOf, class ShareOf>
MORAINE_HD void open_rows(Real open, const Face& face, const BedOf& bed, const ShareOf& share_of,
                          OpenCell<Real, Dim>& cell) {
    const Real x = cell.share, full = cell.particles / open;
    const Real phi = (full < Real(1) ? full : Real(1)) * (Real(1) - x);
    cell.bears = phi + x;
    for (int a = 0; a < Dim; ++a) cell.bed[a] = Real(0);
    for (int i = 0; i < cell.nodes; ++i) {
        const bool holds = share_of(i) >= Real(0);
        const Real of_row = x * share_of(i);
        for (int a = 0; a < Dim; ++a) {
            if (!holds) cell.factor[i].gradient[a] = Real(0);
            if (!holds) continue;
            const Real borne = phi * bed(i, a) + of_row * face(i, a);
            cell.factor[i].gradient[a] = (Real(1) - x) * cell.factor[i].gradient[a] + borne;
            cell.bed[a] += borne;
        }
    }
    cell.state.volume = (Real(1) - x) * cell.particles + x * open;
}

}  // namespace moraine
