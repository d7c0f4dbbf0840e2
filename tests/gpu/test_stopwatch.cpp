#include <doctest/doctest.h>

#include <vector>

#include "gpu/memory/stopwatch.hpp"

using namespace moraine::gpu;

// One step in so many is timed, and those up to the next one count as long as it (gpu/memory/stopwatch.hpp).

namespace {

/// Steps on a stream; `work` says how long the parts are.
class Steps {
  public:
    Steps() { memory_.resize(1 << 26); }

    Stopwatch watch;

    void parts(const std::array<int, Stopwatch::parts>& work) {
        for (int k = 0; k < Stopwatch::parts; ++k) {
            if (k > 0) watch.begin(k, stream_);
            for (int i = 0; i < work[static_cast<std::size_t>(k)]; ++i)
                check(cudaMemsetAsync(memory_.data(), i, memory_.size(), stream_), "Working");
            watch.end(k, stream_);
        }
    }
    Stopwatch::Seconds step(const std::array<int, Stopwatch::parts>& work = {2, 1, 2}) {
        watch.begin_step(stream_);
        parts(work);
        return take();
    }
    Stopwatch::Seconds take() {
        stream_.wait();
        return watch.take();
    }
    cudaStream_t stream() const { return stream_; }

  private:
    Stream stream_;
    Array<unsigned char> memory_;
};

/// Numbers of the steps that were timed: their times differ from those of the step before.
std::vector<int> timed(Steps& steps, int count) {
    std::vector<int> found;
    Stopwatch::Seconds before{};
    for (int k = 0; k < count; ++k) {
        const Stopwatch::Seconds now = steps.step({1 + k % 3, 1, 1 + k % 5});
        CHECK(now[0] > 0);
        CHECK(now[1] > 0);
        CHECK(now[2] > 0);
        if (now != before) found.push_back(k);
        before = now;
    }
    return found;
}

}  // namespace

TEST_CASE("one step in four is timed, the others count as long as it, and each is told once") {
    Steps steps;
    steps.watch.begin(0, steps.stream());  // the first one of a run has nothing to bin
    steps.parts({2, 1, 2});
    CHECK(steps.take()[0] > 0);
    CHECK(steps.take() == Stopwatch::Seconds{});
    CHECK(timed(steps, 9) == std::vector<int>{0, 3, 7});  // 0: those of the first one are told again
    CHECK(steps.take() == Stopwatch::Seconds{});
}

TEST_CASE("rounds of a step are timed alike, and the last one is told") {
    Steps steps;
    for (int k = 0; k < 9; ++k) {
        steps.watch.begin_step(steps.stream());
        steps.parts({1, 1, 1});
        steps.watch.begin(0, steps.stream());
        steps.parts({k < 4 ? 20 : 60, 1, 1});
        const Stopwatch::Seconds now = steps.take();
        if (k >= 3) CHECK(now[0] > 5 * now[1]);
        if (k < 3) CHECK(now == Stopwatch::Seconds{});
    }
}

TEST_CASE("a step that is like no other leaves its turn to the next one") {
    Steps steps;
    steps.watch.begin(0, steps.stream());
    steps.parts({1, 1, 1});
    const Stopwatch::Seconds first = steps.take();
    for (int k = 1; k < 4; ++k) CHECK(steps.step({9, 9, 9}) == first);
    steps.watch.begin_step(steps.stream());
    steps.watch.skip();
    steps.parts({9, 9, 9});
    CHECK(steps.take() == first);
    CHECK(steps.step({3, 3, 3}) != first);
}

TEST_CASE("a step whose beginning is told again is timed, and where few are the host's all are") {
    Steps steps;
    steps.watch.begin(0, steps.stream());
    steps.parts({1, 1, 1});
    const Stopwatch::Seconds first = steps.take();
    steps.watch.begin_step(steps.stream());
    steps.watch.begin_again(steps.stream());
    steps.parts({3, 3, 3});
    const Stopwatch::Seconds second = steps.take();
    CHECK(second != first);
    CHECK(steps.step({1, 1, 1}) == second);
    steps.watch.time_all();
    CHECK(timed(steps, 5) == std::vector<int>{0, 1, 2, 3, 4});
}
