#include <doctest/doctest.h>

#include <cmath>

#include "core/sample_ground.hpp"
#include "sample_scenes.hpp"
#include "seeding/property_profile.hpp"
#include "seeding/seed.hpp"

using namespace moraine;

namespace {

ProfileSpec line(double surface, double gradient) {
    ProfileSpec s;
    s.surface = surface, s.gradient = gradient;
    return s;
}

/// One body of clay of this profile, under this gravity.
Scene scene_of(const BodySpec& body, const Triple& gravity, const ProfileSpec& profile, int dimensions = 2) {
    Scene scene;
    scene.dimensions = dimensions;
    scene.max = {10, 10, dimensions == 3 ? 10.0 : 0.0};
    scene.gravity = gravity;
    scene.materials = {test::material("tresca", 1600, {{"young", 1e6}, {"poisson", 0.45}, {"su", 1}})};
    set_profile(scene.materials[0], 2, profile);
    scene.bodies = {body};
    return scene;
}

double depth(const BodySpec& body, const Triple& gravity, const Triple& x, int dimensions = 2) {
    const Scene scene = scene_of(body, gravity, line(0, 1), dimensions);
    CHECK(profile_at(scene, body, scene.materials[0].profiles[0], x) ==
          depth_at(scene, body, scene.materials[0].profiles[0], x));
    return depth_at(scene, body, scene.materials[0].profiles[0], x);
}

BodySpec polygon(std::vector<std::array<double, 2>> points) {
    BodySpec body;
    body.shape = BodyShape::polygon;
    body.points = std::move(points);
    return body;
}

const Triple down{0, -9.81, 0};

}  // namespace

TEST_CASE("depth in a box counts from its upper face along gravity, which may lean") {
    const BodySpec box = test::box({0, 1, 0}, {8, 5, 2}, 0);
    CHECK(depth(box, down, {3, 2, 0}) == 3);
    CHECK(depth(box, {0, 9.81, 0}, {3, 2, 0}) == 1);
    const double beta = 0.2;
    CHECK(depth(box, {9.81 * std::sin(beta), -9.81 * std::cos(beta), 0}, {0.1, 2, 0}) ==
          doctest::Approx(3 / std::cos(beta)).epsilon(1e-14));
    CHECK(depth(box, {0, 0, -1}, {3, 2, 0.5}, 3) == 1.5);
    CHECK(depth(box, {0, 0, 0}, {3, 2, 0.5}, 3) == 1.5);
    CHECK(depth(box, {0, 0, 0}, {3, 2, 0}) == 3);
    CHECK(depth(box, down, {3, 5.5, 0}) == 0);
}

TEST_CASE("depth in a polygon counts from where the line up leaves it for good") {
    const BodySpec slope = polygon({{0, 0}, {8, 0}, {8, 1}, {4, 1}, {2, 5}, {0, 5}});
    CHECK(depth(slope, down, {1, 2, 0}) == 3);
    CHECK(depth(slope, down, {6, 0.25, 0}) == 0.75);
    CHECK(depth(slope, down, {3, 1, 0}) == doctest::Approx(2).epsilon(1e-14));
    const BodySpec hollow = polygon({{0, 0}, {6, 0}, {6, 6}, {0, 6}, {0, 4}, {4, 4}, {4, 2}, {0, 2}});
    CHECK(depth(hollow, down, {2, 1, 0}) == 5);  // through the hollow
    CHECK(depth(hollow, down, {2, 5, 0}) == 1);
    const double beta = 0.3;
    CHECK(depth(slope, {9.81 * std::sin(beta), -9.81 * std::cos(beta), 0}, {1, 4, 0}) ==
          doctest::Approx(1 / std::cos(beta)).epsilon(1e-14));
    BodySpec prism = slope;
    prism.min[2] = 0, prism.max[2] = 3;
    CHECK(depth(prism, down, {1, 2, 1}, 3) == 3);
    CHECK(depth(prism, {0, 0, -9.81}, {1, 2, 1}, 3) == 2);
}

TEST_CASE("depth in a sphere counts along its chord") {
    BodySpec ball;
    ball.shape = BodyShape::sphere;
    ball.center = {2, 2, 2}, ball.radius = 1;
    CHECK(depth(ball, down, {2, 2, 0}) == 1);
    CHECK(depth(ball, down, {2.6, 2, 0}) == doctest::Approx(0.8).epsilon(1e-14));
    CHECK(depth(ball, {0, 0, -9.81}, {2, 2.6, 1.5}, 3) == doctest::Approx(1.3).epsilon(1e-14));
}

TEST_CASE("depth in a release counts from its own surface") {
    BodySpec layer;
    layer.shape = BodyShape::layer;
    layer.thickness = 2;
    layer.points = {{2, 2}, {8, 2}, {8, 8}, {2, 8}};
    layer.ground =
        std::make_shared<Ground>(test::ground_of({0, 0}, 11, 1, false, [](double x, double) { return 0.5 * x; }));
    Scene scene = scene_of(layer, {0, 0, -9.81}, line(0, 1), 3);
    scene.max[2] = 20, scene.cell = 0.5;
    const BodySeeds all(scene, 0);
    std::vector<Seed> seeds;
    all.fill(0, all.rows(), all.count(0, all.rows()), seeds);
    REQUIRE(seeds.size() > 100);
    const double secant = std::sqrt(1.25);
    for (const Seed& s : seeds) {
        const double top = 0.5 * s.x[0] + 2 * secant;
        CHECK(profile_at(scene, layer, scene.materials[0].profiles[0], s.x) ==
              doctest::Approx(top - s.x[2]).epsilon(1e-9));
    }
}

TEST_CASE("depth below a height is none above it") {
    BodySpec points;
    points.shape = BodyShape::table;
    CHECK(!has_surface(points));
    ProfileSpec profile = line(100, 10);
    profile.from = 4;
    const Scene scene = scene_of(points, down, profile);
    CHECK(profile_at(scene, points, scene.materials[0].profiles[0], {1, 1, 0}) == 130);
    CHECK(profile_at(scene, points, scene.materials[0].profiles[0], {1, 4, 0}) == 100);
    CHECK(profile_at(scene, points, scene.materials[0].profiles[0], {1, 6, 0}) == 100);
}

TEST_CASE("a table is linear between its rows and constant beyond") {
    const BodySpec box = test::box({0, 0, 0}, {1, 10, 0}, 0);
    ProfileSpec profile;
    profile.depth = {1, 2, 2.5, 6};
    profile.value = {1000, 1000, 3000, 4000};
    const Scene scene = scene_of(box, down, profile);
    const auto at = [&](double z) { return profile_at(scene, box, scene.materials[0].profiles[0], {0.5, 10 - z, 0}); };
    CHECK(at(0.5) == 1000);
    CHECK(at(1.5) == 1000);
    CHECK(at(2.25) == 2000);
    CHECK(at(2.5) == 3000);
    CHECK(at(4.25) == 3500);
    CHECK(at(9) == 4000);
}

TEST_CASE("a raster is the strength at the surface, and depth adds to it") {
    const BodySpec box = test::box({2, 2, 0}, {8, 8, 4}, 0);
    ProfileSpec profile = line(0, 10);
    auto raster = std::make_shared<Ground>();
    raster->spacing = 1, raster->count = {11, 11};
    for (int j = 0; j < 11; ++j)
        for (int i = 0; i < 11; ++i) raster->height.push_back(100 * i + j);
    profile.raster = raster;
    const Scene scene = scene_of(box, {0, 0, -9.81}, profile, 3);
    CHECK(profile_at(scene, box, scene.materials[0].profiles[0], {2.5, 4, 1}) ==
          doctest::Approx(250 + 4 + 30).epsilon(1e-14));
}

TEST_CASE("several properties of a material have profiles, each its scalar") {
    MaterialSpec m = test::material("tresca", 1600, {{"young", 1e6}, {"poisson", 0.45}, {"su", 1}});
    CHECK_THROWS_AS(set_profile(m, 1, line(1, 1)), std::logic_error);
    m.profiles.clear();
    set_profile(m, 9, line(1500, 10));
    CHECK(m.law == "tresca over depth (initial_density)");
    CHECK(m.density_profile()->scalar == 1);
    set_profile(m, 2, line(1, 1));
    CHECK(m.law == "tresca over depth (su, initial_density)");
    CHECK(m.profile_of(2)->scalar == 1);
    CHECK(m.density_profile()->scalar == 2);
    set_profile(m, 2, line(3, 1));
    CHECK(m.profiles.size() == 2);
    CHECK(m.profile_of(2)->surface == 3);
}

TEST_CASE("the mass above is the exact integral of a density over depth, also where gravity leans") {
    const BodySpec box = test::box({0, 0, 0}, {8, 8, 0}, 0);
    const auto above = [&](const ProfileSpec& density, double y, double height, double beta) {
        Scene scene = scene_of(box, {9.81 * std::sin(beta), -9.81 * std::cos(beta), 0}, line(1, 1));
        set_profile(scene.materials[0], 9, density);
        return mass_above(scene, box, {1, y, 0}, height);
    };
    CHECK(above(line(1500, 20), 2, 6, 0) == doctest::Approx(1500 * 6 + 10 * 36).epsilon(1e-14));
    CHECK(above(line(1500, 20), 2, 4, 0) == doctest::Approx(1500 * 4 + 10 * (36 - 4)).epsilon(1e-14));
    CHECK(above(line(1500, 20), 2, 9, 0) == doctest::Approx(1500 * 9 + 10 * 36).epsilon(1e-14));  // 3 above the body
    CHECK(above(line(1500, 20), 2, 6, 0.3) == doctest::Approx(1500 * 6 + 10 * 36 / std::cos(0.3)).epsilon(1e-14));
    ProfileSpec layers;
    layers.depth = {2, 2.5, 4};
    layers.value = {1000, 2000, 1600};
    CHECK(above(layers, 1, 7, 0) == doctest::Approx(2000 + 750 + 2700 + 4800).epsilon(1e-14));
    CHECK(above(layers, 7, 1, 0) == doctest::Approx(1000).epsilon(1e-14));
}

TEST_CASE("particles of a density over depth have its mass and one volume") {
    const BodySpec box = test::box({0, 1, 0}, {8, 5, 0}, 0);
    Scene scene = scene_of(box, down, line(1, 1));
    scene.cell = 0.5;
    set_profile(scene.materials[0], 9, line(1500, 20));
    const BodySeeds all(scene, 0);
    std::vector<Seed> seeds;
    all.fill(0, all.rows(), all.count(0, all.rows()), seeds);
    REQUIRE(seeds.size() > 100);
    for (const Seed& s : seeds) {
        CHECK(s.volume == seeds[0].volume);
        CHECK(s.mass == doctest::Approx((1500 + 20 * (5 - s.x[1])) * s.volume).epsilon(1e-14));
    }
    const ProfileRange bounds = profile_bounds(scene, 0, *scene.materials[0].density_profile());
    CHECK(bounds.least == 1500);
    CHECK(bounds.most == 1580);
}
