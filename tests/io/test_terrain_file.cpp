#include <doctest/doctest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/data/error.hpp"
#include "io/terrain_file.hpp"
#include "io/terrain_model.hpp"

using namespace moraine;

namespace {

const std::string grid =
    "ncols 4\nnrows 3\nxllcorner 10\nyllcorner 20\ncellsize 2\nNODATA_value -9999\n"
    "9 10 11 12\n5 6 7 8\n1 2 3 4\n";

/// Gone with the test case.
class TestFolder {
  public:
    TestFolder() : path_(std::filesystem::temp_directory_path() / ("moraine-test-" + std::to_string(getpid()))) {
        std::filesystem::create_directories(path_);
    }
    ~TestFolder() { std::filesystem::remove_all(path_); }
    TestFolder(const TestFolder&) = delete;
    TestFolder& operator=(const TestFolder&) = delete;
    std::string file(const std::string& name) const { return (path_ / name).string(); }

  private:
    std::filesystem::path path_;
};

std::string written(const TestFolder& folder, const std::string& name, const std::string& text) {
    std::ofstream(folder.file(name)) << text;
    return folder.file(name);
}

template <class F>
std::string said_by(const F& f) {
    try {
        f();
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

std::string said_of(const std::string& name, std::string text) {
    const TestFolder folder;
    const std::string path = written(folder, name, text);
    return said_by([&] {
        if (name.ends_with(".asc"))
            cropped(read_ascii_grid(path), path, {10, 20}, {18, 26});
        else if (name == "profile.csv")
            read_profile(path);
        else
            read_polygon(path);
    });
}

std::string with(const std::string& from, const std::string& to) {
    std::string text = grid;
    return text.replace(text.find(from), from.size(), to);
}

bool has(const std::string& text, const std::string& part) {
    CAPTURE(text);
    CHECK(text.find(part) != std::string::npos);
    return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("a grid's first row is the northern one, and a corner is half a cell from a node") {
    const TestFolder folder;
    const Ground g = read_ascii_grid(written(folder, "g.asc", grid));
    CHECK(g.first[0] == 11);
    CHECK(g.first[1] == 21);
    CHECK(g.count == std::array<std::int64_t, 2>{4, 3});
    CHECK(g.height.front() == 1);
    CHECK(g.height.back() == 12);
    const Ground c = read_ascii_grid(written(folder, "c.asc", with("xllcorner 10", "XLLCENTER 10")));
    CHECK(c.first[0] == 10);
}

TEST_CASE("a domain gets the part of a model that it needs") {
    Ground all;
    all.spacing = 1;
    all.count = {100, 100};
    all.height.assign(10000, 5.0);
    all.height[0] = std::nan("");
    const Ground part = cropped(all, "g.asc", {40, 50}, {44, 52});
    CHECK(part.first == std::array<double, 2>{37, 47});
    CHECK(part.count == std::array<std::int64_t, 2>{11, 9});
    CHECK(has(said_by([&] { cropped(all, "g.asc", {1, 1}, {5, 5}); }), "no height at (0, 0)"));
}

TEST_CASE("a model may be unknown beyond the domain, and ends there") {
    const TestFolder folder;
    const std::string path = folder.file("m.asc");
    const auto read = [&](auto is_known) {
        std::string text = "ncols 12\nnrows 9\nxllcenter 0\nyllcenter 0\ncellsize 2\nNODATA_value -3.4028235e+38\n";
        for (int j = 8; j >= 0; --j)
            for (int i = 0; i < 12; ++i)
                text += is_known(i, j) ? std::to_string(100 - i) + " " : "-3.4028234663852886e+38 ";
        written(folder, "m.asc", text);
        std::vector<std::string> notices;
        const Ground g = read_model(path, {7, 6}, {14, 10}, notices);  // nodes 3.5 to 7 and 3 to 5
        return std::array<std::int64_t, 4>{std::llround(g.first[0]), std::llround(g.first[1]), g.count[0], g.count[1]};
    };
    using Part = std::array<std::int64_t, 4>;
    CHECK(read([](int, int) { return true; }) == Part{0, 0, 11, 9});
    CHECK(read([](int i, int j) { return i > 1 && j > 0; }) == Part{4, 2, 9, 8});
    CHECK(read([](int i, int) { return i > 3; }) == Part{8, 0, 7, 9});  // half a cell beyond the last height
    CHECK(read([](int i, int j) { return i != 9 || j != 8; }) == Part{0, 0, 11, 8});
    CHECK(has(said_by([&] { read([](int i, int) { return i > 4; }); }), "no height at (8, 6)"));
    CHECK(has(said_by([&] { read([](int i, int j) { return i != 5 || j != 4; }); }), "no height at (10, 8)"));
}

TEST_CASE("a wrong grid is refused with its line and what is wrong") {
    CHECK(said_of("g.asc", grid).empty());
    CHECK(has(said_of("g.asc", with("ncols 4", "ncols 5")), "15 heights are promised"));
    CHECK(has(said_of("g.asc", with("10 11 12", "10.000 11.00")), "ends after 11 of 12 heights"));
    CHECK(has(said_of("g.asc", with("ncols 4", "ncols 3")), "more than 9 heights"));
    CHECK(has(said_of("g.asc", with("nrows 3", "nrows 500000000")), "heights are promised"));
    CHECK(has(said_of("g.asc", with("6 7", "six 7")), "g.asc:8: the height in row 2, column 2 = \"six\""));
    CHECK(has(said_of("g.asc", with("6 7", std::string("6\0 7", 4))), "It holds zero bytes: is the file whole?"));
    CHECK(has(said_of("g.asc", with("6 7", "inf 7")), "must be a finite number"));
    CHECK(has(said_of("g.asc", with("6 7", "6,5 7")), "Is the decimal sign a point?"));
    CHECK(has(said_of("g.asc", with("6 7", "-9999 7")), "no height at (13, 23)"));
    CHECK(has(said_of("g.asc", with("cellsize 2", "cellsize 0")), "must be > 0"));
    CHECK(has(said_of("g.asc", with("cellsize 2", "cell 2")), "is no key of an ESRI ASCII grid"));
    CHECK(has(said_of("g.asc", with("cellsize 2", "dx 2")), "cellsize, or dx and dy"));
    CHECK(has(said_of("g.asc", with("cellsize 2", "dx 2\ndy 3")), "dx = 2, dy = 3 (cells must be squares)"));
    CHECK(has(said_of("g.asc", with("xllcorner 10\n", "")), "xllcorner or xllcenter"));
    CHECK(has(said_of("g.asc", with("xllcorner 10", "xllcorner 11")), "the model reaches from 11 to 19 along x"));
    CHECK(has(said_of("g.asc", ""), "ncols is missing"));
    CHECK(has(said_by([] { read_ascii_grid("/nowhere/g.asc"); }), "no such file"));
    CHECK(has(said_by([] { read_ascii_grid("/tmp"); }), "not a regular file"));
}

TEST_CASE("what a grid does not know is no height, in whatever form it says so") {
    const auto unknown = [](const std::string& text) { return has(said_of("g.asc", text), "no height at (13, 23)"); };
    const auto at = [](const std::string& value) { return with("6 7", value + " 7"); };
    const auto declared = [&](const std::string& none, const std::string& value) {
        std::string text = at(value);
        return text.replace(text.find("NODATA_value -9999"), 18, "NODATA_value " + none);
    };
    std::string silent = at("-9999");
    silent.erase(silent.find("NODATA_value"), 19);
    CHECK(unknown(silent));  // the format's default
    CHECK(unknown(at("-9999.0")));
    CHECK(unknown(at("nan")));
    CHECK(unknown(at("NaN")));
    CHECK(unknown(declared("nan", "NaN")));
    for (const char* lowest : {"-3.4028234663852886e+38", "-3.4028235e+38", "-3.402823466e+38", "-3.4e38"}) {
        CHECK(unknown(declared("-3.4028234663852886e+38", lowest)));
        CHECK(unknown(declared("-3.4028235e+38", lowest)));
        CHECK(unknown(at(lowest)));
    }
    CHECK(unknown(at("9.96921e+36")));
    CHECK(unknown(declared("0.1", "0.10000000149011612")));  // of 32 bits
    CHECK(said_of("g.asc", declared("-32768", "-9.5")).empty());
}

TEST_CASE("spellings of a grid are read as they are meant") {
    CHECK(said_of("g.asc", with("cellsize 2", "dx 2\ndy 2.0")).empty());
    CHECK(said_of("g.asc", with("6 7", "+6.0 +7")).empty());
    CHECK(has(said_of("g.asc", with("6 7", "+-6 7")), "= \"+-6\""));
    CHECK(said_of("profile.csv", "\"x\",\"z\"\n0,1\n1,\"2\"\n2,+4\n").empty());
    const TestFolder folder;
    std::vector<std::string> notices;
    CHECK(read_model(written(folder, "G.ASC", grid), {12, 22}, {16, 24}, notices).height.size() == 12);
    CHECK(read_polygon(written(folder, "A.CSV", "X,Y\n0,0\n1,0\n0,1\n")).size() == 3);
    const std::string zeros("x,z\n0,1\n1,\0\0\n2,4\n", 17);
    CHECK(has(said_of("profile.csv", zeros), "profile.csv:3"));
}

TEST_CASE("a height kilometres from its neighbours is refused, a cliff is not") {
    const TestFolder folder;
    std::vector<std::string> notices;
    const auto said = [&](const std::string& value) {
        std::string text = with("6 7", value + " 7");
        text.replace(text.find("-9999"), 5, "-1");
        const std::string path = written(folder, "g.asc", text);
        return said_by([&] { read_model(path, {12, 22}, {16, 24}, notices); });
    };
    CHECK(said("900").empty());
    for (const char* value : {"-9999", "-32767", "32767", "1e4"})
        CHECK(has(said(value), "Does one of them stand for no data?"));
}

TEST_CASE("a grid that would not fit into memory is refused before it is read, with its size") {
    const TestFolder folder;
    const std::string path = written(folder, "g.asc", with("ncols 4\nnrows 3", "ncols 50000\nnrows 40000"));
    std::filesystem::resize_file(path, 4100000000);  // a hole
    const std::string said = said_by([&] { read_ascii_grid(path); });
    CHECK(has(said, "2e+09 heights (a grid of text is read whole: 16 GB on each rank; at most 2.7e+08 fit)"));
}

TEST_CASE("a profile has a header and even distances") {
    CHECK(said_of("profile.csv", "x,z\n0,1\n1,2\n2,4\n").empty());
    CHECK(has(said_of("profile.csv", "0,1\n1,2\n2,4\n"), "must be x,z"));
    CHECK(has(said_of("profile.csv", "x,z\n0,1\n1,2\n3,4\n"), "Resample the profile?"));
    CHECK(has(said_of("profile.csv", "x,z\n0,1\n1,a\n3,4\n"), "profile.csv:3: z = \"a\""));
    CHECK(has(said_of("profile.csv", "x,z\n0,1\n1,2\n"), "2 points"));
}

TEST_CASE("points have names and a header") {
    const TestFolder folder;
    const auto found =
        read_points(written(folder, "p.csv", "name,x,y\nroad,1,2.5\n# no\nbridge-1, 3, 4\n"), "hazard.gauges");
    REQUIRE(found.size() == 2);
    CHECK(found[1].name == "bridge-1");
    CHECK(found[0].points[0] == std::array<double, 2>{1, 2.5});
    const auto said = [&](const std::string& text) {
        return said_by([&] { read_points(written(folder, "p.csv", text), "hazard.gauges"); });
    };
    CHECK(has(said("road,1,2\n"), "must be name,x,y"));
    CHECK(has(said("name,x,y\nroad,1\n"), "p.csv:2: not three values"));
    CHECK(has(said("name,x,y\nroad,1,east\n"), "y = \"east\""));
}

TEST_CASE("an area is a ring of corners, from a table or a GeoJSON") {
    const TestFolder folder;
    using Ring = std::vector<std::array<double, 2>>;
    const Ring triangle{{0, 0}, {4, 0}, {4, 3}};
    CHECK(read_polygon(written(folder, "a.csv", "x,y\n0,0\n4,0\n4,3\n")) == triangle);
    const std::string ring = "[[0,0],[4.0, 0],\n[4,3,7],[0,0]]";
    CHECK(read_polygon(written(folder, "a.geojson", R"({"type":"Polygon","coordinates":[)" + ring + "]}")) == triangle);
    CHECK(read_polygon(written(folder, "m.geojson",
                               R"({"type":"Feature","geometry":{"type":"MultiPolygon",)"
                               R"("coordinates": [[)" +
                                   ring + "]]}}")) == triangle);
    CHECK(read_polygon(written(folder, "s.csv", "\xef\xbb\xbfx,y\r\n0,0\r\n4,0\r\n4,3\r\n")) ==
          triangle);  // a spreadsheet's
    CHECK(has(said_of("a.csv", "x,y\n0,0\n4,0\n"), "2 corners"));
    CHECK(has(said_of("a.geojson", R"({"type":"Point","coordinates":[0,0]})"), "no polygon was found"));
    CHECK(has(said_of("a.geojson", R"({"type":"Polygon","coordinates":[[[0,0],[4]]]})"), "without two numbers"));
    CHECK(has(said_of("a.geojson", R"({"type":"Polygon","coordinates":[)"), "without two numbers"));
    CHECK(has(said_of("a.gpkg", "x"), "must be .csv or .geojson"));
}
