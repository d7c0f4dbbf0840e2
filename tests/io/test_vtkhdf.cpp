#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>

#include "core/data/error.hpp"
#include "io/h5.hpp"
#include "io/sample_rows.hpp"
#include "io/test_folder.hpp"
#include "io/vtkhdf.hpp"

using namespace moraine;

namespace {

void append_sample(const Comm& comm, ParticleSeries& series, double time, std::int64_t rows_per_block) {
    const auto all = sample::blocks(30, rows_per_block);
    const sample::Part part(all, comm.rank(), comm.size(), static_cast<std::uint64_t>(rows_per_block));
    const auto columns = part.columns();
    const Column fields[] = {columns[0], columns[2]};
    series.append(time, part.blocks, columns[1], fields);
}

std::int64_t rows_of(std::int64_t rows_per_block) {
    std::int64_t rows = 0;
    for (const BlockRow& block : sample::blocks(30, rows_per_block)) rows += block.count;
    return rows;
}

/// Through the library: the last output's ids count up, its numbers are those of the ids.
bool last_output_is(const std::string& path, std::size_t outputs, std::int64_t rows) {
    const auto state = vtkhdf::read_state(path);
    if (state.steps.size() != outputs || state.steps.back().rows != rows) return false;
    const H5Id file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "file");
    const H5Id set(H5Dopen2(file, "VTKHDF/Points", H5P_DEFAULT), H5Dclose, "set");
    const H5Id space(H5Dget_space(set), H5Sclose, "space");
    const hsize_t start[] = {static_cast<hsize_t>(state.steps.back().first_chunk * state.chunk_rows), 0};
    const hsize_t count[] = {static_cast<hsize_t>(rows), 3};
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr);
    const H5Id memory(H5Screate_simple(2, count, nullptr), H5Sclose, "space");
    std::vector<double> points(static_cast<std::size_t>(3 * rows));
    if (H5Dread(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, points.data()) < 0) return false;
    for (std::size_t r = 0; r < points.size() / 3; ++r)
        if (points[3 * r] != sample::number(r, 0) || points[3 * r + 1] != sample::number(r, 1) ||
            points[3 * r + 2] != 0)
            return false;
    return true;
}

}  // namespace

TEST_CASE("outputs of any size and distribution read back through the HDF5 library") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    ParticleSeries series(comm, folder / "p.vtkhdf");
    std::size_t outputs = 0;
    for (const std::int64_t rows : {400, 390, 0, 1, 700, 400}) {
        append_sample(comm, series, 0.5 * static_cast<double>(outputs), rows);
        ++outputs;
        if (comm.is_root()) CHECK(last_output_is(folder / "p.vtkhdf", outputs, rows_of(rows)));
        comm.barrier();
    }
}

TEST_CASE("an output changes nothing before the old end but the superblock, so a kill cannot tear the file") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const std::string path = folder / "p.vtkhdf";
    ParticleSeries series(comm, path);
    append_sample(comm, series, 0, 200);
    for (int k = 1; k < 24; ++k) {  // more chunks than one node of the tree holds
        const std::string before = content_of(path);
        comm.barrier();
        append_sample(comm, series, k, 200);
        if (k % 10 == 0) series.truncate_to(k - 1);
        const std::string after = content_of(path);
        comm.barrier();
        REQUIRE(after.size() >= before.size());
        CHECK(after.compare(48, before.size() - 48, before, 48) == 0);
        if (comm.is_root() && k % 10 == 5) {
            // All of the new bytes without the switch: the old outputs.
            set_content(folder / "torn", before.substr(0, 48) + after.substr(48));
            CHECK(last_output_is(folder / "torn", vtkhdf::read_state(path).steps.size() - 1, rows_of(200)));
        }
    }
}

TEST_CASE("a series goes on after a cut as if it had never gone further") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const std::string path = folder / "p.vtkhdf";
    {
        ParticleSeries series(comm, path);
        for (int k = 0; k < 5; ++k) append_sample(comm, series, 0.1 * k, 300);
    }
    {
        ParticleSeries series(comm, path);
        series.truncate_to(0.2);
        if (comm.is_root()) CHECK(series.times() == std::vector<double>{0, 0.1, 0.2});
        append_sample(comm, series, 7, 123);
        if (comm.is_root()) CHECK(series.times() == std::vector<double>{0, 0.1, 0.2, 7});
    }
    if (comm.is_root()) CHECK(last_output_is(path, 4, rows_of(123)));
    ParticleSeries series(comm, path);
    series.truncate_to(-1);
    CHECK(!std::filesystem::exists(path));
    comm.barrier();
    append_sample(comm, series, 8, 50);
    if (comm.is_root()) CHECK(last_output_is(path, 1, rows_of(50)));
}

TEST_CASE("what follows a cut is found, not what was cut off") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const std::string path = folder / "p.vtkhdf";
    ParticleSeries series(comm, path);
    for (int k = 0; k < 10; ++k) append_sample(comm, series, k, 300);  // more than a node of chunks
    const auto end = comm.broadcast(comm.is_root() ? std::to_string(vtkhdf::read_state(path).end) : "");
    series.truncate_to(1);
    for (int k = 2; k < 10; ++k) append_sample(comm, series, k, 300);
    if (!comm.is_root()) return;
    const auto state = vtkhdf::read_state(path);
    for (const auto& chunk : state.arrays[0].chunks)
        CHECK((chunk.at >= std::stoull(end)) == (chunk.index >= state.steps[2].first_chunk));
}

TEST_CASE("a series may be compressed from any output on, or no more, and is read by the HDF5 library") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const std::string path = folder / "p.vtkhdf";
    std::int64_t bytes[2] = {};
    for (const bool first : {false, true}) {
        for (int k = 0; k < 30; ++k) {  // more chunks than a node holds
            ParticleSeries series(comm, path, {(k / 10 % 2 == 1) != first});
            append_sample(comm, series, k, k % 3 == 0 ? 2000 : 400);
            if (!comm.is_root()) continue;
            CHECK(last_output_is(path, static_cast<std::size_t>(k) + 1, rows_of(k % 3 == 0 ? 2000 : 400)));
            if (k == 9) bytes[first ? 1 : 0] = static_cast<std::int64_t>(std::filesystem::file_size(path));
        }
        comm.barrier();
        ParticleSeries series(comm, path);
        series.truncate_to(9);
        if (comm.is_root()) CHECK(last_output_is(path, 10, rows_of(2000)));
        series.truncate_to(-1);
    }
    if (comm.is_root()) CHECK(bytes[1] < 0.9 * static_cast<double>(bytes[0]));
}

TEST_CASE("outputs that are written asynchronously are the same bytes, and in the file when they are through") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    for (const bool deflate : {false, true}) {
        ParticleSeries waiting(comm, folder / "w.vtkhdf", {deflate, false});
        ParticleSeries series(comm, folder / "a.vtkhdf", {deflate, true});
        for (int k = 0; k < 6; ++k) {
            append_sample(comm, waiting, k, 4000);
            CHECK(!waiting.under_way());
            append_sample(comm, series, k, 4000);  // waits for the one before
            CHECK(series.under_way());
            while (k % 2 == 0 && series.under_way()) {
                while (comm.max(std::int64_t(series.busy())) != 0) continue;
                series.advance();
            }
            if (comm.is_root() && k > 0) CHECK(vtkhdf::read_state(folder / "a.vtkhdf").steps.size() >= std::size_t(k));
        }
        series.finish();
        CHECK(!series.under_way());
        CHECK(content_of(folder / "a.vtkhdf") == content_of(folder / "w.vtkhdf"));
        comm.barrier();
        series.truncate_to(-1);
        waiting.truncate_to(-1);
    }
}

TEST_CASE("an asynchronous output that cannot be written fails on all ranks, and the next one as well") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    ParticleSeries series(comm, folder / "p.vtkhdf", {false, true});
    append_sample(comm, series, 0, 20);
    series.finish();
    append_sample(comm, series, 1, 20);
    if (comm.is_root()) std::filesystem::remove(folder / "p.vtkhdf");
    comm.barrier();
    for (int k = 2; k < 4; ++k) CHECK_THROWS_AS((append_sample(comm, series, k, 20), series.finish()), MachineError);
    CHECK(!series.under_way());
}

TEST_CASE("a file that is no series is refused and left alone") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    if (comm.is_root()) set_content(folder / "p.vtkhdf", "mine");
    comm.barrier();
    CHECK_THROWS_AS(ParticleSeries(comm, folder / "p.vtkhdf"), InputError);
    CHECK(content_of(folder / "p.vtkhdf") == "mine");
}

TEST_CASE("a series that another run has begun anew is left alone") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const std::string path = folder / "p.vtkhdf";
    ParticleSeries first(comm, path);
    for (int k = 0; k < 3; ++k) append_sample(comm, first, k, 200);
    if (comm.is_root()) std::filesystem::remove(path);
    comm.barrier();
    ParticleSeries second(comm, path);
    append_sample(comm, second, 0, 300);
    const std::string before = content_of(path);
    comm.barrier();
    CHECK_THROWS_AS(append_sample(comm, first, 3, 200), MachineError);
    CHECK(content_of(path) == before);
    comm.barrier();
    append_sample(comm, second, 1, 300);
    if (comm.is_root()) CHECK(last_output_is(path, 2, rows_of(300)));
}

TEST_CASE("a series that cannot be written fails on all ranks") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    ParticleSeries nowhere(comm, folder / "absent/p.vtkhdf");
    CHECK_THROWS_AS(append_sample(comm, nowhere, 0, 20), MachineError);
    ParticleSeries series(comm, folder / "p.vtkhdf");
    append_sample(comm, series, 0, 20);
    if (comm.is_root()) std::filesystem::remove(folder / "p.vtkhdf");
    comm.barrier();
    CHECK_THROWS_AS(append_sample(comm, series, 1, 20), MachineError);
}
