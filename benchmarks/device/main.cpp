// benchmark_device: the whole step of one device, binning, dt, epochs and memory refresh included.
//
//   benchmark_device [CASE ...] [--warm-up N] [--steps N] [--runs N] [--list]
//                    [--transport NAME] [--partitioner NAME] [--weight NAME] [--trigger NAME] [--free] [--led]
//                    [--refresh N]
//
// CASE as --list names them; default: all. Clocks swing for some seconds once a power limit is reached: --warm-up.
// --free: light nodes are not limited. --led: the host makes dt of every step, and the device does not lead. --refresh:
// steps between memory refreshes, whatever the particles take. One JSON line per case; runs are stretches of
// consecutive steps of one simulation, and end with the device idle. Under mpirun, with one rank per device, the same
// cases in parts; those named weak grow with the number of ranks.

#include <cuda_runtime.h>
#include <fmt/format.h>
#include <mpi.h>

#include <cstdio>
#include <exception>
#include <map>
#include <stdexcept>

#include "app/device.hpp"
#include "benchmark_main.hpp"
#include "device/cases.hpp"
#include "machine.hpp"
#include "simulation/diagnostics.hpp"

namespace moraine {

namespace {

struct Runs {
    int runs = 5;
    int steps = 200;
    int warm_up = 10;  ///< steps before the first run
    std::string transport = "auto";
    std::string partitioner;  ///< empty: of the scene
    std::string weight;       ///< empty: of the scene
    std::string trigger = "threshold";
    bool free = false;  ///< light nodes
    bool led = false;   ///< by the host
    int refresh = 0;    ///< 0: by what the particles take
};

Trigger trigger_of(const std::string& name) {
    if (name == "threshold") return Trigger::threshold;
    if (name == "planned") return Trigger::planned;
    throw std::runtime_error("no trigger " + name + " (threshold or planned)");
}

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
    DeviceChoice choice = choose_device("cuda", comm, plan.transport);
    choice.refresh_interval = plan.refresh;
    Scene scene = c.scene;
    if (!plan.partitioner.empty()) scene.balance.partitioner = plan.partitioner;
    if (!plan.weight.empty()) scene.balance.weight = plan.weight;
    scene.balance.trigger = trigger_of(plan.trigger);
    scene.limits_light_nodes = !plan.free;
    Simulation<Real, Dim> sim(scene, comm, device_engine_maker<Real, Dim>(scene, comm, choice));
    const double begun = wall_seconds();
    sim.seed();
    const double seeding = wall_seconds() - begun;
    std::int64_t led = 0;  // steps that the device made by itself
    const auto advance = [&](int steps) {
        if (!plan.led) sim.leave_alone_until(scene.end, sim.clock().step + steps);
        for (int i = 0; i < steps; ++i) {
            sim.step();
            led += sim.follows() ? 1 : 0;
            sim.balance();
        }
        sim.conclude();
    };
    advance(plan.warm_up);
    const auto particles = comm.sum(static_cast<double>(sim.engine().census().particles));
    const RunCounts counted = sim.counts_so_far();
    const std::array<double, Phases::count> before = sim.phases().all();
    std::vector<double> seconds;
    double moved = 0;
    for (int r = 0; r < plan.runs; ++r) {
        comm.barrier();
        const double start = wall_seconds();
        advance(plan.steps);
        seconds.push_back((wall_seconds() - start) / plan.steps);
        moved = std::max(moved, sim.agreement().moved);
    }
    const Spread s = spread_of(seconds);
    const double used = comm.sum(device.free - free_bytes());
    const int steps = plan.runs * plan.steps;
    const RunCounts counts = sim.counts_so_far();
    const double halo = comm.sum(static_cast<double>(counts.halo_bytes - counted.halo_bytes)) / steps;
    const double crossed = comm.sum(static_cast<double>(counts.crossed_particles - counted.crossed_particles)) / steps;
    const double migrated = comm.sum(static_cast<double>(counts.migrated_particles - counted.migrated_particles));
    const double blocks = comm.sum(static_cast<double>(sim.engine().census().blocks));
    std::string phases;
    for (std::size_t k = 0; k < Phases::count; ++k)  // of the rank that is longest in it
        phases += fmt::format("{}\"{}\": {:.4f}", k ? ", " : "", Phases::names[k],
                              comm.max(1e3 * (sim.phases().all()[k] - before[k]) / steps));
    const std::uint64_t hash = c.hashed ? state_hash(sim) : 0;
    if (!comm.is_root()) return;
    fmt::print(
        "{{\"case\": \"{}\", \"ranks\": {}, \"transport\": \"{}\", \"partitioner\": \"{}\", \"weight\": \"{}\", "
        "\"trigger\": \"{}\", \"light_nodes\": \"{}\", \"dt_by\": \"{}\", \"refresh\": {}, "
        "\"device\": \"{}\", "
        "\"driver\": {}, \"runtime\": {}, {}, \"particles\": {:.0f}, "
        "\"blocks\": {:.0f}, \"warm_up\": {}, \"steps\": {}, \"runs\": {}, \"ms_per_step\": {:.4f}, \"deviation_ms\": "
        "{:.4f}, "
        "\"G_particle_steps_per_s\": {:.3f}, \"bytes_per_particle\": {:.1f}, \"largest_move_cells\": {:.4f}, "
        "\"imbalance_mean\": {:.4f}, \"imbalance_time_mean\": {:.4f}, \"halo_bytes_per_step\": {:.0f}, "
        "\"crossed_per_step\": {:.1f}, \"repartitions\": "
        "{}, "
        "\"migrated\": {:.0f}, "
        "\"seeding_s\": {:.1f}, \"ms_per_phase\": {{{}}}, \"state_hash\": \"{:016x}\"}}\n",
        c.name, comm.size(), choice.transport, scene.balance.partitioner, scene.balance.weight, plan.trigger,
        plan.free ? "free" : "limited", led > 0 ? "device" : "host", plan.refresh, device.name, device.driver,
        device.runtime, machine_json(this_machine()), particles, blocks, plan.warm_up, plan.steps, plan.runs,
        1e3 * s.median, 1e3 * s.deviation, particles / s.median * 1e-9, used / particles, moved,
        counts.imbalance_sum / static_cast<double>(counts.steps),
        counts.imbalance_time_sum / static_cast<double>(counts.steps), halo, crossed,
        counts.repartitions - counted.repartitions, migrated, seeding, phases, hash);
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
    const std::map<std::string, int*> numbers{
        {"--steps", &plan.steps}, {"--runs", &plan.runs}, {"--warm-up", &plan.warm_up}, {"--refresh", &plan.refresh}};
    std::vector<std::string> wanted;
    bool list = false;
    for (int i = 1; i < argc; ++i) {
        const std::string key = argv[i];
        if (key == "--list")
            list = true;
        else if (key == "--free")
            plan.free = true;
        else if (key == "--led")
            plan.led = true;
        else if ((key == "--weight" || key == "--trigger") && i + 1 < argc)
            (key == "--weight" ? plan.weight : plan.trigger) = argv[++i];
        else if ((key == "--transport" || key == "--partitioner") && i + 1 < argc)
            (key == "--transport" ? plan.transport : plan.partitioner) = argv[++i];
        else if (const auto number = numbers.find(key); number != numbers.end() && i + 1 < argc)
            *number->second = std::stoi(argv[++i]);
        else
            wanted.push_back(key);
    }
    int ranks = 1;
    MPI_Comm_size(MPI_COMM_WORLD, &ranks);
    const std::vector<DeviceCase> cases = device_cases(ranks);
    const auto known = [&](const std::string& name) {
        return std::any_of(cases.begin(), cases.end(), [&](const DeviceCase& c) { return c.name == name; });
    };
    for (const std::string& name : wanted)
        if (!known(name)) throw std::runtime_error("no case or option " + name + " (see --list)");
    if (!list) choose_device("cuda", Comm(MPI_COMM_WORLD), "host");
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
    return moraine::benchmark_main("benchmark_device", argc, argv, [](int c, char** v) { moraine::benchmark(c, v); });
}
