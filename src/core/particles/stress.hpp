#pragma once
// One particle's stress update: strain increment, law, volume, and what the step control must know.
//
//   V = (m / rho0) exp(ln J), ln J as the law leaves it,    c^2 = M J / rho0   (M = K + 4G/3 now),    signal = c + |v|
//   work of the step: V (sigma_n + sigma_n+1)/2 : de

#include <cmath>

#include "core/material/left_stretch.hpp"
#include "core/material/point.hpp"
#include "core/material/strain.hpp"
#include "core/particles/particle_state.hpp"

namespace moraine {

/// What went wrong on a particle, as bits; the highest is reported first.
enum Fault : std::uint32_t {
    fault_none = 0,
    fault_far = 1,        ///< moved a whole cell or more in one step
    fault_left = 2,       ///< left a closed domain
    fault_inverted = 4,   ///< det(I + dL) <= 0
    fault_nan = 8,        ///< velocity or stress is not a number
    fault_buried = 16,    ///< more than a cell under the ground
    fault_porosity = 32,  ///< its pores have closed, or are all of it
};

/// What one block's particles tell the step control.
struct BlockOutcome {
    double signal = 0;            ///< largest c + |v| [m/s]
    double moved = 0;             ///< largest displacement along an axis in this step [cells]
    double work = 0;              ///< of the stresses in this step [J]
    double square_speed = 0;      ///< largest |v|^2, with the grid's pressure [m2/s2]
    double load_work = 0;         ///< of tractions in this step [J]
    double load_impulse[3] = {};  ///< likewise [kg m/s]
    double weight_work = 0;       ///< of pore water's weight in load_force [J]
    double weight_impulse[3] = {};
    std::uint32_t faults = 0;
    std::uint32_t clamped = 0;                    ///< contiguous GIMP boxes held at half a cell
    std::uint64_t faulty_id = ~std::uint64_t(0);  ///< lowest id with a fault

    MORAINE_HD void fault(std::uint32_t bit, std::uint64_t id) {
        faults |= bit;
        if (id < faulty_id) faulty_id = id;
    }
};

/// a : b
template <class Real, int Dim>
MORAINE_HD Real contract(const Sym<Real, Dim>& a, const Sym<Real, Dim>& b) {
    Real sum = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    for (int k = 3; k < Sym<Real, Dim>::size; ++k) sum += Real(2) * a[k] * b[k];
    return sum;
}

template <class Law, class Real, int Dim>
MORAINE_HD PointState<Real, Dim> load_point(const Law& law, const ParticleView<Real, Dim>& p, std::uint32_t s) {
    PointState<Real, Dim> state;
    state.stress = p.stress[s];
    state.ln_J = p.ln_J[s];
    for (int k = 0; k < scalars_of(law); ++k) state.history[k] = p.history[k][s];
    if constexpr (Law::uses_left_stretch) state.left_stretch = p.left_stretch[s];
    return state;
}

/// Largest speed at which the particle can tell others of itself: c + |v| [m/s].
template <class Law, class Real, int Dim>
MORAINE_HD Real signal_speed(const Law& law, const PointState<Real, Dim>& state, const Vec<Real, Dim>& v, Real J,
                             Real inverse_density) {
    using std::sqrt;
    Real square = Real(0);
    for (int a = 0; a < Dim; ++a) square += v[a] * v[a];
    return sqrt(law.wave_modulus(state) * J * inverse_density_of(law, state, inverse_density)) + sqrt(square);
}

/// What a step of one point tells besides its new state.
template <class Real>
struct PointStep {
    Real volume;           ///< at the end [m3]
    double work;           ///< of the stresses [J]
    double signal;         ///< c + |v| at the end [m/s]
    std::uint32_t faults;  ///< bits of Fault
};

/// What a point of mass m and velocity v tells, whose state is that after the step. before: its stress before it;
/// inverse_density: 1/rho0 of the material [m3/kg].
template <class Law, class Real, int Dim>
MORAINE_HD PointStep<Real> point_step(const Law& law, const StrainIncrement<Real, Dim>& increment,
                                      const Sym<Real, Dim>& before, const PointState<Real, Dim>& state, Real mass,
                                      const Vec<Real, Dim>& v, Real inverse_density) {
    using std::exp;
    const Real J = exp(state.ln_J);
    PointStep<Real> step;
    step.volume = mass * inverse_density_of(law, state, inverse_density) * J;
    step.work = double(step.volume) * 0.5 *
                double(contract(before, increment.middle) + contract(state.stress, increment.middle));
    step.signal = double(signal_speed(law, state, v, J, inverse_density));
    step.faults = fault_none;
    if (!(increment.stretch > Real(0))) step.faults |= increment.stretch <= Real(0) ? fault_inverted : fault_nan;
    if (!(step.signal < 1e300) || !(contract(state.stress, state.stress) >= Real(0))) step.faults |= fault_nan;
    return step;
}

/// The point after the step.
template <class Law, class Real, int Dim>
MORAINE_HD PointStep<Real> advance_point(const Law& law, const StrainIncrement<Real, Dim>& increment,
                                         PointState<Real, Dim>& state, Real mass, const Vec<Real, Dim>& v,
                                         Real inverse_density) {
    const Sym<Real, Dim> before = state.stress;
    state.ln_J += increment.volumetric;
    if constexpr (Law::uses_left_stretch) state.left_stretch = advanced(state.left_stretch, increment.gradient);
    law.update(increment, state);
    return point_step(law, increment, before, state, mass, v, inverse_density);
}

/// Writes the state of the particle in slot s, and what its step tells.
template <class Law, class Real, int Dim>
MORAINE_HD void store_point(const Law& law, const ParticleView<Real, Dim>& p, std::uint32_t s,
                            const PointState<Real, Dim>& state, const PointStep<Real>& step, BlockOutcome& out) {
    p.stress[s] = state.stress;
    p.ln_J[s] = state.ln_J;
    p.volume[s] = step.volume;
    for (int k = 0; k < scalars_of(law); ++k) p.history[k][s] = state.history[k];
    if constexpr (Law::uses_left_stretch) p.left_stretch[s] = state.left_stretch;
    out.work += step.work;
    if (step.signal > out.signal) out.signal = step.signal;
    if (step.faults) out.fault(step.faults, p.id[s]);
}

}  // namespace moraine
