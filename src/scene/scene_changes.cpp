#include "scene/scene_changes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>

#include "core/data/error.hpp"
#include "core/material/laws.hpp"
#include "io/input_error.hpp"
#include "scene/scene_identity.hpp"

namespace moraine {
namespace {

/// Where a law yields, and how that changes with rate and strain; no state and no stable step hangs on them. Of
/// tresca and von-mises, drucker-prager, bingham and herschel-bulkley, mu-i.
constexpr std::array strengths{
    "su",          "rate_log",        "rate_reference", "rate_power",     "rate_exponent", "sensitivity",
    "xi95",        "cohesion",        "friction_angle", "dilation_angle", "yield_stress",  "viscosity",
    "consistency", "static_friction", "limit_friction", "inertial_number"};

bool has_parameter(const LawInfo& law, const std::string& key) {
    return std::any_of(law.parameters.begin(), law.parameters.end(), [&](const Parameter& p) { return p.key == key; });
}

bool has(const std::vector<std::string>& list, const std::string& word) {
    return std::find(list.begin(), list.end(), word) != list.end();
}

std::vector<std::string> allowable(const Scene& scene) {
    std::vector<std::string> keys;
    for (const auto& [key, value] : scene_identity(scene))
        if (may_change(scene, key)) keys.push_back(key);
    return keys;
}

}  // namespace

bool is_strength(const std::string& key) {
    return std::find(strengths.begin(), strengths.end(), key) != strengths.end();
}

bool may_change(const Scene& scene, const std::string& key) {
    if (key == "numerics.damping") return true;
    for (const MaterialSpec& m : scene.materials) {
        const std::string table = "material." + m.name + ".";
        if (!key.starts_with(table) || !is_strength(key.substr(table.size()))) continue;
        const LawInfo& law = *find_law(m.law);
        if (!law.of_file() && has_parameter(law, key.substr(table.size()))) return true;
    }
    if (key.starts_with("traction.")) return key.ends_with(".pressure") || key.ends_with(".shear");
    if (key.starts_with("wall.")) return key.ends_with(".friction");
    if (!key.starts_with("structure.")) return false;
    return key.ends_with(".collision.friction") || key.ends_with(".contact.friction") ||
           key.ends_with(".contact.alpha") || key.ends_with(".contact.su");
}

void check_allowed(const Scene& scene, const std::vector<std::string>& allowed) {
    for (const std::string& key : allowed) {
        if (key == "time.end" || may_change(scene, key)) continue;
        const std::string option = "--allow-change " + key;
        const std::vector<std::string> all = allowable(scene);
        const auto known = scene_identity(scene);
        const bool there =
            std::any_of(known.begin(), known.end(), [&](const auto& entry) { return entry.first == key; });
        if (!there) throw InputError(fmt::format("{} (the scene has no such key). {}", option, suggest(key, all)));
        throw InputError(fmt::format(
            "{} (a restart may change strengths of laws, walls and structures, and numerics.damping; the state "
            "depends on this). Run from the start, or change one of {}?",
            option, listed(all)));
    }
    if (!allowed.empty() && scene.sleep.on)
        throw InputError(
            "--allow-change in a scene with numerics.sleep (blocks that sleep would not notice a change). Make the "
            "checkpoint with numerics.sleep = \"off\"?");
}

std::vector<SceneChange> changes_from(const Scene& scene, const std::string& stored,
                                      const std::vector<std::string>& allowed) {
    const std::map<std::string, std::string> before = entries_of(stored);
    std::vector<SceneChange> changes;
    for (const auto& [key, value] : scene_identity(scene)) {
        const auto was = before.find(key);
        if (has(allowed, key) && was != before.end() && was->second != value)
            changes.push_back({key, was->second, value});
    }
    return changes;
}

}  // namespace moraine
