#include "seeding/seed_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>

#include "core/data/hash.hpp"
#include "core/data/rank_failure.hpp"
#include "io/byte_order_mark.hpp"
#include "io/file_numbers.hpp"
#include "io/h5_open.hpp"
#include "io/input_error.hpp"

namespace moraine {
namespace {

const std::vector<std::string>& column_names(int dimensions) {
    static const std::vector<std::string> names[] = {{"x", "y", "vx", "vy", "mass"},
                                                     {"x", "y", "z", "vx", "vy", "vz", "mass"}};
    return names[dimensions - 2];
}

/// Rows of columns, in the order of column_names; empty where the file has no such column.
using Columns = std::vector<std::vector<double>>;

/// Where row r stands.
using PlaceOfRow = std::function<std::string(std::size_t)>;

std::vector<std::string> cells_of(const std::string& line) {
    std::vector<std::string> cells(1);
    for (const char c : line)
        if (c == ',')
            cells.emplace_back();
        else if (c != ' ' && c != '\t' && c != '\r')
            cells.back() += c;
    for (std::string& cell : cells)
        if (cell.size() > 2 && cell.front() == '"' && cell.back() == '"') cell = cell.substr(1, cell.size() - 2);
    return cells;
}

double number(const std::string& text, const std::string& place, const std::string& column) {
    const std::optional<double> value = number_in(text);
    if (!value || !std::isfinite(*value))
        refuse(place, fmt::format("{} = {}", column, quote(text)), "must be a finite number",
               "Is the decimal sign a point and the separator a comma?");
    return *value;
}

/// Positions in column_names of the header's words.
std::vector<std::size_t> read_header(const std::vector<std::string>& words, const std::vector<std::string>& names,
                                     const std::string& place) {
    std::vector<std::size_t> columns;
    for (const std::string& word : words) {
        const auto found = std::find(names.begin(), names.end(), word);
        if (found == names.end())
            refuse(place, fmt::format("column {}", quote(word)), "must be one of " + listed(names),
                   suggest(word, names));
        columns.push_back(static_cast<std::size_t>(found - names.begin()));
        if (std::count(columns.begin(), columns.end(), columns.back()) > 1)
            refuse(place, fmt::format("column {} is there twice", word), "each column once", "Remove one?");
    }
    return columns;
}

Columns read_csv(const std::string& path, const std::vector<std::string>& names, std::vector<int>& line_of) {
    std::ifstream file(path);
    if (!file) refuse(path, "the table cannot be read", "no such file or no permission", "Is body.file right?");
    Columns data(names.size());
    std::vector<std::size_t> columns;
    std::string line;
    for (int n = 1; std::getline(file, line); ++n) {
        if (n == 1) drop_byte_order_mark(line);
        if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
        const std::string place = fmt::format("{}:{}", path, n);
        const std::vector<std::string> cells = cells_of(line);
        if (columns.empty()) {
            columns = read_header(cells, names, place);
            continue;
        }
        if (cells.size() != columns.size())
            refuse(place, fmt::format("{} numbers", cells.size()),
                   fmt::format("the header has {} columns", columns.size()), "Is the line complete?");
        for (std::size_t c = 0; c < cells.size(); ++c)
            data[columns[c]].push_back(number(cells[c], place, names[columns[c]]));
        line_of.push_back(n);
    }
    return data;
}

/// Throws H5Failure if a dataset of `rows` has no bytes for them in the file: a header alone may claim any number.
void check_storage(hid_t file, hid_t set, hsize_t rows) {
    hsize_t file_bytes = 0;
    h5_check(H5Fget_filesize(file, &file_bytes), "it cannot be read");
    const H5Id list(H5Dget_create_plist(set), H5Pclose, "it has no storage");
    const H5Id type(H5Dget_type(set), H5Tclose, "it has no type");
    const bool packed = H5Pget_nfilters(list) > 0;
    const hsize_t stored = std::min(H5Dget_storage_size(set), file_bytes);
    const hsize_t most = packed ? stored * 100000 : stored;  // a column of one value packs well
    const std::size_t bytes = H5Tget_size(type);             // of a damaged file: 0
    if (bytes == 0 || rows > most / bytes) throw H5Failure(fmt::format("its {} rows are not in the file", rows));
}

std::vector<double> read_dataset(hid_t file, const std::string& name) {
    const H5Id set = open_dataset(file, name, "it cannot be opened");
    const H5Id space(H5Dget_space(set), H5Sclose, "it has no extent");
    if (H5Sget_simple_extent_ndims(space) != 1) throw H5Failure("it must have one dimension");
    const auto rows = static_cast<hsize_t>(H5Sget_simple_extent_npoints(space));
    if (rows == 0) return {};
    check_storage(file, set, rows);
    std::vector<double> data(rows);
    h5_check(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data()), "it cannot be read");
    return data;
}

Columns read_h5(const std::string& path, const std::vector<std::string>& names) {
    const H5Quiet quiet;
    Columns data(names.size());
    std::string now;
    try {
        const H5Id file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "no such file, or not HDF5");
        for (std::size_t c = 0; c < names.size(); ++c) {
            now = names[c];
            if (H5Lexists(file, now.c_str(), H5P_DEFAULT) > 0) data[c] = read_dataset(file, now);
        }
    } catch (const H5Failure& failure) {
        refuse(path, now.empty() ? "the table cannot be read" : fmt::format("dataset {}", quote(now)), failure.what(),
               now.empty() ? "Is body.file right?" : "Write it as a list of numbers?");
    }
    return data;
}

/// The columns that are there have one length, and x, y, z are there.
void check_columns(const Columns& data, const std::vector<std::string>& names, int dimensions,
                   const std::string& path) {
    for (std::size_t c = 0; c < names.size(); ++c) {
        if (static_cast<int>(c) < dimensions && data[c].empty())
            refuse(path, fmt::format("no {} of any particle", names[c]), "columns x, y and in 3-D z are needed",
                   "Does the table have this column, and rows?");
        if (!data[c].empty() && data[c].size() != data[0].size())
            refuse(path, fmt::format("{} has {} rows", names[c], data[c].size()),
                   fmt::format("x has {}", data[0].size()), "Is the file complete?");
    }
}

void check_row(const Scene& scene, const ParticleTable& table, std::size_t r, const PlaceOfRow& place_of_row) {
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a) {
        const double x = table.x[r][a];
        if (!(x >= scene.min[a] && x <= scene.max[a]))
            refuse(place_of_row(r), fmt::format("{} = {}", "xyz"[a], x),
                   fmt::format("outside the domain, {} to {}", scene.min[a], scene.max[a]), "Is it in metres?");
        if (!std::isfinite(table.velocity[r][a]))
            refuse(place_of_row(r), fmt::format("v{} = {}", "xyz"[a], table.velocity[r][a]), "must be finite",
                   "Is the column complete?");
    }
    if (!table.mass.empty() && !(table.mass[r] > 0 && std::isfinite(table.mass[r])))
        refuse(place_of_row(r), fmt::format("mass = {}", table.mass[r]), "must be > 0", "Is it in kilograms?");
}

}  // namespace

std::string path_of_file(const Scene& scene, const std::string& file) {
    return (std::filesystem::path(scene.source.path).parent_path() / file).string();
}

/// Piece by piece: a table may be larger than what is kept of it.
std::uint64_t hash_of_file(const std::string& path) {
    std::error_code none;
    if (!std::filesystem::is_regular_file(path, none)) return 0;
    std::ifstream file(path, std::ios::binary);
    std::uint64_t hash = 0;
    for (std::string piece(1 << 20, '\0'); file;) {
        file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
        const auto count = static_cast<std::size_t>(file.gcount());
        hash = mix(hash ^ mix_bytes(mix(count), reinterpret_cast<const std::byte*>(piece.data()), count));
    }
    return hash;
}

ParticleTable read_particle_table(const Scene& scene, const BodySpec& body) {
    const std::string path = path_of_file(scene, body.file);
    const std::vector<std::string>& names = column_names(scene.dimensions);
    const bool csv = has_ending(path, ".csv");
    if (!csv && !has_ending(path, ".h5")) refuse(path, "unknown kind of table", "must be .csv or .h5", "Rename it?");
    std::error_code none;
    if (std::filesystem::exists(path, none) && !std::filesystem::is_regular_file(path, none))
        refuse(path, "the table cannot be read", "it is not a regular file", "Is body.file right?");
    std::vector<int> line_of;
    const Columns data = csv ? read_csv(path, names, line_of) : read_h5(path, names);
    check_columns(data, names, scene.dimensions, path);
    if (body.table_hash != 0 && hash_of_file(path) != body.table_hash)
        throw RankFailure(fmt::format(
            "{}: the table has changed since the scene was read (all ranks, and restarts, must have one). Does another "
            "program write it?",
            path));
    const PlaceOfRow place_of_row = [&](std::size_t r) {
        return csv ? fmt::format("{}:{}", path, line_of[r]) : fmt::format("{}, row {}", path, r);
    };
    ParticleTable table;
    const std::size_t rows = data[0].size();
    const std::size_t d = static_cast<std::size_t>(scene.dimensions);
    table.x.resize(rows);
    table.velocity.resize(rows);
    table.mass = data[2 * d];
    for (std::size_t r = 0; r < rows; ++r) {
        for (std::size_t a = 0; a < d; ++a) {
            table.x[r][a] = data[a][r];
            if (!data[d + a].empty()) table.velocity[r][a] = data[d + a][r];
        }
        check_row(scene, table, r, place_of_row);
    }
    return table;
}

}  // namespace moraine
