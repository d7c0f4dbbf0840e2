// Stages against closed forms: a settle stage that ends at rest, an excavation, and what is removed and comes again.
#include "records/time_series.hpp"
#include "simulation/rest_watch.hpp"
#include "verification/drive.hpp"
#include "verification/problem_column.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

constexpr Column soil{.height = 8, .young = 4e6, .density = 1000, .gravity = 1};
constexpr double poisson = 0.3, wave_modulus = soil.young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson));
constexpr double k0 = poisson / (1 - poisson);
constexpr int cells = 16;

StageSpec stage(const Scene& scene, const char* name, std::vector<int> removes = {}) {
    StageSpec s;
    s.name = name;
    s.until = scene.end, s.until_rest = true, s.damping = 0.7;
    s.materials = scene.materials, s.walls = scene.walls;
    s.removes = std::move(removes);
    return s;
}

/// Confined layers with their lower ends at `from`, of which those behind the first are taken away, one in each stage.
Scene layers(const std::vector<double>& from, const std::vector<std::vector<int>>& removes) {
    Scene scene = column_scene(soil, cells, quadratic_apic_usl, "linear-elastic", true);
    scene.materials = {material("linear-elastic", soil.density, {{"young", soil.young}, {"poisson", poisson}})};
    scene.end = 1e3;
    scene.rest.displacement = 2e-6;
    scene.rest.mass = 1;
    const BodySpec all = scene.bodies[0];
    scene.bodies.clear();
    for (std::size_t k = 0; k < from.size(); ++k) {
        BodySpec layer = all;
        layer.min[1] = from[k];
        layer.max[1] = k + 1 < from.size() ? from[k + 1] : soil.height;
        scene.bodies.push_back(layer);
    }
    for (const auto& bodies : removes) scene.course.stages.push_back(stage(scene, "part", bodies));
    return scene;
}

/// Through all stages, each until rest.
template <int Dim>
void run_to_rest(Simulation<double, Dim>& sim, const Comm& comm) {
    for (;;) {
        RestWatch<Dim> watch(sim.scene(), comm);
        watch.look(sim);
        while (!watch.is_at_rest()) {
            sim.step(), sim.balance();
            watch.look(sim);
        }
        sim.conclude();
        if (sim.is_last_stage()) return;
        sim.begin_stage();
    }
}

/// Place of each particle of the first body along y, by id [m]. Collective.
std::vector<double> heights(Simulation<double, 2>& sim, const Comm& comm) {
    struct Row {
        std::uint64_t id;
        double y;
    };
    std::vector<Row> rows;
    const ParticleView<double, 2> p = sim.patch().particles.view();
    each_particle(sim, [&](std::uint32_t s, const std::array<double, 2>& x) {
        if (p.body[s] == 0) rows.push_back({p.id[s], x[1]});
    });
    rows = comm.all_gather(rows);
    std::sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) { return a.id < b.id; });
    std::vector<double> y;
    for (const Row& row : rows) y.push_back(row.y);
    return y;
}

/// The upper layer is taken away after so many steps, and comes again at once.
void take_and_bring(int steps) {
    const Comm comm(MPI_COMM_WORLD);
    Scene scene = layers({0, 6}, {{}, {1}, {}});
    scene.bodies.push_back(scene.bodies[1]);
    scene.bodies.back().name = "again";
    scene.bodies.back().stage = 2;
    Simulation<double, 2> sim(scene, comm);
    sim.seed();
    const TimeSeriesRow<2> start = observe(sim, comm);
    for (int k = 0; k < steps; ++k) sim.step(), sim.balance();
    sim.conclude();
    const TimeSeriesRow<2> before = observe(sim, comm);
    sim.begin_stage();
    const TimeSeriesRow<2> removed = observe(sim, comm);
    const StageBegin begin = sim.clock().stages.back();
    CHECK(removed.totals.mass == doctest::Approx(0.75 * before.totals.mass).epsilon(1e-12));
    CHECK(begin.removed_mass == doctest::Approx(0.25 * before.totals.mass).epsilon(1e-9));
    const auto energy = [](const TimeSeriesRow<2>& row) {
        return row.totals.kinetic + row.totals.strain + row.potential;
    };
    const double scale = std::fabs(start.potential);
    CHECK(std::fabs(energy(before) - energy(removed) - begin.removed_energy) <= 1e-9 * scale);
    CHECK(std::fabs(removed.unaccounted - before.unaccounted) <= 1e-9 * scale);
    CHECK(std::fabs(removed.dissipated - before.dissipated) <= 1e-9 * scale);
    CHECK(std::fabs(removed.momentum_error[1] - before.momentum_error[1]) <= 1e-9 * before.totals.mass);
    sim.begin_stage();
    const TimeSeriesRow<2> again = observe(sim, comm);
    CHECK(again.particles == start.particles);
    CHECK(sim.clock().stages.back().added_mass == doctest::Approx(begin.removed_mass).epsilon(1e-9));
    CHECK(again.totals.mass == doctest::Approx(start.totals.mass).epsilon(1e-12));
    CHECK(std::fabs(again.unaccounted - before.unaccounted) <= 1e-9 * scale);
    if (steps > 0) return;  // what comes again does not fit to what has moved
    run_to_rest(sim, comm);
    double worst = 0;
    const ParticleView<double, 2> p = sim.patch().particles.view();
    each_particle(sim, [&](std::uint32_t s, const std::array<double, 2>& x) {
        if (x[1] > soil.height - 2 * scene.cell) return;
        worst =
            std::max(worst, std::fabs(p.stress[s](1, 1) / (soil.density * soil.gravity * (soil.height - x[1])) + 1));
    });
    CHECK(comm.max(worst) <= 0.01);
}

}  // namespace

TEST_CASE("a damped stage that ends at rest leaves K0 = nu / (1 - nu) and the weight above") {
    const Comm comm(MPI_COMM_WORLD);
    const Scene scene = layers({0}, {{}, {}});
    Simulation<double, 2> sim(scene, comm);
    sim.seed();
    run_to_rest(sim, comm);
    double worst = 0, worst_k0 = 0;
    const ParticleView<double, 2> p = sim.patch().particles.view();
    each_particle(sim, [&](std::uint32_t s, const std::array<double, 2>& x) {
        if (x[1] > soil.height - 2 * scene.cell) return;  // a hundredth of little
        const double weight = -soil.density * soil.gravity * (soil.height - x[1]);
        worst = std::max(worst, std::fabs(p.stress[s](1, 1) / weight - 1));
        worst_k0 = std::max(worst_k0, std::fabs(p.stress[s](0, 0) / p.stress[s](1, 1) / k0 - 1));
    });
    worst = comm.max(worst), worst_k0 = comm.max(worst_k0);
    say(fmt::format("settled: vertical stress within {:.2e} of the weight, K0 within {:.2e}", worst, worst_k0));
    CHECK(worst <= 0.01);
    CHECK(worst_k0 <= 0.01);
    CHECK(sim.clock().stages.size() == 2);
}

TEST_CASE("taking away a layer d of a column lets H below it heave by rho g d H / M, in one stage or in several") {
    const Comm comm(MPI_COMM_WORLD);
    std::vector<std::vector<double>> left;
    const double d = 2, H = soil.height - d;
    for (const auto& removes : {std::vector<std::vector<int>>{{}, {1, 2}}, {{}, {2}, {1}}, {{}, {}, {2}, {}, {1}}}) {
        const Scene scene = layers({0, H, H + d / 2}, removes);
        Simulation<double, 2> sim(scene, comm);
        sim.seed();
        const std::vector<double> start = heights(sim, comm);
        {
            const Scene whole = layers({0, H, H + d / 2}, {{}});
            Simulation<double, 2> settled(whole, comm);
            settled.seed();
            run_to_rest(settled, comm);
            run_to_rest(sim, comm);
            const std::vector<double> before = heights(settled, comm), after = heights(sim, comm);
            double heave = 0;  // of the mean, half of that of the top
            for (std::size_t k = 0; k < after.size(); ++k)
                heave += (after[k] - before[k]) / static_cast<double>(after.size());
            const double exact = 0.5 * soil.density * soil.gravity * d * H / wave_modulus;
            say(fmt::format("{} stages: heave {:.5f} of rho g d H / M", removes.size(), heave / exact));
            CHECK(heave == doctest::Approx(exact).epsilon(0.01));
        }
        left.push_back(heights(sim, comm));
        const TimeSeriesRow<2> row = observe(sim, comm);
        CHECK(row.totals.mass == doctest::Approx(soil.density * H * scene.max[0]).epsilon(1e-12));
        CHECK(sim.clock().start_mass == doctest::Approx(row.totals.mass).epsilon(1e-9));
        CHECK(std::fabs(row.momentum_error[1]) <= 1e-9 * row.totals.mass * soil.gravity * row.time);
        CHECK(left.back().size() == start.size());
    }
    const double settlement = soil.density * soil.gravity * soil.height * soil.height / (2 * wave_modulus);
    for (std::size_t way = 1; way < left.size(); ++way)
        for (std::size_t k = 0; k < left[0].size(); ++k)
            CHECK(std::fabs(left[way][k] - left[0][k]) <= 1e-3 * settlement);
}

TEST_CASE("what is taken away leaves the budget as if it had never been there, and comes again as at the start") {
    take_and_bring(0);
    take_and_bring(100);  // a wave has been at the top: energy of all kinds goes
}
