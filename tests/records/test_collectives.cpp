#include <doctest/doctest.h>

#include "io/test_folder.hpp"
#include "records/output_frame.hpp"
#include "records/time_series.hpp"
#include "sample_scenes.hpp"

// On a slow network each collective costs a round trip or more: outputs and checkpoints may have 20. They are counted
// by MPI's profiling interface: a call of MPI_X comes here first, and goes on to PMPI_X.

namespace {
int collectives = 0;
}

extern "C" {
int MPI_Allreduce(const void* mine, void* all, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
    ++collectives;
    return PMPI_Allreduce(mine, all, n, type, op, comm);
}
int MPI_Iallreduce(const void* mine, void* all, int n, MPI_Datatype type, MPI_Op op, MPI_Comm comm, MPI_Request* r) {
    ++collectives;
    return PMPI_Iallreduce(mine, all, n, type, op, comm, r);
}
int MPI_Allgather(const void* mine, int n, MPI_Datatype type, void* all, int m, MPI_Datatype types, MPI_Comm comm) {
    ++collectives;
    return PMPI_Allgather(mine, n, type, all, m, types, comm);
}
int MPI_Allgatherv(const void* mine, int n, MPI_Datatype type, void* all, const int m[], const int at[],
                   MPI_Datatype types, MPI_Comm comm) {
    ++collectives;
    return PMPI_Allgatherv(mine, n, type, all, m, at, types, comm);
}
int MPI_Alltoallv(const void* mine, const int n[], const int from[], MPI_Datatype type, void* all, const int m[],
                  const int at[], MPI_Datatype types, MPI_Comm comm) {
    ++collectives;
    return PMPI_Alltoallv(mine, n, from, type, all, m, at, types, comm);
}
int MPI_Bcast(void* data, int n, MPI_Datatype type, int root, MPI_Comm comm) {
    ++collectives;
    return PMPI_Bcast(data, n, type, root, comm);
}
int MPI_Barrier(MPI_Comm comm) {
    ++collectives;
    return PMPI_Barrier(comm);
}
}

using namespace moraine;

namespace {

/// Everything that takes a collective: three dimensions, an affine field, structures, all fields.
Scene rich() {
    Scene scene = test::column();
    scene.transfer = Transfer::apic;
    scene.output.fields = {"velocity", "stress", "pressure", "density", "ln_J", "mass", "volume", "body"};
    scene.output.labels = {"id", "rank", "block_key"};
    for (const char* name : {"one", "two", "three"}) {
        scene.structures.emplace_back();
        scene.structures.back().name = name;
        scene.structures.back().shape = StructureShape::sphere;
        scene.structures.back().center = {0.1, 0.1, 0.1};
        scene.structures.back().radius = 0.01;
    }
    return scene;
}

}  // namespace

TEST_CASE("an output and a checkpoint take at most 20 collectives each") {
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const Scene scene = rich();
    Simulation<double, 3> sim(scene, comm);
    sim.seed();
    CsvLog history(comm, folder / "history.csv", TimeSeriesRow<3>::columns());
    CsvLog structures(comm, folder / "structures.csv", structure_columns<3>());
    ParticleSeries series(comm, folder / "p.vtkhdf");
    for (int n = 0; n < 2; ++n) {
        sim.step();
        collectives = 0;
        sim.conclude();
        history.row(observe(sim, comm).values());
        record_structures(sim, structures);
        OutputFrame<double, 3>(sim).append_to(series);
        MESSAGE("an output: ", collectives);
        CHECK(collectives > 0);
        CHECK(collectives <= 20);
    }
    collectives = 0;
    sim.conclude();
    save(sim, comm, folder / "c.h5");
    MESSAGE("a checkpoint: ", collectives);
    CHECK(collectives > 0);
    CHECK(collectives <= 20);
}
