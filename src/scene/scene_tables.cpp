#include "scene/scene_tables.hpp"

#include <fmt/format.h>

#include "io/terrain_file.hpp"
#include "scene/scene_keys.hpp"
#include "scene/scene_terrain.hpp"
#include "seeding/seed_table.hpp"

namespace moraine {
namespace {

using enum KeyType;
using T = TableSpec;
using V = KeyValue;

const std::vector<KeyRow<TableSpec>> rows = in_tables<TableSpec>({
    {{.table = "table", .name = "name", .type = name, .meaning = "By which loads and --set refer to it."},
     [](T& t, const V& v) { t.name = v.text; }},
    {{.name = "times", .type = list, .unit = "s", .standard = "", .meaning = "From 0 on, rising."},
     [](T& t, const V& v) { t.rows.times = v.numbers; }},
    {{.name = "values",
      .type = list,
      .standard = "",
      .meaning = "As many; linear between the times, constant before the first and after the last. A step takes the "
                 "mean over its length."},
     [](T& t, const V& v) { t.rows.values = v.numbers; }},
    {{.name = "file",
      .type = text,
      .standard = "",
      .meaning = "In place of both: .csv with a line time, value and the rows below it; relative to the scene."},
     [](T& t, const V& v) { t.file = v.text; }},
});

void check_rows(const TableSpec& table, const std::string& path, const Places& places) {
    const auto& [times, values] = table.rows;
    if (times.empty() || times.size() != values.size())
        refuse(places.of(path + (times.empty() ? "" : ".values")),
               fmt::format("{} has {} times and {} values", path, times.size(), values.size()), "each time has a value",
               "Give as many of both, or a file?");
    for (std::size_t k = 0; k < times.size(); ++k)
        if (times[k] < 0 || (k > 0 && times[k] <= times[k - 1]))
            refuse(places.of(path + ".times"), fmt::format("{}.times has {} s as number {}", path, times[k], k + 1),
                   "times rise from 0 s on, and each is there once", "Put them in order?");
}

}  // namespace

const std::vector<KeyRow<TableSpec>>& table_rows() {
    return rows;
}

TimeTable complete_table(const Scene& scene, const TableSpec& table, const std::string& path, const Places& places) {
    if (table.file.empty()) {
        check_rows(table, path, places);
        return table.rows;
    }
    for (const char* key : {".times", ".values"})
        if (places.has(path + key))
            refuse(places.of(path + key), fmt::format("{}{} beside {}.file", path, key, path),
                   "its rows are in the file", "Remove one of them?");
    require_file(scene, table.file, path + ".file", places);
    TimeTable found;
    for (const auto& [time, value] : read_time_table(path_of_file(scene, table.file), path + ".file")) {
        found.times.push_back(time);
        found.values.push_back(value);
    }
    return found;
}

const TimeTable& table_named(const std::vector<TableSpec>& tables, const std::string& name, const std::string& path,
                             const Places& places) {
    std::vector<std::string> names;
    for (const TableSpec& table : tables) {
        if (table.name == name) return table.rows;
        names.push_back(table.name);
    }
    refuse(places.of(path), fmt::format("{} = {}", path, quote(name)), "there is no such table",
           names.empty() ? "Write one as [[table]]?" : suggest(name, names));
}

}  // namespace moraine
