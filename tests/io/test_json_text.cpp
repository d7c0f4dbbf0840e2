#include <doctest/doctest.h>

#include <cstdlib>
#include <limits>

#include "core/data/error.hpp"
#include "io/json_text.hpp"
#include "io/test_folder.hpp"

using namespace moraine;

namespace {

Json some_summary() {
    return Json::Named{
        {"version", "0.1.0"},
        {"text", std::string("a \"b\" \\ \n\t\x01 µ")},
        {"ranks", 4},
        {"particles", std::int64_t(1) << 60},
        {"wall_s", 0.1 + 0.2},
        {"tiny", 5e-324},
        {"whole", 1e22},
        {"nan", std::numeric_limits<double>::quiet_NaN()},
        {"infinity", -std::numeric_limits<double>::infinity()},
        {"flag", true},
        {"nothing", {}},
        {"momentum", std::vector<double>{1, -2.5, 0}},
        {"empty", Json::List{}},
        {"energies_J", Json::Named{{"kinetic", 1.5}, {"more", Json::Named{{"x", 2}}}, {"none", Json::Named{}}}}};
}

}  // namespace

TEST_CASE("the summary is told in order, and what is no number is null") {
    CHECK(Json(Json::Named{{"b", 1}, {"a", Json::List{1.5, "x", std::numeric_limits<double>::infinity()}}}).text() ==
          "{\n  \"b\": 1,\n  \"a\": [1.5, \"x\", null]\n}");
}

TEST_CASE("a summary replaces the old one at once, and Python reads it back to the bit") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const std::string path = folder / "summary.json";
    write_summary(comm, path, Json(1));
    write_summary(comm, path, some_summary());
    CHECK(!std::filesystem::exists(path + ".partial"));
    CHECK_THROWS_AS(write_summary(comm, folder / "absent/summary.json", some_summary()), MachineError);
    const char* python = std::getenv("MORAINE_PYTHON");
    if (!comm.is_root() || !python) return;
    set_content(folder / "check.py",
                "import json, sys\n"
                "s = json.load(open(sys.argv[1], encoding='utf-8'))\n"
                "assert list(s)[:3] == ['version', 'text', 'ranks'], s\n"
                "assert s['text'] == 'a \"b\" \\\\ \\n\\t\\x01 \\u00b5', s\n"
                "assert s['particles'] == 2**60 and s['wall_s'] == 0.1 + 0.2 and s['tiny'] == 5e-324\n"
                "assert s['whole'] == 1e22 and s['nan'] is None and s['infinity'] is None and s['nothing'] is None\n"
                "assert s['flag'] is True and s['momentum'] == [1, -2.5, 0] and s['empty'] == []\n"
                "assert s['energies_J'] == {'kinetic': 1.5, 'more': {'x': 2}, 'none': {}}\n");
    CHECK(std::system((std::string(python) + " " + (folder / "check.py") + " " + path).c_str()) == 0);
}
