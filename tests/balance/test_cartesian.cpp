#include <doctest/doctest.h>

#include <set>

#include "balance/cartesian.hpp"

using namespace moraine;
using Boxes = std::array<std::int32_t, 3>;

TEST_CASE("boxes are near-cubic, with more cuts along the longer axes") {
    CHECK(boxes_of({3, {16, 16, 16}}, 8) == Boxes{2, 2, 2});
    CHECK(boxes_of({3, {16, 16, 16}}, 64) == Boxes{4, 4, 4});
    CHECK(boxes_of({3, {64, 16, 16}}, 4) == Boxes{4, 1, 1});
    CHECK(boxes_of({3, {8, 32, 8}}, 4) == Boxes{1, 4, 1});
    CHECK(boxes_of({3, {32, 32, 8}}, 16) == Boxes{4, 4, 1});
    CHECK(boxes_of({2, {32, 16, 1}}, 8) == Boxes{4, 2, 1});
    CHECK(boxes_of({3, {12, 12, 12}}, 1) == Boxes{1, 1, 1});
}

TEST_CASE("a prime number of ranks is cut along the longest axis") {
    CHECK(boxes_of({3, {21, 35, 14}}, 7) == Boxes{1, 7, 1});
    CHECK(boxes_of({2, {28, 10, 1}}, 7) == Boxes{7, 1, 1});
}

TEST_CASE("equal boxes go before cubic ones") {
    CHECK(boxes_of({3, {20, 30, 10}}, 7) == Boxes{7, 1, 1});  // layers of 3 of 20 rather than 5 of 30
}

TEST_CASE("no rank is idle where the domain has a box for each") {
    CHECK(boxes_of({3, {3, 3, 2}}, 18) == Boxes{3, 3, 2});
    CHECK(boxes_of({2, {4, 2, 1}}, 8) == Boxes{4, 2, 1});
}

TEST_CASE("every place belongs to the box around it, and places beyond the domain to the outermost boxes") {
    const Cartesian boxes({2, {8, 6, 1}}, 6);  // 3 x 2 boxes or 2 x 3
    std::set<std::int32_t> ranks;
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 6; ++y) ranks.insert(boxes.owner_at({x, y, 0}));
    CHECK(ranks == std::set<std::int32_t>{0, 1, 2, 3, 4, 5});
    CHECK(boxes.owner_at({-1, -1, 0}) == boxes.owner_at({0, 0, 0}));
    CHECK(boxes.owner_at({9, 7, 0}) == boxes.owner_at({7, 5, 0}));
    const Cartesian cubes({3, {4, 4, 4}}, 8);
    CHECK(cubes.owner_at({0, 0, 0}) == 0);
    CHECK(cubes.owner_at({2, 0, 0}) == 1);
    CHECK(cubes.owner_at({1, 2, 1}) == 2);
    CHECK(cubes.owner_at({3, 3, 3}) == 7);
    CHECK(cubes.is_static());
}

TEST_CASE("blocks are owned by the place where they are") {
    const Cartesian cubes({3, {4, 4, 4}}, 8);
    const std::vector<BlockLoad> blocks{{Morton<3>::encode({0, 0, 0}), 1, 1, -1},
                                        {Morton<3>::encode({3, 1, 2}), 1, 1, -1}};
    CHECK(cubes.owners(blocks, 0) == std::vector<std::int32_t>{0, 5});
}
