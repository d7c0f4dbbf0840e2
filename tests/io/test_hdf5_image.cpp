#include <doctest/doctest.h>

#include "io/h5.hpp"
#include "io/test_folder.hpp"
#include "io/vtkhdf_state.hpp"

using namespace moraine;
using namespace moraine::hdf5;
using namespace moraine::vtkhdf;

namespace {

std::string text_of(const std::vector<std::byte>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// 5000 outputs of one or two chunks; the second array lacks every third output.
SeriesState long_series() {
    SeriesState state;
    state.chunk_rows = 1024;
    state.arrays = {{"Points", "m", Column::Type::f64, 3}, {"stage", "", Column::Type::u8, 1}};
    for (int k = 0; k < 5000; ++k) {
        const std::int64_t rows = k % 4 == 0 ? 1500 : 10;
        state.steps.push_back({0.01 * k, rows, state.next_chunk()});
        for (std::int64_t c = state.steps.back().first_chunk; c < state.next_chunk(); ++c) {
            const auto at = static_cast<Address>(30000 * (c + 100));
            state.arrays[0].chunks.push_back({c, at});
            if (k % 3 != 1) state.arrays[1].chunks.push_back({c, at + 25000});
        }
    }
    state.vertices = 48;
    state.vertices_count = 1501;
    return state;
}

char mark_of(std::int64_t chunk) {
    return static_cast<char>(chunk % 100 + 1);
}

/// First number of each chunk of `stage`, 0 where there is no chunk.
std::string marks(const SeriesState& state) {
    std::string list(static_cast<std::size_t>(state.next_chunk()), '\0');
    for (const Chunk& chunk : state.arrays[1].chunks)
        list[static_cast<std::size_t>(chunk.index)] = mark_of(chunk.index);
    return list;
}

std::string first_of_chunks(const std::string& path, const SeriesState& state) {
    const H5Id file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "file");
    const H5Id set(H5Dopen2(file, "VTKHDF/PointData/stage", H5P_DEFAULT), H5Dclose, "set");
    const H5Id space(H5Dget_space(set), H5Sclose, "space");
    const hsize_t start = 0;
    const auto stride = static_cast<hsize_t>(state.chunk_rows);
    const auto count = static_cast<hsize_t>(state.next_chunk());
    H5Sselect_hyperslab(space, H5S_SELECT_SET, &start, &stride, &count, nullptr);
    const H5Id memory(H5Screate_simple(1, &count, nullptr), H5Sclose, "space");
    std::string list(count, '?');
    H5Dread(set, H5T_NATIVE_UINT8, memory, space, H5P_DEFAULT, list.data());
    return list;
}

}  // namespace

TEST_CASE("a link's name fills one byte with its length, and a longer one is refused, not cut") {
    CHECK_NOTHROW(group({{std::string(255, 'a'), 8}}, {}));
    CHECK_THROWS_AS(group({{std::string(256, 'a'), 8}}, {}), std::length_error);
}

TEST_CASE("the HDF5 library finds every chunk of a long series, and none where none was written") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    SeriesState state = long_series();
    // Two commits, the second of which uses full nodes of the first again.
    Address root = 0;
    const Address at = 65536;
    std::string file(at, '\0');
    auto later = state;
    for (auto& array : state.arrays) array.chunks.resize(array.chunks.size() - 5);
    file += text_of(metadata(state, at, root));
    for (std::size_t a = 0; a < 2; ++a) {
        later.arrays[a].full_nodes = state.arrays[a].full_nodes;
        CHECK(state.arrays[a].full_nodes.size() == state.arrays[a].chunks.size() / node_entries);
    }
    file.resize((file.size() + 7) / 8 * 8);
    file += text_of(metadata(later, file.size(), root));
    file.resize(std::size_t(30000) * (later.arrays[0].chunks.size() + 102));  // where the last chunk ends
    file.replace(0, superblock_bytes, text_of(superblock(root, file.size())));
    for (const Chunk& chunk : later.arrays[1].chunks) file[chunk.at] = mark_of(chunk.index);
    set_content(folder / "p.vtkhdf", file);
    CHECK(first_of_chunks(folder / "p.vtkhdf", later) == marks(later));

    const SeriesState read = read_state(folder / "p.vtkhdf");
    CHECK(read.end == file.size());
    CHECK(read.vertices == 48);
    REQUIRE(read.steps.size() == later.steps.size());
    CHECK(read.steps.back().time == later.steps.back().time);
    CHECK(read.steps.back().first_chunk == later.steps.back().first_chunk);
    REQUIRE(read.arrays.size() == 2);
    for (std::size_t a = 0; a < 2; ++a) {
        CHECK(read.arrays[a].name == later.arrays[a].name);
        CHECK(read.arrays[a].unit == later.arrays[a].unit);
        CHECK(read.arrays[a].type == later.arrays[a].type);
        CHECK(read.arrays[a].components == later.arrays[a].components);
        REQUIRE(read.arrays[a].chunks.size() == later.arrays[a].chunks.size());
        bool same = true;
        for (std::size_t c = 0; c < read.arrays[a].chunks.size(); ++c)
            same = same && read.arrays[a].chunks[c].index == later.arrays[a].chunks[c].index &&
                   read.arrays[a].chunks[c].at == later.arrays[a].chunks[c].at;
        CHECK(same);
    }
}
