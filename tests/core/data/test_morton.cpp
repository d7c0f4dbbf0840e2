#include <doctest/doctest.h>

#include "core/data/morton.hpp"

using namespace moraine;

TEST_CASE("a block's position survives its key, also below the domain's corner") {
    for (int x : {-1048576, -7, -1, 0, 1, 63, 64, 1048575})
        for (int y : {-3, 0, 1000}) {
            CHECK(Morton<3>::decode(Morton<3>::encode({x, y, -x - 1})) == BlockPosition<3>{x, y, -x - 1});
            CHECK(Morton<2>::decode(Morton<2>::encode({x, y})) == BlockPosition<2>{x, y});
        }
}

TEST_CASE("the curve visits the four blocks of a square as a Z, x first") {
    const Key k = Morton<2>::encode({0, 0});
    CHECK(Morton<2>::encode({1, 0}) == k + 1);
    CHECK(Morton<2>::encode({0, 1}) == k + 2);
    CHECK(Morton<2>::encode({1, 1}) == k + 3);
}
