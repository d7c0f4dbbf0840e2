#include "records/processor_name.hpp"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <vector>

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

/// Cores that a rank may use, and the boot that it runs under: the same for all ranks of a host, and of no other.
struct RankCores {
    std::array<char, 40> boot{};
    cpu_set_t set;
};

RankCores my_cores() {
    RankCores mine;
    std::ifstream("/proc/sys/kernel/random/boot_id").read(mine.boot.data(), mine.boot.size() - 1);
    CPU_ZERO(&mine.set);
    sched_getaffinity(0, sizeof(mine.set), &mine.set);
    return mine;
}

/// Of all ranks on rank 0's host.
int cores_together(const std::vector<RankCores>& ranks) {
    cpu_set_t together = ranks.front().set;
    for (const RankCores& rank : ranks)
        if (rank.boot == ranks.front().boot) CPU_OR(&together, &together, &rank.set);
    return std::max(1, CPU_COUNT(&together));
}

}  // namespace

std::string processor_name(const Comm& comm) {
    std::string name = of_processor("model name");
    if (name.empty()) name = "unknown processor";
    const std::string family = of_processor("cpu family");
    if (!family.empty()) name += fmt::format(" (family {}, model {})", family, of_processor("model\t"));
    const int cores = cores_together(comm.all_gather(std::vector<RankCores>{my_cores()}));
    return fmt::format("{}, {} core{}", name, cores, cores == 1 ? "" : "s");
}

}  // namespace moraine
