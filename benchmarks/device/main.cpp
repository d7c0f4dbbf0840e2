// benchmark_device: the whole step of one device, filing, dt, epochs and memory refresh included.
//
//   benchmark_device [CASE ...]    CASE as --list names them; default: all
// [--steps N] [--runs N] [--list]
//
// One JSON line per case; runs are stretches of consecutive steps of one simulation, and end with the device idle.

#include <cuda_runtime.h>
#include <fmt/format.h>
#include <mpi.h>

#include <cstdio>
#include <exception>
#include <stdexcept>

#include "device.hpp"
#include "device/cases.hpp"
#include "machine.hpp"
#include "simulation.hpp"

namespace moraine {

namespace {

struct Runs {
    int runs = 5;
    int steps = 200;
    int warm_up = 10;
};

struct Device {
    std::string name;
    int driver = 0, runtime = 0;
    double free = 0;  ///< before anything is allocated [bytes]
};

double free_bytes() {
    std::size_t free = 0, total = 0;
    cudaMemGetInfo(&free, &total);
    return static_cast<double>(free);
}

Device this_device() {
    Device d;
    cudaDeviceProp properties{};
    cudaGetDeviceProperties(&properties, 0);
    d.name = properties.name;
    cudaDriverGetVersion(&d.driver);
    cudaRuntimeGetVersion(&d.runtime);
    d.free = free_bytes();
    return d;
}

template <class Real, int Dim>
void measure(const DeviceCase& c, const Runs& plan, const Device& device) {
    const Comm comm(MPI_COMM_WORLD);
    Simulation<Real, Dim> sim(c.scene, comm, device_engine_maker<Real, Dim>(c.scene));
    const double begun = wall_seconds();
    sim.seed();
    const double seeding = wall_seconds() - begun;
    const auto advance = [&](int steps) {
        for (int i = 0; i < steps; ++i) sim.step(), sim.balance();
        sim.conclude();
    };
    advance(plan.warm_up);
    const auto particles = static_cast<double>(sim.engine().census().particles);
    const std::array<double, Phases::count> before = sim.phases().all();
    std::vector<double> seconds;
    double moved = 0;
    for (int r = 0; r < plan.runs; ++r) {
        const double start = wall_seconds();
        advance(plan.steps);
        seconds.push_back((wall_seconds() - start) / plan.steps);
        moved = std::max(moved, sim.agreement().moved);
    }
    const Spread s = spread_of(seconds);
    const double used = device.free - free_bytes();
    std::string phases;
    for (std::size_t k = 0; k < Phases::count; ++k)
        phases += fmt::format("{}\"{}\": {:.4f}", k ? ", " : "", Phases::names[k],
                              1e3 * (sim.phases().all()[k] - before[k]) / (plan.runs * plan.steps));
    fmt::print(
        "{{\"case\": \"{}\", \"device\": \"{}\", \"driver\": {}, \"runtime\": {}, {}, \"particles\": {:.0f}, "
        "\"blocks\": {}, \"steps\": {}, \"runs\": {}, \"ms_per_step\": {:.4f}, \"deviation_ms\": {:.4f}, "
        "\"G_particle_steps_per_s\": {:.3f}, \"bytes_per_particle\": {:.1f}, \"largest_move_cells\": {:.4f}, "
        "\"seeding_s\": {:.1f}, \"ms_per_phase\": {{{}}}, \"state_hash\": \"{:016x}\"}}\n",
        c.name, device.name, device.driver, device.runtime, machine_json(this_machine()), particles,
        sim.engine().census().blocks, plan.steps, plan.runs, 1e3 * s.median, 1e3 * s.deviation,
        particles / s.median * 1e-9, used / particles, moved, seeding, phases, c.hashed ? sim.state_hash() : 0);
    std::fflush(stdout);
}

void run(const DeviceCase& c, const Runs& plan, const Device& device) {
    const bool single = c.scene.precision == Precision::single_;
    if (c.scene.dimensions == 2)
        single ? measure<float, 2>(c, plan, device) : measure<double, 2>(c, plan, device);
    else
        single ? measure<float, 3>(c, plan, device) : measure<double, 3>(c, plan, device);
}

void benchmark(int argc, char** argv) {
    Runs plan;
    std::vector<std::string> wanted;
    bool list = false;
    for (int i = 1; i < argc; ++i) {
        const std::string key = argv[i];
        if (key == "--list")
            list = true;
        else if ((key == "--steps" || key == "--runs") && i + 1 < argc)
            (key == "--steps" ? plan.steps : plan.runs) = std::stoi(argv[++i]);
        else
            wanted.push_back(key);
    }
    const std::vector<DeviceCase> cases = device_cases();
    const auto known = [&](const std::string& name) {
        return std::any_of(cases.begin(), cases.end(), [&](const DeviceCase& c) { return c.name == name; });
    };
    for (const std::string& name : wanted)
        if (!known(name)) throw std::runtime_error("no case or option " + name + " (see --list)");
    if (!list) choose_device("cuda", Comm(MPI_COMM_WORLD));
    const Device device = list ? Device{} : this_device();
    for (const DeviceCase& c : cases) {
        if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), c.name) == wanted.end()) continue;
        if (list)
            fmt::print("{}\n", c.name);
        else
            run(c, plan, device);
    }
}

}  // namespace

}  // namespace moraine

int main(int argc, char** argv) {
    MPI_Init(&argc, &argv);
    int code = 0;
    try {
        moraine::benchmark(argc, argv);
    } catch (const std::exception& e) {
        fmt::print(stderr, "benchmark_device: {}\n", e.what());
        code = 1;
    }
    MPI_Finalize();
    return code;
}
