#include <doctest/doctest.h>
#include <unistd.h>

#include "app/run_directory.hpp"
#include "core/data/error.hpp"
#include "io/test_folder.hpp"

using namespace moraine;
namespace fs = std::filesystem;

namespace {

std::string refusal(const Comm& comm, const std::string& path, RunClaim claim) {
    std::string message;
    try {
        claim_run_directory(comm, path, claim);
    } catch (const InputError& error) {
        message = error.what();
    }
    CHECK(message == comm.broadcast(message));
    comm.barrier();
    return message;
}

void put(const Comm& comm, const std::string& path) {
    if (comm.is_root()) set_content(path, "x");
    comm.barrier();
}

}  // namespace

TEST_CASE("a check creates nothing, a claim creates the directory") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    check_run_directory(comm, folder / "runs/a", RunClaim::fresh);
    CHECK(!fs::exists(folder / "runs"));
    comm.barrier();
    claim_run_directory(comm, folder / "runs/a", RunClaim::fresh);
    comm.barrier();
    CHECK(fs::is_empty(folder / "runs/a"));
    CHECK(default_run_directory("slurry") == "runs/slurry");
    CHECK_THROWS_AS(default_run_directory(".."), InputError);
    CHECK_THROWS_AS(default_run_directory("."), InputError);
    CHECK(default_run_directory("...") == "runs/...");
}

TEST_CASE("a directory that holds a run is refused, and overwritten only of a run's files") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    for (const char* file : {"summary.json", "history.csv", "particles.vtkhdf", "checkpoint-000000012.h5"}) {
        claim_run_directory(comm, folder / "a", RunClaim::overwrite);
        for (const char* other : {"notes.txt", "balance.csv", "scene.json", "checkpoint-1.h5.partial"})
            put(comm, folder / "a/" + other);
        CHECK(refusal(comm, folder / "a", RunClaim::fresh).empty());
        put(comm, folder / "a/" + file);
        CHECK(refusal(comm, folder / "a", RunClaim::fresh).find("holds a run (it has " + std::string(file)) !=
              std::string::npos);
        CHECK(fs::exists(folder / "a/" + file));
        comm.barrier();
        CHECK(refusal(comm, folder / "a", RunClaim::resume).empty());
        CHECK(fs::exists(folder / "a/" + file));
        CHECK(fs::exists(folder / "a/balance.csv"));
        comm.barrier();
        CHECK(refusal(comm, folder / "a", RunClaim::overwrite).empty());
        CHECK(std::distance(fs::directory_iterator(folder / "a"), {}) == 1);
        CHECK(fs::exists(folder / "a/notes.txt"));
        comm.barrier();
    }
}

TEST_CASE("what a killed run left unfinished is gone after any claim, and nothing else is") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    for (const RunClaim claim : {RunClaim::fresh, RunClaim::overwrite, RunClaim::resume}) {
        claim_run_directory(comm, folder / "a", RunClaim::overwrite);
        for (const char* file : {"checkpoint-000000012.h5.partial", "particles.vtkhdf.partial", "summary.json.partial",
                                 "notes.partial", "checkpoint-000000012.h5.partial.mine"})
            put(comm, folder / "a/" + file);
        CHECK(refusal(comm, folder / "a", claim).empty());
        CHECK(std::distance(fs::directory_iterator(folder / "a"), {}) == 2);
        CHECK(fs::exists(folder / "a/notes.partial"));
        CHECK(fs::exists(folder / "a/checkpoint-000000012.h5.partial.mine"));
        comm.barrier();
    }
}

TEST_CASE("while one run holds a directory others are refused, and afterwards not") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    {
        const RunLock held = claim_run_directory(comm, folder / "a", RunClaim::fresh);
        for (const RunClaim claim : {RunClaim::fresh, RunClaim::overwrite, RunClaim::resume}) {
            CHECK(refusal(comm, folder / "a", claim).find("another run writes into") != std::string::npos);
            CHECK_THROWS_AS(check_run_directory(comm, folder / "a", claim), InputError);
        }
        const std::string mine = comm.broadcast(std::to_string(::getpid()));
        CHECK(refusal(comm, folder / "a", RunClaim::fresh).find("(process " + mine + " on ") != std::string::npos);
        comm.barrier();
    }
    comm.barrier();
    CHECK(fs::is_empty(folder / "a"));
    comm.barrier();
}

TEST_CASE("the lock that a killed run left holds nobody up") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    if (comm.is_root()) fs::create_directory(folder / "a");
    for (const char* words : {"", "elsewhere 1\n", "damaged"}) {
        if (comm.is_root()) set_content(folder / "a/run.lock", words);
        comm.barrier();
        CHECK(refusal(comm, folder / "a", RunClaim::fresh).empty());
        CHECK(!fs::exists(folder / "a/run.lock"));
        comm.barrier();
    }
}

TEST_CASE("a directory that cannot be written is refused, and nothing is left behind") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    put(comm, folder / "file");
    CHECK(refusal(comm, folder / "file", RunClaim::fresh).find("is not a directory") != std::string::npos);
    CHECK(refusal(comm, folder / "file/runs/a", RunClaim::fresh).find("is not a directory") != std::string::npos);
    CHECK(refusal(comm, "/proc/moraine/run", RunClaim::fresh).find("cannot write into") != std::string::npos);
    // Too long a name: only making it shows that it cannot be made.
    const std::string too_long = folder / "made/too/" + std::string(300, 'x');
    CHECK(!refusal(comm, too_long, RunClaim::fresh).empty());
    CHECK(!fs::exists(folder / "made"));
    if (::geteuid() == 0) return;  // to root no directory is closed
    if (comm.is_root()) {
        fs::create_directory(folder / "closed");
        fs::permissions(folder / "closed", fs::perms::owner_read | fs::perms::owner_exec);
    }
    comm.barrier();
    CHECK(refusal(comm, folder / "closed/a", RunClaim::fresh).find("Permission denied") != std::string::npos);
}
