#include <doctest/doctest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstring>
#include <memory>

#include "core/data/error.hpp"
#include "io/checkpoint.hpp"
#include "io/sample_rows.hpp"
#include "io/test_folder.hpp"

using namespace moraine;

namespace {

CheckpointHeader some_header() {
    return {{"step", std::int64_t(120)},
            {"time", 0.1 + 0.2},
            {"scene", std::string(200000, 'x') + "\n[domain]\nµ"},
            {"nothing", std::string()},
            {"state_hash", std::string("0123456789abcdef")},
            {"totals", std::vector<double>{1.5, -0.0, 1e-310}},
            {"counts", std::vector<std::int64_t>{-1, std::int64_t(1) << 62}},
            {"none", std::vector<double>{}}};
}

void write_sample(const Comm& comm, const std::string& path, const std::vector<BlockRow>& all, std::uint64_t seed) {
    const sample::Part part(all, comm.rank(), comm.size(), seed);
    write_checkpoint(comm, path, some_header(), part.blocks, part.columns());
}

/// Whether the rows of a distribution read back as they were made.
bool reads_back(const Comm& comm, const CheckpointReader& reader, const std::vector<BlockRow>& all,
                std::uint64_t seed) {
    const sample::Part part(all, comm.rank(), comm.size(), seed);
    bool same = true;
    for (const Column& column : part.columns()) {
        std::vector<std::byte> rows(part.id.size() * static_cast<std::size_t>(column.row_bytes()));
        reader.read_rows(column, part.ranges, rows.data());
        same = same && (rows.empty() || std::memcmp(rows.data(), column.data, rows.size()) == 0);
    }
    return comm.min(same ? 1.0 : 0.0) == 1.0;
}

std::string words_for(const Comm& comm, const std::string& path) {
    try {
        const CheckpointReader reader(comm, path);
    } catch (const InputError& error) {
        return error.what();
    }
    return {};
}

}  // namespace

TEST_CASE("the bytes of a checkpoint do not depend on who owned the blocks") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const auto all = sample::blocks(100, 30);
    for (const std::uint64_t seed : {1, 2, 3}) write_sample(comm, folder / std::to_string(seed), all, seed);
    if (comm.is_root()) {
        const Comm alone(MPI_COMM_SELF);
        write_sample(alone, folder / "alone", all, 1);
        for (const char* name : {"1", "2", "3"}) CHECK(content_of(folder / name) == content_of(folder / "alone"));
    }
}

TEST_CASE("a checkpoint reads back on any ranks and any distribution") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const auto all = sample::blocks(100, 30);
    write_sample(comm, folder / "c.h5", all, 1);
    {
        const CheckpointReader reader(comm, folder / "c.h5");
        CHECK(reader.header() == some_header());
        CHECK(reader.get<double>("time") == 0.1 + 0.2);
        CHECK_THROWS_AS(reader.get<double>("step"), InputError);
        REQUIRE(reader.blocks().size() == all.size());
        for (std::size_t b = 0; b < all.size(); ++b) {
            CHECK(reader.blocks()[b].key == all[b].key);
            CHECK(reader.starts()[b + 1] - reader.starts()[b] == all[b].count);
        }
        CHECK(reader.columns().size() == 3);
        CHECK(reader.columns()[2].unit == "Pa");
        for (const std::uint64_t seed : {4, 5}) CHECK(reads_back(comm, reader, all, seed));
    }
    MPI_Comm fewer = MPI_COMM_NULL;
    MPI_Comm_split(comm.handle(), comm.rank() < (comm.size() + 1) / 2 ? 0 : MPI_UNDEFINED, 0, &fewer);
    if (fewer != MPI_COMM_NULL) {
        {
            const Comm half(fewer);
            CHECK(reads_back(half, CheckpointReader(half, folder / "c.h5"), all, 6));
        }
        MPI_Comm_free(&fewer);
    }
}

TEST_CASE("a checkpoint without particles or blocks reads back") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    for (const int blocks : {0, 4}) {
        auto all = sample::blocks(blocks, 0);
        write_sample(comm, folder / "c.h5", all, 1);
        const CheckpointReader reader(comm, folder / "c.h5");
        CHECK(reader.blocks().size() == all.size());
        CHECK(reads_back(comm, reader, all, 2));
    }
}

TEST_CASE("what is not a whole checkpoint is refused with the same words on all ranks") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const auto all = sample::blocks(20, 10);
    write_sample(comm, folder / "good.h5", all, 1);
    const std::string good = content_of(folder / "good.h5");
    comm.barrier();
    CHECK(words_for(comm, folder / "absent.h5").find("there is no such file") != std::string::npos);
    CHECK(words_for(comm, folder.path()).find("there is no such file") != std::string::npos);
    for (const double part : {0.0, 0.001, 0.3, 0.9, 0.9999}) {
        if (comm.is_root())
            set_content(folder / "cut.h5", good.substr(0, static_cast<std::size_t>(part * double(good.size()))));
        comm.barrier();
        const std::string message = words_for(comm, folder / "cut.h5");
        CHECK(message.find("cannot restart from") == 0);
        CHECK(message == comm.broadcast(message));
        comm.barrier();
    }
    const CheckpointReader reader(comm, folder / "good.h5");
    std::vector<double> rows(1);
    CHECK_THROWS_AS(reader.read_rows(Column::of("absent", "", rows.data()), {}, nullptr), InputError);
    CHECK_THROWS_AS(reader.read_rows(Column::of("id", "", rows.data()), {}, nullptr), InputError);
}

TEST_CASE("a flipped bit outside the rows is found, or changes nothing") {
    const Comm world(MPI_COMM_WORLD);
    if (!world.is_root()) return;
    const Comm comm(MPI_COMM_SELF);
    const TestFolder folder(comm);
    const auto all = sample::blocks(20, 1);
    CheckpointHeader header = some_header();
    header["scene"] = std::string("title = 'x'");
    const sample::Part part(all, 0, 1, 1);
    write_checkpoint(comm, folder / "good.h5", header, part.blocks, part.columns());
    std::string bytes = content_of(folder / "good.h5");
    int found = 0;
    const int trials = 1000;
    for (int k = 0; k < trials; ++k) {
        const std::uint64_t random = sample::mix(static_cast<std::uint64_t>(k));
        char& byte = bytes[random % bytes.size()];
        const char flip = static_cast<char>(1 << (random >> 60) % 8);
        byte ^= flip;
        set_content(folder / "bad.h5", bytes);
        byte ^= flip;
        try {
            const CheckpointReader reader(comm, folder / "bad.h5");
            CHECK(reader.header() == header);
            CHECK(reader.blocks().size() == all.size());
            CHECK(reader.columns().size() == 3);
        } catch (const InputError&) {
            ++found;
        }
    }
    CHECK(found > trials / 4);
}

TEST_CASE("a disk that is full on one rank fails on all, and leaves the old checkpoint alone") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const auto all = sample::blocks(100, 30);
    write_sample(comm, folder / "c.h5", all, 1);
    const std::string before = content_of(folder / "c.h5");
    comm.barrier();
    rlimit usual{};
    getrlimit(RLIMIT_FSIZE, &usual);
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit little{8192, usual.rlim_max};
    if (comm.rank() + 1 == comm.size()) setrlimit(RLIMIT_FSIZE, &little);
    CHECK_THROWS_AS(write_sample(comm, folder / "c.h5", all, 2), MachineError);
    setrlimit(RLIMIT_FSIZE, &usual);
    CHECK_THROWS_AS(write_sample(comm, folder / "absent/c.h5", all, 2), MachineError);
    CHECK(content_of(folder / "c.h5") == before);
    comm.barrier();
    CHECK(!std::filesystem::exists(folder / "c.h5.partial"));
}

TEST_CASE("checkpoints are named by their step") {
    CHECK(checkpoint_name(120) == "checkpoint-000000120.h5");
}
