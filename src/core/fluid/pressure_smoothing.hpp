#pragma once
// Pressure smoothing: a particle of what flows (material/point.hpp) takes a share of the grid's pressure in each step.
//
//   Q_i = sum_p w_ip m_p Q_p / m_i,    Q_p = P_p + rho g . x_p,    P_p = tr sigma_p / 3
//   P_p <- P_p + a (sum_i w_ip Q_i - Q_p),    ln J_p <- ln J_p + a (sum_i w_ip Q_i - Q_p) / K,    a = min(1/2, k c dt /
//   h)
//
// Q is the piezometric pressure, the same everywhere in a fluid at rest: nodes at a bed and at the surface see one side
// only, and the mean of P itself is wrong there by a share of rho g h in every step, which the fluid answers by
// sinking. rho is that of the first material that smooths.
//
// before the stress update. Every particle integrates a divergence of its own, and nodes see about one of the four to
// nine in a cell: the rest is pressure that no force answers, and grows. a per time and wave is the same at every step
// and cell size. ln J changes with P, so that volume and pressure stay one state: sum m_p ln J_p is kept (weights add
// up to one, constants are exact). Means over cells (volumetric.hpp) do more of the same at once, and need a pass of
// their own.
//
// Density diffusion of delta-SPH (Antuono et al. 2010) is the model; averages by the transfer: Zhao, Jiang, Choo 2022.

#include "core/data/vec.hpp"
#include "core/grid/volumetric.hpp"

namespace moraine {

/// What a fluid's particles take from the grid besides their motion, by body.
template <class Real>
struct FluidTerms {
    Real smoothing;   ///< k c / h [1/s]; 0: none
    Real compliance;  ///< 1 / K [1/Pa]
    Real shifting;    ///< n gamma c h [m2/s]; 0: none (particle_shifting.hpp)
};

/// rho g.x of a particle at fractions f of the cell whose stencil begins at node base[] [Pa]. slope: rho g h.
template <class Real, int Dim>
MORAINE_HD Real gravity_pressure(const Vec<Real, Dim>& slope, const int* base, const Real* f) {
    Real sum = Real(0);
    for (int a = 0; a < Dim; ++a) sum += slope[a] * (Real(base[a]) + f[a]);
    return sum;
}

/// a of a step.
template <class Real>
MORAINE_HD Real smoothing_share(Real smoothing, Real dt) {
    const Real share = smoothing * dt;
    return share < Real(0.5) ? share : Real(0.5);
}

/// Takes the share, if its body smooths. towards: the pressure around the particle [Pa].
template <class Real>
MORAINE_HD void smooth_pressure(const FluidTerms<Real>& fluid, Real dt, Real towards, auto& particle) {
    if (!(fluid.smoothing > Real(0))) return;
    const Real own = (particle.stress(0) + particle.stress(1) + particle.stress(2)) * Real(1.0 / 3.0);
    const Real step = smoothing_share(fluid.smoothing, dt) * (towards - own);
    for (int a = 0; a < 3; ++a) particle.stress(a) += step;
    particle.ln_J() += step * fluid.compliance;
}

}  // namespace moraine
