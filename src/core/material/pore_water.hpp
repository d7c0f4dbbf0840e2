#pragma once
// Soil whose pores are full of water, at a point: what follows from its porosity (fluid/water_cells.hpp has the
// method).
//
//   n = 1 - (1 - n0) / J                    porosity, grains of constant volume                          [-]
//   Q = K_w / n                             storage: dp = -Q div(v + w) dt, grains and skeleton rigid    [Pa]
//   a = rho_w / n                           inertia of Darcy's flux w = n (v_w - v)                      [kg/m3]
//   R = gamma_w / k                         drag of Darcy's law, gamma_w = rho_w 9.81 m/s2               [N s/m4]
//   c^2 = (M a + Q (rho - 2 rho_w + a)) / (rho a - rho_w^2)        no wave is faster, whatever the drag
//
// c^2 is the sum of the largest eigenvalues of the skeleton's part and the water's of
// c^2 [[rho, rho_w], [rho_w, a]] x = [[M + Q, Q], [Q, Q]] x, within 0.1 % of the fast wave where Q >> M. Biot (1956)
// with incompressible grains; Zienkiewicz et al. (1980), who drop the convection of water relative to the soil, too.

#include <cmath>

#include "core/data/block.hpp"

namespace moraine {

/// Of the hydraulic conductivity k, which is measured in water under this [m/s2].
inline constexpr double conductivity_gravity = 9.81;

/// Of one body.
template <class Real>
struct PoreWater {
    Real porosity = Real(0);      ///< n0; 0: dry [-]
    Real resistance = Real(0);    ///< R [N s/m4]
    Real skeleton = Real(0);      ///< M = K' + 4G/3 [Pa]
    Real drained_bulk = Real(0);  ///< K' [Pa]
    Real density = Real(0);       ///< rho_w [kg/m3]
    Real bulk = Real(0);          ///< K_w [Pa]
    Real start_volume = Real(0);  ///< of a mass, at the start [m3/kg]
    bool submerged = false;       ///< p is what is in excess of still water

    MORAINE_HD bool is_wet() const { return porosity > Real(0); }
    /// n, held between bounds that end the run (WaterTerm).
    MORAINE_HD Real porosity_at(Real ln_J) const {
        using std::exp;
        const Real n = Real(1) - (Real(1) - porosity) * exp(-ln_J);
        return n < Real(least_porosity) ? Real(least_porosity) : n > Real(most_porosity) ? Real(most_porosity) : n;
    }
    /// What a particle weighs besides its own mass: water that came or went since the start, or less all the water that
    /// its volume displaced then [kg].
    MORAINE_HD Real more_mass(Real mass, Real volume) const {
        const Real before = mass * start_volume;
        return density * (submerged ? -before : volume - before);
    }
    MORAINE_HD Real storage(Real n) const { return bulk / n; }
    MORAINE_HD Real inertia(Real n) const { return density / n; }
    /// c [m/s]; rho: of soil and water [kg/m3].
    MORAINE_HD Real wave_speed(Real n, Real rho) const {
        using std::sqrt;
        const Real a = inertia(n);
        return sqrt((skeleton * a + storage(n) * (rho - Real(2) * density + a)) / (rho * a - density * density));
    }

    static constexpr double least_porosity = 0.01, most_porosity = 0.99;
};

}  // namespace moraine
