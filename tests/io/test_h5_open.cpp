#include <doctest/doctest.h>

#include <fstream>

#include "core/data/error.hpp"
#include "io/h5_open.hpp"
#include "io/test_folder.hpp"

using namespace moraine;

namespace {

/// A group with a list of two numbers of its own, and three of elsewhere.
void write_files(const std::filesystem::path& folder) {
    const hsize_t two[] = {2};
    const double values[] = {1, 2};
    const H5Id space(H5Screate_simple(1, two, nullptr), H5Sclose, "space");
    const auto file = [&](const char* name) {
        return H5Id(H5Fcreate((folder / name).c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose, name);
    };
    const auto set = [&](hid_t at, const char* name, hid_t list) {
        return H5Id(H5Dcreate2(at, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, list, H5P_DEFAULT), H5Dclose, name);
    };
    const auto group = [](hid_t at, const char* name) {
        return H5Id(H5Gcreate2(at, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose, name);
    };
    const auto list = [] { return H5Id(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "list"); };
    for (const char* name : {"other.h5", "own.h5"}) {
        const H5Id whole = file(name), inner = group(whole, "group");
        const H5Id own = set(inner, "own", H5P_DEFAULT);
        H5Dwrite(own, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
        H5Lcreate_soft("/group/own", inner, "soft", H5P_DEFAULT, H5P_DEFAULT);
    }
    std::ofstream(folder / "raw", std::ios::binary).write(reinterpret_cast<const char*>(values), sizeof values);
    const H5Id link = file("link.h5"), stored = file("stored.h5"), composed = file("composed.h5");
    H5Lcreate_external("other.h5", "/group", link, "group", H5P_DEFAULT, H5P_DEFAULT);
    H5Lcreate_external("other.h5", "/group/own", link, "own", H5P_DEFAULT, H5P_DEFAULT);
    const H5Id raw = list(), views = list();
    H5Pset_external(raw, (folder / "raw").c_str(), 0, sizeof values);
    set(stored, "own", raw);
    H5Pset_virtual(views, space, (folder / "other.h5").c_str(), "/group/own", space);
    set(composed, "own", views);
}

std::string said_by(const std::filesystem::path& path, const char* name, bool group = false) {
    const H5Quiet quiet;
    try {
        const H5Id file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "no file");
        group ? open_group(file, name, "damaged") : open_dataset(file, name, "damaged");
    } catch (const H5Failure& failure) {
        return failure.what();
    }
    return "";
}

std::string said_of_all(const std::filesystem::path& path) {
    try {
        check_hdf5_links(path.string());
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

}  // namespace

TEST_CASE("what a file of HDF5 has in others is refused, and not followed") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    write_files(folder.path());
    CHECK(said_by(folder / "own.h5", "group", true).empty());
    CHECK(said_by(folder / "own.h5", "group/own").empty());
    CHECK(said_by(folder / "own.h5", "group/soft").empty());
    CHECK(said_by(folder / "own.h5", "absent") == "damaged");
    CHECK(said_by(folder / "link.h5", "group", true) == "group lies in another file, and none is followed");
    CHECK(said_by(folder / "link.h5", "group/own") == "group/own lies in another file, and none is followed");
    CHECK(said_by(folder / "link.h5", "own") == "own lies in another file, and none is followed");
    CHECK(said_by(folder / "stored.h5", "own") == "own lies in another file, and none is followed");
    CHECK(said_by(folder / "composed.h5", "own") == "own lies in another file, and none is followed");
}

TEST_CASE("a file that another library reads may not lead into others") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    write_files(folder.path());
    CHECK(said_of_all(folder / "own.h5").empty());
    CHECK(said_of_all(folder / "raw").empty());
    CHECK(said_of_all(folder / "absent").empty());
    for (const char* name : {"link.h5", "stored.h5", "composed.h5"}) {
        CAPTURE(name);
        CHECK(said_of_all(folder / name).find("the file leads into others") != std::string::npos);
    }
}
