#include "io/terrain_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <optional>

#include "io/byte_order_mark.hpp"
#include "io/input_error.hpp"

namespace moraine {
namespace {

/// The first `most` bytes of a file.
std::string text_of(const std::string& path, const char* kind, const char* key,
                    std::streamoff most = std::numeric_limits<std::streamoff>::max()) {
    std::error_code none;
    if (std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none))
        refuse(path, fmt::format("the {} cannot be read", kind), "it is not a regular file",
               fmt::format("Is {} right?", key));
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    if (!file)
        refuse(path, fmt::format("the {} cannot be read", kind), "no such file or no permission",
               fmt::format("Is {} right?", key));
    std::string text(static_cast<std::size_t>(std::min<std::streamoff>(file.tellg(), most)), '\0');
    file.seekg(0);
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    drop_byte_order_mark(text);
    return text;
}

/// Words of a text and the line on which each stands.
class Words {
  public:
    Words(const std::string& text, std::string path, const char* between, int line = 1)
        : text_(text), path_(std::move(path)), between_(between), line_(line) {}

    std::optional<std::string_view> next() {
        while (at_ < text_.size() && std::strchr(between_, text_[at_])) {
            if (text_[at_++] == '\n') ++line_;
        }
        if (at_ == text_.size()) return std::nullopt;
        const std::size_t first = at_;
        while (at_ < text_.size() && !std::strchr(between_, text_[at_])) ++at_;
        return std::string_view(text_).substr(first, at_ - first);
    }
    std::string place() const { return fmt::format("{}:{}", path_, line_); }
    std::size_t bytes_left() const { return text_.size() - at_; }

    double number(std::string_view word, const std::string& what) const {
        double value = 0;
        const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
        if (result.ec != std::errc() || result.ptr != word.data() + word.size() || !std::isfinite(value))
            refuse(place(), fmt::format("{} = {}", what, quote(std::string(word.substr(0, 40)))),
                   "must be a finite number", "Is the decimal sign a point?");
        return value;
    }

  private:
    const std::string& text_;
    std::string path_;
    const char* between_;
    std::size_t at_ = 0;
    int line_;
};

std::string lower_case(std::string_view word) {
    std::string text(word);
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

/// The header of an ESRI ASCII grid: its keys in lower case, and the first word behind it.
std::map<std::string, double> read_header(Words& words, std::optional<std::string_view>& word) {
    static const std::vector<std::string> keys{"ncols",     "nrows",     "xllcorner", "xllcenter",
                                               "yllcorner", "yllcenter", "cellsize",  "nodata_value"};
    std::map<std::string, double> header;
    for (word = words.next(); word && std::isalpha(static_cast<unsigned char>((*word)[0])); word = words.next()) {
        const std::string key = lower_case(*word);
        if (key == "nan" || key == "inf") break;  // a height
        if (std::find(keys.begin(), keys.end(), key) == keys.end())
            refuse(words.place(), fmt::format("{} is no key of an ESRI ASCII grid", quote(key)),
                   "must be one of " + listed(keys), "Cells must be squares; is the file one?");
        const auto value = words.next();
        header[key] = words.number(value.value_or(""), key);
    }
    for (const char* key : {"ncols", "nrows", "cellsize"})
        if (!header.contains(key))
            refuse(words.place(), fmt::format("{} is missing", key), "the file begins with its size and place",
                   "Is it an ESRI ASCII grid?");
    for (const char* axis : {"x", "y"})
        if (header.contains(std::string(axis) + "llcorner") == header.contains(std::string(axis) + "llcenter"))
            refuse(words.place(), fmt::format("{0}llcorner or {0}llcenter", axis), "one of them is needed",
                   "Is it an ESRI ASCII grid?");
    return header;
}

/// Size and place of the grid, without heights; so many bytes are there for them.
Ground grid_of(const std::map<std::string, double>& header, const Words& words, std::uintmax_t left) {
    Ground g;
    const double columns = header.at("ncols"), rows = header.at("nrows"), bytes = 2 * columns * rows;
    if (!(columns >= 1 && rows >= 1) || columns != std::floor(columns) || rows != std::floor(rows))
        refuse(words.place(), fmt::format("ncols = {}, nrows = {}", columns, rows), "must be whole numbers >= 1",
               "Is it an ESRI ASCII grid?");
    if (!(bytes <= static_cast<double>(left) + 3))
        refuse(words.place(), fmt::format("{:.0f} heights are promised", columns * rows),
               fmt::format("the file has {} bytes for them", left), "Is the file complete?");
    if (columns * rows > most_heights)
        refuse(words.place(), fmt::format("{:.3g} heights", columns * rows),
               fmt::format("a grid of text is read whole: {:.3g} GB on each rank; at most {:.2g} fit",
                           8e-9 * columns * rows, most_heights),
               "Convert it by gdal_translate -of GTiff, of which the part under the domain is read?");
    g.spacing = header.at("cellsize");
    if (!(g.spacing > 0)) refuse(words.place(), fmt::format("cellsize = {}", g.spacing), "must be > 0", "Correct it?");
    g.count = {static_cast<std::int64_t>(columns), static_cast<std::int64_t>(rows)};
    for (std::size_t a = 0; a < 2; ++a) {
        const std::string axis = a == 0 ? "x" : "y";
        const auto centre = header.find(axis + "llcenter");
        g.first[a] = centre != header.end() ? centre->second : header.at(axis + "llcorner") + 0.5 * g.spacing;
    }
    return g;
}

/// Says no before the memory is taken.
Ground grid_by_header(const std::string& path, const RasterUse& use) {
    const std::string head = text_of(path, use.kind.c_str(), use.key.c_str(), 65536);
    Words words(head, path, " \t\r\n");
    std::optional<std::string_view> word;
    const std::map<std::string, double> header = read_header(words, word);
    return grid_of(header, words, std::filesystem::file_size(path) - head.size() + words.bytes_left());
}

}  // namespace

Ground read_ascii_grid(const std::string& path, const RasterUse& use) {
    Ground g = grid_by_header(path, use);
    const std::string text = text_of(path, use.kind.c_str(), use.key.c_str());
    Words words(text, path, " \t\r\n");
    std::optional<std::string_view> word;
    const std::map<std::string, double> header = read_header(words, word);
    const auto unknown = header.find("nodata_value");
    const std::int64_t nx = g.count[0], ny = g.count[1];
    g.height.resize(static_cast<std::size_t>(nx * ny));
    for (std::int64_t k = 0; k < nx * ny; ++k, word = words.next()) {
        const std::int64_t row = k / nx, column = k % nx;
        if (!word)
            refuse(words.place(), fmt::format("the file ends after {} of {} heights", k, nx * ny),
                   "ncols and nrows say how many there are", "Is the file complete?");
        const double z =
            words.number(*word, fmt::format("the {} in row {}, column {}", use.value, row + 1, column + 1));
        const bool none = unknown != header.end() && z == unknown->second;
        g.height[static_cast<std::size_t>((ny - 1 - row) * nx + column)] =
            none ? std::numeric_limits<double>::quiet_NaN() : z;
    }
    if (word)
        refuse(words.place(), fmt::format("more than {} heights", nx * ny), "ncols and nrows say how many there are",
               "Are ncols and nrows right?");
    return g;
}

namespace {

/// Calls f(words of the row, Words) for each line below a header that names the columns; # begins a remark.
template <class F>
void each_row(const std::string& path, const char* kind, const char* key, const std::vector<std::string>& columns,
              const F& f) {
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
std::vector<std::array<double, 2>> read_pairs(const std::string& path, const char* kind, const char* key,
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
    const std::string text = text_of(path, what, name.c_str());
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
    const bool csv = path.ends_with(".csv");
    if (!csv && !path.ends_with(".geojson") && !path.ends_with(".json"))
        refuse(path, "unknown kind of area", "must be .csv or .geojson", "Convert or rename it?");
    auto ring = csv ? read_pairs(path, "area", key.c_str(), "x", "y") : points_of(path, key, "area", "Polygon");
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
    each_row(path, "table of the inflow", key.c_str(), {"time", "discharge", "speed"},
             [&](const std::vector<std::string_view>& cells, const Words& words) {
                 rows.push_back({words.number(cells[0], "time"), words.number(cells[1], "discharge"),
                                 words.number(cells[2], "speed")});
             });
    return rows;
}

std::vector<GisShape> read_points(const std::string& path, const std::string& key) {
    std::vector<GisShape> points;
    each_row(path, "table of points", key.c_str(), {"name", "x", "y"},
             [&](const std::vector<std::string_view>& cells, const Words& words) {
                 GisShape point;
                 point.name = std::string(cells[0]);
                 point.points = {{words.number(cells[1], "x"), words.number(cells[2], "y")}};
                 points.push_back(point);
             });
    return points;
}

}  // namespace moraine
