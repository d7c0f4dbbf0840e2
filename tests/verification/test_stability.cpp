// S1, S22 and S24 in small: the default method is stable while it drifts, and random scenes keep their budget.
#include <vector>

#include "scene/scene_defaults.hpp"
#include "verification/drive.hpp"
#include "verification/fluid_scene.hpp"
#include "verification/problem_cloud.hpp"
#include "verification/random_run.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

/// USF and MUSL gain some energy with FLIP.
bool may_gain(const Scene& scene) {
    return scene.stress_update != StressUpdate::usl && scene.transfer == Transfer::flip;
}

}  // namespace

TEST_CASE("S1: the default method is stable adrift at the step of its scenes, and not at h / c") {
    const Cloud strip{"strip adrift", 2, true, false, 0.05};
    CHECK(cloud_is_stable(strip, quadratic_apic_usl, standard_courant(Scene{})));
    CHECK(!cloud_is_stable(strip, quadratic_apic_usl, 1));
}

TEST_CASE("S22: forty random scenes run to their end, lose nothing, keep momentum and gain no energy") {
    for (std::uint64_t number = 1; number <= 40; ++number) {
        CAPTURE(number);
        Scene scene = random_scene(number);
        scene.cfl = standard_courant(scene) * random_share(number);
        const Verdict v = scene.dimensions == 2 ? judge<double, 2>(scene, 120) : judge<double, 3>(scene, 120);
        CHECK(v.fault == "");
        CHECK(v.lost == 0);
        CHECK(v.momentum <= 1e-10);
        CHECK(v.created <= (may_gain(scene) ? 2e-4 : 1e-6));
    }
}

TEST_CASE(
    "S24: random scenes of fluids, by the method that they take by themselves, keep momentum and gain no energy") {
    std::vector<std::uint64_t> numbers{81, 85, 318};  // on a structure: soil at rest rose by what gravity gave
    for (std::uint64_t number = 1; number <= 12; ++number) numbers.push_back(number);
    for (std::uint64_t number : numbers) {
        CAPTURE(number);
        Scene scene = fluid_scene(number);
        take_defaults(scene, Places(""));
        CHECK(scene.transfer == Transfer::aflip);
        CHECK(scene.materials[0].volumetric == Volumetric::grid);
        CHECK((scene.bed == Bed::surface) == !scene.structures.empty());
        const Verdict v = scene.dimensions == 2 ? judge<double, 2>(scene, 2000) : judge<double, 3>(scene, 2000);
        CHECK(v.fault == "");
        CHECK(v.lost == 0);
        CHECK(v.momentum <= 1e-10);
        CHECK(v.created <= 1e-6);
    }
}
