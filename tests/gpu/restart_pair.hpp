#pragma once
// A run on the device beside one that is restarted on the way.

#include <fmt/format.h>

#include "gpu/engine_pair.hpp"
#include "io/test_folder.hpp"
#include "records/checkpoint_state.hpp"

namespace moraine::test {

/// Both have the same bits after `before` steps, a checkpoint and `behind` more. also(straight, restarted): checks of
/// its own at the end.
template <int Dim, class Also>
void compare_restart(Scene scene, int before, int behind, const Also& also) {
    // A checkpoint tells bodies and tractions by their names.
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) scene.bodies[i].name = fmt::format("body {}", i);
    for (std::size_t i = 0; i < scene.course.tractions.size(); ++i)
        scene.course.tractions[i].name = fmt::format("traction {}", i);
    const Comm comm(MPI_COMM_WORLD);
    const TestFolder folder(comm);
    const auto maker = device_engine_maker<double, Dim>(scene, comm, choose_device("cuda", comm));
    Simulation<double, Dim> straight(scene, comm, maker), restarted(scene, comm, maker);
    straight.seed();
    advance(straight, before);
    save(straight, comm, folder / "state");
    load(restarted, comm, CheckpointReader(comm, folder / "state"), folder / "state");
    advance(straight, behind);
    advance(restarted, behind);
    CHECK(state_hash(restarted) == state_hash(straight));
    also(straight, restarted);
}

template <int Dim>
void compare_restart(const Scene& scene, int before, int behind) {
    compare_restart<Dim>(scene, before, behind, [](const auto&, const auto&) {});
}

}  // namespace moraine::test
