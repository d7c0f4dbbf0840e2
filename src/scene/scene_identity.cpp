#include "scene/scene_identity.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <span>
#include <sstream>

#include "core/data/hash.hpp"
#include "core/material/laws.hpp"
#include "core/structures/collisions.hpp"
#include "core/structures/ground.hpp"
#include "scene/scene_check.hpp"
#include "scene/scene_keys.hpp"

namespace moraine {

namespace {

using Entries = std::vector<std::pair<std::string, std::string>>;

template <class T>
void add(Entries& all, const std::string& key, const T& value) {
    if constexpr (std::is_enum_v<T>)
        all.emplace_back(key, fmt::format("{}", static_cast<int>(value)));
    else
        all.emplace_back(key, fmt::format("{}", value));
}

void add_domain(Entries& all, const Scene& s) {
    add(all, "dimensions", s.dimensions);
    add(all, "domain.min", s.min);
    add(all, "domain.max", s.max);
    add(all, "domain.cell", s.cell);
    add(all, "domain.periodic", s.periodic);
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t side = 0; side < 2; ++side) {
            const std::string key = fmt::format("wall.{}-{}", "xyz"[a], side == 0 ? "min" : "max");
            add(all, key + ".kind", s.walls[a][side].kind);
            add(all, key + ".friction", s.walls[a][side].friction);
            if (s.walls[a][side].drains) add(all, key + ".drainage", s.walls[a][side].drains);
            if (s.walls[a][side].absorbs) add(all, key + ".absorbs", s.walls[a][side].material);
        }
}

void add_numerics(Entries& all, const Scene& s) {
    add(all, "numerics.shape", s.shape);
    add(all, "numerics.transfer", s.transfer);
    add(all, "numerics.flip", s.flip);
    add(all, "numerics.order", s.order);
    if (s.substeps != 1) add(all, "numerics.substeps", s.substeps);
    if (s.bed != Bed::nodes) add(all, "numerics.bed", s.bed);
    add(all, "numerics.stress_update", s.stress_update);
    add(all, "numerics.precision", s.precision);
    add(all, "numerics.damping", s.damping);
    add(all, "numerics.boundary", s.boundary_spline);
    add(all, "numerics.light_nodes", s.limits_light_nodes);
    if (s.sleep.on) {
        add(all, "numerics.sleep", s.sleep.on);
        add(all, "sleep.displacement", s.sleep.displacement);
        add(all, "sleep.stress", s.sleep.stress);
        add(all, "sleep.interval", s.sleep.interval);
        add(all, "sleep.wake", s.sleep.wake);
    }
    add(all, "time.cfl", s.cfl);  // behind what its default follows from: who compares names the first difference
    add(all, "time.dt", s.dt);
    add(all, "gravity", s.gravity);
    if (!s.course.gravity.empty()) {
        add(all, "gravity_table.times", s.course.gravity.times);
        add(all, "gravity_table.values", s.course.gravity.values);
    }
    if (const ShakingSpec& shaking = s.course.shaking; !shaking.table.empty()) {
        add(all, "shaking.times", shaking.table.times);
        add(all, "shaking.values", shaking.table.values);
        add(all, "shaking.quantity", shaking.of_velocity);
        add(all, "shaking.direction", shaking.direction);
        add(all, "shaking.motion", shaking.motion);
        add(all, "shaking.stage", shaking.stage);
    }
    add(all, "seed", s.seed);
}

void add_water(Entries& all, const Scene& s) {
    if (!s.water.on) return;
    if (s.water.table) add(all, "water.table", *s.water.table);
    add(all, "water.density", s.water.density);
    add(all, "water.bulk", s.water.bulk);
    add(all, "water.cavitation", s.water.cavitation);
    add(all, "water.outside", s.water.submerged);
}

template <class List>
std::uint64_t hash_of(const List& list) {
    const auto bytes = std::as_bytes(std::span(list));
    return mix_bytes(mix(bytes.size()), bytes.data(), bytes.size());
}

/// Of its values and of where they lie.
std::uint64_t hash_of(const Ground& raster) {
    return mix(hash_of(raster.height) ^ hash_of(fmt::format("{} {} {}", raster.first, raster.spacing, raster.count)));
}

void add_profile(Entries& all, const std::string& key, const ProfileSpec& profile) {
    add(all, key + ".surface", profile.surface);
    add(all, key + ".gradient", profile.gradient);
    add(all, key + ".depth", profile.depth);
    add(all, key + ".value", profile.value);
    if (profile.from) add(all, key + ".from", *profile.from);
    if (profile.raster) add(all, key + ".surface.raster", hash_of(*profile.raster));
}

void add_materials(Entries& all, const Scene& s) {
    for (const MaterialSpec& m : s.materials) {
        const std::string key = "material." + m.name;
        add(all, key + ".law", m.law);
        const auto property = [&](std::size_t number, const char* name, double value) {
            if (const ProfileSpec* profile = m.profile_of(number))
                add_profile(all, key + "." + name, *profile);
            else
                add(all, key + "." + name, value);
        };
        property(m.parameters.size(), "density", m.density);
        add(all, key + ".volumetric", m.volumetric);
        if (m.pressure_smoothing > 0) add(all, key + ".pressure_smoothing", m.pressure_smoothing);
        if (m.porosity > 0) add(all, key + ".porosity", m.porosity), add(all, key + ".conductivity", m.conductivity);
        if (m.particle_shifting > 0) add(all, key + ".particle_shifting", m.particle_shifting);
        const LawInfo& law = *find_law(m.law);
        for (std::size_t p = 0; p < m.parameters.size(); ++p) property(p, law.parameters[p].key, m.parameters[p]);
    }
}

void add_stages(Entries& all, const Scene& s) {
    for (const StageSpec& stage : s.course.stages) {
        const std::string key = "stage." + stage.name;
        add(all, key + ".until", stage.until);
        add(all, key + ".rest", stage.until_rest);
        add(all, key + ".damping", stage.damping);
        add(all, key + ".set", stage.set);
        add(all, key + ".remove", stage.removes);
    }
}

void add_tractions(Entries& all, const Scene& s) {
    for (const TractionSpec& t : s.course.tractions) {
        const std::string key = "traction." + t.name;
        add(all, key + ".body", t.body);
        add(all, key + ".normal", t.normal);
        add(all, key + ".area", t.area);
        add(all, key + ".pressure", t.pressure);
        add(all, key + ".shear", t.shear);
        add(all, key + ".kind", t.follows);
        add(all, key + ".depth", t.depth);
        add(all, key + ".times", t.factor.times);
        add(all, key + ".values", t.factor.values);
    }
}

void add_bodies(Entries& all, const Scene& s) {
    for (const BodySpec& b : s.bodies) {
        const std::string key = path_of(b);
        add(all, key + ".material", b.material);
        add(all, key + ".shape", b.shape);
        add(all, key + ".min", b.min);
        add(all, key + ".max", b.max);
        add(all, key + ".center", b.center);
        add(all, key + ".radius", b.radius);
        add(all, key + ".points", b.points);
        add(all, key + ".file", b.file);
        add(all, key + ".particles_per_cell", b.particles_per_cell);
        add(all, key + ".seeding", b.seeding);
        add(all, key + ".jitter", b.jitter);
        add(all, key + ".velocity", b.velocity);
        add(all, key + ".wave.velocity", b.wave.velocity);
        add(all, key + ".wave.axis", b.wave.axis);
        add(all, key + ".wave.origin", b.wave.origin);
        add(all, key + ".wave.wavelength", b.wave.wavelength);
        add(all, key + ".geostatic", b.geostatic);
        add(all, key + ".geostatic.surface", b.geostatic_surface);
        add(all, key + ".geostatic.k0", b.geostatic_k0);
        if (b.shape == BodyShape::layer) add(all, key + ".thickness", b.thickness);
        if (b.release_time > 0) add(all, key + ".start", b.release_time);
        if (b.stage > 0) add(all, key + ".stage", b.stage);
        if (b.stage > 0 && b.shape == BodyShape::table) add(all, key + ".file.bytes", b.table_hash);
        if (b.hydrograph) {
            add(all, key + ".time", b.hydrograph->time);
            add(all, key + ".discharge", b.hydrograph->discharge);
            add(all, key + ".speed", b.hydrograph->speed);
        }
        if (b.thickness_raster.values) add(all, key + ".thickness.raster", hash_of(*b.thickness_raster.values));
        if (b.start.over_consolidation_ratio != 1)
            add(all, key + ".over_consolidation_ratio", b.start.over_consolidation_ratio);
    }
}

void add_structures(Entries& all, const Scene& s) {
    for (const StructureSpec& r : s.structures) {
        const std::string key = "structure." + r.name;
        add(all, key + ".shape", r.shape);
        add(all, key + ".point", r.point);
        add(all, key + ".normal", r.normal);
        add(all, key + ".center", r.center);
        add(all, key + ".radius", r.radius);
        add(all, key + ".from", r.from);
        add(all, key + ".to", r.to);
        add(all, key + ".min", r.min);
        add(all, key + ".max", r.max);
        add(all, key + ".points", r.points);
        add(all, key + ".clear", r.clear);
        if (r.ground) add(all, key + ".heights", hash_of(r.ground->table));
        if (r.ground && !r.ground->friction.empty()) add(all, key + ".friction", hash_of(r.ground->friction));
        if (r.ground && !r.ground->xi.empty()) add(all, key + ".xi", hash_of(r.ground->xi));
        if (r.ground && !r.ground->su.empty()) add(all, key + ".su", hash_of(r.ground->su));
        if (r.law == InterfaceLaw::voellmy)
            add(all, key + ".contact.xi", r.xi), add(all, key + ".contact.density", r.density);
        add(all, key + ".contact.law", r.law);
        add(all, key + ".contact.friction", r.friction);
        add(all, key + ".contact.alpha", r.alpha);
        if (r.soil_su)
            add(all, key + ".contact.su", std::string("soil"));
        else
            add(all, key + ".contact.su", r.su);
        add(all, key + ".motion.kind", r.motion.kind);
        add(all, key + ".motion.velocity", r.motion.velocity);
        add(all, key + ".motion.ramp", r.motion.ramp);
        add(all, key + ".motion.amplitude", r.motion.amplitude);
        add(all, key + ".motion.period", r.motion.period);
        add(all, key + ".motion.times", r.motion.factor.times);
        add(all, key + ".motion.factors", r.motion.factor.values);
        add(all, key + ".motion.mass", r.motion.mass);
        add(all, key + ".motion.force", r.motion.force);
        if (collides(r)) {
            add(all, key + ".collision.friction", r.motion.collision->friction);
            add(all, key + ".collision.restitution", r.motion.collision->restitution);
        }
        if (!turns(r.motion)) continue;
        add(all, key + ".motion.turns", r.motion.turns);
        add(all, key + ".motion.inertia", r.motion.inertia);
        add(all, key + ".motion.angular_velocity", r.motion.angular_velocity);
    }
}

}  // namespace

Entries scene_identity(const Scene& scene) {
    Entries all;
    add_domain(all, scene);
    add_numerics(all, scene);
    add_water(all, scene);
    add_materials(all, scene);
    add_bodies(all, scene);
    add_tractions(all, scene);
    add_stages(all, scene);
    add_structures(all, scene);
    if (scene.hazard.cell > 0) add(all, "hazard.cell", scene.hazard.cell);
    if (scene.hazard.cell > 0) add(all, "hazard.threshold", scene.hazard.threshold);
    for (const SectionSpec& section : scene.hazard.sections)
        add(all, "hazard.sections." + section.name, section.points);
    return all;
}

std::string identity_text(const Scene& scene) {
    std::string text;
    for (const auto& [key, value] : scene_identity(scene)) text += key + " = " + value + "\n";
    return text;
}

std::string in_words(const std::string& key, const std::string& value) {
    const std::size_t dot = key.rfind('.');
    if (dot == std::string::npos) return value;
    std::string table = key.substr(0, dot);  // wall.x-min, structure.pipe.contact: without the name
    const std::size_t label = table.find('.');
    if (label != std::string::npos) {
        const std::size_t rest = table.find('.', label + 1);
        table = table.substr(0, label) + (rest == std::string::npos ? "" : table.substr(rest));
    }
    for (const SceneKey& known : all_scene_keys()) {
        if (known.table != table || known.name != key.substr(dot + 1) || known.type != KeyType::choice) continue;
        const std::vector<std::string>& words = known.choices;
        if (words.size() == 2 && (value == "true" || value == "false")) return words[value == "true" ? 0 : 1];
        for (std::size_t k = 0; k < words.size(); ++k)
            if (value == fmt::format("{}", k)) return words[k];
    }
    return value;
}

std::map<std::string, std::string> entries_of(const std::string& identity) {
    std::map<std::string, std::string> entries;
    std::istringstream lines(identity);
    for (std::string line; std::getline(lines, line);) {
        const std::size_t at = line.find(" = ");
        if (at != std::string::npos) entries[line.substr(0, at)] = line.substr(at + 3);
    }
    return entries;
}

std::string first_difference(const Scene& scene, const std::string& stored, const std::vector<std::string>& allowed) {
    std::map<std::string, std::string> before = entries_of(stored);
    for (const auto& [key, value] : scene_identity(scene)) {
        const auto it = before.find(key);
        if (it == before.end()) return key + " is new";
        const bool is_free = std::find(allowed.begin(), allowed.end(), key) != allowed.end();
        if (it->second != value && !is_free)
            return fmt::format("{} is {} and was {}", key, in_words(key, value), in_words(key, it->second));
        before.erase(it);
    }
    return before.empty() ? "" : before.begin()->first + " is gone";
}

}  // namespace moraine
