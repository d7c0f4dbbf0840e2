#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "core/data/error.hpp"
#include "io/checkpoint.hpp"
#include "io/checkpoint_format.hpp"
#include "io/disk_file.hpp"
#include "io/h5_open.hpp"

namespace moraine {

namespace {

H5Id open_file(const std::string& path) {
    return {H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "it is truncated or damaged"};
}

H5Id group_of(hid_t file, const char* name) {
    return open_group(file, name, fmt::format("group {} is missing or damaged", name));
}

H5Id dataset_of(hid_t group, const std::string& name) {
    return open_dataset(group, name, fmt::format("dataset {} is missing or damaged", name));
}

H5Id type_of(hid_t set) {
    return {H5Dget_type(set), H5Tclose, "a type is damaged"};
}

H5Id space_of(hid_t set) {
    return {H5Dget_space(set), H5Sclose, "a shape is damaged"};
}

/// Lengths along each dimension; none for a scalar.
std::vector<hsize_t> extent_of(hid_t set) {
    const H5Id space = space_of(set);
    const int dims = H5Sget_simple_extent_ndims(space);
    if (dims < 0) throw H5Failure("a shape is damaged");
    std::vector<hsize_t> extent(static_cast<std::size_t>(dims));
    if (dims > 0) h5_check(H5Sget_simple_extent_dims(space, extent.data(), nullptr), "a shape is damaged");
    return extent;
}

void read_all(hid_t set, hid_t type, void* data) {
    h5_check(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), "a dataset is truncated or damaged");
}

template <class T>
std::vector<T> read_list(hid_t set, hid_t type) {
    const auto extent = extent_of(set);
    if (extent.size() != 1) throw H5Failure("a list has a wrong shape");
    // What the file says of its size is believed only if the bytes are there.
    if (extent[0] > 0 && H5Dget_storage_size(set) / sizeof(T) != extent[0]) throw H5Failure("a list is truncated");
    std::vector<T> list(extent[0]);
    if (!list.empty()) read_all(set, type, list.data());
    return list;
}

std::string read_text(hid_t set, hid_t type) {
    if (H5Tis_variable_str(type) > 0) throw H5Failure("a text has a wrong type");
    std::string text(H5Tget_size(type), '\0');
    read_all(set, type, text.data());
    if (text.size() == 1 && text[0] == '\0') text.clear();
    return text;
}

HeaderValue read_value(hid_t group, const std::string& key) {
    const H5Id set = dataset_of(group, key);
    const H5Id type = type_of(set);
    const bool list = !extent_of(set).empty();
    switch (H5Tget_class(type)) {
        case H5T_STRING:
            return read_text(set, type);
        case H5T_INTEGER: {
            if (list) return read_list<std::int64_t>(set, H5T_NATIVE_INT64);
            std::int64_t value = 0;
            read_all(set, H5T_NATIVE_INT64, &value);
            return value;
        }
        case H5T_FLOAT: {
            if (list) return read_list<double>(set, H5T_NATIVE_DOUBLE);
            double value = 0;
            read_all(set, H5T_NATIVE_DOUBLE, &value);
            return value;
        }
        default:
            throw H5Failure("a type is damaged");
    }
}

std::vector<std::string> names_in(hid_t group) {
    std::vector<std::string> names;
    const auto add = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
        static_cast<std::vector<std::string>*>(list)->emplace_back(name);
        return 0;
    };
    hsize_t at = 0;
    h5_check(H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, &at, add, &names), "a group is damaged");
    return names;
}

template <class T>
T read_attribute(hid_t object, const char* name, hid_t type) {
    const H5Id attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose,
                         fmt::format("attribute {} is missing or damaged", name));
    T value{};
    h5_check(H5Aread(attribute, type, &value), "an attribute is damaged");
    return value;
}

Column read_shape(hid_t group, const std::string& name, std::int64_t rows) {
    const H5Id set = dataset_of(group, name);
    const auto extent = extent_of(set);
    if (extent.size() != 2 || static_cast<std::int64_t>(extent[0]) != rows)
        throw H5Failure(fmt::format("column {} has not the rows of the blocks", name));
    const H5Id type = type_of(set);
    using Type = Column::Type;
    for (const Type t : {Type::u8, Type::u16, Type::u32, Type::u64, Type::f32, Type::f64})
        if (H5Tequal(type, checkpoint::file_type(t)) > 0) {
            Column shape{name, "", t, static_cast<int>(extent[1]), nullptr};
            if (rows > 0 && H5Dget_storage_size(set) != static_cast<hsize_t>(rows) * shape.row_bytes())
                throw H5Failure(fmt::format("column {} is truncated", name));
            const H5Id unit(H5Aopen(set, "unit", H5P_DEFAULT), H5Aclose, "a unit is missing or damaged");
            const H5Id text(H5Aget_type(unit), H5Tclose, "a unit is damaged");
            shape.unit.resize(H5Tget_size(text));
            h5_check(H5Aread(unit, text, shape.unit.data()), "a unit is damaged");
            return shape;
        }
    throw H5Failure(fmt::format("column {} has an unknown type", name));
}

constexpr std::int64_t most_of_block = std::numeric_limits<std::int32_t>::max();

std::string damaged(const std::string& path, const std::string& why) {
    return fmt::format("cannot restart from {} ({}). Use an older checkpoint?", path, why);
}

}  // namespace

CheckpointReader::CheckpointReader(const Comm& comm, const std::string& path) : comm_(comm), path_(path) {
    const H5Quiet quiet;
    const auto agree = [&](const std::string& message) {
        comm.agree_no_error<InputError>(message.empty() ? message : damaged(path, message));
    };
    agree(message_of([&] {
        if (comm.is_root()) checkpoint::check_seal(path);
    }));
    agree(message_of([&] { read_tables(); }));
}

/// Everything but the rows.
void CheckpointReader::read_tables() {
    const H5Id file = open_file(path_);
    const auto version = read_attribute<std::int64_t>(file, "format_version", H5T_NATIVE_INT64);
    if (version != checkpoint::format_version)
        throw H5Failure(
            fmt::format("its format is version {}, this program's is {}", version, checkpoint::format_version));
    const H5Id group = group_of(file, "header");
    for (const std::string& key : names_in(group)) header_[key] = read_value(group, key);
    const H5Id table = group_of(file, "blocks");
    const auto keys = read_list<Key>(dataset_of(table, "key"), H5T_NATIVE_UINT64);
    const auto counts = read_list<std::int64_t>(dataset_of(table, "count"), H5T_NATIVE_INT64);
    if (keys.size() != counts.size()) throw H5Failure("its table of blocks is damaged");
    for (std::size_t k = 0; k < keys.size(); ++k) {
        if (counts[k] < 0 || counts[k] > most_of_block || (k > 0 && keys[k] <= keys[k - 1]))
            throw H5Failure(fmt::format("block {} of its table cannot be", k));
        blocks_.push_back({keys[k], counts[k]});
    }
    starts_.assign(1, 0);
    for (const BlockRow& block : blocks_) starts_.push_back(starts_.back() + block.count);
    const H5Id particles = group_of(file, "particles");
    for (const std::string& name : names_in(particles)) columns_.push_back(read_shape(particles, name, starts_.back()));
}

void CheckpointReader::refuse(const std::string& why) const {
    throw InputError(damaged(path_, why));
}

void CheckpointReader::missing(const std::string& what) const {
    refuse("it has no " + what);
}

void CheckpointReader::read_rows(const Column& shape, std::span<const RowRange> mine, std::byte* rows) const {
    const auto found = std::find_if(columns_.begin(), columns_.end(), [&](const Column& c) {
        return c.name == shape.name && c.type == shape.type && c.components == shape.components;
    });
    if (found == columns_.end()) missing(fmt::format("column {} of this type", shape.name));
    const RowOrder exchange(comm_, mine, starts_.back());
    const RowRange slice = exchange.slice();
    std::vector<std::byte> bytes(static_cast<std::size_t>(slice.count) * static_cast<std::size_t>(shape.row_bytes()));
    const H5Quiet quiet;
    const std::string message = message_of([&] {
        if (slice.count == 0) return;
        const H5Id file = open_file(path_);
        const H5Id set = dataset_of(group_of(file, "particles"), shape.name);
        const H5Id space = space_of(set);
        const hsize_t start[] = {static_cast<hsize_t>(slice.start), 0};
        const hsize_t count[] = {static_cast<hsize_t>(slice.count), static_cast<hsize_t>(shape.components)};
        h5_check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr), "a column is damaged");
        const H5Id memory(H5Screate_simple(2, count, nullptr), H5Sclose, "a column is damaged");
        h5_check(H5Dread(set, checkpoint::file_type(shape.type), memory, space, H5P_DEFAULT, bytes.data()),
                 fmt::format("column {} is truncated or damaged", shape.name));
    });
    comm_.agree_no_error<InputError>(message.empty() ? message : damaged(path_, message));
    exchange.from_file(bytes.data(), shape.row_bytes(), rows);
}

}  // namespace moraine
