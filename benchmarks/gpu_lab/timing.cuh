#pragma once
// Times by device events over real steps: particles move, lists change, memory goes stale and is refreshed.

#include <functional>

#include "variants.cuh"

namespace lab {

inline double median(std::vector<float> t) {
    std::sort(t.begin(), t.end());
    return t.empty() ? 0 : double(t[t.size() / 2]);
}

class Stopwatch {
  public:
    Stopwatch() { check(cudaEventCreate(&a_), "event"), check(cudaEventCreate(&b_), "event"); }
    ~Stopwatch() { cudaEventDestroy(a_), cudaEventDestroy(b_); }
    template <class F>
    float time(const F& f) {
        check(cudaEventRecord(a_), "event");
        f();
        check(cudaEventRecord(b_), "event");
        check(cudaEventSynchronize(b_), "event");
        check(cudaGetLastError(), "kernel");
        float ms = 0;
        check(cudaEventElapsedTime(&ms, a_, b_), "event");
        return ms;
    }

  private:
    cudaEvent_t a_{}, b_{};
};

/// Device-to-device copy, bytes read and written per second.
inline double copy_bandwidth() {
    static double rate = 0;
    if (rate > 0) return rate;
    const std::size_t n = std::size_t(2) << 30;
    Device<char> a, b;
    a.resize(n), b.resize(n);
    Stopwatch w;
    std::vector<float> t;
    for (int i = 0; i < 12; ++i)
        t.push_back(w.time([&] { check(cudaMemcpyAsync(b.data(), a.data(), n, cudaMemcpyDeviceToDevice), "copy"); }));
    return rate = 2 * double(n) / (median(t) * 1e-3);
}

inline void print_machine() {
    cudaDeviceProp p;
    check(cudaGetDeviceProperties(&p, 0), "device");
    int driver = 0;
    check(cudaDriverGetVersion(&driver), "driver");
    std::printf("%s, %d multiprocessors, CUDA driver %d, copy %.2f TB/s\n", p.name, p.multiProcessorCount, driver,
                copy_bandwidth() * 1e-12);
}

/// Bytes per particle-step that must move at least: what each kernel reads and writes once.
struct Traffic {
    double file, p2g, nodes, g2p;
};
template <class Real>
Traffic traffic(const Stepper<Real>& s) {
    const double n = s.count, r = sizeof(Real), tile = double(s.v.blocks) * tile_nodes * 8 * r,
                 node = double(s.v.node_blocks) * cells * 8 * r;
    return {n * (2 + 4 + 4), n * (16 * r + 4) + tile, tile + node, n * (32 * r + 4 + 2) + node};
}

template <class Real>
void print_kernel(const Stepper<Real>& s, const char* what, const char* name, double ms, double bytes) {
    std::printf("  %-6s %-4s %-15s %8.4f ms %7.2f G/s %8.1f MB %5.1f %% of copy\n",
                sizeof(Real) == 4 ? "single" : "double", what, name, ms, s.count / ms * 1e-6, bytes * 1e-6,
                100 * bytes / (ms * 1e-3) / copy_bandwidth());
}

/// Whole steps back to back; then kernels one by one. Hash of the end of both runs.
template <class Real>
void time_steps(const SceneSpec& spec, const P2gVariant<Real>& a, const G2pVariant<Real>& b, int every, int ahead,
                int steps) {
    Stepper<Real> s;
    std::uint64_t hash[2];
    std::vector<float> runs;
    Stopwatch w;
    for (int r = 0; r < 5; ++r) {
        s.ahead = ahead;
        s.init(spec);
        s.refresh_every = every;
        for (int i = 0; i < 8; ++i) s.step(a, b);
        runs.push_back(w.time([&] {
            for (int i = 0; i < steps; ++i) s.step(a, b);
        }) / float(steps));
        if (r < 2) hash[r] = s.hash();
    }
    std::vector<float> part[5];
    for (int i = 0; i < 16; ++i) {
        part[0].push_back(w.time([&] { s.file(); }));
        if (i % 8 == 0 && every > 0) part[4].push_back(w.time([&] { s.refresh(); }));
        part[1].push_back(w.time([&] { s.p2g(a); }));
        part[2].push_back(w.time([&] { s.nodes(); }));
        part[3].push_back(w.time([&] { s.g2p(b); }));
    }
    std::uint32_t faults = 0;
    float moved = 0;
    for (const Outcome& o : s.outcome_.host()) faults |= o.faults, moved = std::max(moved, o.moved);
    std::size_t free_bytes = 0, total_bytes = 0;
    check(cudaMemGetInfo(&free_bytes, &total_bytes), "memory");
    const Traffic t = traffic(s);
    const double ms = median(runs);
    std::printf(
        "%s %s: %.2f M particles, refresh every %d, ahead %d: %.4f ms/step (%.4f to %.4f), %.2f G particle-steps/s, "
        "%.0f B/particle, moved %.3f cells, faults %u, %s\n",
        spec.name, sizeof(Real) == 4 ? "single" : "double", s.count * 1e-6, every, ahead, ms,
        double(*std::min_element(runs.begin(), runs.end())), double(*std::max_element(runs.begin(), runs.end())),
        s.count / ms * 1e-6, double(total_bytes - free_bytes) / s.count, double(moved), faults,
        hash[0] == hash[1] ? "same to the bit" : "RUNS DIFFER");
    print_kernel(s, "file", "", median(part[0]), t.file);
    print_kernel(s, "p2g", a.name, median(part[1]), t.p2g);
    print_kernel(s, "node", "", median(part[2]), t.nodes);
    print_kernel(s, "g2p", b.name, median(part[3]), t.g2p);
    if (every > 0) print_kernel(s, "fresh", "", median(part[4]), double(s.count) * (32 * sizeof(Real) + 24));
    std::fflush(stdout);
}

/// One P2G over moving particles; the step goes on with `base`.
template <class Real>
void time_p2g(const SceneSpec& spec, const P2gVariant<Real>& variant, const P2gVariant<Real>& base,
              const G2pVariant<Real>& b) {
    static Stepper<Real> s;
    s.init(spec);
    s.refresh_every = 16;
    std::vector<float> t;
    Stopwatch w;
    for (int i = 0; i < 24; ++i) {
        s.step(base, b);
        if (i >= 8 && i % 2 == 0)
            s.file(), ++s.steps, t.push_back(w.time([&] { s.p2g(variant); })), s.p2g(base), s.nodes(), s.g2p(b);
    }
    print_kernel(s, "p2g", variant.name, median(t), traffic(s).p2g);
    std::fflush(stdout);
}

template <class Real>
void time_g2p(const SceneSpec& spec, const P2gVariant<Real>& a, const G2pVariant<Real>& variant) {
    static Stepper<Real> s;
    s.init(spec);
    s.refresh_every = 16;
    std::vector<float> t;
    Stopwatch w;
    for (int i = 0; i < 24; ++i) {
        s.step(a, variant);
        if (i >= 8) s.file(), ++s.steps, s.p2g(a), s.nodes(), t.push_back(w.time([&] { s.g2p(variant); }));
    }
    print_kernel(s, "g2p", variant.name, median(t), traffic(s).g2p);
    std::fflush(stdout);
}

}  // namespace lab
