#include <doctest/doctest.h>

#include "app/watchdog.hpp"
#include "scene/scene_keys.hpp"

using namespace moraine;

TEST_CASE("a stall is over with every finished step") {
    StallTimer timer(10, 5, 100);
    for (int step = 1; step < 50; ++step) CHECK_FALSE(timer.expired(100 + 4 * step, step / 2, 1));
}

TEST_CASE("a rank that finishes no step for the limit has stalled, and not before") {
    StallTimer timer(10, 5, 100);
    CHECK_FALSE(timer.expired(103, 7, 1));  // the step was new
    CHECK_FALSE(timer.expired(107, 7, 1));
    CHECK_FALSE(timer.expired(111, 7, 1));
    CHECK(timer.expired(113, 7, 1));
}

TEST_CASE("time in output, checkpoints and plans counts a tenth, so that a link lost there is found as well") {
    StallTimer timer(10, 5, 0);
    CHECK_FALSE(timer.expired(4, 7, 1));
    int t = 4;
    while (!timer.expired(t += 4, 7, 0.1)) CHECK(t < 200);
    CHECK(t >= 104);
    CHECK(t <= 108);
}

TEST_CASE("time in which the process was stopped does not count as a stall") {
    StallTimer timer(10, 5, 0);
    CHECK_FALSE(timer.expired(1, 7, 1));
    CHECK_FALSE(timer.expired(10000, 7, 1));
    CHECK_FALSE(timer.expired(10004, 7, 1));
    CHECK(timer.expired(10005, 7, 1));
}

TEST_CASE("the clock of phases tells the innermost phase under way") {
    Phases phases;
    CHECK_FALSE(phases.now());
    phases.time(Phase::output, [&] {
        CHECK(phases.now() == Phase::output);
        phases.time(Phase::migrate, [&] { CHECK(phases.now() == Phase::migrate); });
        CHECK(phases.now() == Phase::output);
    });
    CHECK_FALSE(phases.now());
}

TEST_CASE("a watchdog that has nothing to say ends with its run, whatever its limit became") {
    Watchdog never(0, 0), as_scenes(0, Watchdog::standard_limit);
    for (const double limit : {7200.0, 0.0}) as_scenes.set_limit(limit);
    Watchdog on(0, 3600);
    const Phases phases;
    {
        const WatchedPhases watched(on, phases);
        on.step_finished(1);
    }
}

TEST_CASE("before its scene is read a run has the default of run.watchdog") {
    for (const SceneKey& key : all_scene_keys())
        if (key.table == "run" && key.name == "watchdog") CHECK(std::stod(*key.standard) == Watchdog::standard_limit);
}
