#include "records/processor_name.hpp"

#include <fmt/format.h>
#include <sched.h>

#include <fstream>

namespace moraine {
namespace {

/// The value of "key<blanks>: value" among the lines about the first processor; empty if there is none.
std::string of_processor(const std::string& key) {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);) {
        if (line.rfind(key, 0) != 0) continue;
        const std::size_t from = line.find_first_not_of(" \t", line.find(':') + 1);
        return from == std::string::npos ? "" : line.substr(from);
    }
    return "";
}

}  // namespace

std::string processor_name() {
    std::string name = of_processor("model name");
    if (name.empty()) name = "unknown processor";
    const std::string family = of_processor("cpu family");
    if (!family.empty()) name += fmt::format(" (family {}, model {})", family, of_processor("model\t"));
    cpu_set_t set;
    const int cores = sched_getaffinity(0, sizeof(set), &set) == 0 ? CPU_COUNT(&set) : 1;
    return fmt::format("{}, {} core{}", name, cores, cores == 1 ? "" : "s");
}

}  // namespace moraine
