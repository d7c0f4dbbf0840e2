#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "scene/scene_text.hpp"
#include "seeding/seed.hpp"

using namespace moraine;

namespace {

/// A scene of one body.
Scene scene_of(int dimensions, const std::string& body) {
    const bool flat = dimensions == 2;
    return read_text("dimensions = " + std::to_string(dimensions) + "\nseed = 5\n[domain]\nmin = " +
                     (flat ? "[-1.0, 0.0]\nmax = [3.0, 2.0]" : "[-1.0, 0.0, 0.0]\nmax = [3.0, 2.0, 2.0]") +
                     "\ncell = 0.1\n[time]\nend = 1.0\n[[material]]\nname = \"m\"\nlaw = \"linear-elastic\"\n"
                     "density = 1500.0\nyoung = 1e5\npoisson = 0.3\n[[body]]\nname = \"b\"\nmaterial = \"m\"\n" +
                     body);
}

std::vector<Seed> seeds_in(const Scene& scene, int parts) {
    const std::int64_t rows = seed_rows(scene, 0);
    const std::int64_t total = seed_count(scene, 0, 0, rows);
    std::vector<Seed> seeds;
    for (int p = 0; p < parts; ++p) seed_body(scene, 0, rows * p / parts, rows * (p + 1) / parts, total, seeds);
    return seeds;
}

double mass_of(const std::vector<Seed>& seeds) {
    double sum = 0;
    for (const Seed& s : seeds) sum += s.mass;
    return sum;
}

const std::string flat_box = "shape = \"box\"\nmin = [0.0, 0.0]\nmax = [1.03, 0.5]\n";
const std::string box = "shape = \"box\"\nmin = [0.0, 0.0, 0.0]\nmax = [1.0, 0.5, 0.37]\n";
const std::string triangle = "shape = \"polygon\"\npoints = [[0, 0], [0.5, 1.5], [1.5, 0.2]]\n";
const std::string prism = triangle + "z = [0.3, 0.9]\n";
const std::string disk = "shape = \"sphere\"\ncenter = [1.0, 1.0]\nradius = 0.8\n";
const std::string ball = "shape = \"sphere\"\ncenter = [1.0, 1.0, 1.0]\nradius = 0.6\n";
const std::string jitter = "seeding = \"jittered\"\njitter = 0.5\n";

struct Case {
    int dimensions;
    std::string body;
    double measure;
};
const double pi = std::numbers::pi;
const std::vector<Case> cases{
    {2, flat_box, 0.515},
    {3, box, 0.185},
    {2, triangle, 1.075},
    {3, prism, 1.075 * 0.6},
    {2, disk, pi * 0.64},
    {3, ball, 4 * pi * 0.216 / 3},
    {2, flat_box + jitter, 0.515},
    {2, triangle + jitter, 1.075},
    {3, ball + jitter, 4 * pi * 0.216 / 3},
};

}  // namespace

TEST_CASE("a body's mass is its density times its exact volume") {
    for (const Case& c : cases) {
        CAPTURE(c.body);
        const Scene scene = scene_of(c.dimensions, c.body);
        const std::vector<Seed> seeds = seeds_in(scene, 1);
        CHECK(mass_of(seeds) == doctest::Approx(1500 * c.measure).epsilon(1e-12));
        CHECK(static_cast<std::int64_t>(seeds.size()) == seed_count(scene, 0, 0, seed_rows(scene, 0)));
    }
}

TEST_CASE("a box has its particles per cell, and a row more where it is longer") {
    CHECK(seeds_in(scene_of(2, flat_box), 1).size() == 21 * 10);
    CHECK(seeds_in(scene_of(3, box), 1).size() == 20 * 10 * 7);
    CHECK(seeds_in(scene_of(3, box + "particles_per_cell = [1, 2, 3]\n"), 1).size() == 10 * 10 * 11);
}

TEST_CASE("the particles are the same for any division into rows") {
    for (const Case& c : cases)
        for (int parts : {2, 3, 7, 100}) {
            CAPTURE(c.body);
            const Scene scene = scene_of(c.dimensions, c.body);
            const std::vector<Seed> whole = seeds_in(scene, 1);
            const std::vector<Seed> divided = seeds_in(scene, parts);
            REQUIRE(whole.size() == divided.size());
            bool same = true;
            for (std::size_t k = 0; k < whole.size(); ++k)
                same = same && whole[k].id == divided[k].id && whole[k].x == divided[k].x &&
                       whole[k].mass == divided[k].mass && whole[k].velocity == divided[k].velocity;
            CHECK(same);
        }
}

TEST_CASE("ids are unique and name the body") {
    for (const Case& c : cases) {
        std::set<std::uint64_t> ids;
        const std::vector<Seed> seeds = seeds_in(scene_of(c.dimensions, c.body), 1);
        for (const Seed& s : seeds) ids.insert(s.id);
        CHECK(ids.size() == seeds.size());
        CHECK((*ids.rbegin() >> 48) == 0);
    }
    const Scene two = read_text(good_scene);
    std::vector<Seed> seeds;
    seed_body(two, 1, 0, seed_rows(two, 1), 1, seeds);
    for (const Seed& s : seeds) CHECK((s.id >> 48) == 1);
}

TEST_CASE("every particle is inside its body, jittered or not") {
    for (const Case& c : cases) {
        const Scene scene = scene_of(c.dimensions, c.body);
        bool inside = true;
        for (const Seed& s : seeds_in(scene, 1)) inside = inside && is_inside(scene.bodies[0], c.dimensions, s.x);
        CHECK(inside);
    }
}

TEST_CASE("jitter moves by at most its share of the spacing, and on average not at all") {
    const Scene still = scene_of(2, flat_box);
    const Scene moved = scene_of(2, flat_box + "seeding = \"jittered\"\njitter = 0.4\n");
    const std::vector<Seed> a = seeds_in(still, 1);
    const std::vector<Seed> b = seeds_in(moved, 1);
    REQUIRE(a.size() == b.size());
    double most = 0, mean = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
        most = std::max(most, std::abs(b[k].x[1] - a[k].x[1]));
        mean += (b[k].x[1] - a[k].x[1]) / static_cast<double>(a.size());
    }
    CHECK(most <= 0.4 * 0.05);
    CHECK(most > 0.9 * 0.4 * 0.05);
    CHECK(std::abs(mean) < 0.1 * 0.05);
}

TEST_CASE("another seed gives other places of the same particles") {
    Scene scene = scene_of(2, flat_box + jitter);
    const std::vector<Seed> a = seeds_in(scene, 1);
    scene.seed = 6;
    const std::vector<Seed> b = seeds_in(scene, 1);
    CHECK(a[0].id == b[0].id);
    CHECK(a[0].x != b[0].x);
}

TEST_CASE("a wave is in the velocity of the start") {
    const Scene scene = scene_of(
        2,
        flat_box +
            "velocity = [1.0, 0.0]\nwave = { velocity = [0.0, 2.0], axis = \"x\", wavelength = 4.0, origin = 0.5 }\n");
    for (const Seed& s : seeds_in(scene, 1)) {
        CHECK(s.velocity[0] == 1);
        CHECK(s.velocity[1] == doctest::Approx(2 * std::sin(2 * pi * (s.x[0] - 0.5) / 4)));
    }
}

TEST_CASE("a polygon may go round either way") {
    const std::string back = "shape = \"polygon\"\npoints = [[0, 0], [1.5, 0.2], [0.5, 1.5]]\n";
    CHECK(seeds_in(scene_of(2, back), 1).size() == seeds_in(scene_of(2, triangle), 1).size());
    CHECK(mass_of(seeds_in(scene_of(2, back), 1)) == doctest::Approx(1500 * 1.075).epsilon(1e-12));
}
