#include "gpu/engine_pair.hpp"
#include "material_scenes.hpp"

using namespace moraine;
using namespace moraine::test;

// A device that leads (engine/lead_rule.hpp) gives the answer of one whose dt the host makes, to the bit; it stops
// where somebody looks, and where a step went wrong.

namespace {

enum class DtBy { host, device };

/// Steps of the device, how many of them it made by itself, and what the run came to.
template <class Real, int Dim>
struct Led {
    std::uint64_t hash = 0;
    double time = 0;
    std::int64_t step = 0, led = 0, epochs = 0;
    std::vector<double> told;  ///< budget and counts
    std::string fault;
};

template <class Real, int Dim>
void advance_until(Simulation<Real, Dim>& sim, double time, std::int64_t step, DtBy by, Led<Real, Dim>& out) {
    if (by == DtBy::device) sim.leave_alone_until(time, step);
    while (sim.clock().time < time && sim.clock().step < step) {
        sim.step();
        out.led += sim.follows() ? 1 : 0;
        sim.balance();
    }
    sim.conclude();
}

/// Looks every `interval` seconds, and at the end. refresh: steps between memory refreshes; 0: as usual.
template <class Real, int Dim>
Led<Real, Dim> run_by(const Scene& scene, std::int64_t steps, DtBy by, double interval = 1e9, int refresh = 0) {
    const Comm comm(MPI_COMM_WORLD);
    DeviceChoice device = choose_device("cuda", comm);
    device.refresh_interval = refresh;
    Simulation<Real, Dim> sim(scene, comm, device_engine_maker<Real, Dim>(scene, comm, device));
    Led<Real, Dim> out;
    try {
        sim.seed();
        for (double look = interval; sim.clock().step < steps && sim.clock().time < scene.end; look += interval) {
            advance_until(sim, std::min(look, scene.end), steps, by, out);
            out.told.push_back(static_cast<double>(state_hash(sim) >> 12));
        }
    } catch (const PhysicsError& e) {
        out.fault = e.what();
        sim.bin();
    }
    out.hash = state_hash(sim, true);
    out.time = sim.clock().time;
    out.step = sim.clock().step;
    out.epochs = sim.counts_so_far().epochs;
    const Budget<Dim>& budget = sim.budget();
    for (const ExactSum& s : {budget.work, budget.impulse[0], budget.impulse[1], budget.lost_mass,
                              budget.lost_momentum[0], budget.lost_gravity_impulse[1], budget.gravity_work})
        out.told.push_back(sim.quantum().value(s));
    const RunCounts counts = sim.counts_so_far();
    for (std::int64_t n : {budget.lost_count, counts.steps, counts.exchanges, counts.clamped_boxes})
        out.told.push_back(static_cast<double>(n));
    out.told.push_back(counts.particle_steps);
    for (std::size_t k = 0; k < sim.structures().size(); ++k)
        for (const ExactSum& s : sim.structures().state(k).felt.sum) out.told.push_back(sim.quantum().value(s));
    return out;
}

template <class Real, int Dim>
Led<Real, Dim> compare_dims(const Scene& scene, std::int64_t steps, double interval) {
    const Led<Real, Dim> host = run_by<Real, Dim>(scene, steps, DtBy::host, interval);
    const Led<Real, Dim> device = run_by<Real, Dim>(scene, steps, DtBy::device, interval);
    CAPTURE(scene.name);
    CHECK(host.led == 0);
    CHECK(device.hash == host.hash);
    CHECK(device.time == host.time);
    CHECK(device.step == host.step);
    CHECK(device.told == host.told);
    CHECK(device.fault == host.fault);
    MESSAGE(scene.name << ": " << device.led << " of " << device.step << " steps by the device, epochs "
                       << device.epochs << " and " << host.epochs);
    return device;
}

/// Returns how many steps the device made by itself.
std::int64_t compare_leads(const Scene& scene, std::int64_t steps, double interval = 1e9) {
    const bool single = scene.precision == Precision::single_;
    if (scene.dimensions == 2)
        return single ? compare_dims<float, 2>(scene, steps, interval).led
                      : compare_dims<double, 2>(scene, steps, interval).led;
    return single ? compare_dims<float, 3>(scene, steps, interval).led
                  : compare_dims<double, 3>(scene, steps, interval).led;
}

}  // namespace

TEST_CASE("a device that leads gives the same state, budget, times and counts to the bit") {
    for (const char* name : {"slurry_runout", "granular_column", "elastic_bar"})
        for (const char* precision : {"single", "double"})
            CHECK(compare_leads(input(name, {std::string("numerics.precision=") + precision}), 400) > 300);
    CHECK(compare_leads(input("slurry_runout_3d", {"domain.cell=0.2"}), 300) > 200);
}

TEST_CASE("an open wall, two materials, friction and damping do not hinder it") {
    for (Transfer transfer : {Transfer::flip, Transfer::apic})
        for (Scene scene : {test::slurry(), test::column()}) {
            scene.transfer = transfer;
            scene.end = 100;
            CHECK(compare_leads(scene, 500) > 300);
        }
}

TEST_CASE("while a table changes gravity the host makes dt, and the device leads from then on") {
    Scene scene = test::column();
    scene.end = 100;
    const double ramp = run_by<double, 3>(scene, 100, DtBy::host).time;
    scene.course.gravity = {{0, ramp}, {0.5, 1}};
    const std::int64_t led = compare_leads(scene, 400);
    CHECK(led > 200);
    CHECK(led < 310);
}

TEST_CASE("layers of three materials, whose blocks go to four gathers, do not hinder it") {
    for (int dimensions : {2, 3})
        for (Transfer transfer : {Transfer::flip, Transfer::apic})
            for (bool limits : {true, false}) {
                Scene scene = test::soils(dimensions, 3);
                scene.transfer = transfer;
                scene.limits_light_nodes = limits;
                scene.end = 100;
                CHECK(compare_leads(scene, 200) > 100);
            }
}

TEST_CASE("structures at rest do not hinder it, and feel the same") {
    for (const char* name : {"sliding_block", "submarine_slide", "submarine_slide_3d"})
        for (const char* precision : {"single", "double"}) {
            const Scene scene = input(name, {std::string("numerics.precision=") + precision, "time.end=100"});
            CHECK(compare_leads(scene, 150, 0.2) > 75);
        }
}

TEST_CASE("it stands back where a structure moves, and over terrain") {
    for (const char* name : {"strip_footing", "debris_flume"}) CHECK(compare_leads(input(name, {}), 40) == 0);
}

TEST_CASE("sixteen materials are not too many for it") {
    Scene scene = test::soils(2, 3);
    for (int m = 3; m < 16; ++m) scene.materials.push_back(scene.materials[static_cast<std::size_t>(m % 3)]);
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) scene.bodies[b].material += 3 * static_cast<int>(b % 4);
    scene.end = 100;
    CHECK(compare_leads(scene, 200) > 100);
}

TEST_CASE("shapes, means of cells and a dt that the scene says do not hinder it") {
    for (Shape shape : {Shape::linear, Shape::gimp, Shape::gimp_contiguous, Shape::quadratic, Shape::cubic}) {
        Scene scene = test::column();
        scene.shape = shape;
        scene.cfl = 0.2;
        scene.end = 100;
        CHECK(compare_leads(scene, 40) > 20);
        scene.materials[0].volumetric = Volumetric::cell;
        CHECK(compare_leads(scene, 40) > 20);
        scene.dt = 0.002;
        CHECK(compare_leads(scene, 40) > 20);
    }
}

TEST_CASE("a flow that spreads over many epochs, and needs more tiles, gives the same state") {
    const Scene scene = input("slurry_runout", {"domain.cell=0.02", "time.end=0.6"});
    CHECK(compare_leads(scene, 100000) > 500);
}

TEST_CASE("how often memory is put into list order changes no bit, whoever makes dt") {
    for (const Scene& scene :
         {input("slurry_runout", {"domain.cell=0.02", "time.end=0.6"}), input("elastic_bar", {})}) {
        const auto host = run_by<double, 2>(scene, 1500, DtBy::host, 1e9, 2);
        for (int refresh : {2, 7, 12, 96, 1000, 0}) {
            const auto device = run_by<double, 2>(scene, 1500, DtBy::device, 1e9, refresh);
            CAPTURE(refresh);
            CHECK(device.hash == host.hash);
            CHECK(device.told == host.told);
            CHECK(device.led > host.step / 2);
        }
    }
}

TEST_CASE("a lead goes on to the next refresh of memory where nobody is near the end of the epoch") {
    const Comm comm(MPI_COMM_WORLD);
    const Scene scene = input("elastic_bar", {});
    const auto leads_ended = [&](int refresh) {
        DeviceChoice device = choose_device("cuda", comm);
        device.refresh_interval = refresh;
        const auto make = device_engine_maker<double, 2>(scene, comm, device);
        Engine<double, 2>* engine = nullptr;
        Simulation<double, 2> sim(scene, comm, [&](const Method<Host, double, 2>& method) {
            auto made = make(method);
            engine = made.get();
            return made;
        });
        sim.seed();
        sim.leave_alone_until(scene.end, 400);
        int ended = 0;
        while (sim.clock().step < 400) {
            sim.step();
            if (!engine->leads()) ++ended;
            if (sim.clock().step % 10 == 0) engine->synchronize();  // the host may hear of all that is queued late
            sim.balance();
        }
        sim.conclude();
        return ended;
    };
    CHECK(leads_ended(12) > 30);
    CHECK(leads_ended(100) < 10);
    CHECK(leads_ended(1000) < 4);
}

TEST_CASE("it stops after the first step at or past the time at which somebody looks") {
    Scene scene = test::slurry();
    scene.end = 0.2;
    CHECK(compare_leads(scene, 100000, 0.003) > 20);
    CHECK(compare_leads(scene, 101, 0.011) > 10);
}

/// A square that goes up and to the right: the last block of the list gains particles for many steps.
Scene drifting_square(Precision precision) {
    Scene s = test::elastic_spray(2, Transfer::flip);
    s.max = {40, 40, 0};
    s.cell = 1;
    s.gravity = {};
    s.precision = precision;
    s.bodies = {test::box({4, 4, 0}, {14, 14, 0}, 0)};
    s.bodies[0].velocity = {4, 4, 0};
    s.end = 100;
    return s;
}

// That it reads none is seen under compute-sanitizer: what lies behind a list is often harmless.
TEST_CASE("what was queued behind the end of a lead reads no list that is out of date") {
    for (Precision precision : {Precision::single_, Precision::double_})
        for (double interval : {0.053, 0.071})  // some five and seven steps
            CHECK(compare_leads(drifting_square(precision), 600, interval) > 200);
}

TEST_CASE("a step that goes wrong is named as where the host makes dt, and the particles stay as it left them") {
    Scene scene = test::slurry();
    scene.end = 10;
    scene.dt = 8e-3;  // too long: some particle is turned inside out, or goes more than a cell
    const auto host = run_by<double, 2>(scene, 4000, DtBy::host);
    const auto device = run_by<double, 2>(scene, 4000, DtBy::device);
    REQUIRE(!host.fault.empty());
    MESSAGE(host.fault << ", " << device.led << " steps by the device");
    CHECK(device.led > 5);
    CHECK(device.fault == host.fault);
    CHECK(device.hash == host.hash);
    CHECK(device.step == host.step);
    CHECK(device.time == host.time);
}

TEST_CASE("who looks at particles that were to be left alone is told so") {
    const Comm comm(MPI_COMM_WORLD);
    const Scene scene = input("slurry_runout", {});
    const DeviceChoice device = choose_device("cuda", comm);
    Simulation<float, 2> sim(scene, comm, device_engine_maker<float, 2>(scene, comm, device));
    sim.seed();
    sim.leave_alone_until(scene.end, 1000);
    for (int k = 0; k < 7; ++k) sim.step(), sim.balance();
    CHECK_THROWS_AS(sim.conclude(), std::logic_error);
}
