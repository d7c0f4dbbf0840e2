#pragma once
// Water in the pores of soil: velocities of the soil and of its water on nodes, one pore pressure and the mean of the
// effective stress on cells (docs/theory/water.md).
//
//   nodes   a, R, w from particles (SumFlow), then (nodes/water_nodes.hpp)
//           m_i dv + b_i dw = dts (f_i + m_i g + F_i),   b_i dv + a_i dw = dts (b_i g + F_i - R_i (w_i + dw))
//   cells   F_i = -sum_c G_ic P_c,   f_i = (deviators, loads) - sum_c G_ic P'_c          P = -p: tension positive
//           dl_c = dts (sum_i G_ic . v_i / V_c - t/2 tr(L L))                            the soil's
//           dP_c = Q_c (dl_c + dts sum_i G_ic . w_i / V_c - spread_c)
//   end     p_p -= Q_p dP_c / Q_c,   the law gets dL with the cell's dl_c, and its mean stress is P' of the next step
//
// G, V_c and what is loose are those of grid_pressure.hpp, whose cells these are: one G for v and w, and its transpose
// for both forces, so that but for drag energy only changes hands. A cell that is not whole is bounded by
// K' + Q under the mass that v and w have together.
//
// spread: pressures of alternating sign push no node, so no flux drains them (7 patterns in 3-D). Per axis, of three
// full cells in a row with B2 P = P_-1 - 2 P_0 + P_1 of the start of the step:
//   spread_c = kappa dts h^(d-2) / (4 V_c) (B2^T B2 P)_c,     kappa = min(k / gamma_w, 0.2 h^2 / (4 d Q dts))
// It is what Darcy's law over faces does beyond G^T G, leaves linear pressures alone and takes energy only. A cell's
// pressure travels as a value of the node in its middle, with the sums of SumFlow; B2^T B2 P with the forces.

#include "core/fluid/grid_pressure.hpp"
#include "core/material/pore_water.hpp"

namespace moraine {

/// What a cell holds besides CellPressure, whose modulus is Q here.
template <class Real>
struct WaterCell {
    Real effective;  ///< P', as the cell bears it [Pa]
    Real increment;  ///< dl of the soil so far [-]
};

}  // namespace moraine
