#include "machine.hpp"

#include <fmt/format.h>
#include <sched.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <sstream>

#include "records/version.hpp"

namespace moraine {

namespace {

/// The value after "key<spaces>:" in a file of such lines; empty if there is none.
std::string value_in(const char* path, const std::string& key) {
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        if (line.rfind(key, 0) != 0) continue;
        const std::size_t from = line.find_first_not_of(" \t", line.find(':') + 1);
        return from == std::string::npos ? "" : line.substr(from);
    }
    return "";
}

int usable_cores() {
    cpu_set_t set;
    return sched_getaffinity(0, sizeof(set), &set) == 0 ? CPU_COUNT(&set) : 1;
}

std::string last_cache() {
    std::string size = "unknown";
    for (int level = 0; level < 8; ++level) {
        std::ifstream file(fmt::format("/sys/devices/system/cpu/cpu0/cache/index{}/size", level));
        if (!file) break;
        std::getline(file, size);
    }
    return size;
}

}  // namespace

Machine this_machine() {
    Machine m;
    m.processor = value_in("/proc/cpuinfo", "model name");
    const std::string family = value_in("/proc/cpuinfo", "cpu family");
    if (!family.empty()) m.processor += " (family " + family + ", model " + value_in("/proc/cpuinfo", "model\t") + ")";
    m.cache = last_cache();
    m.cores = usable_cores();
    m.compiler = "g++ " __VERSION__ " " MORAINE_BUILD_FLAGS;
    m.march = MORAINE_BUILD_MARCH;
    return m;
}

std::int64_t peak_memory() {
    std::istringstream line(value_in("/proc/self/status", "VmHWM"));
    std::int64_t kib = 0;
    line >> kib;
    return kib * 1024;
}

double processor_seconds() {
    rusage use{};
    getrusage(RUSAGE_SELF, &use);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(use.ru_utime) + seconds(use.ru_stime);
}

double wall_seconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

Spread spread_of(std::vector<double> values) {
    const auto median = [](std::vector<double>& v) {
        std::sort(v.begin(), v.end());
        const std::size_t half = v.size() / 2;
        return v.size() % 2 ? v[half] : 0.5 * (v[half - 1] + v[half]);
    };
    Spread s{};
    s.median = median(values);
    for (double& v : values) v = std::fabs(v - s.median);
    s.deviation = median(values);
    return s;
}

std::string machine_json(const Machine& m) {
    return fmt::format(R"("commit": "{}", "machine": "{}", "cores": {}, "compiler": "{}", "march": "{}")", commit_text,
                       m.processor, m.cores, m.compiler, m.march);
}

std::string machine_sentence(const Machine& m) {
    return fmt::format("{}, {} cores, last-level cache {}; {}, -march={}; commit {}.", m.processor, m.cores, m.cache,
                       m.compiler, m.march.empty() ? "(none)" : m.march, commit_text);
}

}  // namespace moraine
