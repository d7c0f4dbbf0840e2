#pragma once
// Times of steps: one after the other, by kernels, and as a graph.

#include <cstdio>
#include <string>

#include "device_lab/share.cuh"

namespace moraine::gpu::lab {

using moraine::lab::ColumnPlan;

struct Options {
    ColumnPlan plan;
    std::vector<int> edges{128, 64, 29};
    int steps = 62, warm_up = 10, check_edge = 40, check_steps = 40;
    std::string precision = "both", only;
};

inline std::string number(const char* key, double x) {
    char text[100];
    std::snprintf(text, sizeof(text), "\"%s\": %.3g", key, x);
    return text;
}
/// Time between marks.
class Watch {
  public:
    Watch(std::size_t marks, cudaStream_t stream) : stream_(stream), event_(marks + 1) {
        for (auto& e : event_) check(cudaEventCreate(&e), "Timing");
        mark(0);
    }
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;
    ~Watch() {
        for (auto& e : event_) cudaEventDestroy(e);
    }
    void mark(std::size_t k) const { check(cudaEventRecord(event_[k], stream_), "Timing"); }
    double between(std::size_t from, std::size_t to) const {
        check(cudaEventSynchronize(event_[to]), "Timing");
        float ms = 0;
        check(cudaEventElapsedTime(&ms, event_[from], event_[to]), "Timing");
        return ms;
    }

  private:
    cudaStream_t stream_;
    std::vector<cudaEvent_t> event_;
};

inline constexpr auto unmarked = [](int) {};

template <class Share>
double time_steps(Share& share, int steps) {
    const Watch whole(1, share.stream());
    for (int i = 0; i < steps; ++i) share.step(unmarked);
    whole.mark(1);
    return whole.between(0, 1) / steps;
}

/// The same as a graph of two steps.
template <class Share>
double time_graph(Share& share, int steps) {
    cudaGraph_t graph = nullptr;
    cudaGraphExec_t run = nullptr;
    check(cudaStreamBeginCapture(share.stream(), cudaStreamCaptureModeThreadLocal), "Capturing");
    share.step(unmarked), share.step(unmarked);
    check(cudaStreamEndCapture(share.stream(), &graph), "Capturing");
    check(cudaGraphInstantiate(&run, graph, 0), "Making a graph");
    check(cudaGraphLaunch(run, share.stream()), "Launching a graph");
    const Watch whole(1, share.stream());
    for (int i = 0; i < steps / 2; ++i) check(cudaGraphLaunch(run, share.stream()), "Launching a graph");
    whole.mark(1);
    const double ms = whole.between(0, 1) / (steps / 2 * 2);
    cudaGraphExecDestroy(run);
    cudaGraphDestroy(graph);
    return ms;
}

/// Microseconds of each kernel.
template <class Share>
std::string time_phases(Share& share, int steps) {
    constexpr std::size_t phases = Share::phase_count;
    const Watch watch(phases * std::size_t(steps), share.stream());
    for (int i = 0; i < steps; ++i)
        share.step([&](int k) { watch.mark(std::size_t(i) * phases + std::size_t(k) + 1); });
    std::string parts;
    for (std::size_t k = 0; k < phases; ++k) {
        std::vector<double> each;
        double sum = 0;
        for (int i = 0; i < steps; ++i) {
            const std::size_t at = std::size_t(i) * phases + k;
            each.push_back(1e3 * watch.between(at, at + 1));
            sum += each.back();
        }
        std::sort(each.begin(), each.end());
        char text[200];
        std::snprintf(text, sizeof(text), "%s\"%s\": {\"mean\": %.1f, \"median\": %.1f, \"most\": %.1f}", k ? ", " : "",
                      Share::phases[k], sum / steps, each[each.size() / 2], each.back());
        parts += text;
    }
    return parts;
}

inline void print_time(const char* name, const char* precision, std::size_t particles, double ms,
                       const std::string& more) {
    std::printf("{\"precision\": \"%s\", \"step\": \"%s\", \"particles\": %zu, \"ms\": %.4f, \"G_per_s\": %.3f%s}\n",
                precision, name, particles, ms, double(particles) / ms * 1e-6, more.c_str());
    std::fflush(stdout);
}

template <class Share>
void measure(const std::string& name, const char* precision, std::size_t particles, Share& share, const Options& o) {
    for (int i = 0; i < o.warm_up; ++i) share.step(unmarked);
    const double ms = time_steps(share, o.steps);
    print_time(name.c_str(), precision, particles, ms, ", \"us\": {" + time_phases(share, o.steps) + "}");
}

}  // namespace moraine::gpu::lab
