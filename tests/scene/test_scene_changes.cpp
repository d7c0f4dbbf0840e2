#include <doctest/doctest.h>

#include "core/data/error.hpp"
#include "core/material/laws.hpp"
#include "sample_scenes.hpp"
#include "scene/scene_changes.hpp"
#include "scene/scene_identity.hpp"

using namespace moraine;
using namespace moraine::test;

namespace {

Scene slope() {
    Scene s = column();
    s.materials[0] = material("drucker-prager", 2000, {{"young", 1e6}, {"poisson", 0.3}, {"friction_angle", 30}});
    s.materials[0].name = "sand";
    s.walls[2][0].kind = WallKind::friction;
    s.walls[2][0].friction = 0.4;
    s.damping = 0;
    s.bodies[0].name = "high", s.bodies[1].name = "low";
    return s;
}

std::string refusal_of(const Scene& scene, const std::vector<std::string>& allowed) {
    try {
        check_allowed(scene, allowed);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

}  // namespace

TEST_CASE("a restart may change strengths and damping, and nothing that the state is made of") {
    const Scene scene = slope();
    for (const char* key : {"material.sand.friction_angle", "material.sand.cohesion", "wall.z-min.friction",
                            "numerics.damping", "structure.pipe.contact.friction", "structure.pipe.contact.su"})
        CHECK(may_change(scene, key));
    for (const char* key : {"material.sand.young", "material.sand.density", "material.sand.law", "material.sand.su",
                            "material.mud.cohesion", "domain.cell", "numerics.shape", "gravity", "wall.z-min.kind",
                            "structure.pipe.friction", "body.sand.max"})
        CHECK_FALSE(may_change(scene, key));
    CHECK(refusal_of(scene, {"material.sand.cohesion", "numerics.damping", "time.end"}).empty());
}

TEST_CASE("what cannot be changed is refused with what can") {
    const Scene scene = slope();
    CHECK(refusal_of(scene, {"domain.cell"}).find("material.sand.friction_angle") != std::string::npos);
    CHECK(refusal_of(scene, {"material.sand.cohesio"}).find("Did you mean material.sand.cohesion?") !=
          std::string::npos);
    Scene sleepy = scene;
    sleepy.sleep.on = true;
    CHECK(refusal_of(sleepy, {"numerics.damping"}).find("numerics.sleep = \"off\"") != std::string::npos);
    CHECK(refusal_of(sleepy, {}).empty());
}

TEST_CASE("the state of modified Cam Clay knows its strength, so that no key of it may change") {
    Scene scene = slope();
    scene.materials[0].law = "modified-cam-clay";
    CHECK_FALSE(may_change(scene, "material.sand.critical_state_ratio"));
}

TEST_CASE("what restarts and stages may change is one list, of the keys that the law has") {
    Scene scene = slope();
    for (const char* key : {"su", "sensitivity", "viscosity"}) CHECK(is_strength(key));
    for (const char* key : {"young", "critical_state_ratio", "matching"}) CHECK_FALSE(is_strength(key));
    scene.materials[0].law = find_law_over_depth(*find_law("drucker-prager"), {{4}})->name;  // a cohesion over depth
    CHECK(may_change(scene, "material.sand.friction_angle"));
    scene.materials[0].law = "tresca";
    CHECK(may_change(scene, "material.sand.sensitivity"));
    CHECK_FALSE(may_change(scene, "material.sand.cohesion"));
}

TEST_CASE("allowed differences are told, others are still differences") {
    const Scene before = slope();
    const std::string stored = identity_text(before);
    Scene now = before;
    now.materials[0].parameters[2] = 25;
    now.damping = 0.5;
    const std::vector<std::string> both{"numerics.damping", "material.sand.friction_angle"};
    CHECK(first_difference(now, stored, both).empty());
    CHECK(first_difference(now, stored, {"material.sand.friction_angle"}) == "numerics.damping is 0.5 and was 0");
    const std::vector<SceneChange> changes = changes_from(now, stored, both);
    REQUIRE(changes.size() == 2);
    CHECK(changes[0].key == "numerics.damping");
    CHECK(changes[1].key == "material.sand.friction_angle");
    CHECK(changes[1].was == "30");
    CHECK(changes[1].is == "25");
    CHECK(changes_from(before, stored, both).empty());
}
