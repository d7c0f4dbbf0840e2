#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "core/error.hpp"
#include "io/checkpoint_format.hpp"
#include "io/disk_file.hpp"
#include "io/h5.hpp"

namespace moraine {

namespace {

H5Id space_of(const std::vector<hsize_t>& extent) {
    return {extent.empty() ? H5Screate(H5S_SCALAR)
                           : H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr),
            H5Sclose, "cannot make a data space"};
}

/// Times of writing are left out: equal runs make equal files.
H5Id creation_list(hid_t kind) {
    H5Id list(H5Pcreate(kind), H5Pclose, "cannot make a property list");
    h5_check(H5Pset_obj_track_times(list, false), "cannot make a property list");
    return list;
}

H5Id new_group(hid_t file, const char* name) {
    return {H5Gcreate2(file, name, H5P_DEFAULT, creation_list(H5P_GROUP_CREATE), H5P_DEFAULT), H5Gclose,
            "cannot make a group"};
}

void write_dataset(hid_t group, const std::string& name, hid_t type, const std::vector<hsize_t>& extent,
                   const void* data) {
    const H5Id space = space_of(extent);
    const H5Id set(
        H5Dcreate2(group, name.c_str(), type, space, H5P_DEFAULT, creation_list(H5P_DATASET_CREATE), H5P_DEFAULT),
        H5Dclose, "cannot make dataset " + name);
    h5_check(H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data), "cannot write dataset " + name);
}

void write_attribute(hid_t object, const char* name, hid_t type, const void* data) {
    const H5Id space = space_of({});
    const H5Id attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                         "cannot make an attribute");
    h5_check(H5Awrite(attribute, type, data), "cannot write an attribute");
}

H5Id text_type(std::size_t length) {
    H5Id type(H5Tcopy(H5T_C_S1), H5Tclose, "cannot make a text type");
    h5_check(H5Tset_size(type, std::max<std::size_t>(1, length)), "cannot make a text type");
    h5_check(H5Tset_strpad(type, H5T_STR_NULLPAD), "cannot make a text type");
    h5_check(H5Tset_cset(type, H5T_CSET_UTF8), "cannot make a text type");
    return type;
}

struct WriteValue {
    hid_t group;
    const std::string& key;
    void operator()(std::int64_t v) const { write_dataset(group, key, H5T_NATIVE_INT64, {}, &v); }
    void operator()(double v) const { write_dataset(group, key, H5T_NATIVE_DOUBLE, {}, &v); }
    void operator()(const std::string& v) const { write_dataset(group, key, text_type(v.size()), {}, v.c_str()); }
    void operator()(const std::vector<std::int64_t>& v) const {
        write_dataset(group, key, H5T_NATIVE_INT64, {v.size()}, v.data());
    }
    void operator()(const std::vector<double>& v) const {
        write_dataset(group, key, H5T_NATIVE_DOUBLE, {v.size()}, v.data());
    }
};

/// Space for a column, not yet written; returns where it is in the file.
std::int64_t reserve_column(hid_t group, const Column& column, std::int64_t rows) {
    const H5Id space = space_of({static_cast<hsize_t>(rows), static_cast<hsize_t>(column.components)});
    const H5Id plist = creation_list(H5P_DATASET_CREATE);
    h5_check(H5Pset_layout(plist, H5D_CONTIGUOUS), "cannot set a layout");
    h5_check(H5Pset_alloc_time(plist, H5D_ALLOC_TIME_EARLY), "cannot set a layout");
    h5_check(H5Pset_fill_time(plist, H5D_FILL_TIME_NEVER), "cannot set a layout");
    const H5Id set(H5Dcreate2(group, column.name.c_str(), checkpoint::file_type(column.type), space, H5P_DEFAULT, plist,
                              H5P_DEFAULT),
                   H5Dclose, "cannot make column " + column.name);
    write_attribute(set, "unit", text_type(column.unit.size()), column.unit.c_str());
    const haddr_t at = H5Dget_offset(set);
    if (at == HADDR_UNDEF && rows > 0) throw H5Failure("no place for column " + column.name);
    return rows > 0 ? static_cast<std::int64_t>(at) : 0;
}

/// All but the rows; returns where each column's rows go.
std::vector<std::int64_t> lay_out(const std::string& path, const CheckpointHeader& header, const FileOrder& order,
                                  std::span<const Column> columns) {
    const H5Quiet quiet;
    const H5Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "cannot make a property list");
    h5_check(H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18), "cannot set the format version");
    H5Id file(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation_list(H5P_FILE_CREATE), access), H5Fclose,
              "cannot create the file");
    write_attribute(file, "format_version", H5T_NATIVE_INT64, &checkpoint::format_version);
    {
        const H5Id group = new_group(file, "header");
        for (const auto& [key, value] : header) std::visit(WriteValue{group, key}, value);
    }
    std::vector<Key> keys;
    std::vector<std::int64_t> counts;
    for (const BlockRow& block : order.blocks) {
        keys.push_back(block.key);
        counts.push_back(block.count);
    }
    {
        const H5Id group = new_group(file, "blocks");
        write_dataset(group, "key", H5T_NATIVE_UINT64, {keys.size()}, keys.data());
        write_dataset(group, "count", H5T_NATIVE_INT64, {counts.size()}, counts.data());
    }
    std::vector<std::int64_t> places;
    {
        const H5Id group = new_group(file, "particles");
        for (const Column& column : columns) places.push_back(reserve_column(group, column, order.rows));
    }
    file.close("cannot write the file");
    std::vector<checkpoint::Region> regions;
    for (std::size_t c = 0; c < columns.size(); ++c)
        if (order.rows > 0) regions.push_back({places[c], order.rows * columns[c].row_bytes()});
    checkpoint::seal(path, regions);
    return places;
}

}  // namespace

void write_checkpoint(const Comm& comm, const std::string& path, const CheckpointHeader& header,
                      std::span<const BlockRow> my_blocks, std::span<const Column> columns) {
    const std::string partial = path + ".partial";
    const FileOrder order = file_order(comm, my_blocks);
    const RowOrder exchange(comm, order.mine, order.rows);
    try {
        std::vector<std::int64_t> places;
        comm.agree_no_error<MachineError>(words_of([&] {
            if (!comm.is_root()) return;
            DiskFile(partial, DiskFile::Mode::create);  // says why it cannot, in the words of the system
            try {
                places = lay_out(partial, header, order, columns);
            } catch (const H5Failure& failure) {
                throw MachineError(
                    fmt::format("cannot write {} ({}). Is the disk full or read-only?", path, failure.what()));
            }
        }));
        places = comm.all_gather(places);
        std::unique_ptr<DiskFile> file;
        std::string trouble = words_of([&] { file = std::make_unique<DiskFile>(partial, DiskFile::Mode::append); });
        for (std::size_t c = 0; c < columns.size(); ++c) {
            const auto rows = exchange.to_file(columns[c].data, columns[c].row_bytes());
            if (trouble.empty())
                trouble =
                    words_of([&] { file->write(rows, places[c] + exchange.slice().start * columns[c].row_bytes()); });
        }
        if (trouble.empty()) trouble = words_of([&] { file->sync(); });
        comm.agree_no_error<MachineError>(trouble);
        comm.agree_no_error<MachineError>(words_of([&] {
            if (comm.is_root()) move_file(partial, path);
        }));
    } catch (const MachineError&) {
        if (comm.is_root()) std::remove(partial.c_str());
        throw;
    }
}

}  // namespace moraine
