#include "app/check_report.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/courant.hpp"
#include "core/data/plan_samples.hpp"
#include "core/material/laws.hpp"
#include "core/rest_interval.hpp"
#include "core/sleep/scene_sleep.hpp"
#include "core/structures/ground_curvature.hpp"
#include "core/transfer/kernel_key.hpp"
#include "io/input_error.hpp"
#include "predict/prediction.hpp"
#include "predict/scene_warnings.hpp"
#include "predict/step_speed.hpp"
#include "scene/scene_check.hpp"
#include "scene/scene_defaults.hpp"
#include "scene/scene_keys.hpp"
#include "seeding/inflow.hpp"
#include "seeding/property_profile.hpp"
#include "seeding/seed_region.hpp"
#include "seeding/traction_place.hpp"

namespace moraine {
namespace {

std::string bytes_text(double bytes) {
    if (bytes < 1e9) return fmt::format("{:.1f} MB", bytes / 1e6);
    return fmt::format("{:.2f} GB", bytes / 1e9);
}

/// "terrain    200 x 100 heights, 5 m apart, from 812.3 to 1520 m, voellmy", and how sharply it bends; of the part that
/// the domain needs.
std::string terrain_lines(const Scene& scene, const Ground& ground, const std::string& law) {
    const auto [low, high] = std::minmax_element(ground.height.begin(), ground.height.end());
    std::string text = fmt::format("terrain    {} x {} heights, {:.6g} m apart, from {:.4g} to {:.4g} m, {}\n",
                                   ground.count[0], ground.count[1], ground.spacing, *low, *high, law);
    const double radius = least_radius(ground), wanted = 5 * scene.cell;
    if (radius > 1e4 * scene.cell) return text;
    text += fmt::format("           least radius of curvature {:.3g} m\n", radius);
    if (radius < wanted)
        text += fmt::format(
            "warning    that is less than 5 cells: soil may jump over it or rest on its edge. "
            "terrain.smooth = {:.6g}, or a smaller domain.cell?\n",
            wanted);
    return text;
}

/// "domain     from 0 0 -8 to 260 120 96 m", where the scene leaves it to the terrain.
std::string domain_line(const Scene& scene) {
    const auto corner = [&](const Triple& x) {
        return fmt::format("{:.10g} {:.10g}{}", x[0], x[1], scene.dimensions == 3 ? fmt::format(" {:.10g}", x[2]) : "");
    };
    return fmt::format("domain     from {} to {} m\n", corner(scene.min), corner(scene.max));
}

/// "structure  pipe: sphere, velocity, rough"
std::string structure_lines(const Scene& scene) {
    const auto word = [](const std::string& table, const std::string& key, int choice) {
        return key_of(structure_rows(), table, key).choices[static_cast<std::size_t>(choice)];
    };
    std::string text;
    for (const StructureSpec& s : scene.structures) {
        const std::string law = word("structure.contact", "law", static_cast<int>(s.law));
        text += s.ground
                    ? domain_line(scene) + terrain_lines(scene, *s.ground, law)
                    : fmt::format("structure  {}: {}, {}{}, {}{}\n", s.name,
                                  word("structure", "shape", static_cast<int>(s.shape)),
                                  word("structure.motion", "kind", static_cast<int>(s.motion.kind)),
                                  turns(s.motion) ? " and turns" : "", law, s.motion.collision ? ", meets others" : "");
    }
    return text;
}

/// "release    scar: 2412 m3, 3.5 cells thick"
std::string release_lines(const Scene& scene) {
    std::string text;
    for (const BodySpec& b : scene.bodies) {
        if (b.shape != BodyShape::layer && b.shape != BodyShape::inflow) continue;
        const double cells = (b.hydrograph ? peak_depth(b) : b.thickness) / scene.cell;
        const std::string when = b.release_time > 0 ? fmt::format(" at {:.6g} s", b.release_time) : "";
        text += fmt::format("{:<10} {}: {:.6g} m3{}, {:.3g} cells thick\n", b.hydrograph ? "inflow" : "release", b.name,
                            measure_of(b, scene.dimensions), when, cells);
    }
    return text;
}

/// "output     24 bytes a particle: 384.0 MB at each of 11 times, every 500 steps; 4.22 GB in all"
std::string output_line(const Scene& scene, const Prediction& p) {
    const OutputPrediction o = predict_output(scene, p);
    const double bytes = o.row_bytes * o.rows;
    const bool cells = scene.output.on_cells;
    return fmt::format("output     {:.0f} bytes a {}: {}{} at each of {:.0f} times, every {:.0f} steps; {} in all\n",
                       o.row_bytes, cells ? "cell" : "particle", cells ? "about " : "", bytes_text(bytes), o.outputs,
                       o.steps, bytes_text(bytes * o.outputs + 8 * o.rows));
}

/// "law        clay: my_law.hpp:1f6b0a8be2c4d793, "soft-clay", of young, poisson, su; remembers damage"
std::string law_lines(const Scene& scene) {
    std::string text;
    for (const MaterialSpec& m : scene.materials) {
        const LawInfo& law = *find_law(m.law);
        if (!law.of_file()) continue;
        std::vector<std::string> keys, scalars(law.history_names.begin(), law.history_names.end());
        for (const Parameter& parameter : law.parameters) keys.emplace_back(parameter.key);
        text += fmt::format("law        {}: {}, {}, of {}{}\n", m.name, law.name, quote(law.file.title), listed(keys),
                            scalars.empty() ? "" : "; remembers " + listed(scalars));
    }
    return text;
}

/// "profile    body.slope: su from 313.4 to 9715 Pa"
std::string profile_lines(const Scene& scene) {
    std::string text;
    for (std::size_t k = 0; k < scene.bodies.size(); ++k) {
        const BodySpec& b = scene.bodies[k];
        const MaterialSpec& m = scene.materials[static_cast<std::size_t>(b.material)];
        const LawInfo& law = *find_law(m.law);
        for (const ProfileSpec& profile : m.profiles) {
            const auto property = static_cast<std::size_t>(profile.property);
            const ProfileRange range = profile_range(scene, static_cast<int>(k), profile);
            text += fmt::format("profile    {}: {} from {:.4g} to {:.4g} {}\n", path_of(b),
                                property_name(law, property), range.least, range.most,
                                &profile == m.density_profile() ? "kg/m3" : law.parameters[property].unit);
        }
    }
    for (const StructureSpec& s : scene.structures)
        if (s.soil_su)
            text += fmt::format("contact    {}: {:.4g} of the soil's own su, as it is at the time\n",
                                s.name == "terrain" ? s.name : "structure." + s.name, s.alpha);
    return text;
}

/// "stage      1 settle: until rest, damping 0.7"
std::string stage_lines(const Scene& scene) {
    std::string text;
    const std::vector<StageSpec>& stages = scene.course.stages;
    for (std::size_t k = 0; k < stages.size(); ++k) {
        const StageSpec& s = stages[k];
        std::vector<std::string> changes = s.set;
        for (const int b : s.removes) changes.push_back(scene.bodies[static_cast<std::size_t>(b)].name + " goes");
        for (const BodySpec& b : scene.bodies)
            if (b.stage == static_cast<int>(k) && k > 0) changes.push_back(b.name + " comes");
        text +=
            fmt::format("stage      {} {}: until {}{:.6g} s{}{}{}\n", k + 1, s.name, s.until_rest ? "rest, or " : "",
                        s.until, s.damping > 0 ? fmt::format(", damping {:.4g}", s.damping) : "",
                        changes.empty() ? "" : "; ", listed(changes));
    }
    return text;
}

/// "traction   crest: 2e+04 Pa on 4 m2 of body.slope, dead; by a table, at most 1 of it"
std::string traction_lines(const Scene& scene) {
    std::string text;
    for (const TractionSpec& t : scene.course.tractions)
        text +=
            fmt::format("traction   {}: {:.4g} Pa on {:.4g} {} of {}, {}{}\n", t.name,
                        std::hypot(t.pressure, t.shear[0], std::hypot(t.shear[1], t.shear[2])),
                        loaded_part(scene, t).area, scene.dimensions == 2 ? "m" : "m2",
                        path_of(scene.bodies[static_cast<std::size_t>(t.body)]), t.follows ? "follower" : "dead",
                        t.factor.empty() ? "" : fmt::format("; by a table, at most {:.4g} of it", t.factor.largest()));
    return text;
}

/// What changes over time, and whether rest is looked for.
std::string course_lines(const Scene& scene) {
    const auto rests = [](const StageSpec& s) { return s.until_rest; };
    const CourseSpec& course = scene.course;
    std::string text = stage_lines(scene) + traction_lines(scene);
    if (const TimeTable& t = course.gravity; !t.empty())
        text +=
            fmt::format("gravity    by a table: {:.4g} of it until {:.4g} s, {:.4g} from {:.4g} s on, at most {:.4g}\n",
                        t.values.front(), t.times.front(), t.values.back(), t.end(), t.largest());
    if (const ShakingSpec& s = course.shaking; !s.table.empty())
        text += fmt::format("shaking    for {:.4g} s{}, at most {:.4g} {}\n", s.table.end(),
                            s.stage < 0 ? "" : " from the begin of stage " + s.stage_name, s.table.largest(),
                            s.of_velocity ? "m/s" : "m/s2");
    if (scene.rest.stops || std::any_of(course.stages.begin(), course.stages.end(), rests))
        text += fmt::format("rest       may end it: {:.6g} % of the mass within {:.4g} m for {} times {:.4g} s\n",
                            100 * scene.rest.mass, scene.rest.displacement * scene.cell, scene.rest.intervals,
                            rest_interval(scene));
    return text;
}

/// "steps      3634 of 6 substeps to t = 20 s; 21812 without, in about 2.5 times the time"
std::string steps_line(const Scene& scene, const Prediction& p) {
    if (scene.substeps == 1) return fmt::format("steps      {:.0f} to t = {} s\n", p.steps, scene.end);
    const double gain = p.steps_without / (p.steps * substep_cost(p.substeps));
    return fmt::format("steps      {:.0f} of {} substeps to t = {} s; {:.0f} without, in about {:.2g} times the time\n",
                       p.steps, p.substeps, scene.end, p.steps_without, gain);
}

}  // namespace

std::string check_report(const Scene& scene, const CheckedRun& run) {
    const Prediction p = predict(scene);
    const int ranks = run.ranks;
    std::string text = fmt::format("{}: good\n", scene.source.path);
    if (!scene.source.title.empty()) text += fmt::format("title      {}\n", scene.source.title);
    text += fmt::format("particles  {}\n", p.particles);
    text += fmt::format("blocks     {} occupied at the start, of 4^{} cells\n", p.blocks, scene.dimensions);
    for (const std::string& notice : scene.notices) text += fmt::format("notice     {}\n", notice);
    for (const std::string& warning : scene_warnings(scene)) text += fmt::format("warning    {}\n", warning);
    text += fmt::format("method     {}\n", method_text(scene));
    text += law_lines(scene);
    text += profile_lines(scene);
    text += structure_lines(scene);
    text += release_lines(scene);
    text += fmt::format("mass       {:.6g} kg{}\n", p.mass, scene.dimensions == 2 ? " per metre" : "");
    text += fmt::format("dt         {:.4g} s ({})\n", p.dt,
                        scene.dt > 0 ? std::string("fixed")
                                     : fmt::format("cfl {:.3g}, waves {:.4g} m/s, particles {:.4g} m/s at the start",
                                                   courant_number(scene), p.max_wave_speed, p.max_speed));
    text += steps_line(scene, p);
    if (run.on_devices) text += fmt::format("kernels    {}\n", kernel_key(scene).text());
    text += fmt::format("time       {}\n", run.timing.empty() ? run_time_text(scene, p, ranks, run.on_devices) +
                                                                    " (--time measures it here)"
                                                              : run.timing);
    text += course_lines(scene);
    if (scene.sleep.on)
        text +=
            fmt::format("sleep      blocks may: less than {:.4g} m in {:.4g} s, and {:.4g} Pa of a density of 1000\n",
                        sleep_displacement(scene) * scene.cell, sleep_interval(scene), 1000 * sleep_rule(scene).weight);
    if (run.writes_particles) text += output_line(scene, p);
    text += fmt::format("memory     {} on each of {} rank{}\n", bytes_text(bytes_per_rank(scene, p, ranks)), ranks,
                        ranks == 1 ? "" : "s");
    if (scene.hazard.cell > 0)
        text += fmt::format(
            "           hazard maps take {} bytes more for each column that soil comes to: {} in all if "
            "that is all of the domain\n",
            PlanColumns::kept_bytes, bytes_text(map_bytes_at_most(scene)));
    text += fmt::format("           {} on one GPU (--device cuda), beside what the driver takes\n",
                        bytes_text(bytes_on_device(scene, p)));
    if (ranks > 1)
        text += fmt::format("           {} on each of {} GPUs\n", bytes_text(bytes_on_device(scene, p, ranks)), ranks);
    text += fmt::format("           {} of the host for each of {} rank{} on GPUs\n",
                        bytes_text(host_bytes_with_device(scene, p, ranks, run.writes_particles)), ranks,
                        ranks == 1 ? "" : "s");
    return text;
}

}  // namespace moraine
