#pragma once
// The state of a run that is not in its particles.

#include <array>
#include <cstdint>
#include <vector>

#include "core/nodes/absorbing_ends.hpp"

namespace moraine {

/// When a stage began, and what it took away then.
struct StageBegin {
    double time = 0;  ///< [s]
    std::int64_t step = 0;
    double removed_mass = 0;    ///< [kg]
    double removed_energy = 0;  ///< kinetic, stored and potential [J]
    double added_mass = 0;      ///< [kg]
};

/// Where a run stands, apart from its particles; the same on all ranks, and what a checkpoint keeps.
template <int Dim>
struct RunClock {
    std::int64_t step = 0;
    double time = 0;                            ///< [s]
    double dt = 0;                              ///< of the last step [s]
    double signal = 0;                          ///< largest c + |v|, for the next step [m/s]
    double square_speed = 0;                    ///< largest |v|^2 likewise, with the grid's pressure [m2/s2]
    std::array<double, Dim> gravity{};          ///< of the last step; before the first, that of the start [m/s2]
    std::array<double, Dim> gravity_impulse{};  ///< integral of gravity over time [m/s]
    double mass_cutoff = 0;                     ///< nodes below take no part [kg]
    double quantum_scale = 1;                   ///< of the exact sums
    double start_strain = 0;                    ///< stored energy at the start [J]
    std::array<double, Dim> start_momentum{};
    double start_mass = 0;
    double start_energy = 0;     ///< kinetic, stored and potential [J]
    double start_potential = 0;  ///< of it [J]
    std::int64_t round = 0;      ///< partitions made
    double sleep_check = -1;     ///< when the last sleep check was, and its step; -1: none was [s]
    std::int64_t sleep_step = 0;
    std::vector<StageBegin> stages;  ///< that have begun; the last one is under way
    EndNodes<Dim> ends;              ///< as they were last measured
};

}  // namespace moraine
