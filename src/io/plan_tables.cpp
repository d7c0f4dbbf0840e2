// Profiles, polygons, points, lines, inflows and tables of time of text files.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "io/file_numbers.hpp"
#include "io/input_error.hpp"
#include "io/terrain_file.hpp"

namespace moraine {
namespace {

/// Calls f(words of the row, Words) for each line below a header that names the columns; # begins a remark.
template <class F>
void each_row(const std::string& path, const char* kind, const std::string& key,
              const std::vector<std::string>& columns, const F& f) {
    static const char* const count[] = {"no", "one", "two", "three"};
    const std::string text = text_of(path, kind, key), header = fmt::format("{}", fmt::join(columns, ","));
    std::size_t at = 0;
    bool headed = false;
    for (int line = 1; at < text.size(); ++line) {
        const std::size_t end = std::min(text.find('\n', at), text.size());
        const std::string row = text.substr(at, end - at);
        at = end + 1;
        Words words(row, path, " \t\r,;", line);
        std::vector<std::string_view> cells;
        while (const auto word = words.next()) cells.push_back(*word);
        if (cells.empty() || cells[0][0] == '#') continue;
        if (cells.size() != columns.size())
            refuse(words.place(), fmt::format("not {} values", count[columns.size()]), "a line is " + header,
                   "Is the separator a comma?");
        const auto names = [](std::string_view cell, const std::string& column) { return lower_case(cell) == column; };
        if (!headed && !std::equal(cells.begin(), cells.end(), columns.begin(), names))
            refuse(words.place(), fmt::format("the header is {}", quote(row.substr(0, 40))), "must be " + header,
                   "Add it as the first line?");
        if (headed) f(cells, words);
        headed = true;
    }
}

/// Rows of two numbers.
std::vector<std::array<double, 2>> read_pairs(const std::string& path, const char* kind, const std::string& key,
                                              const std::string& first, const std::string& second) {
    std::vector<std::array<double, 2>> rows;
    each_row(path, kind, key, {first, second}, [&](const std::vector<std::string_view>& cells, const Words& words) {
        rows.push_back({words.number(cells[0], first), words.number(cells[1], second)});
    });
    return rows;
}

}  // namespace

Ground read_profile(const std::string& path) {
    const auto rows = read_pairs(path, "profile", "terrain.profile", "x", "z");
    if (rows.size() < 3)
        refuse(path, fmt::format("the profile has {} points", rows.size()), "at least 3 are needed",
               "Is the file complete?");
    Ground g;
    g.count[0] = static_cast<std::int64_t>(rows.size());
    g.spacing = (rows.back()[0] - rows.front()[0]) / static_cast<double>(rows.size() - 1);
    g.first[0] = rows.front()[0];
    for (std::size_t k = 0; k < rows.size(); ++k) {
        const double expected = g.first[0] + static_cast<double>(k) * g.spacing;
        if (!(g.spacing > 0) || std::fabs(rows[k][0] - expected) > 1e-6 * g.spacing)
            refuse(path, fmt::format("x = {} of point {}", rows[k][0], k + 1),
                   fmt::format("points must rise at even distances, which would be {:.6g} here", g.spacing),
                   "Resample the profile?");
        g.height.push_back(rows[k][1]);
    }
    return g;
}

namespace {

/// The numbers of a list that begins at `at`, up to its end: one point.
std::array<double, 2> point_of(const std::string& text, std::size_t& at, const std::string& place) {
    const std::size_t end = std::min(text.find(']', at), text.size());
    const std::string list = text.substr(at + 1, end - at - 1);
    at = end + 1;
    Words words(list, place, " \t\r\n,");
    const auto x = words.next(), y = words.next();
    if (!x || !y) refuse(place, "a corner without two numbers", "a corner is [x, y]", "Is the file complete?");
    return {words.number(*x, "x"), words.number(*y, "y")};
}

/// The outer ring of the one polygon of a GeoJSON, or its one line. `what`: area or section.
std::vector<std::array<double, 2>> points_of(const std::string& path, const std::string& name, const char* what,
                                             const std::string& type) {
    const std::string text = text_of(path, what, name);
    const std::string key = "\"coordinates\"";
    const std::size_t first = text.find(key);
    if (first == std::string::npos || text.find(type + "\"") == std::string::npos)
        refuse(path, fmt::format("no {} was found", type == "Polygon" ? "polygon" : "line"),
               fmt::format("a geometry of type {} is needed", type), fmt::format("Is it the GeoJSON of the {}?", what));
    if (text.find(key, first + 1) != std::string::npos)
        refuse(path, "more than one geometry", "without GDAL one is read", "Give each a file, or write them as .csv?");
    std::vector<std::array<double, 2>> ring;
    std::size_t at = text.find('[', first);
    const auto inner = [&] { return at < text.size() ? text.find_first_not_of(" \t\r\n[", at) : at; };
    if (at != std::string::npos && inner() != std::string::npos) at = text.rfind('[', inner());
    while (at < text.size() && text[at] == '[') {
        ring.push_back(point_of(text, at, path));
        at = std::min(text.find_first_not_of(" \t\r\n,", at), text.size());
    }
    return ring;
}

}  // namespace

std::vector<std::array<double, 2>> read_polygon(const std::string& path, const std::string& key) {
    const bool csv = has_ending(path, ".csv");
    if (!csv && !has_ending(path, ".geojson") && !has_ending(path, ".json"))
        refuse(path, "unknown kind of area", "must be .csv or .geojson", "Convert or rename it?");
    auto ring = csv ? read_pairs(path, "area", key, "x", "y") : points_of(path, key, "area", "Polygon");
    if (ring.size() > 1 && ring.front() == ring.back()) ring.pop_back();
    if (ring.size() < 3)
        refuse(path, fmt::format("the polygon has {} corners", ring.size()), "at least 3 are needed",
               "Is the file complete?");
    return ring;
}

GisShape read_line(const std::string& path, const std::string& key) {
    GisShape line;
    line.points = points_of(path, key, "section", "LineString");
    return line;
}

std::vector<std::array<double, 3>> read_hydrograph(const std::string& path, const std::string& key) {
    std::vector<std::array<double, 3>> rows;
    each_row(path, "table of the inflow", key, {"time", "discharge", "speed"},
             [&](const std::vector<std::string_view>& cells, const Words& words) {
                 rows.push_back({words.number(cells[0], "time"), words.number(cells[1], "discharge"),
                                 words.number(cells[2], "speed")});
             });
    return rows;
}

std::vector<std::array<double, 2>> read_time_table(const std::string& path, const std::string& key) {
    std::vector<std::array<double, 2>> rows;
    each_row(path, "table of time", key, {"time", "value"},
             [&](const std::vector<std::string_view>& cells, const Words& words) {
                 const double time = words.number(cells[0], "time");
                 if (time < 0 || (!rows.empty() && time <= rows.back()[0]))
                     refuse(words.place(), fmt::format("time = {}", time),
                            "times rise from 0 s on, and each is there once", "Put the rows in order?");
                 rows.push_back({time, words.number(cells[1], "value")});
             });
    if (rows.empty()) refuse(path, "no rows", "a table has one at least", "Is the file complete?");
    return rows;
}

std::vector<GisShape> read_points(const std::string& path, const std::string& key) {
    std::vector<GisShape> points;
    each_row(path, "table of points", key, {"name", "x", "y"},
             [&](const std::vector<std::string_view>& cells, const Words& words) {
                 GisShape point;
                 point.name = std::string(cells[0]);
                 point.points = {{words.number(cells[1], "x"), words.number(cells[2], "y")}};
                 points.push_back(point);
             });
    return points;
}

}  // namespace moraine
