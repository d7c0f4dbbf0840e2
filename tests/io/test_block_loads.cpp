#include <doctest/doctest.h>

#include <filesystem>

#include "core/data/error.hpp"
#include "io/block_loads.hpp"
#include "io/test_folder.hpp"

using namespace moraine;

namespace {

LoadHeader header() {
    LoadHeader h;
    h.dimensions = 2;
    h.blocks = {8, 4, 1};
    return h;
}

LoadFrame frame(std::int64_t step) {
    const auto n = static_cast<std::uint32_t>(step);
    return {step,
            0.5 * static_cast<double>(step),
            0.25 * n,
            3 * step,
            {{0.25f}, {0.5f}},
            {{7, (10 + n) & 0x7fffffff, 0, 0}, {9, 20, 1, 1}, {12, n & 0x7fffffff, 0, 1}}};
}

void write_frames(const Comm& comm, const std::string& path, const std::vector<std::int64_t>& steps,
                  std::optional<std::int64_t> resume = {}) {
    BlockLoadWriter writer(comm, path, header(), resume);
    for (std::int64_t step : steps) writer.write(frame(step));
    comm.barrier();
}

/// Steps of the whole frames; then what is wrong with the rest.
std::pair<std::vector<std::int64_t>, std::string> read_steps(const std::string& path) {
    std::vector<std::int64_t> steps;
    try {
        BlockLoadReader reader(path);
        LoadFrame f;
        while (reader.next(f)) steps.push_back(f.step);
    } catch (const InputError& e) {
        return {steps, e.what()};
    }
    return {steps, ""};
}

using Steps = std::vector<std::int64_t>;

}  // namespace

TEST_CASE("what was written is read back, 16 bytes a block and 32 a rank") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const std::string path = folder / "block_loads.bin";
    write_frames(comm, path, {0, 50});
    BlockLoadReader reader(path);
    CHECK(reader.header().blocks[0] == 8);
    LoadFrame f;
    REQUIRE(reader.next(f));
    REQUIRE(reader.next(f));
    CHECK(f.step == 50);
    CHECK(f.time == 25);
    CHECK(f.lost == 12.5);
    CHECK(f.exchanges == 150);
    CHECK(f.seconds[1][0] == 0.5f);
    CHECK(f.rows[2].key == 12);
    CHECK(+f.rows[0].particles == 60);
    CHECK(f.rows[2].owner == 1);
    CHECK(+f.rows[1].asleep == 1);
    CHECK(+f.rows[1].particles == 20);
    CHECK(+f.rows[2].asleep == 0);
    CHECK_FALSE(reader.next(f));
    CHECK(std::filesystem::file_size(path) == 176 + 2 * (64 + 2 * 32 + 3 * 16));
}

TEST_CASE("a file that is cut anywhere but between frames is refused, and the last whole step is named") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const std::string path = folder / "block_loads.bin";
    write_frames(comm, path, {0, 50});
    for (std::uintmax_t size = std::filesystem::file_size(path) - 1; size > 0; size -= 13) {
        comm.barrier();
        if (comm.is_root()) std::filesystem::resize_file(path, size);
        comm.barrier();
        const auto [steps, message] = read_steps(path);
        const bool between = size == 176 || size == 352;
        CHECK((message.find("is truncated or damaged") != std::string::npos) == !between);
        CHECK(steps == (size >= 352 ? Steps{0} : Steps{}));
        if (size > 352) CHECK(message.find("--last-step 0?") != std::string::npos);
        if (size < 13) break;
    }
}

TEST_CASE("a changed bit is seen") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const std::string path = folder / "block_loads.bin";
    for (const std::streamoff at : {0, 8, 12, 40, 64, 100, 130, 175, 196, 216, 266, 316, 335}) {
        write_frames(comm, path, {0, 50});
        if (comm.is_root()) {
            std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
            file.seekg(at);
            const char c = static_cast<char>(file.get() ^ 1);
            file.seekp(at);
            file.put(c);
        }
        comm.barrier();
        CHECK_MESSAGE(read_steps(path).second.find("is truncated or damaged") != std::string::npos, at);
        comm.barrier();
    }
}

TEST_CASE("a resumed record keeps what was before the checkpoint, also of a torn file, and no step twice") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const std::string path = folder / "block_loads.bin";
    write_frames(comm, path, {0, 50, 100});
    write_frames(comm, path, {50, 80}, 60);
    CHECK(read_steps(path).first == Steps{0, 50, 80});
    comm.barrier();
    if (comm.is_root()) std::filesystem::resize_file(path, std::filesystem::file_size(path) - 1);
    comm.barrier();
    write_frames(comm, path, {90}, 85);
    CHECK(read_steps(path) == std::pair(Steps{0, 50, 90}, std::string()));
}

TEST_CASE("a record of another domain, or that says otherwise who sleeps, is not continued") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const std::string path = folder / "block_loads.bin";
    write_frames(comm, path, {0});
    LoadHeader other = header();
    other.blocks[0] = 9;
    CHECK_THROWS_AS(BlockLoadWriter(comm, path, other, 0), InputError);
    other = header();
    other.sleepers = static_cast<std::int32_t>(SleepersRecord::would);
    CHECK_THROWS_AS(BlockLoadWriter(comm, path, other, 0), InputError);
    comm.barrier();
}
