#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "core/sample_ground.hpp"
#include "seeding/seed.hpp"

using namespace moraine;

namespace {

constexpr double slope = 0.4;

/// Soil comes in over a line that runs up a slope, by a hydrograph that rises and falls.
Scene inflow_scene() {
    Scene scene;
    scene.dimensions = 3;
    scene.min = {0, 0, -10};
    scene.max = {40, 40, 50};
    scene.cell = 0.5;
    scene.end = 100;
    scene.materials.resize(1);
    scene.materials[0].density = 1500;
    BodySpec body;
    body.name = "torrent";
    body.shape = BodyShape::inflow;
    body.ground = std::make_shared<Ground>(
        test::ground_of({0, 0}, 41, 1, false, [](double x, double y) { return 20 - slope * x + 0.1 * y; }));
    body.points = {{10, 22}, {10, 18}};
    Hydrograph h;
    h.time = {1, 3, 7, 9};
    h.discharge = {0, 12, 12, 2};
    h.speed = {1, 3, 3, 2};
    body.hydrograph = std::make_shared<Hydrograph>(h);
    scene.bodies.push_back(body);
    return scene;
}

/// Integral of the discharge up to t: 12 m3, 48 m3 and 14 m3.
double volume_until(double t) {
    if (t < 3) return 3 * (t - 1) * (t - 1);
    if (t < 7) return 12 + 12 * (t - 3);
    return 60 + 12 * (t - 7) - 2.5 * (t - 7) * (t - 7);
}

}  // namespace

TEST_CASE("an inflow has the volume of its hydrograph, and at every time but for a layer") {
    const Scene scene = inflow_scene();
    const Inflow inflow(scene, scene.bodies[0]);
    CHECK(inflow.volume() == doctest::Approx(74).epsilon(1e-12));
    double in = 0, before = 1;
    for (std::int64_t k = 0; k < inflow.layers(); ++k) {
        const double t = inflow.time(k);
        CHECK(t > before);
        before = t;
        inflow.each(k, t, [&](std::int64_t, const Triple&, double volume, const Triple&) { in += volume; });
        CHECK(in == doctest::Approx(volume_until(t)).epsilon(1e-9));
    }
    CHECK(before == 9);
    CHECK(in == doctest::Approx(74).epsilon(1e-12));
}

TEST_CASE("on a slope of 45 degrees, across and along the line, an inflow has the volume of its hydrograph") {
    for (const auto& [down, up] : {std::pair(1.0, 0.0), std::pair(0.0, 1.0), std::pair(0.7, 0.7)}) {
        CAPTURE(down);
        CAPTURE(up);
        Scene scene = inflow_scene();
        scene.bodies[0].ground = std::make_shared<Ground>(
            test::ground_of({0, 0}, 41, 1, false, [&](double x, double y) { return 20 - down * x + up * y; }));
        const Inflow inflow(scene, scene.bodies[0]);
        CHECK(inflow.volume() == doctest::Approx(74).epsilon(1e-12));
        // Q = v L d, the line is 4 m in plan and sqrt(1 + up^2) times as long on the ground
        CHECK(inflow.deepest() == doctest::Approx(12 / (3 * 4 * std::sqrt(1 + up * up))).epsilon(0.01));
        const double steep = std::sqrt(1 + down * down + up * up);
        double in = 0;
        for (std::int64_t k = 0; k < inflow.layers(); ++k)
            inflow.each(k, inflow.time(k), [&](std::int64_t, const Triple& x, double volume, const Triple& v) {
                const double above = (x[2] - (20 - down * x[0] + up * x[1])) / steep;
                REQUIRE(above > 0);
                REQUIRE(above < inflow.deepest());
                REQUIRE(v[2] == doctest::Approx(-down * v[0] + up * v[1]));  // along the ground
                in += volume;
            });
        CHECK(in == doctest::Approx(74).epsilon(1e-12));
    }
}

TEST_CASE("the part that comes in until the end of the run is what counts") {
    Scene scene = inflow_scene();
    scene.end = 5;
    const Inflow inflow(scene, scene.bodies[0]);
    CHECK(inflow.volume() == doctest::Approx(36).epsilon(1e-9));
    CHECK(inflow.time(inflow.layers() - 1) == 5);
}

TEST_CASE("a layer stands on the ground across the line, goes to its left, and as far as the time since it came in") {
    const Scene scene = inflow_scene();
    const Inflow inflow(scene, scene.bodies[0]);
    const double sec = std::sqrt(1 + slope * slope), steep = std::sqrt(1 + slope * slope + 0.01);
    const std::int64_t k = 40;
    const double late = 0.05, speed = 3;
    double from[3] = {}, to[3] = {}, count = 0;
    inflow.each(k, inflow.time(k), [&](std::int64_t, const Triple& x, double, const Triple& v) {
        for (std::size_t a = 0; a < 3; ++a) from[a] += x[a];
        const double above = (x[2] - (20 - slope * x[0] + 0.1 * x[1])) / steep;
        CHECK(above > 0);
        CHECK(above < inflow.deepest());
        CHECK(v[0] == doctest::Approx(speed / sec));
        CHECK(v[1] == doctest::Approx(0).scale(1));
        CHECK(v[2] == doctest::Approx(-slope * speed / sec));
        ++count;
    });
    inflow.each(k, inflow.time(k) + late, [&](std::int64_t, const Triple& x, double, const Triple&) {
        for (std::size_t a = 0; a < 3; ++a) to[a] += x[a];
    });
    CHECK(count == inflow.count(k, k + 1));
    CHECK((to[0] - from[0]) / count == doctest::Approx(late * speed / sec));
    CHECK((to[2] - from[2]) / count == doctest::Approx(-slope * late * speed / sec));
    const double depth = 12 / (speed * 4 * std::sqrt(1.01));  // Q = v L d, the line is 4 m in plan
    CHECK(inflow.deepest() == doctest::Approx(depth).epsilon(0.01));
}

TEST_CASE("ids of an inflow are each there once") {
    const Scene scene = inflow_scene();
    const BodySeeds body(scene, 0);
    std::vector<Seed> seeds;
    body.fill(0, body.rows(), 1, seeds);
    CHECK(static_cast<std::int64_t>(seeds.size()) == body.count(0, body.rows()));
    std::vector<std::uint64_t> ids;
    for (const Seed& s : seeds) ids.push_back(s.id);
    std::sort(ids.begin(), ids.end());
    CHECK(std::adjacent_find(ids.begin(), ids.end()) == ids.end());
}
