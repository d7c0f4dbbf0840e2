#pragma once
// [[table]]: loads over time, which other keys name. Not collective.

#include <string>
#include <vector>

#include "core/scene_spec.hpp"
#include "io/input_error.hpp"

namespace moraine {

struct TableSpec {
    std::string name;
    std::string file;  ///< .csv with time, value; empty: the rows are in the scene
    TimeTable rows;
};

/// The rows, from the file where it names one. `path`: of the table. Throws InputError.
TimeTable complete_table(const Scene& scene, const TableSpec& table, const std::string& path, const Places& places);

/// The table that the key at `path` names. Throws InputError.
const TimeTable& table_named(const std::vector<TableSpec>& tables, const std::string& name, const std::string& path,
                             const Places& places);

}  // namespace moraine
