#include <doctest/doctest.h>

#include <chrono>
#include <string>
#include <vector>

#include "comm/phases.hpp"
#include "comm/timeline.hpp"

using namespace moraine;

namespace {

std::vector<std::string> names_of(Timeline& timeline) {
    std::vector<std::string> names;
    for (const Span& span : timeline.sorted()) names.emplace_back(span.name.text);
    return names;
}

}  // namespace

TEST_CASE("a phase is a span that begins after the one it is in and ends before it") {
    Timeline timeline(100);
    Phases phases;
    phases.record(&timeline);
    timeline.begin_step(7);
    phases.group("step", [&] {
        phases.time(Phase::p2g, "P2G interior", [] {});
        phases.time(Phase::output, [&] { phases.time(Phase::agree, "agree on dt", [] {}); });
    });
    const std::vector<Span> spans = timeline.sorted();
    CHECK(names_of(timeline) == std::vector<std::string>{"step", "P2G interior", "output", "agree on dt"});
    for (const Span& span : spans) {
        CHECK(span.step == 7);
        CHECK(span.begin >= spans[0].begin);
        CHECK(span.begin + span.length <= spans[0].begin + spans[0].length);
    }
    CHECK(spans[1].begin + spans[1].length <= spans[2].begin);
    CHECK(spans[3].begin >= spans[2].begin);
    CHECK(spans[0].phase == -1);
    CHECK(spans[1].phase == static_cast<int>(Phase::p2g));
}

TEST_CASE("spans of a phase add up to its seconds") {
    Timeline timeline(10000);
    Phases phases;
    phases.record(&timeline);
    for (int k = 0; k < 1000; ++k) phases.time(Phase::nodes, [] {});
    std::int64_t sum = 0;
    for (const Span& span : timeline.sorted()) sum += span.length;
    CHECK(1e-9 * static_cast<double>(sum) == doctest::Approx(phases.seconds(Phase::nodes)).epsilon(1e-9));
}

TEST_CASE("memory is bounded, and whole steps are left from the first to the last") {
    constexpr std::size_t most = 64;
    Timeline timeline(most);
    const SteadyTime now = std::chrono::steady_clock::now();
    for (std::int64_t step = 0; step < 10000; ++step) {
        timeline.begin_step(step);
        for (const char* name : {"a", "b", "c"}) timeline.add(name, 0, now, now);
        CHECK(timeline.sorted().size() <= most);
    }
    CHECK(timeline.stride() == 512);  // 20 steps of 3 spans; of 256 they would be 40
    const std::vector<Span> spans = timeline.sorted();
    REQUIRE(spans.size() == 60);
    for (std::size_t k = 0; k < spans.size(); ++k) CHECK(spans[k].step == static_cast<std::int64_t>(512 * (k / 3)));
}

TEST_CASE("rare spans are kept in every step, and counted where there is no space for them") {
    Timeline timeline(16);
    const SteadyTime now = std::chrono::steady_clock::now();
    const auto step = [&](std::int64_t number, bool writes) {
        timeline.begin_step(number);
        timeline.add("step", -1, now, now);
        if (writes) timeline.add({"output", true}, 7, now, now);
    };
    for (std::int64_t k = 0; k < 100; ++k) step(k, k % 10 == 5);
    std::int64_t outputs = 0;
    for (const Span& span : timeline.sorted()) outputs += span.name.rare;
    CHECK(outputs == 10);
    CHECK(timeline.lost() == 0);
    for (std::int64_t k = 100; k < 120; ++k) step(k, true);
    CHECK(timeline.sorted().size() == 16);
    CHECK(timeline.lost() > 0);
}

TEST_CASE("ranks agree on a stride by forgetting more") {
    Timeline timeline(100);
    const SteadyTime now = std::chrono::steady_clock::now();
    for (std::int64_t step = 0; step < 8; ++step) {
        timeline.begin_step(step);
        timeline.add("step", -1, now, now);
    }
    timeline.thin(4);
    CHECK(timeline.sorted().size() == 2);
    timeline.thin(1);
    CHECK(timeline.stride() == 4);
}

TEST_CASE("a profiler hears of each span when it begins and when it ends") {
    static std::vector<std::string> heard;
    heard.clear();
    Phases phases;
    phases.tell({[](const char* name) { heard.emplace_back(name); }, [] { heard.emplace_back("end"); }});
    phases.group("step", [&] { phases.time(Phase::halo, "send halo", [] {}); });
    CHECK(heard == std::vector<std::string>{"step", "send halo", "end", "end"});
}
