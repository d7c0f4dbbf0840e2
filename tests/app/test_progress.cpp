#include <doctest/doctest.h>

#include <algorithm>
#include <string>

#include "app/progress.hpp"

using namespace moraine;

namespace {

/// What a run of `wall` seconds to t = 2 s says; a step takes 10 ms and counts 25 000 particle-steps.
std::string said(Progress::Style style, double wall) {
    std::FILE* file = std::tmpfile();
    Progress progress(style, 0, 2, 100, file);
    ProgressState state;
    const auto steps = static_cast<std::int64_t>(wall * 100);
    for (state.step = 1; state.step <= steps; ++state.step) {
        state.time = 2.0 * static_cast<double>(state.step) / static_cast<double>(steps);
        state.particle_steps += 25000;
        progress.report(state, 100 + 0.01 * static_cast<double>(state.step));
    }
    state.step = steps;
    progress.finish(state, 100 + wall + 0.001);
    std::string text(static_cast<std::size_t>(std::ftell(file)), ' ');
    std::rewind(file);
    CHECK(std::fread(text.data(), 1, text.size(), file) == text.size());
    std::fclose(file);
    return text;
}

auto count(const std::string& text, char c) {
    return std::count(text.begin(), text.end(), c);
}

}  // namespace

TEST_CASE("the line tells step, time, time to go, speed and imbalance") {
    CHECK(progress_line({1200, 0.25, 0, 1.0312}, 2, 3670, 2.514e6) ==
          "step 1200  t 0.25 of 2 s (12 %)  ETA 1:01:10  2.51 M particle-steps/s  imbalance 1.031");
    CHECK(progress_line({1, 2, 0, 1}, 2, 1.0 / 0.0, 4.5e9).find("ETA -  4.5 G particle-steps/s") != std::string::npos);
}

TEST_CASE("a log gets a line per five per cent, a minute at most without one, and the last") {
    CHECK(count(said(Progress::Style::lines, 2), '\n') == 1);
    CHECK(count(said(Progress::Style::lines, 50), '\n') == 10);     // not more often than every 5 s
    CHECK(count(said(Progress::Style::lines, 400), '\n') == 20);    // every 5 %
    CHECK(count(said(Progress::Style::lines, 6000), '\n') == 100);  // every minute
    CHECK(said(Progress::Style::lines, 50).find("2.5 M particle-steps/s") != std::string::npos);
    CHECK(count(said(Progress::Style::lines, 50), '\r') == 0);
}

TEST_CASE("a terminal gets one line, rewritten") {
    const std::string text = said(Progress::Style::terminal, 10);
    CHECK(count(text, '\n') == 1);
    CHECK(text.back() == '\n');
    CHECK(count(text, '\r') > 40);
    CHECK(text.find("ETA 0:00:05") != std::string::npos);
}

TEST_CASE("a quiet run and ranks other than 0 say nothing") {
    CHECK(said(Progress::Style::silent, 10).empty());
    CHECK(Progress::style_for(true, true) == Progress::Style::silent);
    CHECK(Progress::style_for(false, false) == Progress::Style::silent);
}
