#include "predict/capacity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>

#include "core/data/error.hpp"
#include "seeding/seed.hpp"

namespace moraine {
namespace {

constexpr double most_slots = 2147483647.0;  // 2^31 - 1 particles on a rank: MPI counts the rows of an output as int

/// The number behind `word` in a file of words and numbers, or, without a word, the first; 0: none.
double number_in(const std::string& path, const std::string& word) {
    std::ifstream file(path);
    std::string found;
    while (!word.empty() && found != word && file >> found) continue;
    double number = 0;
    return file >> number ? number : 0;
}

/// Particles of one body per volume of a cell, over all its cells.
double particles_of(const Scene& scene, std::size_t b) {
    const BodySpec& body = scene.bodies[b];
    if (body.shape == BodyShape::table) return static_cast<double>(seed_rows(scene, static_cast<int>(b)));
    double count = body.shape == BodyShape::box ? 1 : measure_of(body, scene.dimensions);
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a) {
        const double spacing = scene.cell / body.particles_per_cell[a];
        count *= body.shape == BodyShape::box ? std::max(1.0, std::round((body.max[a] - body.min[a]) / spacing))
                                              : 1 / spacing;
    }
    return count;
}

/// With the half block more at each end that a body seldom fills; all but boxes as cubes.
double blocks_of(const Scene& scene, const BodySpec& body, double particles) {
    double box = 1, full = 1;
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a) {
        box *= (body.max[a] - body.min[a]) / (4 * scene.cell) + 1;
        full *= 4 * body.particles_per_cell[a];
    }
    if (body.shape == BodyShape::box) return box;
    return std::pow(std::pow(particles / full, 1.0 / scene.dimensions) + 1, scene.dimensions);
}

/// Rounded up to two digits.
double rounded_up(double x) {
    const double unit = std::pow(10, std::floor(std::log10(x)) - 1);
    return std::ceil(x / unit) * unit;
}

/// Of the host, for one rank [B].
double bytes_of(const Scene& scene, const Prediction& p, const Machine& machine) {
    if (machine.devices) return host_bytes_with_device(scene, p, machine.ranks, machine.writes_particles);
    return bytes_per_rank(scene, p, machine.ranks);
}

/// The cell with which a need that is `excess` times too large would fit.
std::string coarser(const Scene& scene, double excess) {
    return fmt::format("domain.cell of {:.4g} m", rounded_up(scene.cell * std::pow(excess, 1.0 / scene.dimensions)));
}

}  // namespace

double control_group_memory(const std::string& membership, const std::string& mount) {
    double least = std::numeric_limits<double>::infinity();
    const auto bound = [&](const std::string& file) {
        const double number = number_in(file, "");  // "max" is no number
        if (number > 0) least = std::min(least, number);
    };
    bound(mount + "/memory.max");
    std::ifstream file(membership);
    for (std::string line; std::getline(file, line);) {  // NUMBER:CONTROLLERS:/PATH; of version 2 it is 0::/PATH
        const std::size_t first = line.find(':'), second = line.find(':', first + 1);
        if (first == std::string::npos || second == std::string::npos || line.find('/') != second + 1) continue;
        const std::string controllers = fmt::format(",{},", line.substr(first + 1, second - first - 1));
        const bool version_2 = controllers == ",,";
        if (!version_2 && controllers.find(",memory,") == std::string::npos) continue;
        for (std::string path = line.substr(second + 1); !path.empty(); path.resize(path.rfind('/')))
            bound(version_2 ? mount + path + "/memory.max" : mount + "/memory" + path + "/memory.limit_in_bytes");
    }
    return std::isfinite(least) ? least : 0;
}

double host_memory() {
    if (const char* pretended = std::getenv("MORAINE_PRETEND_MEMORY")) return std::max(0.0, std::atof(pretended));
    const double total = 1024 * number_in("/proc/meminfo", "MemTotal:");
    const double allowed = control_group_memory("/proc/self/cgroup", "/sys/fs/cgroup");
    return allowed > 0 ? std::min(total, allowed) : total;
}

Prediction estimate(const Scene& scene) {
    Prediction p;
    double particles = 0, blocks = 0;
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
        const double mine = particles_of(scene, b);
        particles += mine;
        blocks += blocks_of(scene, scene.bodies[b], mine);
    }
    const auto whole = [](double x) { return static_cast<std::int64_t>(std::min(x, 9e18)); };
    p.particles = whole(particles);
    p.blocks = whole(blocks);
    return p;
}

std::int64_t particles_in_memory(const Scene& scene, const Machine& machine) {
    const Prediction p = estimate(scene);
    if (machine.memory <= 0 || p.particles == 0) return static_cast<std::int64_t>(most_slots);
    const double each = bytes_of(scene, p, machine) * machine.ranks / static_cast<double>(p.particles);
    return static_cast<std::int64_t>(std::min(most_slots, machine.memory / machine.ranks_here / each));
}

void check_capacity(const Scene& scene, const Machine& machine) {
    const Prediction p = estimate(scene);
    const auto particles = static_cast<double>(p.particles);
    if (particles > most_slots * machine.ranks)
        throw InputError(fmt::format(
            "{}: {:.3g} particles on {} rank{} (a rank numbers at most {:.0f}). Use {:.0f} ranks, or a {}?",
            scene.source.path, particles, machine.ranks, machine.ranks == 1 ? "" : "s", most_slots,
            std::ceil(1.1 * particles / most_slots), coarser(scene, particles / most_slots / machine.ranks)));
    const double bytes = machine.ranks_here * bytes_of(scene, p, machine);
    if (machine.memory <= 0 || bytes <= machine.memory) return;
    const double excess = bytes / machine.memory;
    throw InputError(fmt::format(
        "{}: {:.3g} particles need {:.3g} GB of memory for {} rank{} here (this machine has {:.3g} GB). Use {:.0f} "
        "such machines with {} rank{} each, or a {}?{}",
        scene.source.path, particles, bytes / 1e9, machine.ranks_here, machine.ranks_here == 1 ? "" : "s",
        machine.memory / 1e9, std::ceil(1.05 * excess * machine.ranks / machine.ranks_here), machine.ranks_here,
        machine.ranks_here == 1 ? "" : "s", coarser(scene, excess),
        machine.devices && machine.writes_particles ? " Or --no-particles?" : ""));
}

}  // namespace moraine
