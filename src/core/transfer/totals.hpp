#pragma once
// Totals of the flow for the records: mass, momentum, energies, extent. Only at output times.
//
// Each block gives doubles in list order; their sum over blocks and ranks is exact (exact_sum.hpp),
// so the records are the same on any number of ranks.

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "core/data/exact_sum.hpp"
#include "core/material/pore_water.hpp"
#include "core/nodes/node_energy.hpp"
#include "core/nodes/water_account.hpp"
#include "core/particles/law_batch.hpp"
#include "core/particles/particles.hpp"

namespace moraine {

/// The lesser of both, the greater of both: not a number where either is none, which std::min and std::max may drop.
inline double least(double a, double b) {
    return b < a || std::isnan(b) ? b : a;
}
inline double greatest(double a, double b) {
    return b > a || std::isnan(b) ? b : a;
}

/// A particle by the largest of a quantity, and where it is; what is not a number is larger than all. Equals are told
/// apart by place: the same of any order.
template <int Dim>
struct Extremum {
    double value = 0;
    std::array<double, Dim> x{};  ///< [m]

    void widen(const Extremum& o) {
        const bool none = std::isnan(value), other_none = std::isnan(o.value);
        if (none != other_none ? other_none : none ? x < o.x : std::tie(value, x) < std::tie(o.value, o.x)) *this = o;
    }
};

template <int Dim>
struct Totals {
    double mass = 0;                     ///< [kg]
    std::array<double, Dim> momentum{};  ///< [kg m/s]
    std::array<double, Dim> centre{};    ///< sum m x [kg m]
    double kinetic = 0;                  ///< with that of Darcy's flux [J]
    double strain = 0;                   ///< stored elastic energy, with that of pore water [J]
    Extremum<Dim> speed;                 ///< the fastest [m/s]
    Extremum<Dim> stretch;               ///< |ln J|, of those whose volume should stay (keeps_volume) [-]
    double min_J = std::numeric_limits<double>::infinity();
    double max_J = 0;
    double max_x = -std::numeric_limits<double>::infinity();  ///< furthest particle [m]

    static constexpr int sums = 3 + 2 * Dim;

    /// The additive ones, in a fixed order.
    std::array<double, sums> additive() const {
        std::array<double, sums> all{mass, kinetic, strain};
        std::copy(momentum.begin(), momentum.end(), all.begin() + 3);
        std::copy(centre.begin(), centre.end(), all.begin() + 3 + Dim);
        return all;
    }
    void set_additive(const std::array<double, sums>& all) {
        mass = all[0], kinetic = all[1], strain = all[2];
        std::copy_n(all.begin() + 3, Dim, momentum.begin());
        std::copy_n(all.begin() + 3 + Dim, Dim, centre.begin());
    }
    void widen(const Totals& o) {
        speed.widen(o.speed);
        stretch.widen(o.stretch);
        min_J = least(min_J, o.min_J);
        max_J = greatest(max_J, o.max_J);
        max_x = std::max(max_x, o.max_x);
    }
};

/// Totals of a part of the flow, on the way to those of all: sums that are exact, and extremes.
template <int Dim>
struct TotalSums {
    std::array<ExactSum, Totals<Dim>::sums> sum{};
    Totals<Dim> extremes;

    void add(const TotalSums& o) {
        for (std::size_t q = 0; q < sum.size(); ++q) sum[q].add(o.sum[q]);
        extremes.widen(o.extremes);
    }
    Totals<Dim> value(const Quantum& quantum) const {
        Totals<Dim> totals = extremes;
        std::array<double, Totals<Dim>::sums> whole{};
        for (std::size_t q = 0; q < sum.size(); ++q) whole[q] = quantum.value(sum[q]);
        totals.set_additive(whole);
        return totals;
    }
};

/// Adds what water in the pores of the particle in slot s has: energy of its flux, and stored by its pressure.
template <class Real, int Dim>
void add_water(Totals<Dim>& t, const ParticleView<Real, Dim>& p, std::uint32_t s, const PoreWater<Real>& pore) {
    if (!pore.is_wet()) return;
    const Real n = pore.porosity_at(p.ln_J[s]);
    const double volume = double(p.volume[s]), pressure = double(p.pore_pressure[s]);
    for (int a = 0; a < Dim; ++a) {
        const double w = double(p.darcy_velocity[s][a]), v = double(p.velocity[s][a]);
        t.kinetic += volume * w * (double(pore.density) * v + 0.5 * double(pore.inertia(n)) * w);
    }
    t.strain += 0.5 * volume * pressure * pressure / double(pore.storage(n));
}

/// Adds the particle in slot s at x [m]. keeps_volume: it is nearly incompressible.
template <class Real, int Dim>
void add_particle(Totals<Dim>& t, const ParticleView<Real, Dim>& p, std::uint32_t s, const std::array<double, Dim>& x,
                  const LawBatch<Real, Dim>& law, bool keeps_volume) {
    const double m = static_cast<double>(p.mass[s]);
    double square = 0;
    for (int a = 0; a < Dim; ++a) {
        const auto i = static_cast<std::size_t>(a);
        const double v = static_cast<double>(p.velocity[s][a]);
        t.momentum[i] += m * v;
        t.centre[i] += m * x[i];
        square += v * v;
    }
    t.mass += m;
    t.kinetic += 0.5 * m * square;
    t.strain += law.strain_energy(p, s);
    const double ln_J = static_cast<double>(p.ln_J[s]);
    const double J = std::exp(ln_J);
    t.speed.widen({std::sqrt(square), x});
    if (keeps_volume) t.stretch.widen({std::abs(ln_J), x});
    t.min_J = least(t.min_J, J);
    t.max_J = greatest(t.max_J, J);
    t.max_x = std::max(t.max_x, x[0]);
}

/// Accounts that grow step by step, on each rank for what it did; their sum over ranks is exact.
template <int Dim>
struct Budget {
    ExactSum work;                      ///< of the stresses [J]
    std::array<ExactSum, Dim> impulse;  ///< of walls and damping [kg m/s]
    ExactSum lost_mass;                 ///< through open walls [kg]
    std::array<ExactSum, Dim> lost_momentum;
    std::array<ExactSum, Dim> lost_gravity_impulse;  ///< sum of m_p times the integral of g up to its loss [kg m/s]
    std::int64_t lost_count = 0;
    ExactSum gravity_work;                       ///< of who changes gravity (core/gravity.hpp) [J]
    ExactSum load_work;                          ///< of tractions [J]
    std::array<ExactSum, Dim> load_impulse{};    ///< likewise [kg m/s]
    ExactSum slept_kinetic;                      ///< taken from what fell asleep, and from sleepers [J]
    std::array<ExactSum, Dim> slept_momentum{};  ///< likewise [kg m/s]
    EnergyAccount energy;                        ///< zero but in scenes that want it
    WaterAccount<Dim> water;                     ///< of water in the ground

    void add(const Budget& o) {
        work.add(o.work);
        lost_mass.add(o.lost_mass);
        gravity_work.add(o.gravity_work);
        load_work.add(o.load_work);
        slept_kinetic.add(o.slept_kinetic);
        energy.add(o.energy);
        water.add(o.water);
        for (std::size_t a = 0; a < Dim; ++a) {
            impulse[a].add(o.impulse[a]);
            lost_momentum[a].add(o.lost_momentum[a]);
            lost_gravity_impulse[a].add(o.lost_gravity_impulse[a]);
            slept_momentum[a].add(o.slept_momentum[a]);
            load_impulse[a].add(o.load_impulse[a]);
        }
        lost_count += o.lost_count;
    }
};

}  // namespace moraine
