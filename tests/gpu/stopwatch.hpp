#pragma once
// Times of work on the device by events, for the timing modes of the tests: MORAINE_TIMING=1 in the environment.
//
// A time covers the launches of `work`, so that of a single small kernel holds two or three microseconds of launching.

#include <algorithm>
#include <vector>

#include "gpu/memory/array.hpp"

namespace moraine::test {

/// Median over `runs` of what `work` takes on the default stream [ms]; `prepare` goes before each, untimed.
template <class Prepare, class Work>
double median_ms(int runs, const Prepare& prepare, const Work& work) {
    cudaEvent_t start{}, end{};
    gpu::check(cudaEventCreate(&start), "Making an event");
    gpu::check(cudaEventCreate(&end), "Making an event");
    std::vector<float> all;
    for (int n = 0; n < runs; ++n) {
        prepare();
        gpu::check(cudaEventRecord(start), "Recording an event");
        work();
        gpu::check(cudaEventRecord(end), "Recording an event");
        gpu::check(cudaEventSynchronize(end), "Waiting for an event");
        float ms = 0;
        gpu::check(cudaEventElapsedTime(&ms, start, end), "Timing");
        all.push_back(ms);
    }
    cudaEventDestroy(start), cudaEventDestroy(end);
    std::sort(all.begin(), all.end());
    return double(all[all.size() / 2]);
}

}  // namespace moraine::test
