// benchmark_stability: stress tests of the method, on one core of the host.
//
//   benchmark_stability CASE... [--configurations WORDS] [--few] [--free] [--defaults] [--first N] [--count N] [--list]
//
// One JSON line per case and configuration: numbers, whether its goal is met, and why not. `run` makes tables of it.

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <stdexcept>

#include "benchmark_main.hpp"
#include "machine.hpp"
#include "stability/cases.hpp"

namespace moraine {

namespace {

constexpr StabilityCase cases[] = {
    {"S1",
     "largest stable dt c / h: a perturbation of 1e-9 c grows less than 1000 times in 2000 steps (frozen) or 4000",
     find_limits},
    {"S2",
     "largest stable dt c / h of a particle alone and of a droplet of 2 per axis: a pressure of 1e-6 rho c^2 grows "
     "less than 1000 times in 2000 steps (frozen) or 4000; 4: no limit was found",
     find_lone_limits},
    {"S6",
     "a bar that rings (E1, 64 cells per wave, v0 = c / 10 000), at rest and adrift at Mach 0.05, and a square that "
     "turns (E7, 10 cells along a side, E = 1e5 Pa), at the program's step and at a quarter of it; goal: the energy "
     "within 1 % after 100 periods, or at the end of the turns",
     drift_on},
    {"S8",
     "a pulse in a strip meets a bonded block of other stiffness or density (2-D, one block wide): what comes back of "
     "momentum and energy, and stress and velocity at the interface, over the pulse's; goal 2 % at ratios to 1000",
     meet_contrasts},
    {"S9",
     "results of runs whose particles lie otherwise at the start: on a lattice, on lattices turned against the grid, "
     "and "
     "at random with 10 seeds; goal: the runouts of the 10 vary by 1 % (coefficient of variation)",
     vary_seeds},
    {"S10",
     "a bar that flies apart to 20 times its length: from which stretch the ln J of one inner particle is off by half, "
     "and from which they see less than half or more than one and a half of what grows (20: never), ln J over ln "
     "lambda "
     "at the end; a slab sheared to 50: largest error of the stress over itself and of ln J, in its middle",
     pull_apart},
    {"S12",
     "inputs that nobody should give (2-D): a bounded result with a closed budget (1e-10 of M c), or a clear error",
     push_extremes},
    {"S15",
     "an elastic block rests on a rigid plane for 1e6 steps, undamped, looked at over the last 9e5; goal: kinetic "
     "energy "
     "1e-8 of m g height, no drift (1e-6 h in 1e4 steps), sunk by 0.05 h at most",
     rest_on_plane},
    {"S16",
     "where the energy goes that a run had at its start, over what was set free; goal: the transfers take 5 % of what "
     "the laws dissipate, 1 % of the energy where no law does",
     keep_accounts},
    {"S17",
     "steps by the program's rule and in a saw of 0.2 to 1 of them against fixed steps of a quarter; goal: the "
     "centre's "
     "way off by 0.2 %, no step above 0.9 of the method's stable one",
     vary_steps},
    {"S22", "random scenes, 240 steps: no fault, no lost particle, momentum to 1e-10 of M c, no energy growth",
     run_random},
    {"S23",
     "thin random scenes (films, sprays, drops, fronts over steps), 2000 steps of the whole default length: no fault, "
     "no lost particle, momentum to 1e-10 of M c, no energy growth",
     run_thin},
    {"S24",
     "random scenes of fluids whose pressure is the grid's, in up to 10 substeps (blocks, films, sprays, corners, "
     "splashes, tanks), 2000 steps of the whole default length: no fault, no lost particle, momentum to 1e-10 of M c, "
     "no energy growth",
     run_fluids},
    {"S25",
     "largest stable substep dts c / h of a fluid without viscosity whose pressure is the grid's, by the most substeps "
     "S of a step, and the step dt_L c / h at the limit of S = 10: a perturbation of 1e-9 c grows less than 1000 times "
     "in 2000 steps; goal: the default, 0.8 of the method's limit",
     find_substeps},
    {"S26",
     "fluids with pressure smoothing, particle shifting and pressures on the grid: the bar of S6 with a fluid without "
     "viscosity, at rest and adrift at Mach 0.05, and a square of a fluid that does not yield; goal: the energy grows "
     "by no more than 1 % above its least in 1000 periods (motion alone: not twice), the angular momentum is within 1 "
     "% after ten turns",
     drift_fluids},
    {"S27",
     "largest stable dt c / h of a fluid without viscosity with and without smoothing, shifts and pressures on the "
     "grid: a perturbation of 1e-9 c grows less than "
     "1000 times in 4000 steps; goal: the default, 0.8 of the method's limit",
     find_fluid_limits},
    {"S28",
     "random scenes of saturated soil (beds, columns, slopes, corners, dry caps), 2000 steps of up to the default "
     "length: no fault, no lost particle, momentum to 1e-10 of M c, no energy growth, no checkerboard",
     run_wet},
};

struct Options {
    std::vector<std::string> names;
    Wanted wanted;
    bool list = false;
};

Options parse(int argc, char** argv) {
    Options o;
    for (int i = 1; i < argc; ++i) {
        const std::string key = argv[i];
        const auto value = [&]() -> std::string {
            if (++i == argc) throw std::runtime_error(key + " needs a value");
            return argv[i];
        };
        if (key == "--list")
            o.list = true;
        else if (key == "--configurations")
            o.wanted.configurations = value();
        else if (key == "--few")
            o.wanted.few = true;
        else if (key == "--free")
            o.wanted.free = true;
        else if (key == "--defaults")
            o.wanted.defaults = true;
        else if (key == "--first")
            o.wanted.first = std::stoi(value());
        else if (key == "--count")
            o.wanted.count = std::stoi(value());
        else
            o.names.push_back(key);
    }
    return o;
}

std::string escaped(std::string message) {
    std::replace(message.begin(), message.end(), '"', '\'');
    std::replace(message.begin(), message.end(), '\n', ' ');
    return message;
}

void print(const StabilityCase& of, const Finding& finding, double seconds) {
    std::string numbers;
    for (const auto& [name, value] : finding.numbers)
        numbers += fmt::format("{}\"{}\": {}", numbers.empty() ? "" : ", ", name,
                               std::isfinite(value) ? fmt::format("{:.6g}", value) : "null");
    fmt::print(
        R"({{"case": "{}", "configuration": "{}", "numbers": {{{}}}, "pass": {}, "why": "{}", "seconds": {:.1f}, {}}})"
        "\n",
        of.name, finding.configuration, numbers, finding.pass ? (*finding.pass ? "true" : "false") : "null",
        escaped(finding.why), seconds, machine_json(this_machine()));
    std::fflush(stdout);
}

void benchmark(const Options& o) {
    if (o.list)
        for (const StabilityCase& c : cases) fmt::print("{}: {}\n", c.name, c.message);
    for (const std::string& name : o.names) {
        const auto* found =
            std::find_if(std::begin(cases), std::end(cases), [&](const auto& c) { return c.name == name; });
        if (found == std::end(cases)) throw std::runtime_error("no case " + name + " (see --list)");
        double began = processor_seconds();
        found->run(o.wanted, [&](const Finding& finding) {
            print(*found, finding, processor_seconds() - began);
            began = processor_seconds();
        });
    }
}

}  // namespace

}  // namespace moraine

int main(int argc, char** argv) {
    return moraine::benchmark_main("benchmark_stability", argc, argv,
                                   [](int c, char** v) { moraine::benchmark(moraine::parse(c, v)); });
}
