#pragma once
// scene.json: what stands around the particles of a run, for pictures: domain, walls, structures; and what makes the
// scene the one it is, for comparisons.
//
// Keys and values are those of the scene with all that --set changed, so that a picture needs no scene file. It is
// written when the run begins: a run that goes on, or was killed, can be drawn too. Where structures have moved to is
// in structures.csv.

#include <filesystem>

#include "core/scene_spec.hpp"
#include "core/structures/ground.hpp"
#include "io/json_text.hpp"
#include "records/version.hpp"
#include "scene/scene_identity.hpp"

namespace moraine {

namespace scene_record {

/// A point or vector: as many components as the scene has dimensions.
inline Json vector(const Scene& scene, const Triple& v) {
    return std::vector<double>(v.begin(), v.begin() + scene.dimensions);
}

inline Json walls(const Scene& scene) {
    constexpr const char* kinds[] = {"none", "no-slip",  "free-slip", "friction",
                                     "open", "periodic", "law",       "absorbing"};
    std::vector<Json> list;
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a)
        for (std::size_t side = 0; side < 2; ++side)
            list.push_back(Json::Named{
                {"face", std::string(1, "xyz"[a]) + (side == 0 ? "-min" : "-max")},
                {"kind",
                 scene.walls[a][side].absorbs ? "absorbing" : kinds[static_cast<int>(scene.walls[a][side].kind)]}});
    return list;
}

/// The ground of a scene in 2-D, down to the domain's lower end; in 3-D its file alone, from where the run was started.
inline Json ground(const Scene& scene, const StructureSpec& s) {
    Json::Named named{{"name", s.name}, {"shape", scene.dimensions == 2 ? "polygon" : "ground"}};
    named.emplace_back("file", (std::filesystem::path(scene.source.path).parent_path() / s.file).string());
    named.emplace_back("spacing", s.ground->spacing);
    named.emplace_back("crs", s.ground->crs);
    if (scene.dimensions == 3) return named;
    const auto place = [&](std::int64_t i) { return s.ground->first[0] + static_cast<double>(i) * s.ground->spacing; };
    std::vector<Json> points{std::vector<double>{place(0), scene.min[1]}};
    for (std::int64_t i = 0; i < s.ground->count[0]; ++i)
        points.push_back(std::vector<double>{place(i), s.ground->height[static_cast<std::size_t>(i)]});
    points.push_back(std::vector<double>{place(s.ground->count[0] - 1), scene.min[1]});
    named.emplace_back("points", points);
    return named;
}

inline Json structure(const Scene& scene, const StructureSpec& s) {
    if (s.ground) return ground(scene, s);
    constexpr const char* shapes[] = {"plane", "sphere", "cylinder", "box", "capsule", "polygon"};
    Json::Named named{{"name", s.name}, {"shape", shapes[static_cast<int>(s.shape)]}};
    const auto add = [&](const char* key, const Triple& v) { named.emplace_back(key, vector(scene, v)); };
    switch (s.shape) {
        case StructureShape::plane:
            add("point", s.point), add("normal", s.normal);
            break;
        case StructureShape::sphere:
            add("center", s.center);
            break;
        case StructureShape::box:
            add("min", s.min), add("max", s.max);
            break;
        case StructureShape::cylinder:
        case StructureShape::capsule:
            add("from", s.from), add("to", s.to);
            break;
        case StructureShape::polygon: {
            std::vector<Json> points;
            for (const auto& p : s.points) points.push_back(std::vector<double>(p.begin(), p.end()));
            named.emplace_back("points", points);
            if (scene.dimensions == 3) named.emplace_back("z", std::vector<double>{s.min[2], s.max[2]});
            break;
        }
        case StructureShape::ground:  // above
            break;
    }
    if (s.radius > 0) named.emplace_back("radius", s.radius);
    return named;
}

/// Releases and inflows with their volume [m3] and thickness over the ground [m]; `volumes`: of each body.
inline Json sources(const Scene& scene, const std::vector<double>& volumes) {
    std::vector<Json> list;
    for (std::size_t k = 0; k < scene.bodies.size(); ++k)
        if (const BodySpec& b = scene.bodies[k]; b.shape == BodyShape::layer || b.shape == BodyShape::inflow)
            list.push_back(Json::Named{{"name", b.name},
                                       {"kind", b.shape == BodyShape::inflow ? "inflow" : "release"},
                                       {"material", scene.materials[static_cast<std::size_t>(b.material)].name},
                                       {"volume_m3", volumes[k]},
                                       {"thickness_m", b.thickness},
                                       {"start_s", b.release_time}});
    return list;
}

/// What [hazard] asks for, with the places and lines of its files.
inline Json hazard(const HazardSpec& h) {
    const auto line = [](const std::vector<std::array<double, 2>>& points) {
        std::vector<Json> list;
        for (const auto& p : points) list.push_back(std::vector<double>(p.begin(), p.end()));
        return Json(list);
    };
    std::vector<Json> gauges, sections;
    for (const GaugeSpec& g : h.gauges)
        gauges.push_back(Json::Named{{"name", g.name}, {"place", std::vector<double>{g.x, g.y}}});
    for (const SectionSpec& s : h.sections)
        sections.push_back(Json::Named{{"name", s.name}, {"points", line(s.points)}});
    return Json::Named{{"cell", h.cell},
                       {"threshold", h.threshold},
                       {"gauges", gauges},
                       {"sections", sections},
                       {"path", line(h.path)}};
}

/// All that the answer depends on, by which a report says in what runs differ.
inline Json keys(const Scene& scene) {
    Json::Named named;
    for (const auto& [key, value] : scene_identity(scene)) named.emplace_back(key, in_words(key, value));
    return named;
}

}  // namespace scene_record

inline Json surroundings(const Scene& scene, const std::vector<double>& volumes) {
    std::vector<Json> structures;
    for (const StructureSpec& s : scene.structures) structures.push_back(scene_record::structure(scene, s));
    Json::Named all{{"version", version_text},
                    {"scene", scene.name},
                    {"title", scene.source.title},
                    {"dimensions", scene.dimensions},
                    {"domain", Json::Named{{"min", scene_record::vector(scene, scene.min)},
                                           {"max", scene_record::vector(scene, scene.max)},
                                           {"cell", scene.cell}}},
                    {"wall", scene_record::walls(scene)},
                    {"structure", structures}};
    if (scene.hazard.cell > 0) all.emplace_back("hazard", scene_record::hazard(scene.hazard));
    all.emplace_back("source", scene_record::sources(scene, volumes));
    all.emplace_back("keys", scene_record::keys(scene));
    return all;
}

}  // namespace moraine
