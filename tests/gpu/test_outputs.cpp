#include <doctest/doctest.h>

#include <filesystem>

#include "app/device.hpp"
#include "io/test_folder.hpp"
#include "lattice_scenes.hpp"
#include "records/frame_choice.hpp"

using namespace moraine;

// What a device's outputs hold comes to the host in pieces; how it is then packed, compressed and written is the
// host's.

namespace {

struct Kind {
    bool on_cells, single, deflate, asynchronous;
    std::int64_t every;
};

Scene shown(Scene scene, const Kind& kind) {
    scene.output.fields = {"velocity", "stress", "pressure", "density", "mass", "volume"};
    scene.output.labels = {"id", "block_key"};
    scene.output.on_cells = kind.on_cells;
    scene.output.single = kind.single;
    scene.output.every = kind.every;
    return scene;
}

/// An output at the start and, while that may still be under way, one after some steps.
template <int Dim>
void write(const Scene& scene, const Comm& comm, const DeviceChoice& device, const Kind& kind, int steps,
           const std::string& path) {
    Simulation<float, Dim> sim(scene, comm,
                               device.cuda ? device_engine_maker<float, Dim>(scene, comm, device) : nullptr);
    sim.seed();
    ParticleSeries series(comm, path, {kind.deflate, kind.asynchronous});
    with_frame(sim, [&](auto& frame) { frame.append_to(series); });
    for (int k = 0; k < steps; ++k) {
        sim.step(), sim.balance();
        if (series.under_way() && comm.max(std::int64_t(series.busy())) == 0) series.advance();
    }
    sim.conclude();
    if (steps > 0) with_frame(sim, [&](auto& frame) { frame.append_to(series); });
    series.finish();
}

}  // namespace

TEST_CASE("the start of a run on devices is written as on the host, to the byte, in every way") {
    const Comm comm(MPI_COMM_WORLD), self(MPI_COMM_SELF);
    const DeviceChoice device = choose_device("cuda", comm);
    const TestFolder folder(comm);
    for (const bool on_cells : {false, true})
        for (const bool deflate : {false, true})
            for (const bool asynchronous : {false, true}) {
                const Kind kind{on_cells, deflate, deflate, asynchronous, on_cells ? 1 : 7};
                const Scene scene = shown(test::without_jitter(test::column()), kind);
                write<3>(scene, comm, device, kind, 0, folder / "device");
                if (comm.is_root()) {
                    write<3>(scene, self, {}, kind, 0, folder / "host");
                    CHECK(content_of(folder / "device") == content_of(folder / "host"));
                    std::filesystem::remove(folder / "device");
                    std::filesystem::remove(folder / "host");
                }
                comm.barrier();
            }
}

TEST_CASE("an output that is written while a device steps holds what it held when it was begun") {
    const Comm comm(MPI_COMM_WORLD);
    const DeviceChoice device = choose_device("cuda", comm);
    const TestFolder folder(comm);
    for (const bool on_cells : {false, true}) {
        const Kind at_once{on_cells, false, true, false, 1}, beside{on_cells, false, true, true, 1};
        const Scene scene = shown(test::without_jitter(test::slurry()), at_once);
        write<2>(scene, comm, device, at_once, 30, folder / "at_once");
        write<2>(scene, comm, device, beside, 30, folder / "beside");
        if (comm.is_root()) {
            CHECK(content_of(folder / "at_once") == content_of(folder / "beside"));
            std::filesystem::remove(folder / "at_once");
            std::filesystem::remove(folder / "beside");
        }
        comm.barrier();
    }
}
