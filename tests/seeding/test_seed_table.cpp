#include <doctest/doctest.h>
#include <hdf5.h>

#include <cmath>

#include "core/data/rank_failure.hpp"
#include "scene/scene_text.hpp"
#include "seeding/seed.hpp"
#include "seeding/seed_table.hpp"

using namespace moraine;

namespace {

const std::string disk = "shape = \"sphere\"\ncenter = [2.0, 1.0]\nradius = 0.5";

Scene scene_with(const TestFolder& folder, const std::string& file) {
    return read_scene(
        folder.write("scene.toml", replaced(good_scene, disk, "shape = \"table\"\nfile = \"" + file + "\"")));
}

std::vector<Seed> seeds_of(const Scene& scene) {
    std::vector<Seed> seeds;
    seed_body(scene, 1, 0, seed_rows(scene, 1), seed_rows(scene, 1), seeds);
    return seeds;
}

/// What is said about this .csv, from its name on.
std::string said_of_csv(const std::string& text) {
    const TestFolder folder;
    folder.write("t.csv", text);
    try {
        scene_with(folder, "t.csv");
    } catch (const InputError& e) {
        const std::string message = e.what();
        return message.substr(std::min(message.size(), message.find("t.csv")));
    }
    return "";
}

void write_dataset(hid_t file, const char* name, const std::vector<double>& values) {
    const hsize_t n = values.size();
    const hid_t space = H5Screate_simple(1, &n, nullptr);
    const hid_t set = H5Dcreate2(file, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Dclose(set);
    H5Sclose(space);
}

void write_h5(const std::string& path, const std::vector<double>& x, const std::vector<double>& y) {
    const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    write_dataset(file, "x", x);
    write_dataset(file, "y", y);
    write_dataset(file, "vy", std::vector<double>(x.size(), 0.5));
    H5Fclose(file);
}

}  // namespace

TEST_CASE("a table in .csv gives places, velocities and masses") {
    const TestFolder folder;
    folder.write("t.csv", "# grains\nx, y, vx, mass\n2.0, 1.0, 0.5, 3.0\n\n2.1, 1.5, -0.5, 4.0\n");
    const std::vector<Seed> seeds = seeds_of(scene_with(folder, "t.csv"));
    REQUIRE(seeds.size() == 2);
    CHECK(seeds[1].x == Triple{2.1, 1.5, 0});
    CHECK(seeds[1].velocity == Triple{-0.5, 0, 0});
    CHECK(seeds[1].mass == doctest::Approx(4));
    CHECK(seeds[1].volume == doctest::Approx(4.0 / 1600));
    CHECK(seeds[1].id == (std::uint64_t(1) << 48 | 1));
}

TEST_CASE("a table may come from a spreadsheet, with a byte order mark and two characters at each line's end") {
    const TestFolder folder;
    folder.write("t.csv", "\xef\xbb\xbfx,y\r\n2.0,1.0\r\n");
    CHECK(seeds_of(scene_with(folder, "t.csv"))[0].x == Triple{2, 1, 0});
}

TEST_CASE("without masses a table's particles fill their share of a cell") {
    const TestFolder folder;
    folder.write("t.csv", "y,x\n1.0,2.0\n");
    const std::vector<Seed> seeds = seeds_of(scene_with(folder, "t.csv"));
    CHECK(seeds[0].x == Triple{2, 1, 0});
    CHECK(seeds[0].volume == doctest::Approx(0.05 * 0.05));
}

TEST_CASE("a table in .h5 gives the same") {
    const TestFolder folder;
    write_h5(folder.file("t.h5"), {2.0, 2.1, 2.2}, {1.0, 1.1, 1.2});
    const std::vector<Seed> seeds = seeds_of(scene_with(folder, "t.h5"));
    REQUIRE(seeds.size() == 3);
    CHECK(seeds[2].x == Triple{2.2, 1.2, 0});
    CHECK(seeds[2].velocity == Triple{0, 0.5, 0});
}

TEST_CASE("a table that claims rows that its file does not hold is refused before memory is taken for them") {
    const TestFolder folder;
    for (const bool chunked : {false, true}) {
        const hid_t file = H5Fcreate(folder.file("t.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
        const hsize_t rows = 1000000000000, chunk = 1000;
        const hid_t space = H5Screate_simple(1, &rows, nullptr), list = H5Pcreate(H5P_DATASET_CREATE);
        if (chunked) H5Pset_chunk(list, 1, &chunk);
        for (const char* name : {"x", "y"})
            H5Dclose(H5Dcreate2(file, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, list, H5P_DEFAULT));
        H5Pclose(list);
        H5Sclose(space);
        H5Fclose(file);
        CHECK_THROWS_WITH_AS(
            scene_with(folder, "t.h5"),
            (folder.file("t.h5") + ": dataset \"x\" (its 1000000000000 rows are not in the file). Write it "
                                   "as a list of numbers?")
                .c_str(),
            InputError);
    }
}

TEST_CASE("a packed table is read") {
    const TestFolder folder;
    const hid_t file = H5Fcreate(folder.file("t.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hsize_t rows = 20000;
    const hid_t space = H5Screate_simple(1, &rows, nullptr), list = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(list, 1, &rows);
    H5Pset_deflate(list, 9);
    const std::vector<double> values(rows, 1.0);
    for (const char* name : {"x", "y"}) {
        const hid_t set = H5Dcreate2(file, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, list, H5P_DEFAULT);
        H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
        H5Dclose(set);
    }
    H5Pclose(list);
    H5Sclose(space);
    H5Fclose(file);
    Scene scene;
    scene.dimensions = 2;
    scene.max = {2, 2, 0};
    BodySpec body;
    body.file = folder.file("t.h5");
    CHECK(read_particle_table(scene, body).x.size() == rows);
}

TEST_CASE("a table that is another than when the scene was read is refused") {
    const TestFolder folder;
    folder.write("t.csv", "x,y\n1.0,1.0\n");
    Scene scene;
    scene.dimensions = 2;
    scene.max = {2, 2, 0};
    BodySpec body;
    body.file = folder.file("t.csv");
    body.table_hash = hash_of_file(body.file);
    CHECK(read_particle_table(scene, body).x.size() == 1);
    folder.write("t.csv", "x,y\n1.0,1.5\n");
    CHECK_THROWS_AS(read_particle_table(scene, body), RankFailure);
}

TEST_CASE("a table that is no regular file is refused") {
    const TestFolder folder;
    std::filesystem::create_symlink("/dev/zero", folder.file("t.csv"));
    CHECK_THROWS_WITH_AS(
        scene_with(folder, "t.csv"),
        (folder.file("t.csv") + ": the table cannot be read (it is not a regular file). Is body.file right?").c_str(),
        InputError);
}

TEST_CASE("a bad .csv names file and line") {
    CHECK(said_of_csv("x,y\n2.0,1.0\n") == "");
    CHECK(said_of_csv("x,y\n2.0,abc\n") ==
          "t.csv:2: y = \"abc\" (must be a finite number). Is the decimal sign a point and the separator a comma?");
    CHECK(said_of_csv("x,y\n2.0\n").starts_with("t.csv:2: 1 numbers (the header has 2 columns)"));
    CHECK(said_of_csv("x,y\n\n9.0,1.0\n").starts_with("t.csv:3: x = 9 (outside the domain, 0 to 4)"));
    CHECK(said_of_csv("x,y,mass\n2.0,1.0,-3\n").starts_with("t.csv:2: mass = -3 (must be > 0)"));
    CHECK(said_of_csv("x,y,nan\n").starts_with("t.csv:1: column \"nan\""));
    CHECK(said_of_csv("x,y,vz\n").ends_with("Did you mean vx?"));
    CHECK(said_of_csv("x,x\n").starts_with("t.csv:1: column x is there twice"));
    CHECK(said_of_csv("x,y\n2.0,nan\n").starts_with("t.csv:2: y = \"nan\""));
    CHECK(said_of_csv("x,y\n").starts_with("t.csv: no x of any particle"));
    CHECK(said_of_csv("").starts_with("t.csv: no x of any particle"));
}

TEST_CASE("a bad .h5 names file and dataset") {
    const TestFolder folder;
    write_h5(folder.file("t.h5"), {2.0, 2.1}, {1.0});
    CHECK_THROWS_AS(scene_with(folder, "t.h5"), InputError);
    write_h5(folder.file("t.h5"), {2.0, std::nan("")}, {1.0, 1.0});
    CHECK_THROWS_AS(scene_with(folder, "t.h5"), InputError);
    folder.write("t.h5", "not HDF5");
    CHECK_THROWS_AS(scene_with(folder, "t.h5"), InputError);
    CHECK_THROWS_AS(scene_with(folder, "absent.h5"), InputError);
    CHECK_THROWS_AS(scene_with(folder, "absent.csv"), InputError);
    CHECK_THROWS_AS(scene_with(folder, "t.txt"), InputError);
}

TEST_CASE("a table's particle inside another body is an overlap") {
    const TestFolder folder;
    folder.write("t.csv", "x,y\n0.52,0.52\n");
    try {
        scene_with(folder, "t.csv");
        FAIL("accepted");
    } catch (const InputError& e) {
        CHECK(std::string(e.what()).find("body.disk overlaps body.block") != std::string::npos);
    }
}
