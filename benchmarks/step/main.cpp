// benchmark_step: the whole step on one core.
//
//   benchmark_step                    the two cases with a target: double and single
//   benchmark_step --all              every shape, transfer, stress update, law and dimension
//   benchmark_step --costs            the cost of a block, for balance.weight = "cost"
//   benchmark_step --write DIR        all of these; DIR/results.md and DIR/results.jsonl
// [--particles N] [--runs N] [--steps N] [--list]

#include <fmt/format.h>
#include <malloc.h>
#include <mpi.h>

#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <map>
#include <stdexcept>

#include "step/children.hpp"
#include "step/costs.hpp"
#include "step/report.hpp"

namespace moraine {

namespace {

struct Options {
    bool all = false, costs = false, list = false;
    std::string write, child;
    double particles = 1e6;
    std::int64_t empty_bytes = 0;
    Runs plan;
};

Options parse(int argc, char** argv) {
    Options o;
    for (int i = 1; i < argc; ++i) {
        const std::string key = argv[i];
        const auto value = [&]() -> std::string {
            if (++i == argc) throw std::runtime_error(key + " needs a value");
            return argv[i];
        };
        if (key == "--all")
            o.all = true;
        else if (key == "--costs")
            o.costs = true;
        else if (key == "--list")
            o.list = true;
        else if (key == "--write")
            o.write = value(), o.all = o.costs = true;
        else if (key == "--child")
            o.child = value();
        else if (key == "--particles")
            o.particles = std::stod(value());
        else if (key == "--empty")
            o.empty_bytes = std::stoll(value());
        else if (key == "--runs")
            o.plan.runs = std::stoi(value());
        else if (key == "--steps")
            o.plan.steps = std::stoi(value());
        else
            throw std::runtime_error("no option " + key +
                                     " (--all, --costs, --write DIR, --particles N, --runs N, --steps N, --list)");
    }
    return o;
}

struct Pages {
    std::string table, json;
};

Pages measure_cases(const Options& o) {
    Pages pages;
    pages.table = table_head();
    fmt::print("{}", pages.table);
    for (const Case& c : o.all ? all_cases(o.particles) : target_cases(o.particles)) {
        const Runs once{1, 1, 5};
        const std::int64_t empty = run_child(c.name, 8, once, 0).peak_bytes;
        const ChildResult r = run_child(c.name, o.particles, o.plan, empty);
        fmt::print("{}\n", r.row);
        std::fflush(stdout);
        pages.table += r.row + "\n";
        pages.json += r.json + "\n";
    }
    return pages;
}

std::string measure_costs(const Options& o) {
    const std::vector<Case> cases = cost_cases(o.particles);
    std::vector<ChildResult> results;
    for (const Case& c : cases) results.push_back(run_child(c.name, o.particles, o.plan, 0));
    const std::string text = cost_table(fit_costs(results), cases, results);
    fmt::print("\n{}", text);
    return text;
}

void write(const Options& o, const Pages& pages, const std::string& costs) {
    std::ofstream page(o.write + "/results.md");
    page << "# The step on one core\n\nMade by `benchmark_step --write DIR`.\n\n"
         << machine_sentence(this_machine()) << "\n\n"
         << table_notes(o.plan)
         << "\nTargets (3-D, quadratic, FLIP, USL, von Mises, 8 particles per cell): at least 2.5 million "
            "particle-steps/s "
            "in double and 4 in single; at most 260 bytes per particle in double.\n\n"
         << pages.table << "\n## The cost of a block\n\n"
         << costs;
    std::ofstream(o.write + "/results.jsonl") << pages.json;
    if (!page) throw std::runtime_error("cannot write " + o.write + "/results.md");
}

void benchmark(const Options& o) {
    if (o.list) {
        for (const Case& c : all_cases(o.particles)) fmt::print("{}\n", c.name);
        return;
    }
    fmt::print("{}\n\n", machine_sentence(this_machine()));
    const Pages pages = measure_cases(o);
    if (!o.write.empty() || !o.costs) fmt::print("\n{}", pages.json);
    const std::string costs = o.costs ? measure_costs(o) : "";
    if (!o.write.empty()) write(o, pages, costs);
}

}  // namespace

}  // namespace moraine

int main(int argc, char** argv) {
    mallopt(M_MMAP_THRESHOLD, 1 << 20);  // as the program does
    try {
        const moraine::Options options = moraine::parse(argc, argv);
        if (options.child.empty()) {
            moraine::benchmark(options);
            return 0;
        }
        MPI_Init(&argc, &argv);
        moraine::be_child(options.child, options.particles, options.plan, options.empty_bytes);
        MPI_Finalize();
        return 0;
    } catch (const std::exception& e) {
        fmt::print(stderr, "benchmark_step: {}\n", e.what());
        return 1;
    }
}
