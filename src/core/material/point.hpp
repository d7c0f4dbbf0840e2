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
// and, where it wants them,
//   Hypoelastic<Real> elastic;                          whose trial stress update() begins with, and
//   template <int Dim> void after_trial(const StrainIncrement<Real, Dim>&, PointState<Real, Dim>&) const;
//                                                       the rest of it: the host makes trials of several particles at
//                                                       once (law_batch.cpp)
//   const char* begin(const BodyStart&, PointState&) const;   host only: its scalars at the start, from the body's keys
//                                                       and the initial stress; nullptr, or why there are none
//   static constexpr bool flows = true;                 its particles may be shifted, and its pressure be that of the
//                                                       grid: beyond a strength no shape is remembered, and the mean
//                                                       stress is K times the change of volume
//   static constexpr bool is_fluid = true;              flows, and devices have kernels for that; may have substeps
//   static constexpr DeviceBlocks device_blocks;        registers of its kernels (below)
//   static constexpr int over_depth[];                  parameters that may be each particle's own, young first
//   Law of(const OwnProperties<Real>&) const;           the law of such a particle (over_depth.hpp)
// update() gets a state whose stress is that of the start of the step and leaves Cauchy stress at
// its end (tension positive); ln_J and b (left_stretch.hpp) have been advanced by the caller. A law may take
// volume out of ln_J that its material does not fill (gap.hpp); what it leaves there is the particle's volume.

#include <limits>

#include "core/data/vec.hpp"
#include "core/material/left_stretch.hpp"
#include "core/material/strain.hpp"

namespace moraine {

/// Scalars that a law may keep; more is a compile error. Those that no law of a scene has cost it nothing.
inline constexpr int max_history = 6;

template <class Real, int Dim>
struct PointState {
    Sym<Real, Dim> stress;        ///< Cauchy stress, tension positive [Pa]
    Sym<Real, Dim> left_stretch;  ///< b - I, b = F Fᵀ, only where the law uses it [-]
    Real ln_J;                    ///< logarithm of the volume ratio [-]
    Real history[max_history];    ///< the law's own scalars
};

/// What the keys of a body tell a law of its particles at the start.
struct BodyStart {
    double over_consolidation_ratio = 1;  ///< [-]
};

/// Whether a law has a state at the start that is not zero.
template <class Law, class Real>
concept HasInitialState = requires(const Law& law, PointState<Real, 3>& state) {
    law.begin(BodyStart{}, state);
};

/// The law's scalars at the start; the others of the state are set. nullptr, or why there are none. Host only.
template <class Law, class Real, int Dim>
const char* begin_point(const Law& law, const BodyStart& start, PointState<Real, Dim>& state) {
    if constexpr (HasInitialState<Law, Real>) return law.begin(start, state);
    return nullptr;
}

/// Thread blocks of a device's multiprocessor that leave the kernels with a law the registers they need: fewer blocks,
/// more registers. A kernel that spills fails the build (scripts/kernel-table), which is where a law learns its
/// numbers.
struct DeviceBlocks {
    int plain = 5;            ///< gather with stress, single precision
    int averaged = 5;         ///< the same with means of cells (volumetric.hpp)
    int affine = 5;           ///< APIC, TPIC
    int affine_averaged = 4;  ///< both
    int split = 5;            ///< stress in a kernel of its own
    int double_fused = 3, double_split = 3;
};

template <class Law>
constexpr DeviceBlocks device_blocks_of() {
    if constexpr (requires {
                      typename Law::Uniform;
                      Law::device_blocks_over_depth;
                  })
        return Law::device_blocks_over_depth;
    else if constexpr (requires { Law::device_blocks; })
        return Law::device_blocks;
    else
        return {};
}

/// Scalars that the law keeps of a particle: of some which are not known before the scene is.
template <class Law>
MORAINE_HD constexpr int scalars_of(const Law& law) {
    if constexpr (requires { law.scalars(); })
        return law.scalars();
    else
        return Law::history;
}

/// 1/rho0 of a particle [m3/kg].
template <class Law, class State, class Real>
MORAINE_HD Real inverse_density_of(const Law& law, const State& state, Real of_material) {
    if constexpr (requires { law.inverse_density(state, of_material); })
        return law.inverse_density(state, of_material);
    else
        return of_material;
}

template <class Law>
constexpr bool is_fluid() {
    if constexpr (requires { Law::is_fluid; })
        return Law::is_fluid;
    else
        return false;
}

template <class Law>
constexpr bool flows() {
    if constexpr (requires { Law::flows; })
        return Law::flows;
    else
        return is_fluid<Law>();
}

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
