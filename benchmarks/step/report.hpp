#pragma once
// What a measured case looks like: one JSON line, one row of a table.

#include <string>

#include "step/measure.hpp"

namespace moraine {

/// Memory of a case above that of the same case with one cell of particles [bytes per particle].
inline double bytes_per_particle(const Measured& m, std::int64_t empty_bytes) {
    return static_cast<double>(m.peak_bytes - empty_bytes) / m.particles;
}

std::string json_line(const Case& c, const Runs& plan, const Measured& m, std::int64_t empty_bytes,
                      const Machine& machine);

std::string table_head();
std::string table_row(const Case& c, const Runs& plan, const Measured& m, std::int64_t empty_bytes);

/// The lines that explain the table.
std::string table_notes(const Runs& plan);

}  // namespace moraine
