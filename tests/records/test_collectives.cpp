#include <doctest/doctest.h>

#include "io/test_folder.hpp"
#include "records/output_frame.hpp"
#include "records/time_series.hpp"
#include "sample_scenes.hpp"

// On a slow network each collective costs a round trip or more: outputs and checkpoints may have 20. They are counted
// by MPI's profiling interface: a call of MPI_X comes here first, and goes on to PMPI_X.

namespace {
int collectives = 0;
int waits = 0;      // times that a rank waits for what was sent since it waited last
bool sent = false;  // since it waited last

void wait(int n) {
    if (n > 0 && sent) ++waits;
    if (n > 0) sent = false;
}
}  // namespace

// clang-format off
extern "C" {
#define COUNTED(name, parameters, arguments) int name parameters { ++collectives; return P##name arguments; }
COUNTED(MPI_Allreduce, (const void* a, void* b, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c), (a, b, n, t, o, c))
COUNTED(MPI_Iallreduce, (const void* a, void* b, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c, MPI_Request* r), (a, b, n, t, o, c, r))
COUNTED(MPI_Allgather, (const void* a, int n, MPI_Datatype t, void* b, int m, MPI_Datatype u, MPI_Comm c), (a, n, t, b, m, u, c))
COUNTED(MPI_Allgatherv, (const void* a, int n, MPI_Datatype t, void* b, const int* m, const int* at, MPI_Datatype u, MPI_Comm c), (a, n, t, b, m, at, u, c))
COUNTED(MPI_Alltoallv, (const void* a, const int* n, const int* from, MPI_Datatype t, void* b, const int* m, const int* at, MPI_Datatype u, MPI_Comm c), (a, n, from, t, b, m, at, u, c))
COUNTED(MPI_Bcast, (void* a, int n, MPI_Datatype t, int root, MPI_Comm c), (a, n, t, root, c))
COUNTED(MPI_Barrier, (MPI_Comm c), (c))
int MPI_Isend(const void* data, int n, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* r) {
    sent = true;
    return PMPI_Isend(data, n, type, to, tag, comm, r);
}
int MPI_Waitall(int n, MPI_Request requests[], MPI_Status statuses[]) {
    wait(n);
    return PMPI_Waitall(n, requests, statuses);
}
}
// clang-format on

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
    CsvLog history(comm, folder / "history.csv", TimeSeriesRow<3>::columns({}));
    CsvLog structures(comm, folder / "structures.csv", structure_columns<3>(false));
    history.begin(), structures.begin();
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

TEST_CASE("a step on few ranks waits twice in turn, and takes no collective") {
    const Comm comm(MPI_COMM_WORLD);
    Scene scene = test::slurry();
    scene.balance.trigger = Trigger::never;
    Simulation<double, 2> sim(scene, comm);
    sim.seed();
    sim.step();
    const std::int64_t epochs = sim.counts().epochs;
    for (int n = 0; n < 3; ++n) {
        collectives = waits = 0;
        sim.step();
        CHECK(collectives == 0);
        CHECK(waits == 2);  // for who came over with the last step; then for the halo and dt together
        sim.balance();
    }
    sim.conclude();  // takes in what is on its way
    CHECK(sim.counts().epochs == epochs);
}
