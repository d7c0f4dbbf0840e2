#pragma once
// Scenes in stages, which a test begins by Simulation::begin_stage().

#include "sample_scenes.hpp"

namespace moraine::test {

/// First as it is; then damped, with half of its strengths, on floors with friction and with another box; then without
/// its first body.
inline Scene in_stages(Scene s, const BodySpec& comes) {
    StageSpec begin, weak, dug;
    begin.materials = s.materials, begin.walls = s.walls, begin.tractions = s.course.tractions;
    begin.until = s.end;
    weak = begin;
    begin.name = "begin", weak.name = "weak";
    weak.damping = 0.3;
    weak.walls[static_cast<std::size_t>(s.dimensions - 1)][0] = {WallKind::friction, 0.2};
    for (MaterialSpec& m : weak.materials) {
        const LawInfo& law = *find_law(m.law);
        for (const char* key : {"su", "yield_stress", "cohesion", "friction_angle"})
            if (const int k = parameter_named(law, key); k >= 0) m.parameters[static_cast<std::size_t>(k)] /= 2;
    }
    dug = weak;
    dug.name = "dug", dug.damping = 0, dug.removes = {0};
    s.course.stages = {begin, weak, dug};
    s.bodies.push_back(comes);
    s.bodies.back().stage = 1;
    return s;
}

/// Runs all stages, of so many steps each.
template <class Simulation>
void run_stages(Simulation& sim, int steps) {
    for (;;) {
        for (int k = 0; k < steps; ++k) sim.step(), sim.balance();
        if (sim.is_last_stage()) return;
        sim.begin_stage();
    }
}

}  // namespace moraine::test
