#pragma once
// What a scene may do for its fluids (pressure_smoothing.hpp, particle_shifting.hpp, grid_pressure.hpp), each alone and
// together, with the values that the pages on them measure; and the transfers that take it.

#include "core/fluid/grid_pressure.hpp"
#include "verification/run.hpp"

namespace moraine {

struct Cure {
    const char* name;
    double smoothing, shifting;
    bool grid = false;
    int substeps = 1;  ///< most of a step
};

inline constexpr Cure cures[] = {
    {"plain", 0, 0},
    {"smoothed", 0.22, 0},
    {"shifted", 0, 0.2},
    {"both", 0.22, 0.2},
    {"grid", 0, 0, true},
    {"grid with both", 0.22, 0.2, true},
    {"grid in substeps", 0, 0, true, most_substeps},
    {"grid in substeps with both", 0.22, 0.2, true, most_substeps},
    {"grid in substeps, smoothed", 0.22, 0, true, most_substeps},
    {"grid in substeps, shifted", 0, 0.2, true, most_substeps},
};

inline constexpr const Cure& shipped = cures[7];  ///< what the scenes of fluids in inputs/ have

inline constexpr verification::Choice cured_methods[] = {
    {"PIC", Shape::quadratic, Transfer::pic, StressUpdate::usl},
    {"FLIP", Shape::quadratic, Transfer::flip, StressUpdate::usl},
    {"APIC", Shape::quadratic, Transfer::apic, StressUpdate::usl},
    {"TPIC", Shape::quadratic, Transfer::tpic, StressUpdate::usl},
    {"AFLIP", Shape::quadratic, Transfer::aflip, StressUpdate::usl},
};

/// Of all its materials.
inline void cure_fluid(Scene& scene, const Cure& cure) {
    for (MaterialSpec& m : scene.materials) {
        m.pressure_smoothing = cure.smoothing;
        m.particle_shifting = cure.shifting;
        if (cure.grid) m.volumetric = Volumetric::grid;
    }
    scene.substeps = cure.substeps;
}

}  // namespace moraine
