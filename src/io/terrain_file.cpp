#include "io/terrain_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>

#include "io/file_numbers.hpp"
#include "io/input_error.hpp"

namespace moraine {
namespace {

/// The header of an ESRI ASCII grid: its keys in lower case, and the first word behind it.
std::map<std::string, double> read_header(Words& words, std::optional<std::string_view>& word) {
    static const std::vector<std::string> keys{"ncols",     "nrows",    "xllcorner",    "xllcenter", "yllcorner",
                                               "yllcenter", "cellsize", "nodata_value", "dx",        "dy"};
    std::map<std::string, double> header;
    for (word = words.next(); word && std::isalpha(static_cast<unsigned char>((*word)[0])); word = words.next()) {
        const std::string key = lower_case(*word);
        if (key == "nan" || key == "inf") break;  // a height
        if (std::find(keys.begin(), keys.end(), key) == keys.end())
            refuse(words.place(), fmt::format("{} is no key of an ESRI ASCII grid", quote(key)),
                   "must be one of " + listed(keys), "Is it an ESRI ASCII grid?");
        const std::string value(words.next().value_or(""));
        if (key == "nodata_value" && lower_case(value) == "nan") continue;  // NaN is no height anyway
        header[key] = words.number(value, key);
    }
    for (const char* key : {"ncols", "nrows"})
        if (!header.contains(key))
            refuse(words.place(), fmt::format("{} is missing", key), "the file begins with its size and place",
                   "Is it an ESRI ASCII grid?");
    if (header.contains("dx") != header.contains("dy") || header.contains("dx") == header.contains("cellsize"))
        refuse(words.place(), "cellsize, or dx and dy", "one of them is needed", "Is it an ESRI ASCII grid?");
    if (header.contains("dx")) {
        if (!(std::fabs(header["dx"] - header["dy"]) <= 1e-6 * std::fabs(header["dx"])))
            refuse(words.place(), fmt::format("dx = {}, dy = {}", header["dx"], header["dy"]), "cells must be squares",
                   "Resample it, by gdalwarp -tr?");
        header["cellsize"] = header["dx"];
    }
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
    const std::string head = text_of(path, use.kind, use.key, 65536);
    Words words(head, path, " \t\r\n");
    std::optional<std::string_view> word;
    const std::map<std::string, double> header = read_header(words, word);
    return grid_of(header, words, std::filesystem::file_size(path) - head.size() + words.bytes_left());
}

double value_of(const Words& words, std::string_view word, const std::string& what, std::int64_t row,
                std::int64_t column) {
    const std::optional<double> z = number_in(word);
    if (z && !std::isinf(*z)) return *z;
    return words.number(word, fmt::format("the {} in row {}, column {}", what, row + 1, column + 1));
}

}  // namespace

Ground read_ascii_grid(const std::string& path, const RasterUse& use) {
    Ground g = grid_by_header(path, use);
    const std::string text = text_of(path, use.kind, use.key);
    Words words(text, path, " \t\r\n");
    std::optional<std::string_view> word;
    const std::map<std::string, double> header = read_header(words, word);
    const auto declared = header.find("nodata_value");
    const double unknown = declared != header.end() ? declared->second : -9999;  // the format's default
    const std::int64_t nx = g.count[0], ny = g.count[1];
    g.height.resize(static_cast<std::size_t>(nx * ny));
    for (std::int64_t k = 0; k < nx * ny; ++k, word = words.next()) {
        const std::int64_t row = k / nx, column = k % nx;
        if (!word)
            refuse(words.place(), fmt::format("the file ends after {} of {} heights", k, nx * ny),
                   "ncols and nrows say how many there are", "Is the file complete?");
        const double z = value_of(words, *word, use.value, row, column);
        g.height[static_cast<std::size_t>((ny - 1 - row) * nx + column)] =
            is_no_data(z, unknown) ? std::numeric_limits<double>::quiet_NaN() : z;
    }
    if (word)
        refuse(words.place(), fmt::format("more than {} heights", nx * ny), "ncols and nrows say how many there are",
               "Are ncols and nrows right?");
    return g;
}

}  // namespace moraine
