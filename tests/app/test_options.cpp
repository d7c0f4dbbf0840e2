#include <doctest/doctest.h>

#include "app/options.hpp"
#include "balance/partitioner.hpp"
#include "core/data/error.hpp"

using namespace moraine;

namespace {

Options parse(std::vector<const char*> message) {
    message.insert(message.begin(), "moraine");
    return parse_options(static_cast<int>(message.size()), message.data());
}

std::string said_of(const std::vector<const char*>& message) {
    try {
        parse(message);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

}  // namespace

TEST_CASE("run takes a scene and its options, in any order") {
    const Options o =
        parse({"run", "--set", "a=1", "s.toml", "--output", "d", "--overwrite", "--set=b.c=x y", "--device", "cpu",
               "--transport=host", "--partitioner", "slabs", "--restart", "c.h5", "--quiet"});
    CHECK(o.command == "run");
    CHECK(o.scene == "s.toml");
    CHECK(o.output == "d");
    CHECK(o.overwrite);
    CHECK(o.sets == std::vector<std::string>{"a=1", "b.c=x y"});
    CHECK(o.device == "cpu");
    CHECK(o.transport == "host");
    CHECK(o.partitioner == "slabs");
    CHECK(o.restart == "c.h5");
    CHECK(o.quiet);
}

TEST_CASE("a restart may be allowed to change keys, a run from the start not") {
    const Options o = parse({"run", "s.toml", "--restart", "c.h5", "--allow-change", "numerics.damping",
                             "--allow-change=material.clay.su"});
    CHECK(o.allow_changes == std::vector<std::string>{"numerics.damping", "material.clay.su"});
    CHECK(said_of({"run", "s.toml", "--allow-change", "numerics.damping"})
              .starts_with("--allow-change without --restart"));
}

TEST_CASE("what is not said is automatic") {
    const Options o = parse({"run", "s.toml"});
    CHECK(o.output.empty());
    CHECK_FALSE(o.overwrite);
    CHECK_FALSE(o.quiet);
    CHECK(o.device == "auto");
    CHECK(o.transport == "auto");
    CHECK(o.partitioner.empty());
    CHECK(o.restart.empty());
}

TEST_CASE("check takes a scene, --set and --ranks") {
    const Options o = parse({"check", "s.toml", "--set", "seed=-1", "--ranks", "8"});
    CHECK(o.command == "check");
    CHECK(o.sets.size() == 1);
    CHECK(o.ranks == 8);
    CHECK_FALSE(o.time);
    CHECK(parse({"check", "s.toml", "--time", "--transport", "host"}).time);
    CHECK(said_of({"check", "s.toml", "--time", "--ranks", "2"}).ends_with("mpirun -n 2 moraine check s.toml --time?"));
    CHECK(said_of({"check", "s.toml", "--overwrite"}).starts_with("--overwrite (moraine check has no such option)"));
    CHECK(said_of({"check", "s.toml", "--ranks", "0"}).starts_with("--ranks 0 (must be at least 1)"));
    CHECK_FALSE(said_of({"check", "s.toml", "--ranks", "many"}).empty());
}

TEST_CASE("help and version need no scene") {
    CHECK(parse({}).command == "help");
    CHECK(parse({"--help"}).command == "help");
    CHECK(parse({"run", "--help"}).command == "help");
    CHECK(parse({"--version"}).command == "version");
    CHECK(help_text("").find("--partitioner") != std::string::npos);
}

TEST_CASE("an unknown option or command names the nearest") {
    CHECK(said_of({"run", "s.toml", "--partitoner", "morton"}) ==
          "--partitoner (moraine run has no such option). Did you mean --partitioner?");
    CHECK(said_of({"rnu", "s.toml"}) == "rnu (not a command). Did you mean run?");
    CHECK(said_of({"s.toml"}) == "s.toml (not a command). Did you mean moraine run s.toml?");
}

TEST_CASE("a value that is missing, unknown or given twice is refused") {
    CHECK(said_of({"run", "s.toml", "--output"}) ==
          "--output (a value is missing, or not wanted). See moraine --help?");
    CHECK(said_of({"run", "s.toml", "--quiet=1"}).starts_with("--quiet"));
    CHECK(said_of({"run", "s.toml", "--output", "a", "--output", "b"}) == "--output (given twice). Remove one?");
    CHECK(said_of({"run", "s.toml", "--device", "cuba"}) ==
          "--device cuba (must be one of auto, cpu, cuda). Did you mean cuda?");
    CHECK(said_of({"run", "s.toml", "--transport", "ncl"}).ends_with("Did you mean nccl?"));
    CHECK(said_of({"run", "s.toml", "--partitioner", "mortn"}).ends_with("Did you mean morton?"));
}

TEST_CASE("one scene is needed, and no more") {
    CHECK(said_of({"run"}).starts_with("no scene"));
    CHECK(said_of({"run", "a.toml", "b.toml"}).starts_with("two scenes, a.toml and b.toml"));
    CHECK(said_of({"run", "a.toml", "--set", "x=1", "y=2"}).ends_with("Does each --set have its own KEY=VALUE?"));
}

TEST_CASE("every partitioner of the program can be asked for") {
    for (const std::string& name : partitioner_names())
        CHECK(parse({"run", "s.toml", "--partitioner", name.c_str()}).partitioner == name);
}
