#include <fmt/format.h>

#include <algorithm>

#include "core/structures/collisions.hpp"
#include "core/structures/structure_set.hpp"
#include "scene/scene_check.hpp"

namespace moraine {
namespace {

constexpr const char* faces[] = {"x-min", "x-max", "y-min", "y-max", "z-min", "z-max"};

std::string path_of(const StructureSpec& s) {
    return s.shape == StructureShape::ground ? s.name : "structure." + s.name;
}

bool is_free(const StructureSpec& s) {
    return s.motion.kind == StructureMotion::free;
}

bool is_round(const StructureSpec& s) {
    return s.shape == StructureShape::cylinder || s.shape == StructureShape::capsule;
}

void check_alone(const StructureSpec& s, const Places& places) {
    if (!is_free(s) || (!is_round(s) && s.shape != StructureShape::plane)) return;
    refuse(places.of(path_of(s) + ".collision"), path_of(s) + " cannot meet others",
           "of the free structures only spheres, boxes and convex polygons do",
           "Use one of these, or remove collision?");
}

void check_pair(const StructureSpec& a, const StructureSpec& b, const Places& places) {
    if (!collide(a, b)) return;
    for (const auto& [one, other] : {std::pair(&a, &b), std::pair(&b, &a)}) {
        if (is_round(*one) && other->shape != StructureShape::sphere)
            refuse(places.of(path_of(*other) + ".collision"),
                   fmt::format("{} cannot meet {}", path_of(*other), path_of(*one)),
                   "cylinders and capsules are met by spheres alone",
                   "Use a polygon for one, or a sphere for the other?");
        if (one->shape == StructureShape::polygon && !is_convex(one->points))
            refuse(places.of(path_of(*one) + ".points"), path_of(*one) + " has a corner that points inwards",
                   path_of(*other) + " meets it, and only what is convex is met", "Divide it into convex ones?");
    }
}

/// A wall is the same to them all the time.
void check_stages(const Scene& scene, const Places& places) {
    for (const StageSpec& stage : scene.course.stages)
        for (std::size_t face = 0; face < 2 * static_cast<std::size_t>(scene.dimensions); ++face)
            if (meets_structures(stage.walls[face / 2][face % 2]) != meets_structures(scene.walls[face / 2][face % 2]))
                refuse(places.of("stage." + stage.name),
                       fmt::format("stage.{} changes wall.{}", stage.name, faces[face]),
                       "structures meet walls that stay", "Use a plane of kind table in place of that wall?");
}

template <int Dim>
void check_apart(const Scene& scene, const Places& places) {
    StructureSet<Dim> set(scene);
    set.place();
    const ContactField<Dim> field = set.field();
    const auto worst = set.collisions()->worst_overlap({field.structure, set.size()}, field.corners);
    if (worst.first < 0) return;
    const std::string one = path_of(set.spec(static_cast<std::size_t>(worst.first)));
    const std::string other = worst.wall >= 0 ? std::string("wall.") + faces[worst.wall]
                                              : path_of(set.spec(static_cast<std::size_t>(worst.second)));
    refuse(places.of(one), fmt::format("{} begins inside {}", one, other),
           fmt::format("they overlap by {:.3g} m, and meet", worst.depth), "Move one of them?");
}

}  // namespace

void check_collisions(const Scene& scene, const Places& places) {
    const std::vector<StructureSpec>& all = scene.structures;
    const auto first = std::find_if(all.begin(), all.end(), collides);
    if (first == all.end()) return;
    if (std::none_of(all.begin(), all.end(), [](const StructureSpec& s) { return is_free(s) && collides(s); }))
        refuse(places.of(path_of(*first) + ".collision"), path_of(*first) + ".collision is not used",
               "no free structure has it", "Give it to the structure that moves?");
    for (auto a = all.begin(); a != all.end(); ++a) {
        if (collides(*a)) check_alone(*a, places);
        for (auto b = a + 1; b != all.end(); ++b) check_pair(*a, *b, places);
    }
    check_stages(scene, places);
    scene.dimensions == 2 ? check_apart<2>(scene, places) : check_apart<3>(scene, places);
}

}  // namespace moraine
