#pragma once
// Gravity of a step (core/gravity.hpp): the mean of its length, once dt is agreed on.

#include <algorithm>
#include <limits>

#include "core/gravity.hpp"
#include "engine/engine.hpp"
#include "simulation/run_clock.hpp"

namespace moraine {

template <int Dim>
std::array<double, Dim> components(const Triple& t) {
    std::array<double, Dim> c;
    std::copy_n(t.begin(), Dim, c.begin());
    return c;
}

/// When the base begins to shake; never: the stage is still to come [s].
template <int Dim>
double shaking_begin(const Scene& scene, const RunClock<Dim>& clock) {
    const int stage = scene.course.shaking.stage;
    if (stage < 0) return 0;
    const auto k = static_cast<std::size_t>(stage);
    return k < clock.stages.size() ? clock.stages[k].time : std::numeric_limits<double>::infinity();
}

/// Whether all steps from now on have the gravity of the last one.
template <int Dim>
bool gravity_stays(const Scene& scene, const RunClock<Dim>& clock) {
    const double begin = shaking_begin(scene, clock), t = clock.time;
    if (!scene.course.shaking.table.empty())
        return t >= std::max(scene.course.gravity.end(), begin + scene.course.shaking.table.end()) &&
               clock.gravity == components<Dim>(gravity_over(scene, t, t + clock.dt, begin));
    return t >= scene.course.gravity.end() && clock.gravity == components<Dim>(gravity_at(scene, t));
}

/// Sets the gravity of the step of clock.dt and adds up its integral. Where it is another than that of the step before,
/// the work on this rank's particles goes to the budget: between binning and the gather. Not collective.
template <class Real, int Dim>
void begin_gravity(const Scene& scene, const PlanPlaces& places, Engine<Real, Dim>& engine, RunClock<Dim>& clock,
                   Budget<Dim>& budget) {
    const auto now =
        components<Dim>(gravity_over(scene, clock.time, clock.time + clock.dt, shaking_begin(scene, clock)));
    if (now != clock.gravity) {
        GravityQuery<Dim> query{places, {}, {clock.quantum_scale}, {}};
        for (std::size_t a = 0; a < Dim; ++a) query.change[a] = now[a] - clock.gravity[a];
        engine.answer(&query);
        budget.gravity_work.add(query.work);
        clock.gravity = now;
    }
    for (std::size_t a = 0; a < Dim; ++a) clock.gravity_impulse[a] += now[a] * clock.dt;
}

}  // namespace moraine
