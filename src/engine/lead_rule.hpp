#pragma once
// Steps that a device makes by itself, ahead of the reports that the simulation has taken: how each dt is made, and
// when the device must stop, because the particles are to be read, or the host has to decide.
//
//   dt = C h / (c + |v|), or what the scene says;   t += dt;   integral of gravity += g dt
//
// These are the operations of Simulation::agree_on_dt() and EpochLifetime::step(), in their order, so that an engine
// that leads and the simulation that follows agree bitwise: products are not contracted on a device either. One pure
// function serves both: what stops a device is tested on the host.

#include <cstdint>

#include "blocks/epoch_lifetime.hpp"
#include "core/data/rounded_product.hpp"

namespace moraine {

/// In longer steps the device does not wait for the host, and the end of a lead costs more than it saved: one NVIDIA
/// H200, single precision, 2.1 million particles 3 to 4 % faster, 16.8 and 64 million 2 and 1 % slower.
inline constexpr std::int64_t most_led_particles = 4'000'000;

template <int Dim>
struct LeadRule {
    double dt;     ///< that the scene says [s]; 0: by the signal
    double reach;  ///< C h [m]
    double end;    ///< of the run [s]
    double until;  ///< particles are read after the first step at or past it, not before [s]
    double gravity[Dim];
};

/// Where the run stands, between two steps.
template <int Dim>
struct LeadClock {
    double time;
    double dt;  ///< of the next step, once goes_on() says that there is one [s]
    double gravity_impulse[Dim];
    double in_guard_layer;  ///< as EpochLifetime counts it [cells]
    std::int64_t steps;     ///< that may still be made
};

/// What the report of the last step says.
struct LeadReport {
    double signal, moved;
    bool in_guard_layer;
    bool stops;  ///< a fault, or more blocks than there is space for
};

/// Whether the next step is made, by the report of the last one. If so the clock is that of the step's end.
template <int Dim>
MORAINE_HD bool goes_on(const LeadRule<Dim>& rule, const LeadReport& last, LeadClock<Dim>& clock) {
    clock.in_guard_layer = last.in_guard_layer ? clock.in_guard_layer + last.moved : 0;
    if (last.stops || clock.steps <= 0 || clock.in_guard_layer > EpochLifetime::reach) return false;
    if (clock.time >= rule.until || clock.time >= rule.end) return false;
    if (!(rule.dt > 0 || last.signal > 0)) return false;
    const double dt = rule.dt > 0 ? rule.dt : rule.reach / last.signal;
    if (!(rounded_product(dt, 1e12) >= rule.end - clock.time)) return false;  // Simulation::check_step()
    clock.dt = dt;
    for (int a = 0; a < Dim; ++a) clock.gravity_impulse[a] += rounded_product(rule.gravity[a], dt);
    clock.time += dt;
    --clock.steps;
    return true;
}

}  // namespace moraine
