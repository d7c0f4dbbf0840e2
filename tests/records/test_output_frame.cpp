#include <doctest/doctest.h>

#include <algorithm>
#include <memory>

#include "io/h5.hpp"
#include "io/test_folder.hpp"
#include "predict/prediction.hpp"
#include "records/output_frame.hpp"
#include "sample_scenes.hpp"

using namespace moraine;

namespace {

Scene scene_that_shows(std::int64_t every, bool single, std::vector<std::string> labels) {
    Scene scene = test::slurry();
    scene.output.fields = {"velocity", "stress", "pressure"};
    scene.output.labels = std::move(labels);
    scene.output.every = every;
    scene.output.single = single;
    scene.balance.trigger = Trigger::every;
    scene.balance.interval = 5;
    return scene;
}

/// Two outputs, 20 steps apart.
void write(const Scene& scene, const Comm& comm, const std::string& path) {
    Simulation<double, 2> sim(scene, comm);
    sim.seed();
    ParticleSeries series(comm, path, {scene.output.deflate});
    const OutputFrame<double, 2> frame(sim);
    frame.append_to(series);
    for (int n = 0; n < 20; ++n) {
        sim.step();
        sim.balance();
    }
    sim.conclude();
    frame.append_to(series);
}

/// The rows of a dataset in output `step`.
template <class T>
std::vector<T> rows_of(const std::string& path, const std::string& set_name, hid_t type, std::size_t step) {
    const auto state = vtkhdf::read_state(path);
    const H5Id file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "file");
    const H5Id set(H5Dopen2(file, ("VTKHDF/" + set_name).c_str(), H5P_DEFAULT), H5Dclose, "set");
    const H5Id space(H5Dget_space(set), H5Sclose, "space");
    hsize_t extent[2] = {0, 1};
    H5Sget_simple_extent_dims(space, extent, nullptr);
    const hsize_t start[] = {static_cast<hsize_t>(state.steps[step].first_chunk * state.chunk_rows), 0};
    const hsize_t count[] = {static_cast<hsize_t>(state.steps[step].rows), extent[1]};
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr);
    const H5Id memory(H5Screate_simple(2, count, nullptr), H5Sclose, "space");
    std::vector<T> rows(count[0] * count[1]);
    h5_check(H5Dread(set, type, memory, space, H5P_DEFAULT, rows.data()), "rows");
    return rows;
}

std::vector<std::uint64_t> ids_of(const std::string& path, std::size_t step) {
    auto ids = rows_of<std::uint64_t>(path, "PointData/id", H5T_NATIVE_UINT64, step);
    std::sort(ids.begin(), ids.end());
    return ids;
}

}  // namespace

TEST_CASE("outputs are the same bytes on any number of ranks, whatever is shown of the particles") {
    const Comm comm(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    const TestFolder folder(comm);
    for (const std::int64_t every : {1, 7})
        for (const int kind : {0, 1, 2}) {
            CAPTURE(every);
            CAPTURE(kind);
            Scene scene = scene_that_shows(every, kind > 0, {"id", "block_key"});
            scene.output.deflate = kind > 1;
            write(scene, comm, folder / "all");
            if (comm.is_root()) {
                write(scene, self, folder / "alone");
                CHECK(content_of(folder / "all") == content_of(folder / "alone"));
                std::filesystem::remove(folder / "all");
                std::filesystem::remove(folder / "alone");
            }
            comm.barrier();
        }
}

TEST_CASE("one particle of so many is shown, the same ones at all times, with its own numbers") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    write(scene_that_shows(1, false, {"id"}), comm, folder / "whole");
    write(scene_that_shows(5, true, {"id"}), comm, folder / "few");
    if (!comm.is_root()) return;
    const auto all = ids_of(folder / "whole", 0), first = ids_of(folder / "few", 0);
    std::vector<std::uint64_t> chosen;
    std::copy_if(all.begin(), all.end(), std::back_inserter(chosen), [](std::uint64_t id) { return is_shown(id, 5); });
    CHECK(first == chosen);
    const double expected = static_cast<double>(all.size()) / 5;
    CHECK(std::abs(static_cast<double>(chosen.size()) - expected) < 3 * std::sqrt(expected));
    const auto last = ids_of(folder / "few", 1);
    CHECK(std::includes(first.begin(), first.end(), last.begin(), last.end()));
    CHECK(last.size() > 0.8 * static_cast<double>(first.size()));
    for (const auto& [name, components] :
         {std::pair{"Points", 3}, {"PointData/velocity", 3}, {"PointData/stress", 4}}) {
        CAPTURE(name);
        const auto ids = rows_of<std::uint64_t>(folder / "whole", "PointData/id", H5T_NATIVE_UINT64, 1);
        const auto whole = rows_of<double>(folder / "whole", name, H5T_NATIVE_DOUBLE, 1);
        const auto few = rows_of<float>(folder / "few", name, H5T_NATIVE_FLOAT, 1);
        std::vector<float> rounded;
        for (std::size_t r = 0; r < ids.size(); ++r)
            for (int c = 0; is_shown(ids[r], 5) && c < components; ++c)
                rounded.push_back(
                    static_cast<float>(whole[r * static_cast<std::size_t>(components) + static_cast<std::size_t>(c)]));
        CHECK(few == rounded);
    }
}

TEST_CASE("a particle's bytes in an output are those predicted") {
    const Comm comm(MPI_COMM_WORLD);
    for (const bool single : {false, true})
        for (const std::vector<std::string>& labels : {std::vector<std::string>{}, {"id", "rank", "block_key"}}) {
            Scene scene = scene_that_shows(1, single, labels);
            scene.output.fields = {"velocity", "stress", "pressure", "density", "ln_J", "mass", "volume", "body"};
            scene.end = 1;
            Simulation<double, 2> sim(scene, comm);
            const OutputFrame<double, 2> frame(sim);
            int bytes = (frame.labels().rank ? 4 : 0) + (frame.labels().block_key ? 8 : 0);
            std::vector<Column> columns = frame.fields();
            columns.push_back(frame.position());
            for (const Column& c : columns) bytes += Column::bytes_of(c.type) * (c.components == 2 ? 3 : c.components);
            CHECK(predict_output(scene, {}).row_bytes == bytes);
        }
}

TEST_CASE("a series goes on only with numbers of the type that it has") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    write(scene_that_shows(1, false, {"id"}), comm, folder / "p.vtkhdf");
    const ParticleSeries series(comm, folder / "p.vtkhdf");
    for (const bool single : {false, true}) {
        const Scene scene = scene_that_shows(3, single, {});
        Simulation<double, 2> sim(scene, comm);
        const OutputFrame<double, 2> frame(sim);
        if (single)
            CHECK_THROWS_AS(series.check_types(frame.position(), frame.fields()), InputError);
        else
            CHECK_NOTHROW(series.check_types(frame.position(), frame.fields()));
    }
}
