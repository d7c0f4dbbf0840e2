#include <algorithm>
#include <array>
#include <fstream>

#include "io/h5_open.hpp"
#include "io/vtkhdf_state.hpp"

namespace moraine::vtkhdf {

namespace {

constexpr const char* damaged = "it is not a time series of this program, or is damaged";

H5Id open(hid_t file, const std::string& path) {
    return open_dataset(file, path, damaged);
}

std::vector<hsize_t> extent_of(hid_t set) {
    const H5Id space(H5Dget_space(set), H5Sclose, damaged);
    std::array<hsize_t, 32> extent{};
    const int dims = H5Sget_simple_extent_dims(space, extent.data(), nullptr);
    if (dims < 1) throw H5Failure(damaged);
    return {extent.begin(), extent.begin() + dims};
}

template <class T>
std::vector<T> read_list(hid_t file, const std::string& path, hid_t type) {
    const H5Id set = open(file, path);
    std::vector<T> list(extent_of(set)[0]);
    h5_check(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, list.data()), damaged);
    return list;
}

Column::Type type_of(hid_t set) {
    const H5Id type(H5Dget_type(set), H5Tclose, damaged);
    using Type = Column::Type;
    const std::pair<Type, hid_t> known[] = {{Type::u8, H5T_STD_U8LE},    {Type::u16, H5T_STD_U16LE},
                                            {Type::u32, H5T_STD_U32LE},  {Type::u64, H5T_STD_U64LE},
                                            {Type::f32, H5T_IEEE_F32LE}, {Type::f64, H5T_IEEE_F64LE}};
    for (const auto& [ours, theirs] : known)
        if (H5Tequal(type, theirs) > 0) return ours;
    throw H5Failure(damaged);
}

std::string unit_of(hid_t set) {
    if (H5Aexists(set, "unit") <= 0) return {};
    const H5Id attribute(H5Aopen(set, "unit", H5P_DEFAULT), H5Aclose, damaged);
    const H5Id type(H5Aget_type(attribute), H5Tclose, damaged);
    std::string unit(H5Tget_size(type), '\0');
    h5_check(H5Aread(attribute, type, unit.data()), damaged);
    return unit;
}

/// Rows of a chunk; `array` is the first, or must agree.
std::int64_t chunk_rows_of(hid_t set, std::size_t dims) {
    const H5Id plist(H5Dget_create_plist(set), H5Pclose, damaged);
    std::array<hsize_t, 32> chunk{};
    if (H5Pget_chunk(plist, 32, chunk.data()) != static_cast<int>(dims)) throw H5Failure(damaged);
    return static_cast<std::int64_t>(chunk[0]);
}

/// Whether chunks may be compressed by our two filters; by no others.
bool is_filtered(hid_t set) {
    const H5Id plist(H5Dget_create_plist(set), H5Pclose, damaged);
    const int filters = H5Pget_nfilters(plist);
    if (filters == 0) return false;
    for (int k = 0; k < filters; ++k) {
        unsigned flags = 0, config = 0;
        std::size_t values = 0;
        const auto filter =
            H5Pget_filter2(plist, static_cast<unsigned>(k), &flags, &values, nullptr, 0, nullptr, &config);
        if (filters != 2 || filter != (k == 0 ? H5Z_FILTER_SHUFFLE : H5Z_FILTER_DEFLATE)) throw H5Failure(damaged);
    }
    return true;
}

SeriesArray read_array(hid_t file, const std::string& path, SeriesState& state) {
    const H5Id set = open(file, path);
    const auto extent = extent_of(set);
    SeriesArray array{path.substr(path.rfind('/') + 1), unit_of(set), type_of(set),
                      extent.size() > 1 ? static_cast<int>(extent[1]) : 1};
    const std::int64_t chunk_rows = chunk_rows_of(set, extent.size());
    if (state.chunk_rows != 0 && state.chunk_rows != chunk_rows) throw H5Failure(damaged);
    state.chunk_rows = chunk_rows;
    const bool filtered = is_filtered(set);
    if (state.arrays.empty()) state.filtered = filtered;
    if (state.filtered != filtered) throw H5Failure(damaged);
    const auto chunks = static_cast<std::int64_t>(extent[0]) / chunk_rows;
    for (std::int64_t index = 0; index < chunks; ++index) {
        const hsize_t corner[] = {static_cast<hsize_t>(index * chunk_rows), 0};
        unsigned filters = 0;
        haddr_t at = HADDR_UNDEF;
        hsize_t bytes = 0;
        h5_check(H5Dget_chunk_info_by_coord(set, corner, &filters, &at, &bytes), damaged);
        const auto packed = filtered && filters == 0 ? static_cast<std::int64_t>(bytes) : 0;
        if (at != HADDR_UNDEF) array.chunks.push_back({index, at, packed});
    }
    return array;
}

std::vector<std::string> names_in(hid_t file, const char* path) {
    const H5Id members = open_group(file, path, damaged);
    std::vector<std::string> names;
    const auto add = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
        static_cast<std::vector<std::string>*>(list)->emplace_back(name);
        return 0;
    };
    hsize_t at = 0;
    h5_check(H5Literate(members, H5_INDEX_NAME, H5_ITER_INC, &at, add, &names), damaged);
    return names;
}

Address end_in(const std::string& path) {
    std::array<std::byte, hdf5::superblock_bytes> head{};
    std::ifstream(path, std::ios::binary).read(reinterpret_cast<char*>(head.data()), head.size());
    const Address end = hdf5::end_of_file(head);
    if (end == hdf5::nowhere) throw H5Failure(damaged);
    return end;
}

}  // namespace

SeriesState read_state(const std::string& path) {
    const H5Quiet quiet;
    SeriesState state;
    state.end = end_in(path);
    const H5Id file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, damaged);
    state.arrays.push_back(read_array(file, "VTKHDF/Points", state));
    for (const std::string& name : names_in(file, "VTKHDF/PointData"))
        state.arrays.push_back(read_array(file, "VTKHDF/PointData/" + name, state));
    const auto times = read_list<double>(file, "VTKHDF/Steps/Values", H5T_NATIVE_DOUBLE);
    const auto first = read_list<std::int64_t>(file, "VTKHDF/Steps/PointOffsets", H5T_NATIVE_INT64);
    const auto rows = read_list<std::int64_t>(file, "VTKHDF/NumberOfPoints", H5T_NATIVE_INT64);
    const auto part = read_list<std::size_t>(file, "VTKHDF/Steps/PartOffsets", H5T_NATIVE_HSIZE);
    if (times.empty() || first.size() != times.size() || part.size() != times.size()) throw H5Failure(damaged);
    for (std::size_t s = 0; s < times.size(); ++s) {
        if (part[s] >= rows.size()) throw H5Failure(damaged);
        state.steps.push_back({times[s], rows[part[s]], first[s] / state.chunk_rows});
    }
    const H5Id vertices = open(file, "VTKHDF/Vertices/Connectivity");
    state.vertices_count = static_cast<std::int64_t>(extent_of(vertices)[0]);
    state.vertices = H5Dget_offset(vertices);
    return state;
}

}  // namespace moraine::vtkhdf
