#include "scene/scene_changes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/data/error.hpp"
#include "io/input_error.hpp"
#include "scene/scene_identity.hpp"

namespace moraine {
namespace {

/// Of laws of the program: the keys that only say where it yields.
const std::map<std::string, std::vector<std::string>>& strengths() {
    static const std::map<std::string, std::vector<std::string>> keys{
        {"drucker-prager", {"cohesion", "friction_angle", "dilation_angle"}},
        {"tresca", {"su"}},
        {"von-mises", {"su"}},
        {"mu-i", {"static_friction", "limit_friction"}},
        {"herschel-bulkley", {"yield_stress"}},
        {"bingham", {"yield_stress"}}};
    return keys;
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

bool may_change(const Scene& scene, const std::string& key) {
    if (key == "numerics.damping") return true;
    for (const MaterialSpec& m : scene.materials) {
        const auto law = strengths().find(m.law);
        const std::string table = "material." + m.name + ".";
        if (law != strengths().end() && key.starts_with(table) && has(law->second, key.substr(table.size())))
            return true;
    }
    if (key.starts_with("wall.")) return key.ends_with(".friction");
    if (!key.starts_with("structure.")) return false;
    return key.ends_with(".contact.friction") || key.ends_with(".contact.alpha") || key.ends_with(".contact.su");
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
