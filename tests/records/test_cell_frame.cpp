#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "io/h5.hpp"
#include "io/test_folder.hpp"
#include "predict/prediction.hpp"
#include "records/cell_frame.hpp"
#include "records/output_frame.hpp"
#include "sample_scenes.hpp"

using namespace moraine;

namespace {

const std::vector<std::string> all_fields{"velocity", "stress", "pressure", "density", "ln_J", "mass", "volume"};

Scene on_cells(Scene scene, bool single = false) {
    scene.output.on_cells = true;
    scene.output.fields = all_fields;
    scene.output.labels = {"id", "block_key"};
    scene.output.single = single;
    scene.balance.trigger = Trigger::every;
    scene.balance.interval = 5;
    return scene;
}

/// Two outputs of cells, 20 steps apart, and beside each one of particles.
template <int Dim>
void write(const Scene& scene, const Comm& comm, const std::string& path) {
    Simulation<double, Dim> sim(scene, comm);
    sim.seed();
    ParticleSeries series(comm, path, {scene.output.deflate}), particles(comm, path + ".particles");
    CellFrame<double, Dim> frame(sim);
    const OutputFrame<double, Dim> single_ones(sim);
    for (int n = 0; n <= 20; ++n) {
        if (n % 20 == 0) frame.append_to(series), single_ones.append_to(particles);
        sim.step();
        sim.balance();
        sim.conclude();
    }
}

/// Numbers of a dataset in output `step`, row by row.
std::vector<std::vector<double>> rows_of(const std::string& path, const std::string& name, std::size_t step) {
    const auto state = vtkhdf::read_state(path);
    const H5Id file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "file");
    const H5Id set(H5Dopen2(file, ("VTKHDF/" + name).c_str(), H5P_DEFAULT), H5Dclose, "set");
    const H5Id space(H5Dget_space(set), H5Sclose, "space");
    hsize_t extent[2] = {0, 1};
    H5Sget_simple_extent_dims(space, extent, nullptr);
    const hsize_t start[] = {static_cast<hsize_t>(state.steps[step].first_chunk * state.chunk_rows), 0};
    const hsize_t count[] = {static_cast<hsize_t>(state.steps[step].rows), extent[1]};
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, nullptr);
    const H5Id memory(H5Screate_simple(2, count, nullptr), H5Sclose, "space");
    std::vector<double> numbers(count[0] * count[1]);
    h5_check(H5Dread(set, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, numbers.data()), "rows");
    std::vector<std::vector<double>> rows;
    for (std::size_t r = 0; r < count[0]; ++r)
        rows.emplace_back(numbers.begin() + static_cast<std::ptrdiff_t>(r * count[1]),
                          numbers.begin() + static_cast<std::ptrdiff_t>((r + 1) * count[1]));
    return rows;
}

using Cell = std::vector<long>;

/// Of a quadratic spline's cell, the node that it lies around: along a periodic axis the first and the last are one.
Cell cell_at(const Scene& scene, const std::vector<double>& x) {
    Cell cell;
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene.dimensions); ++a) {
        const long n = std::lround((scene.max[a] - scene.min[a]) / scene.cell);
        const long node = std::lround((x[a] - scene.min[a]) / scene.cell);
        cell.push_back(scene.periodic[a] ? node % n : node);
    }
    return cell;
}

/// Means over the particles of each cell, straight from the particles' file.
struct Expected {
    double mass = 0, volume = 0, pressure = 0, ln_J = 0;
    std::vector<double> velocity{0, 0, 0};
};

std::map<Cell, Expected> expected_of(const Scene& scene, const std::string& path, std::size_t step) {
    const auto field = [&](const char* name) { return rows_of(path, std::string("PointData/") + name, step); };
    const auto x = rows_of(path, "Points", step);
    const auto mass = field("mass"), volume = field("volume"), v = field("velocity"), p = field("pressure"),
               ln_J = field("ln_J");
    std::map<Cell, Expected> cells;
    for (std::size_t r = 0; r < x.size(); ++r) {
        Expected& e = cells[cell_at(scene, x[r])];
        e.mass += mass[r][0];
        e.volume += volume[r][0];
        e.pressure += volume[r][0] * p[r][0];
        e.ln_J += volume[r][0] * ln_J[r][0];
        for (std::size_t a = 0; a < 3; ++a) e.velocity[a] += mass[r][0] * v[r][a];
    }
    return cells;
}

double share_inside(const Scene& scene, const Cell& cell) {
    double share = 1;
    for (std::size_t a = 0; a < cell.size(); ++a) {
        const long n = std::lround((scene.max[a] - scene.min[a]) / scene.cell);
        if (!scene.periodic[a] && (cell[a] == 0 || cell[a] == n)) share /= 2;
    }
    return share;
}

void check_means(const Scene& scene, const std::string& path, std::size_t step) {
    const auto cells = expected_of(scene, path + ".particles", step);
    const auto x = rows_of(path, "Points", step);
    const auto field = [&](const char* name) { return rows_of(path, std::string("PointData/") + name, step); };
    const auto mass = field("mass"), volume = field("volume"), v = field("velocity"), p = field("pressure"),
               ln_J = field("ln_J"), density = field("density"), fraction = field("volume_fraction");
    REQUIRE(x.size() == cells.size());
    std::map<Cell, int> seen;
    for (std::size_t r = 0; r < x.size(); ++r) {
        const Cell cell = cell_at(scene, x[r]);
        ++seen[cell];
        REQUIRE(cells.contains(cell));
        const Expected& e = cells.at(cell);
        for (std::size_t a = 0; a < cell.size(); ++a)
            CHECK(x[r][a] == doctest::Approx(scene.min[a] + scene.cell * static_cast<double>(cell[a])));
        CHECK(mass[r][0] == doctest::Approx(e.mass));
        CHECK(volume[r][0] == doctest::Approx(e.volume));
        CHECK(density[r][0] == doctest::Approx(e.mass / e.volume));
        CHECK(p[r][0] == doctest::Approx(e.pressure / e.volume));
        CHECK(ln_J[r][0] == doctest::Approx(e.ln_J / e.volume));
        for (std::size_t a = 0; a < 3; ++a) CHECK(v[r][a] == doctest::Approx(e.velocity[a] / e.mass));
        const double space = std::pow(scene.cell, scene.dimensions) * share_inside(scene, cell);
        CHECK(fraction[r][0] == doctest::Approx(e.volume / space));
    }
    CHECK(seen.size() == cells.size());
}

}  // namespace

TEST_CASE("an output of cells is the same bytes on any number of ranks") {
    const Comm comm(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    const TestFolder folder(comm);
    for (const bool single : {false, true}) {
        Scene scene = on_cells(test::slurry(), single);
        scene.output.deflate = single;
        write<2>(scene, comm, folder / "all");
        if (comm.is_root()) {
            write<2>(scene, self, folder / "alone");
            CHECK(content_of(folder / "all") == content_of(folder / "alone"));
            for (const char* name : {"all", "alone", "all.particles", "alone.particles"})
                std::filesystem::remove(folder / name);
        }
        comm.barrier();
    }
}

TEST_CASE("a cell has the means over its particles, at its centre") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const Scene plane = on_cells(test::slurry()), space = on_cells(test::column());
    write<2>(plane, comm, folder / "plane");
    write<3>(space, comm, folder / "space");
    if (!comm.is_root()) return;
    for (const std::size_t step : {0, 1}) {
        check_means(plane, folder / "plane", step);
        check_means(space, folder / "space", step);
    }
}

TEST_CASE("a full cell is full, at walls as inside, for every shape") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    for (const Shape shape : {Shape::linear, Shape::quadratic, Shape::cubic, Shape::gimp}) {
        CAPTURE(static_cast<int>(shape));
        Scene scene = on_cells(test::slurry());
        scene.shape = shape;
        scene.transfer = Transfer::flip;
        scene.bodies[0].min = {0, 0, 0};
        scene.bodies[0].max = scene.max;
        scene.bodies[0].seeding = Seeding::lattice;
        write<2>(scene, comm, folder / "full");
        if (comm.is_root()) {
            const bool around_nodes = shape == Shape::quadratic || shape == Shape::gimp;
            const auto fraction = rows_of(folder / "full", "PointData/volume_fraction", 0);
            CHECK(fraction.size() == (around_nodes ? 42 * 21 : 41 * 20));
            for (const auto& row : fraction) CHECK(row[0] == doctest::Approx(1));
            std::filesystem::remove(folder / "full");
            std::filesystem::remove(folder / "full.particles");
        }
        comm.barrier();
    }
}

TEST_CASE("a cell's bytes in an output are those predicted") {
    const Comm comm(MPI_COMM_WORLD);
    for (const bool single : {false, true})
        for (const std::vector<std::string>& labels : {std::vector<std::string>{}, {"id", "rank", "block_key"}}) {
            Scene scene = on_cells(test::slurry(), single);
            scene.output.labels = labels;
            Simulation<double, 2> sim(scene, comm);
            const CellFrame<double, 2> frame(sim);
            int bytes = (frame.labels().rank ? 4 : 0) + (frame.labels().block_key ? 8 : 0);
            std::vector<Column> columns = frame.fields();
            columns.push_back(frame.position());
            for (const Column& c : columns) bytes += Column::bytes_of(c.type) * (c.components == 2 ? 3 : c.components);
            CHECK(predict_output(scene, {}).row_bytes == bytes);
        }
}
