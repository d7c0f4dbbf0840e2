#include "app/step_timing.hpp"

#include <fmt/format.h>
#include <omp.h>

#include <chrono>

#include "predict/prediction.hpp"
#include "predict/step_speed.hpp"
#include "simulation/simulation.hpp"

namespace moraine {
namespace {

constexpr double wanted = 1;  // [s] of steps

struct Timing {
    std::int64_t steps = 0;
    double seconds = 0;
    bool whole = false;  ///< the scene ended within it
};

double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// All ranks stop after the same step: when rank 0's second is over. Collective.
template <class Real, int Dim>
Timing measure(const Scene& scene, const Comm& comm, const DeviceChoice& device) {
    Simulation<Real, Dim> sim(scene, comm, device.cuda ? device_engine_maker<Real, Dim>(scene, comm, device) : nullptr);
    sim.seed();
    Timing timing;
    const auto ended = [&] { return sim.clock().time >= scene.end; };
    if (!ended()) sim.step(), sim.balance();
    sim.conclude();
    const double start = now();
    while (!ended() && comm.max(std::int64_t(comm.is_root() && now() - start >= wanted)) == 0) {
        sim.step();
        sim.balance();
        ++timing.steps;
    }
    sim.conclude();
    timing.seconds = comm.max(now() - start);
    timing.whole = ended();
    return timing;
}

Timing measure(const Scene& scene, const Comm& comm, const DeviceChoice& device) {
    const bool in_double = scene.precision == Precision::double_;
    if (scene.dimensions == 2)
        return in_double ? measure<double, 2>(scene, comm, device) : measure<float, 2>(scene, comm, device);
    return in_double ? measure<double, 3>(scene, comm, device) : measure<float, 3>(scene, comm, device);
}

}  // namespace

std::string time_steps(const Scene& scene, const Comm& comm, const DeviceChoice& device) {
    const Timing timing = measure(scene, comm, device);
    const std::string ranks = fmt::format("{} rank{}", comm.size(), comm.size() == 1 ? "" : "s");
    const int threads = omp_get_max_threads();
    const std::string where =
        device.cuda ? ranks + " on CUDA"
                    : fmt::format("{} of {} thread{} on the host", ranks, threads, threads == 1 ? "" : "s");
    if (timing.whole) return fmt::format("{} for the whole run ({})", duration_text(timing.seconds), where);
    const double each = timing.seconds / static_cast<double>(timing.steps);
    return fmt::format("about {} by {} steps of {:.3g} ms ({}), without outputs",
                       duration_text(each * predict(scene).steps), timing.steps, 1e3 * each, where);
}

}  // namespace moraine
