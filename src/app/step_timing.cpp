#include "app/step_timing.hpp"

#include <fmt/format.h>
#include <omp.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>

#include "io/vtkhdf.hpp"
#include "predict/prediction.hpp"
#include "predict/step_speed.hpp"
#include "records/frame_choice.hpp"
#include "simulation/simulation.hpp"

namespace moraine {
namespace {

constexpr double wanted = 1;           // [s] of steps
constexpr double most_written = 10e9;  // [B]: an output above that is not tried

struct Timing {
    std::int64_t steps = 0;
    double seconds = 0;
    bool whole = false;  ///< the scene ended within it
    double waited = 0;   ///< for one output [s]
    double behind = 0;   ///< that it went on, asynchronously [s]
    double bytes = 0;    ///< of its file; 0: none was tried, because of:
    std::string refused = {};
};

double now() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// One output into the present folder, which is removed again. Binned state. Collective.
template <class Real, int Dim>
void write_output(Simulation<Real, Dim>& sim, const Scene& scene, const Comm& comm, Timing& timing) {
    const std::string path = fmt::format(".moraine-check-{}.vtkhdf", comm.of_root(static_cast<std::int64_t>(getpid())));
    const auto remove = [&] {
        std::error_code none;
        for (const char* end : {"", ".partial"})
            if (comm.is_root()) std::filesystem::remove(path + end, none);
    };
    try {
        ParticleSeries series(comm, path, {scene.output.deflate, scene.output.asynchronous});
        comm.barrier();
        const double start = now();
        with_frame(sim, [&](auto& frame) { frame.append_to(series); });
        const double begun = now();
        series.finish();
        timing.waited = comm.max(begun - start);
        timing.behind = comm.max(now() - begun);
        const auto size = comm.is_root() ? static_cast<double>(std::filesystem::file_size(path)) : 0.0;
        timing.bytes = comm.max(size);
    } catch (const MachineError& e) {
        timing.refused = e.what();
    } catch (...) {
        remove();
        throw;
    }
    remove();
}

/// All ranks stop after the same step: when rank 0's second is over. Collective.
template <class Real, int Dim>
Timing measure(const Scene& scene, const Comm& comm, const DeviceChoice& device, bool with_output) {
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
    if (with_output) write_output(sim, scene, comm, timing);
    return timing;
}

Timing measure(const Scene& scene, const Comm& comm, const DeviceChoice& device, bool with_output) {
    const bool in_double = scene.precision == Precision::double_;
    if (scene.dimensions == 2)
        return in_double ? measure<double, 2>(scene, comm, device, with_output)
                         : measure<float, 2>(scene, comm, device, with_output);
    return in_double ? measure<double, 3>(scene, comm, device, with_output)
                     : measure<float, 3>(scene, comm, device, with_output);
}

/// "outputs 1.2 % more: 11 of 0.35 s each (38.4 MB at 110 MB/s into this folder)". Of what is asynchronous a run waits
/// for the beginning, and for what its steps until the next output do not cover.
std::string output_share(const OutputPrediction& o, const Timing& timing, double steps_seconds) {
    if (timing.bytes == 0) return timing.refused.empty() ? std::string() : "outputs were not timed: " + timing.refused;
    const double between = o.outputs > 1 ? steps_seconds / (o.outputs - 1) : 0;
    const double each = timing.waited + std::max(0.0, timing.behind - between);
    return fmt::format("outputs {:.2g} % more: {:.0f} of {:.2g} s each ({:.1f} MB at {:.3g} MB/s into this folder)",
                       100 * o.outputs * each / steps_seconds, o.outputs, each, timing.bytes / 1e6,
                       timing.bytes / 1e6 / (timing.waited + timing.behind));
}

}  // namespace

std::string time_steps(const Scene& scene, const Comm& comm, const DeviceChoice& device, bool writes) {
    const Prediction p = predict(scene);
    const OutputPrediction output = predict_output(scene, p);
    const Timing timing = measure(scene, comm, device, writes && output.row_bytes * output.rows <= most_written);
    const std::string ranks = fmt::format("{} rank{}", comm.size(), comm.size() == 1 ? "" : "s");
    const int threads = omp_get_max_threads();
    const std::string where =
        device.cuda ? ranks + " on CUDA"
                    : fmt::format("{} of {} thread{} on the host", ranks, threads, threads == 1 ? "" : "s");
    const double each = timing.seconds / static_cast<double>(std::max<std::int64_t>(timing.steps, 1));
    const double seconds = timing.whole ? timing.seconds : each * p.steps;
    std::string text = timing.whole ? fmt::format("{} for the whole run ({})", duration_text(seconds), where)
                                    : fmt::format("about {} by {} steps of {:.3g} ms ({}), without outputs",
                                                  duration_text(seconds), timing.steps, 1e3 * each, where);
    const std::string share = seconds > 0 ? output_share(output, timing, seconds) : "";
    return share.empty() ? text : text + "\n           " + share;
}

}  // namespace moraine
