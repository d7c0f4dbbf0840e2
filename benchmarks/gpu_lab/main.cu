// The kernel laboratory: variants of the device kernels, each checked, then timed in whole steps.
//
//   gpu_lab check                        every variant against the host, to the bit again
//   gpu_lab chosen                       the chosen kernels on a small box, for compute-sanitizer
//   gpu_lab time [single|double] [scene ...]   whole steps and kernels
//   gpu_lab variants [single|double]     each P2G and G2P at 16.8 M particles
//   gpu_lab profile [single|double]      40 steps for a profiler; launches 291 to 297 are the last step

#include "check.cuh"
#include "timing.cuh"

namespace {

using namespace lab;

const SceneSpec scenes[] = {{"column-16M", {128, 128, 128}, 128},
                            {"column-2M", {64, 64, 64}, 64},
                            {"slab-8M", {448, 448, 16}, 5},
                            {"column-64M", {200, 200, 200}, 200},
                            {"small-200k", {28, 32, 28}, 28}};

template <class Real>
bool check_all() {
    const auto p2g = p2g_variants<Real>();
    const auto g2p = g2p_variants<Real>();
    SceneSpec box{"box ", {16, 12, 16}, 16}, heap{"heap", {16, 20, 24}, 9};
    box.stride = 30, heap.stride = 2;
    bool good = true;
    for (const auto& g : g2p) good = check_step<Real>(box, 4, p2g[0], g, true) && good;
    for (const auto& a : p2g)
        if (!a.sums && std::strchr(a.name, ' ') == nullptr) good = check_step<Real>(heap, 5, a, g2p[0], true) && good;
    for (const auto& a : p2g)
        good = check_sums<Real>(heap, a, p2g[0], g2p[0],
                                std::strstr(a.name, "atomics") == nullptr && std::strstr(a.name, "warp") == nullptr) &&
               good;
    return good;
}

/// The chosen kernels alone on a small box: for compute-sanitizer.
template <class Real>
bool check_chosen() {
    SceneSpec box{"box ", {12, 12, 8}, 6};
    box.stride = 30;
    return check_step<Real>(box, 2, p2g_variants<Real>()[0], g2p_variants<Real>()[0], true);
}

template <class Real>
void time_variants() {
    const auto p2g = p2g_variants<Real>();
    const auto g2p = g2p_variants<Real>();
    for (const auto& a : p2g) time_p2g<Real>(scenes[0], a, p2g[0], g2p[0]);
    for (const auto& g : g2p) time_g2p<Real>(scenes[0], p2g[0], g);
    for (int every : {0, 8, 16, 32}) time_steps<Real>(scenes[0], p2g[0], g2p[0], every, 0, 64);
    time_steps<Real>(scenes[0], p2g[0], g2p[0], 16, 800, 64);
}

template <class Real>
void time_scenes(int argc, char** argv) {
    for (const SceneSpec& s : scenes) {
        bool wanted = argc == 0;
        for (int i = 0; i < argc; ++i) wanted = wanted || std::strcmp(argv[i], s.name) == 0;
        if (wanted) time_steps<Real>(s, p2g_variants<Real>()[0], g2p_variants<Real>()[0], 12, 0, 96);
    }
}

template <class Real>
void profile() {
    Stepper<Real> s;
    s.init(scenes[0]);
    s.refresh_every = 12;
    for (int i = 0; i < 40; ++i) s.step(p2g_variants<Real>()[0], g2p_variants<Real>()[0]);
    check(cudaDeviceSynchronize(), "profile");
}

}  // namespace

int main(int argc, char** argv) {
    const std::string verb = argc > 1 ? argv[1] : "";
    const bool both = argc < 3, single = both || std::strcmp(argv[2], "single") == 0;
    const bool twice = both || !single;
    if (verb == "check") return check_all<double>() & check_all<float>() ? 0 : 1;
    if (verb == "chosen") return check_chosen<double>() & check_chosen<float>() ? 0 : 1;
    print_machine();
    if (verb == "time") {
        if (single) time_scenes<float>(std::max(0, argc - 3), argv + 3);
        if (twice) time_scenes<double>(std::max(0, argc - 3), argv + 3);
    } else if (verb == "variants") {
        if (single) time_variants<float>();
        if (twice) time_variants<double>();
    } else if (verb == "profile") {
        if (single) profile<float>();
        if (twice) profile<double>();
    } else {
        std::fprintf(stderr, "What to do? (check, chosen, time, variants, profile)\n");
        return 2;
    }
    return 0;
}
