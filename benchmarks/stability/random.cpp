// S22: random scenes at a random share of the program's own step. S23: thin ones at the whole of it, S24: fluids whose
// pressure is the grid's, S28: saturated soil.

#include <fmt/format.h>

#include "method_name.hpp"
#include "scene/scene_defaults.hpp"
#include "stability/cases.hpp"
#include "verification/fluid_scene.hpp"
#include "verification/random_run.hpp"
#include "verification/thin_scene.hpp"
#include "verification/wet_scene.hpp"

namespace moraine {

namespace {

using namespace verification;

constexpr int steps = 240, thin_steps = 2000;

std::string description_of(const Scene& scene) {
    std::string laws, ends;
    for (const MaterialSpec& m : scene.materials) laws += (laws.empty() ? "" : " + ") + m.law;
    return fmt::format("{}-D {}, {}, cfl {:.3g}{}{}", scene.dimensions,
                       method_name(scene.shape, scene.transfer, scene.stress_update), laws, scene.cfl,
                       scene.boundary_spline ? "" : ", plain ghosts", scene.structures.empty() ? "" : ", structure");
}

std::string grid_pressure_of(const Scene& scene) {
    const MaterialSpec& m = scene.materials[0];
    return fmt::format("nu {:.5g}, {} substeps, smoothing {:.2g}, shifts {:.2g}", poisson_ratio(m), scene.substeps,
                       m.pressure_smoothing, m.particle_shifting);
}

Verdict judge(const Scene& scene, int length, Kinetic kinetic) {
    return scene.dimensions == 2 ? verification::judge<double, 2>(scene, length, kinetic)
                                 : verification::judge<double, 3>(scene, length, kinetic);
}

std::string why(const Verdict& v) {
    if (!v.fault.empty()) return v.fault;
    if (v.lost > 0) return fmt::format("{} particles lost", v.lost);
    if (v.momentum > 1e-10) return fmt::format("momentum error {:.2g}", v.momentum);
    if (v.noise > 0.5) return fmt::format("a checkerboard of {:.2g}", v.noise);
    return v.created > 1e-6 ? fmt::format("energy grows by {:.2g} per step", v.created) : "";
}

Finding finding_of(const std::string& description, const Verdict& v) {
    return {description,
            {{"particles", v.particles}, {"momentum", v.momentum}, {"created", v.created}},
            v.stands(),
            why(v)};
}

std::string water_of(const Scene& scene) {
    const MaterialSpec& m = scene.materials[0];
    return fmt::format("{}, h {:.2g}, E {:.2g}, nu {:.2f}, n {:.2f}, k {:.1e}, K_w {:.1e}{}", m.law, scene.cell,
                       m.parameters[0], poisson_ratio(m), m.porosity, m.conductivity, scene.water.bulk,
                       scene.water.submerged ? ", submerged" : "");
}

}  // namespace

void run_random(const Wanted& wanted, const Report& report) {
    for (int n = wanted.first; n < wanted.first + wanted.count; ++n) {
        Scene scene = random_scene(static_cast<std::uint64_t>(n));
        scene.cfl = standard_courant(scene) * random_share(static_cast<std::uint64_t>(n));
        const std::string description = fmt::format("scene {}: {}", n, description_of(scene));
        if (!wanted.names(description)) continue;
        report(finding_of(description, judge(scene, steps, Kinetic::of_velocities)));
    }
}

void run_thin(const Wanted& wanted, const Report& report) {
    for (int n = wanted.first; n < wanted.first + wanted.count; ++n) {
        const auto number = static_cast<std::uint64_t>(n);
        Scene scene = thin_scene(number);
        const std::string description =
            fmt::format("scene {}: {}, {}", n, name_of(thin_kind(number)), description_of(scene));
        if (!wanted.names(description)) continue;
        scene.limits_light_nodes = !wanted.free;
        report(finding_of(description, judge(scene, thin_steps, Kinetic::with_affine)));
    }
}

void run_fluids(const Wanted& wanted, const Report& report) {
    for (int n = wanted.first; n < wanted.first + wanted.count; ++n) {
        const auto number = static_cast<std::uint64_t>(n);
        Scene scene = fluid_scene(number);
        if (wanted.defaults) take_defaults(scene, Places(""));
        const std::string description = fmt::format("scene {}: {}, {}, {}", n, name_of(fluid_kind(number)),
                                                    description_of(scene), grid_pressure_of(scene));
        if (wanted.names(description)) report(finding_of(description, judge(scene, thin_steps, Kinetic::with_affine)));
    }
}

void run_wet(const Wanted& wanted, const Report& report) {
    for (int n = wanted.first; n < wanted.first + wanted.count; ++n) {
        const auto number = static_cast<std::uint64_t>(n);
        const Scene scene = wet_scene(number);
        const std::string description =
            fmt::format("scene {}: {}, {}-D {}, cfl {:.3g}, {}", n, name_of(wet_kind(number)), scene.dimensions,
                        method_name(scene.shape, scene.transfer, scene.stress_update), scene.cfl, water_of(scene));
        if (wanted.names(description)) report(finding_of(description, judge(scene, thin_steps, Kinetic::with_affine)));
    }
}

}  // namespace moraine
