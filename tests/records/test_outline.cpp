#include <doctest/doctest.h>

#include <random>
#include <set>

#include "records/outline.hpp"

using namespace moraine;

namespace {

/// Rows from north to south, as one reads them.
std::vector<Rings> outline(const std::string& picture) {
    std::vector<PlanCell> reached;
    for (std::int64_t k = 0; k < 30; ++k)
        if (picture[static_cast<std::size_t>(k)] == '#') reached.push_back({k % 6, 4 - k / 6});
    return outline_of(reached, {{6, 5}, {10, 20}, 2, {10, 20}, {22, 30}});
}

double area_of(const std::vector<std::array<double, 2>>& ring) {
    double sum = 0;
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++)
        sum += ring[j][0] * ring[i][1] - ring[i][0] * ring[j][1];
    return 0.5 * sum;
}

}  // namespace

TEST_CASE("a block of cells is a rectangle, counter-clockwise") {
    const auto found = outline(
        "......"
        ".###.."
        ".###.."
        "......"
        "......");
    REQUIRE(found.size() == 1);
    CHECK(found[0] == Rings{{{12, 24}, {18, 24}, {18, 28}, {12, 28}}});
    CHECK(outline(std::string(30, '.')).empty());
    CHECK(area_of(outline(std::string(30, '#'))[0][0]) == 120);
}

TEST_CASE("holes are in the polygon around them, and cells that share a corner are polygons that meet") {
    const auto ring = outline(
        "###..."
        "#.#.##"
        "###.##"
        "......"
        "#.....");
    REQUIRE(ring.size() == 3);
    double total = 0;
    for (const Rings& polygon : ring) {
        CHECK(area_of(polygon[0]) > 0);
        for (const auto& r : polygon) total += area_of(r);
    }
    CHECK(total == 4 * 13);
    CHECK(outline("#....."
                  ".#...."
                  "......"
                  "......"
                  "......")
              .size() == 2);
    const auto closed = outline(
        "###..."
        "#.#..."
        "##.#.."
        ".####."
        "......");  // a loop that a corner closes
    REQUIRE(closed.size() == 1);
    CHECK(closed[0].size() == 3);
}

TEST_CASE("of any cells the polygons have their area, and no ring comes to a corner twice") {
    std::mt19937 random(4);
    for (int k = 0; k < 2000; ++k) {
        std::string picture(30, '.');
        for (char& c : picture) c = random() % 5 < 3 ? '#' : '.';
        double total = 0;
        for (const Rings& polygon : outline(picture)) {
            REQUIRE(!polygon.empty());
            for (std::size_t r = 0; r < polygon.size(); ++r) {
                CHECK((area_of(polygon[r]) > 0) == (r == 0));
                total += area_of(polygon[r]);
                CHECK(std::set(polygon[r].begin(), polygon[r].end()).size() == polygon[r].size());
            }
        }
        REQUIRE(total == doctest::Approx(4.0 * double(std::count(picture.begin(), picture.end(), '#'))));
    }
}

TEST_CASE("flows that are a thousand million cells apart take no memory for what is between them") {
    const std::int64_t far = 1000000000;
    const auto found =
        outline_of({{far, far}, {0, 0}, {far, far - 1}}, {{far + 9, far + 9}, {0, 0}, 1, {0, 0}, {1e9 + 9, 1e9 + 9}});
    REQUIRE(found.size() == 2);
    CHECK(found[0] == Rings{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}});
    CHECK(found[1][0].size() == 4);
}

TEST_CASE("as GeoJSON every ring is closed") {
    const std::string text = outline_json(outline("#....."
                                                  "......"
                                                  "......"
                                                  "......"
                                                  "......"),
                                          0.25);
    CHECK(text.find("\"threshold\": 0.25") != std::string::npos);
    CHECK(text.find("[[[10, 28], [12, 28], [12, 30], [10, 30], [10, 28]]]") != std::string::npos);
}
