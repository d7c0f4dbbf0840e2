#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "balance/hilbert.hpp"

using namespace moraine;

namespace {

/// All blocks of a cube of 2^k a side, along the curve.
template <int Dim>
std::vector<BlockPosition<Dim>> cube(int side) {
    std::vector<BlockPosition<Dim>> blocks;
    const int count = Dim == 2 ? side * side : side * side * side;
    for (int i = 0; i < count; ++i) {
        BlockPosition<Dim> at{};
        for (int a = 0, rest = i; a < Dim; ++a, rest /= side) at[static_cast<std::size_t>(a)] = rest % side;
        blocks.push_back(at);
    }
    std::sort(blocks.begin(), blocks.end(), [](const BlockPosition<Dim>& x, const BlockPosition<Dim>& y) {
        return Hilbert<Dim>::encode(x) < Hilbert<Dim>::encode(y);
    });
    return blocks;
}

template <int Dim>
int distance(const BlockPosition<Dim>& x, const BlockPosition<Dim>& y) {
    int sum = 0;
    for (std::size_t a = 0; a < Dim; ++a) sum += std::abs(x[a] - y[a]);
    return sum;
}

template <int Dim>
void check_steps(int side) {
    const auto blocks = cube<Dim>(side);
    int jumps = 0;
    for (std::size_t i = 1; i < blocks.size(); ++i) jumps += distance<Dim>(blocks[i - 1], blocks[i]) != 1;
    CHECK(jumps == 0);
    CHECK(distance<Dim>(blocks.front(), blocks.back()) == side - 1);  // from a corner to the next one
}

}  // namespace

TEST_CASE("the Hilbert curve visits every block of a square and a cube, always going on to a neighbour") {
    for (int side : {2, 4, 8, 32}) check_steps<2>(side);
    for (int side : {2, 4, 8, 16}) check_steps<3>(side);
}

TEST_CASE("a part of the curve that fills an aligned cube is a curve through that cube") {
    std::vector<Key> keys;
    for (int i = 0; i < 512; ++i) keys.push_back(Hilbert<3>::encode({8 + i % 8, 16 + i / 8 % 8, i / 64}));
    std::sort(keys.begin(), keys.end());
    CHECK(keys.back() - keys.front() == 511);
    CHECK(std::adjacent_find(keys.begin(), keys.end()) == keys.end());
}

TEST_CASE("blocks below the domain's corner have keys too, different from all others") {
    std::vector<Key> keys;
    for (int x = -3; x < 3; ++x)
        for (int y = -3; y < 3; ++y) keys.push_back(Hilbert<2>::encode({x, y}));
    std::sort(keys.begin(), keys.end());
    CHECK(std::adjacent_find(keys.begin(), keys.end()) == keys.end());
}
