#include "step/children.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "step/report.hpp"

namespace moraine {

namespace {

std::string own_path() {
    char path[4096];
    const ssize_t n = readlink("/proc/self/exe", path, sizeof(path));
    if (n <= 0) throw std::runtime_error("no /proc/self/exe (a Linux system is needed)");
    return std::string(path, static_cast<std::size_t>(n));
}

std::string output_of(const std::string& command) {
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    if (!pipe) throw std::runtime_error("cannot start " + command);
    std::string text;
    char part[4096];
    for (std::size_t n; (n = std::fread(part, 1, sizeof(part), pipe.get())) > 0;) text.append(part, n);
    return text;
}

Case find_case(const std::string& name, double particles) {
    for (const Case& c : all_cases(particles))
        if (c.name == name) return c;
    for (const Case& c : cost_cases(particles))
        if (c.name == name) return c;
    throw std::runtime_error("no case \"" + name + "\" (--list names them)");
}

}  // namespace

ChildResult run_child(const std::string& name, double particles, const Runs& plan, std::int64_t empty_bytes) {
    std::istringstream lines(
        output_of(fmt::format("OMP_NUM_THREADS=1 '{}' --child '{}' --particles {:.0f} --runs {} --steps {} --empty {}",
                              own_path(), name, particles, plan.runs, plan.steps, empty_bytes)));
    ChildResult r{};
    std::getline(lines, r.json);
    std::getline(lines, r.row);
    lines >> r.particles >> r.cells >> r.blocks >> r.step_seconds >> r.peak_bytes;
    if (!lines) throw std::runtime_error("the case \"" + name + "\" did not end well");
    return r;
}

void be_child(const std::string& name, double particles, const Runs& plan, std::int64_t empty_bytes) {
    const Case c = find_case(name, particles);
    const Measured m = measure(c, plan);
    fmt::print("{}\n{}\n{} {} {} {:.9e} {}\n", json_line(c, plan, m, empty_bytes, this_machine()),
               table_row(c, plan, m, empty_bytes), m.particles, m.cells, m.blocks, m.processor.median / plan.steps,
               m.peak_bytes);
}

}  // namespace moraine
