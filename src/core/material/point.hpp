#pragma once
// What a constitutive law sees of one particle, and how a law describes its parameters.
//
// A law is a small struct template <class Real> with
//   static constexpr const char* name;                  as in material.law
//   static constexpr int history;                       scalars remembered per particle, 0 to max_history
//   static constexpr const char* history_names[];       output names, when history > 0
//   static constexpr bool uses_left_stretch;            needs b = F Fᵀ, kept as b - I
//   static constexpr Parameter parameters[];            keys of [[material]], in the order of the constructor
//   explicit Law(const double* values);                 host only; parameters in that order, then derived constants
//   template <int Dim> void update(const StrainIncrement<Real, Dim>&, PointState<Real, Dim>&) const;
//   Real wave_modulus(state) const;                     K + 4G/3 now: rho c^2               [Pa]
//   Real strain_energy(state) const;                    stored elastic energy per current volume [J/m3]
//   static const char* problem(const double* values);   nullptr, or what is wrong between parameters
// update() gets a state whose stress is that of the start of the step and leaves Cauchy stress at
// its end (tension positive); ln_J and b (left_stretch.hpp) have been advanced by the caller. A law may take
// volume out of ln_J that its material does not fill (gap.hpp); what it leaves there is the particle's volume.

#include <limits>

#include "core/material/left_stretch.hpp"
#include "core/strain.hpp"
#include "core/vec.hpp"

namespace moraine {

/// Scalars that a law may keep; more is a compile error. Those that no law of a scene has cost it nothing.
inline constexpr int max_history = 4;

template <class Real, int Dim>
struct PointState {
    Sym<Real, Dim> stress;        ///< Cauchy stress, tension positive [Pa]
    Sym<Real, Dim> left_stretch;  ///< b - I, b = F Fᵀ, only where the law uses it [-]
    Real ln_J;                    ///< logarithm of the volume ratio [-]
    Real history[max_history];    ///< the law's own scalars
};

/// One key of a [[material]] table.
struct Parameter {
    const char* key;
    const char* unit;
    double standard;  ///< default; NaN: must be given
    double lower;
    double upper;
    bool open;  ///< the bounds themselves are not allowed
    const char* meaning;
};

inline constexpr double required = std::numeric_limits<double>::quiet_NaN();
inline constexpr double unbounded = std::numeric_limits<double>::infinity();

}  // namespace moraine
