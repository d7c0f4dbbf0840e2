// benchmark_accuracy: run time against error, on one core of the host.
//
//   benchmark_accuracy CASE [--configurations WORDS,WORDS] [--cells N,N,...] [--precision single|double|both] [--list]
//
// One JSON line per run: case, configuration, cells, particle-steps, time of the step loop (wall and processor), norms
// of the error, or why it failed. Short runs are repeated, at most five times, and say their median. `run` makes tables
// of it.

#include <fmt/format.h>
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <sstream>
#include <stdexcept>

#include "accuracy/cases.hpp"
#include "benchmark_main.hpp"
#include "core/data/error.hpp"
#include "machine.hpp"

namespace moraine {

namespace {

constexpr double long_enough = 0.2;  ///< [s]

struct Options {
    std::string wanted;
    std::vector<std::string> configurations;  ///< parts of the names; empty: all
    std::vector<int> cells;                   ///< empty: the case's
    std::string precision = "both";
    bool list = false;
};

/// Between commas.
std::vector<std::string> words(const std::string& text) {
    std::vector<std::string> all;
    std::istringstream list(text);
    for (std::string word; std::getline(list, word, ',');) all.push_back(word);
    return all;
}

bool is_wanted(const Options& o, const AccuracyCase& problem, const Configuration& c) {
    if (problem.long_runs ? !is_for_long_runs(c) : c.on_cells) return false;
    return o.configurations.empty() || std::any_of(o.configurations.begin(), o.configurations.end(),
                                                   [&](const auto& w) { return c.name.find(w) != std::string::npos; });
}

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
            o.configurations = words(value());
        else if (key == "--precision")
            o.precision = value();
        else if (key == "--cells") {
            for (const std::string& n : words(value())) o.cells.push_back(std::stoi(n));
        } else
            o.wanted = key;
    }
    if (o.precision != "single" && o.precision != "double" && o.precision != "both")
        throw std::runtime_error("--precision " + o.precision + " is none of single, double, both");
    return o;
}

std::string number(double value) {
    return std::isfinite(value) ? fmt::format("{:.6e}", value) : "null";
}

/// Median time of up to five runs, and its spread.
struct Timed {
    Measured measured;
    Spread wall{}, processor{};
    int runs = 0;
};

Timed timed(const AccuracyCase& problem, const Configuration& c, int cells, Precision precision) {
    Timed t;
    std::vector<double> wall, processor;
    double spent = 0;
    while (t.runs == 0 || (t.runs < 5 && spent < long_enough)) {
        t.measured =
            precision == Precision::single_ ? measure<float>(problem, c, cells) : measure<double>(problem, c, cells);
        wall.push_back(t.measured.wall);
        processor.push_back(t.measured.processor);
        spent += processor.back();
        ++t.runs;
    }
    t.wall = spread_of(wall);
    t.processor = spread_of(processor);
    return t;
}

void report(const AccuracyCase& problem, const Configuration& c, int cells, Precision precision) {
    const std::string what =
        fmt::format(R"("case": "{}", "configuration": "{}", "precision": "{}", "cfl": {}, "cells": {})", problem.name,
                    c.name, precision == Precision::single_ ? "single" : "double", c.cfl, cells);
    std::string result;
    try {
        const Timed t = timed(problem, c, cells, precision);
        const Measured& m = t.measured;
        std::string norms;
        for (const auto& [name, value] : m.norms)
            norms += fmt::format("{}\"{}\": {}", norms.empty() ? "" : ", ", name, number(value));
        result = fmt::format(
            R"("particles": {:.0f}, "steps": {:.0f}, "particle_steps": {:.0f}, "runs": {}, "wall_s": {:.6f}, )"
            R"("wall_spread_s": {:.6f}, "processor_s": {:.6f}, "processor_spread_s": {:.6f}, "norms": {{{}}}, "error": {})",
            m.particles, m.steps, m.particle_steps, t.runs, t.wall.median, t.wall.deviation, t.processor.median,
            t.processor.deviation, norms, number(m.norms.front().second));
    } catch (const PhysicsError& e) {
        std::string message = e.what();
        std::replace(message.begin(), message.end(), '"', '\'');
        result = fmt::format(R"("failed": "{}")", message);
    }
    fmt::print("{{{}, {}, {}}}\n", what, result, machine_json(this_machine()));
    std::fflush(stdout);
}

void benchmark(const Options& o) {
    if (o.list) {
        for (const AccuracyCase& problem : accuracy_cases()) fmt::print("{}: {}\n", problem.name, problem.message);
        for (const Configuration& c : configurations()) fmt::print("  {}\n", c.name);
        return;
    }
    const auto& all = accuracy_cases();
    const auto problem = std::find_if(all.begin(), all.end(), [&](const auto& p) { return p.name == o.wanted; });
    if (problem == all.end()) throw std::runtime_error("no case " + o.wanted + " (see --list)");
    for (int cells : o.cells.empty() ? problem->cells : o.cells)
        for (const Configuration& c : configurations()) {
            if (!is_wanted(o, *problem, c)) continue;
            if (o.precision != "single") report(*problem, c, cells, Precision::double_);
            if (o.precision != "double") report(*problem, c, cells, Precision::single_);
        }
}

}  // namespace

}  // namespace moraine

int main(int argc, char** argv) {
    return moraine::benchmark_main("benchmark_accuracy", argc, argv,
                                   [](int c, char** v) { moraine::benchmark(moraine::parse(c, v)); });
}
