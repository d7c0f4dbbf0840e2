#include <doctest/doctest.h>

#include <cmath>

#include "records/hazard_maps.hpp"
#include "simulation/diagnostics.hpp"
#include "terrain_scene.hpp"

using namespace moraine;

// The volume in the maps is that of the particles, whatever comes in late and whatever leaves.

namespace {

BodySpec late(const Scene& s, double start, double x) {
    BodySpec body;
    body.name = "late", body.shape = BodyShape::layer, body.material = 0;
    body.ground = s.structures[0].ground;
    body.points = {{x, 0.2}, {x + 0.5, 0.2}, {x + 0.5, 1}, {x, 1}};
    body.thickness = 0.2;
    body.release_time = start;
    return body;
}

/// Layers that flow out by the open side x-max, and two releases with a start.
Scene leaving() {
    Scene s = test::small_valley(InterfaceLaw::voellmy, false);
    s.end = 1;
    s.max[0] = 1.6;
    s.structures.resize(1);
    for (BodySpec& body : s.bodies) body.velocity = {9, 0.3, -3};
    s.bodies.push_back(late(s, 0.05, 0.1));
    s.bodies.push_back(late(s, 0.08, 1));
    s.hazard.cell = 0.23;  // the last column is cut by the domain's end
    s.hazard.threshold = 0.02;
    s.hazard.maps = {"deposit"};
    return s;
}

/// Of the last sample, from what a checkpoint keeps of the maps [m3].
double volume_in(const HazardMaps& maps, double cell) {
    const std::vector<double> all = maps.stored();
    double sum = 0;
    for (std::size_t at = 1; at < all.size(); at += 7) sum += all[at + 6];
    return sum * cell * cell;
}

template <class Real>
double volume_of(Simulation<Real, 3>& sim, const Comm& comm) {
    double sum = 0;
    const ParticleView<Real, 3> p = sim.patch().particles.view();
    each_particle(sim, [&](std::uint32_t s, const std::array<double, 3>&) { sum += double(p.volume[s]); });
    return comm.sum(sum);
}

template <class Real>
void maps_hold_all() {
    const Comm comm(MPI_COMM_WORLD);
    const Scene scene = leaving();
    Simulation<Real, 3> sim(scene, comm);
    sim.seed();
    HazardMaps maps(scene, comm);
    double worst = 0, lost = 0, released = 0;
    while (sim.clock().time < 0.15) {
        sim.step(), sim.balance();
        sim.bin();
        maps.sample(sim);
        worst = std::max(worst, std::fabs(volume_in(maps, scene.hazard.cell) / volume_of(sim, comm) - 1));
    }
    sim.conclude();
    for (const BodySpec& body : scene.bodies) released += 1500 * measure_of(body, 3);
    lost = sum_of(sim, sim.budget().lost_mass);
    CAPTURE(worst);
    CHECK(worst <= 1e-6);
    CHECK(lost > 0.1 * released);
    CHECK(totals_of(sim).mass + lost == doctest::Approx(released).epsilon(std::is_same_v<Real, float> ? 1e-6 : 1e-12));
}

}  // namespace

TEST_CASE("maps have the volume of the particles in 1e-6, with releases that come late and soil that leaves") {
    maps_hold_all<double>();
    maps_hold_all<float>();
}
