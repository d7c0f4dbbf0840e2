#pragma once
// Words about a run in each of its maps: who finds one in a folder years later knows what it is of.

#include <fmt/format.h>

#include <string>
#include <vector>

#include "io/gis_file.hpp"
#include "records/version.hpp"
#include "scene/scene_identity.hpp"
#include "simulation/diagnostics.hpp"

namespace moraine {

/// scene, title, version, commit, laws and parameters of materials and bed, releases, cell, threshold [m], time [s] and
/// state_hash; `warnings`: what was said of the scene. Binned state only. Collective.
template <class Real, int Dim>
MapTags map_tags(const Simulation<Real, Dim>& sim, const std::vector<std::string>& warnings) {
    const Scene& scene = sim.scene();
    std::string laws, releases, said;
    const auto append = [](std::string& text, const std::string& word) { text += (text.empty() ? "" : "; ") + word; };
    for (const auto& [key, value] : scene_identity(scene)) {
        const bool bed = key.starts_with("structure.terrain.contact.");
        if (key.starts_with("material.") || bed) append(laws, key + " = " + in_words(key, value));
    }
    for (const BodySpec& body : scene.bodies)
        if (body.shape == BodyShape::layer || body.shape == BodyShape::inflow)
            append(releases, fmt::format("{}: {:.6g} m, {:.3g} cells thick", body.name, body.thickness,
                                         body.thickness / scene.cell));
    for (const std::string& warning : warnings) append(said, warning);
    return {{"scene", scene.name},
            {"title", scene.source.title},
            {"version", version_text},
            {"commit", commit_text},
            {"laws", laws},
            {"releases", releases},
            {"cell_m", fmt::format("{:.6g}", scene.cell)},
            {"threshold_m", fmt::format("{:.6g}", scene.hazard.threshold)},
            {"time_s", fmt::format("{:.6g}", sim.clock().time)},
            {"state_hash", fmt::format("{:016x}", state_hash(sim))},
            {"warnings", said}};
}

}  // namespace moraine
