#include <doctest/doctest.h>

#include <cstdio>
#include <cstdlib>

#include "gpu/binning_pair.hpp"
#include "gpu/stopwatch.hpp"

using namespace moraine;

namespace {

using test::Chances;
using test::Plan;

template <int Dim>
void same_lists(const Plan<Dim>& plan, const Chances& chances, int steps = 6) {
    CAPTURE(plan.count[0]);
    CAPTURE(chances.leave);
    test::BinningPair<Dim> pair(plan);
    for (int n = 0; n < steps; ++n) pair.step(chances);
}

}  // namespace

TEST_CASE("the device files as the host does, in domains of one and more blocks that are their own neighbours") {
    for (const BlockPosition<2>& count : {BlockPosition<2>{1, 1}, {2, 1}, {3, 5}})
        same_lists<2>({.count = count}, {0.1, 0, 0.3});
    for (const BlockPosition<3>& count : {BlockPosition<3>{1, 1, 1}, {2, 1, 3}, {3, 4, 3}})
        same_lists<3>({.count = count, .particles = 100}, {0.1, 0, 0.3});
}

TEST_CASE("device and host lists agree where most blocks are empty and the domain has ends") {
    same_lists<2>({.count = {9, 7}, .periodic = false, .filled = 0.3}, {0.1, 0.02, 0.2});
    same_lists<3>({.count = {5, 6, 4}, .periodic = false, .filled = 0.3, .particles = 200}, {0.05, 0.02, 0.1});
}

TEST_CASE("device and host lists agree when all particles leave at once, when hardly any does, and when none does") {
    for (const Chances& chances : {Chances{1, 0, 1}, {0.002, 0, 0}, {0, 0, 0.002}, {0, 0, 0}}) {
        same_lists<2>({.count = {4, 4}}, chances);
        same_lists<3>({.count = {3, 3, 3}, .particles = 200}, chances);
    }
}

TEST_CASE("device and host lists agree in blocks of tens of thousands of particles, at first all in one cell") {
    same_lists<2>({.count = {3, 2}, .crammed = 70001}, {0.02, 0.001, 0.1}, 4);
    same_lists<3>({.count = {3, 2, 2}, .crammed = 70001}, {0.02, 0.001, 0.1}, 4);
    same_lists<3>({.count = {2, 2, 2}, .crammed = 40000}, {1, 0, 1}, 3);
}

TEST_CASE("particles that leave through an open wall leave the device's lists, down to the last") {
    test::BinningPair<3> pair({.count = {2, 3, 2}});
    for (double gone : {0.5, 1.0, 0.5}) pair.step({0.1, gone, 0.3});
    CHECK(pair.patch.count() == 0);
    CHECK(pair.device().boundary().empty());
    CHECK(pair.device().interior().empty());
}

TEST_CASE(
    "incoming particles from ghost blocks merge by the same rule, and boundary blocks are told from interior ones") {
    same_lists<2>({.count = {6, 5}, .ranks = 2, .filled = 0.7}, {0.1, 0.01, 0.2});
    same_lists<3>({.count = {4, 4, 3}, .ranks = 2, .filled = 0.7, .particles = 60}, {0.1, 0.01, 0.2});
    same_lists<3>({.count = {7, 7, 7}, .ranks = 40, .filled = 0.9, .particles = 60}, {0.1, 0, 0.2});
}

TEST_CASE("places add up over many chunks of blocks") {
    same_lists<2>({.count = {41, 37}, .filled = 0.6, .particles = 4}, {0.1, 0.01, 0.2}, 3);
    same_lists<3>({.count = {12, 11, 13}, .filled = 0.6, .particles = 4}, {0.1, 0.01, 0.2}, 3);
}

TEST_CASE("a share without blocks has empty lists") {
    test::DeviceLists<3> device(BlockTable<3>{}, {std::vector<std::uint32_t>{0}.data(), nullptr, nullptr}, {}, {}, 1);
    device.set_moves({}, {0});
    device.launch();
    device.advance();
    CHECK(device.first() == std::vector<std::uint32_t>{0});
    CHECK(device.boundary().empty());
    CHECK(device.interior().empty());
}

TEST_CASE("with fewer tiles than occupied blocks the lists serve no block, and all again once there are enough") {
    test::BinningPair<3> pair({.count = {3, 4, 3}, .filled = 0.6});
    test::DeviceLists<3>& lists = pair.device();
    const std::uint32_t occupied = lists.counts()[1];
    REQUIRE(occupied > 1);
    for (std::uint32_t tiles : {occupied - 1, occupied}) {
        lists.binning.occupied.tiles = tiles;
        gpu::number_blocks(lists.binning, nullptr);
        const std::vector<std::uint32_t> counts = lists.counts();
        CHECK(counts[1] == occupied);
        CHECK(counts[3] == (tiles < occupied ? 0 : occupied));
    }
}

TEST_CASE("timing of binning, where MORAINE_TIMING asks for it") {
    if (!std::getenv("MORAINE_TIMING")) return;
    const auto time = [](auto& pair, const char* what, const Chances& chances) {
        pair.move(chances);
        const std::vector<std::uint32_t> cells = pair.device().cell_first();
        const double ms = test::median_ms(
            20, [&] { pair.device().set_cell_first(cells.data()); }, [&] { pair.device().launch(); });
        std::printf("binning %s: %.2f M particles, %d blocks, %.4f ms\n", what, double(pair.patch.count()) * 1e-6,
                    pair.patch.own(), ms);
    };
    test::BinningPair<3> box({.count = {32, 32, 32}, .particles = 512, .even = true});
    time(box, "3-D, 10 % change cell, 1 % block", {0.01, 0, 0.09, true});
    time(box, "3-D, 1 % change cell, 0.1 % block", {0.001, 0, 0.009, true});
    time(box, "3-D, none moves", {0, 0, 0, true});
    test::BinningPair<3> sparse({.count = {64, 64, 64}, .filled = 0.02, .particles = 512, .even = true});
    time(sparse, "3-D, 2 % of the blocks filled", {0.01, 0, 0.09, true});
    test::BinningPair<2> plane({.count = {512, 512}, .particles = 64, .even = true});
    time(plane, "2-D, 10 % change cell, 1 % block", {0.01, 0, 0.09, true});
}
