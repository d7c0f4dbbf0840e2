#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <map>

#include "core/sample_ground.hpp"
#include "seeding/seed.hpp"
#include "seeding/seed_layer.hpp"

using namespace moraine;

namespace {

double hill(double x, double y) {
    return 0.6 * x + 4 * std::sin(x / 9) * std::cos(y / 11);
}

/// A release of two metres over a polygon that is not convex, on a hill.
Scene layer_scene() {
    Scene scene;
    scene.dimensions = 3;
    scene.min = {0, 0, -10};
    scene.max = {40, 40, 50};
    scene.cell = 0.5;
    scene.materials.resize(1);
    scene.materials[0].density = 1500;
    auto ground = std::make_shared<Ground>();
    ground->spacing = 1;
    ground->count = {41, 41};
    for (int j = 0; j < 41; ++j)
        for (int i = 0; i < 41; ++i) ground->height.push_back(hill(i, j));
    ground->fit();
    BodySpec body;
    body.name = "scar";
    body.shape = BodyShape::layer;
    body.ground = ground;
    body.thickness = 2;
    body.points = {{8, 8}, {30.3, 9}, {29, 31}, {20, 17.5}, {9, 28}};
    scene.bodies.push_back(body);
    return scene;
}

std::vector<Seed> seeds_of(const Scene& scene) {
    const BodySeeds body(scene, 0);
    std::vector<Seed> seeds;
    body.fill(0, body.rows(), body.count(0, body.rows()), seeds);
    return seeds;
}

}  // namespace

TEST_CASE("a release has its thickness times the sloping area of its polygon, within 0.1 %") {
    const Scene scene = layer_scene();
    const BodySpec& body = scene.bodies[0];
    double area = 0;  // by small squares, of the heights themselves
    const double side = 0.02;
    for (double y = 8; y < 31; y += side)
        for (double x = 8; x < 31; x += side) {
            if (!is_in_polygon(body, x + side / 2, y + side / 2)) continue;
            const double u = (x + side / 2) / 9, v = (y + side / 2) / 11;
            const double zx = 0.6 + 4.0 / 9 * std::cos(u) * std::cos(v), zy = -4.0 / 11 * std::sin(u) * std::sin(v);
            area += side * side * std::sqrt(1 + zx * zx + zy * zy);
        }
    CHECK(layer_volume(body) == doctest::Approx(2 * area).epsilon(1e-3));
    double volume = 0;
    for (const Seed& s : seeds_of(scene)) volume += s.volume;
    CHECK(volume == doctest::Approx(layer_volume(body)).epsilon(1e-12));
}

TEST_CASE("its particles stand in upright columns, the lowest half a spacing over the ground") {
    const Scene scene = layer_scene();
    const std::vector<Seed> seeds = seeds_of(scene);
    CHECK(seeds.size() > 5000);
    CHECK(std::int64_t(seeds.size()) == BodySeeds(scene, 0).count(0, BodySeeds(scene, 0).rows()));
    for (const Seed& s : seeds) {
        const double row = height_in_layer(scene.bodies[0], s.x) / 0.25 - 0.5;
        REQUIRE(std::fabs(row - std::round(row)) < 1e-9);
        REQUIRE((row > -0.5 && row < 7.5));
        REQUIRE(is_inside(scene.bodies[0], 3, s.x));
        REQUIRE(s.mass == doctest::Approx(1500 * s.volume));
        for (const std::size_t a : {0, 1}) {
            const double column = s.x[a] / 0.25 - 0.5;
            REQUIRE(std::fabs(column - std::round(column)) < 1e-9);
        }
    }
}

TEST_CASE("each of its particles has its volume of space, also in a hollow, and none is above its top") {
    Scene scene = layer_scene();
    BodySpec& body = scene.bodies[0];
    body.ground = std::make_shared<Ground>(test::ground_of(
        {-2, -2}, 45, 1, false, [](double x, double y) { return 0.04 * ((x - 19) * (x - 19) + (y - 17) * (y - 17)); }));
    std::map<std::array<double, 2>, double> below;
    const double top = layer_top(body);
    const std::vector<Seed> seeds = seeds_of(scene);
    for (const Seed& s : seeds) {
        const auto [before, is_lowest] = below.try_emplace({s.x[0], s.x[1]}, s.x[2]);
        if (!is_lowest) {
            REQUIRE(s.volume == doctest::Approx(0.25 * 0.25 * (s.x[2] - before->second)).epsilon(0.02));
            before->second = s.x[2];
        }
        REQUIRE(s.x[2] < top);
    }
    CHECK(seeds.size() == 8 * below.size());
}

TEST_CASE("on a plane of 45 degrees a release of a cell, of 1.5 and of 4 cells has its volume and its rows") {
    Scene scene = layer_scene();
    BodySpec& body = scene.bodies[0];
    const double down = std::sqrt(0.5);  // along x and y
    body.ground = std::make_shared<Ground>(
        test::ground_of({-2, -2}, 45, 1, false, [&](double x, double y) { return 30 - down * (x + y); }));
    body.points = {{8, 8}, {30, 9}, {29, 31}, {20, 17.5}, {9, 28}};
    double area = 0;
    for (std::size_t i = 0, j = 4; i < 5; j = i++)
        area += 0.5 * (body.points[j][0] * body.points[i][1] - body.points[i][0] * body.points[j][1]);
    for (const auto& [cells, rows] : {std::pair(1.0, 2), std::pair(1.5, 3), std::pair(4.0, 8)}) {
        CAPTURE(cells);
        body.thickness = cells * scene.cell;
        double volume = 0;
        std::array<int, 8> in_row{};
        for (const Seed& s : seeds_of(scene)) {
            const double above = (s.x[2] - (30 - down * (s.x[0] + s.x[1]))) / std::sqrt(2.0);
            const double row = above / (body.thickness / rows) - 0.5;
            REQUIRE(row == doctest::Approx(std::round(row)).scale(1).epsilon(1e-9));
            REQUIRE((row > -0.5 && row < rows - 0.5));
            ++in_row[static_cast<std::size_t>(std::lround(row))];
            volume += s.volume;
        }
        CHECK(volume == doctest::Approx(body.thickness * area * std::sqrt(2.0)).epsilon(1e-9));
        for (int row = 1; row < rows; ++row) CHECK(in_row[static_cast<std::size_t>(row)] == in_row[0]);
    }
}

TEST_CASE("an area with the place of a single column is one column with the volume of the area") {
    Scene scene = layer_scene();
    BodySpec& body = scene.bodies[0];
    body.particles_per_cell = {2, 2, 1};
    body.thickness = scene.cell;
    body.points = {{20.1, 20.1}, {20.15, 20.1}, {20.15, 20.15}, {20.1, 20.15}};  // around (20.125, 20.125)
    const std::vector<Seed> seeds = seeds_of(scene);
    REQUIRE(seeds.size() == 1);
    const double u = 20.125 / 9, v = 20.125 / 11;
    const double zx = 0.6 + 4.0 / 9 * std::cos(u) * std::cos(v), zy = -4.0 / 11 * std::sin(u) * std::sin(v);
    const double volume = 0.5 * 0.05 * 0.05 * std::sqrt(1 + zx * zx + zy * zy);
    CHECK(seeds[0].volume / volume == doctest::Approx(1).epsilon(1e-3));
}
