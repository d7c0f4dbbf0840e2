// E2: a column under its own weight finds the exact stress and settlement at finite strain.
#include "verification/drive.hpp"
#include "verification/exact_column.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

struct Settled {
    double stress;      ///< sum V0 |sigma - exact| / (rho0 g l0 sum V0)
    double settlement;  ///< rms of the place's error over the settlement of the top
    double base;        ///< largest stress error in the lowest cell over the base pressure
    double speed;       ///< largest left, over the wave speed
};

Scene column_scene(const Column& column, int cells, const Choice& choice, const std::string& law, bool spline) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = column.height / cells;
    scene.max = {4 * scene.cell, column.height + 2 * scene.cell, 0};
    scene.boundary_spline = spline;
    scene.cfl = 0.4;
    scene.damping = 0.3;
    scene.gravity[1] = -column.gravity;
    choose(scene, choice);
    make_periodic(scene, 0);
    scene.walls[1][0].kind = WallKind::free_slip;
    scene.materials.push_back(material(law, column.density, {{"young", column.young}, {"poisson", 0}}));
    BodySpec body;
    body.max = {scene.max[0], column.height, 0};
    body.particles_per_cell = {1, 2, 1};
    scene.bodies.push_back(body);
    return scene;
}

/// Gravity is there at once; damping brings it to rest in `periods` of its first mode, 4 l0 / c.
Settled settle(const Column& column, int cells, const Choice& choice, const std::string& law = "linear-elastic",
               bool spline = true, double periods = 30) {
    const Scene scene = column_scene(column, cells, choice, law, spline);
    Run<> run(scene);
    while (run.time() < periods * 4 * column.height / column.wave_speed()) run.steps(50);
    const double volume = scene.max[0] * column.height;
    const double particle = 0.5 * scene.cell * scene.cell;  // V0
    Settled settled;
    settled.stress = run.sum([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
        return particle * std::fabs(p.stress[s](1, 1) - column.stress(X[1]));
    });
    settled.stress /= column.base_pressure() * volume;
    const bool elastic = law == "linear-elastic";
    const double top =
        column.height - (elastic ? column.place(column.height) : column.place_neo_hookean(column.height));
    settled.settlement = run.sum([&](const auto&, std::uint32_t, const auto& X, const auto& x) {
        const double error = x[1] - (elastic ? column.place(X[1]) : column.place_neo_hookean(X[1]));
        return particle * error * error;
    });
    settled.settlement = std::sqrt(settled.settlement / volume) / top;
    settled.base = run.largest([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
        return X[1] > scene.cell ? 0 : std::fabs(p.stress[s](1, 1) - column.stress(X[1])) / column.base_pressure();
    });
    settled.speed = run.sim.totals().max_speed / column.wave_speed();
    return settled;
}

/// Halves the cells from 8 on; returns what each rung left, in print too.
std::vector<Settled> ladder(const Choice& choice, int rungs, const Column& column = {}, bool spline = true,
                            const std::string& law = "linear-elastic") {
    std::vector<Settled> all;
    for (int k = 0; k < rungs; ++k) {
        const int cells = 8 << k;
        all.push_back(settle(column, cells, choice, law, spline));
        const Settled& now = all.back();
        std::string orders;
        if (k > 0) {
            const Settled& last = all[all.size() - 2];
            orders = fmt::format(" (p {:.2f}, {:.2f})", order(last.stress, now.stress),
                                 order(last.settlement, now.settlement));
        }
        say(fmt::format(
            "E2 {}{} {}, k l0 = {:.2g}, {} cells: stress {:.2e}, place {:.2e}{}, base {:.1e}, left {:.0e} c",
            choice.name, spline ? "" : ", plain ghost nodes,", law, column.base_pressure() / column.young, cells,
            now.stress, now.settlement, orders, now.base, now.speed));
    }
    return all;
}

constexpr Column hard{.height = 10, .young = 125e3, .density = 1000, .gravity = 10};

}  // namespace

TEST_CASE("E2: GIMP converges to the stress of a column under its own weight at the GATE of order 0.9") {
    const std::vector<Settled> r = ladder(gimp_flip_usl, 4);
    for (std::size_t k = 1; k < r.size(); ++k) CHECK(order(r[k - 1].stress, r[k].stress) >= 0.9);
    CHECK(r.back().stress <= 3e-3);
    CHECK(r.back().settlement <= 5e-4);
}

TEST_CASE("E2: contiguous GIMP converges in place at second order and in stress at first") {
    const std::vector<Settled> r = ladder(contiguous_flip_usl, 3);
    for (std::size_t k = 1; k < r.size(); ++k) {
        CHECK(order(r[k - 1].stress, r[k].stress) >= 0.9);
        CHECK(order(r[k - 1].settlement, r[k].settlement) >= 1.9);
    }
}

TEST_CASE("E2: splines come within a thousandth of the stress at 32 cells") {
    for (const Choice& choice : {quadratic_flip_usl, quadratic_apic_usl, cubic_flip_usl}) {
        const std::vector<Settled> r = ladder(choice, 3);
        CHECK(r.back().stress <= 1.3e-3);
        CHECK(r.back().settlement <= 5e-4);
        CHECK(order(r.front().stress, r.back().stress) >= 1.9);  // over two halvings: quadratic stalls beyond
    }
}

TEST_CASE("E2: a neo-Hookean column settles to its own exact height") {
    const std::vector<Settled> r = ladder(contiguous_flip_usl, 3, {}, true, "neo-hookean");
    CHECK(r.back().stress <= 6e-3);
    CHECK(r.back().settlement <= 1.5e-4);
}

TEST_CASE("E2: plain ghost nodes cost a quarter of the base pressure, boundary splines do not") {
    for (const Choice& choice : {quadratic_apic_usl, cubic_flip_usl}) {
        const Settled plain = ladder(choice, 2, {}, false).back();
        const Settled spline = ladder(choice, 2).back();
        CHECK(plain.base >= 0.25);
        CHECK(spline.base <= 0.015);
        CHECK(spline.settlement <= 0.05 * plain.settlement);
    }
}

TEST_CASE("E2: long ladders and the hard case" * doctest::skip(!long_tests())) {
    for (const Choice& choice :
         {gimp_flip_usl, contiguous_flip_usl, quadratic_flip_usl, quadratic_apic_usl, cubic_flip_usl, cubic_apic_usl})
        ladder(choice, 5);
    for (const Choice& choice : {contiguous_flip_usl, quadratic_apic_usl, cubic_flip_usl}) ladder(choice, 3, hard);
    for (const Choice& choice : {gimp_flip_usl, quadratic_flip_usl}) ladder(choice, 4, {}, false);
}
