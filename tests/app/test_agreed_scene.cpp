#include <doctest/doctest.h>

#include "app/agreed_scene.hpp"
#include "core/data/error.hpp"
#include "io/test_folder.hpp"

using namespace moraine;

namespace {

constexpr char scene[] =
    "dimensions = 2\n[domain]\nmin = [0, 0]\nmax = [4, 2]\ncell = 0.25\n[time]\nend = 0.1\n[[material]]\nname = \"m\"\n"
    "law = \"linear-elastic\"\ndensity = 1000\nyoung = 1e5\npoisson = 0.3\n[[body]]\nname = \"b\"\nmaterial = \"m\"\n"
    "shape = \"box\"\nmin = [1, 1]\nmax = [2, 2]\n";

/// What all ranks end with where the last one throws E.
template <class E>
std::string end_of(const Comm& comm, const Options& options) {
    try {
        read_agreed(comm, options, [&](const Scene&) {
            if (comm.rank() == comm.size() - 1) throw E("it is not there");
        });
    } catch (const E& error) {
        return error.what();
    }
    return "";
}

}  // namespace

TEST_CASE("what one rank cannot read, or has no library for, ends all ranks with the same words") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    Options options;
    options.scene = folder / "s.toml";
    if (comm.is_root()) set_content(options.scene, scene);
    comm.barrier();
    CHECK(read_agreed(comm, options, [](const Scene&) {}).bodies.size() == 1);
    CHECK(end_of<InputError>(comm, options) == "it is not there");
    CHECK(end_of<MachineError>(comm, options) == "it is not there");
}
