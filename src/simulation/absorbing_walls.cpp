#include "simulation/absorbing_walls.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "simulation/gravity_step.hpp"

namespace moraine {
namespace {

/// Impedances of the material of this name.
template <class Face>
void set_behind(const Scene& scene, const std::string& name, Face& face) {
    for (const MaterialSpec& m : scene.materials) {
        if (m.name != name) continue;
        const double poisson = poisson_ratio(m);
        face.p = m.density * wave_speed(m);
        face.s = face.p * std::sqrt((1 - 2 * poisson) / (2 - 2 * poisson));
    }
}

}  // namespace

template <class Real, int Dim>
void begin_ends(const Scene& scene, const Comm& comm, const MeasureEnds<Dim>& measure, Engine<Real, Dim>& engine,
                RunClock<Dim>& clock) {
    const std::size_t number = clock.stages.size();  // 0: no stages
    const WallSpecs& now = number == 0 ? scene.walls : scene.course.stages[number - 1].walls;
    EndQuery<Dim> query;
    bool any = false, asked = false;
    for (std::size_t a = 0; a < Dim; ++a)
        for (std::size_t s = 0; s < 2; ++s) {
            auto& face = query.face[a][s];
            face.absorbs = now[a][s].absorbs;
            const bool before = number > 1 && scene.course.stages[number - 2].walls[a][s].absorbs;
            face.asked = face.absorbs && !before;
            if (face.absorbs) set_behind(scene, now[a][s].material, face);
            any = any || face.absorbs, asked = asked || face.asked;
        }
    if (asked && measure) {
        query.gravity = components<Dim>(gravity_at(scene, clock.time));
        query.mass_cutoff = clock.mass_cutoff;
        measure(query);
        EndNodes<Dim> all = comm.all_gather(query.found);
        const auto by_node = [](const EndNode<Dim>& a, const EndNode<Dim>& b) { return a.node < b.node; };
        std::sort(all.begin(), all.end(), by_node);
        EndNodes<Dim> kept;  // of those before, what was not measured anew
        std::set_difference(clock.ends.begin(), clock.ends.end(), all.begin(), all.end(), std::back_inserter(kept),
                            by_node);
        clock.ends.clear();
        std::merge(all.begin(), all.end(), kept.begin(), kept.end(), std::back_inserter(clock.ends), by_node);
    }
    if (any || !clock.ends.empty()) engine.hold_ends(clock.ends);
}

template void begin_ends(const Scene&, const Comm&, const MeasureEnds<2>&, Engine<float, 2>&, RunClock<2>&);
template void begin_ends(const Scene&, const Comm&, const MeasureEnds<3>&, Engine<float, 3>&, RunClock<3>&);
template void begin_ends(const Scene&, const Comm&, const MeasureEnds<2>&, Engine<double, 2>&, RunClock<2>&);
template void begin_ends(const Scene&, const Comm&, const MeasureEnds<3>&, Engine<double, 3>&, RunClock<3>&);

}  // namespace moraine
