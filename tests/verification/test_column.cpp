// E2: a column under its own weight finds the exact stress and settlement at finite strain.
#include "verification/drive.hpp"
#include "verification/problem_column.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

/// At rest after 30 periods.
Settled settle(const Column& column, int cells, const Choice& choice, const std::string& law = "linear-elastic",
               bool spline = true) {
    const Scene scene = column_scene(column, cells, choice, law, spline);
    Run<> run(scene);
    return settle(run, column, 30);
}

/// Halves the cells from 8 on; returns what each level left, in print too.
std::vector<Settled> refine(const Choice& choice, int levels, const Column& column = {}, bool spline = true,
                            const std::string& law = "linear-elastic") {
    std::vector<Settled> all;
    for (int k = 0; k < levels; ++k) {
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

TEST_CASE("E2: GIMP converges to the stress of a column under its own weight at the limit of order 0.9") {
    const std::vector<Settled> r = refine(gimp_flip_usl, 4);
    for (std::size_t k = 1; k < r.size(); ++k) CHECK(order(r[k - 1].stress, r[k].stress) >= 0.9);
    CHECK(r.back().stress <= 3e-3);
    CHECK(r.back().settlement <= 5e-4);
}

TEST_CASE("E2: contiguous GIMP converges in place at second order and in stress at first") {
    const std::vector<Settled> r = refine(contiguous_flip_usl, 3);
    for (std::size_t k = 1; k < r.size(); ++k) {
        CHECK(order(r[k - 1].stress, r[k].stress) >= 0.9);
        CHECK(order(r[k - 1].settlement, r[k].settlement) >= 1.9);
    }
}

TEST_CASE("E2: splines come within a thousandth of the stress at 32 cells") {
    for (const Choice& choice : {quadratic_flip_usl, quadratic_apic_usl, cubic_flip_usl}) {
        const std::vector<Settled> r = refine(choice, 3);
        CHECK(r.back().stress <= 1.3e-3);
        CHECK(r.back().settlement <= 5e-4);
        CHECK(order(r.front().stress, r.back().stress) >= 1.9);  // over two halvings: quadratic stalls beyond
    }
}

TEST_CASE("E2: a neo-Hookean column settles to its own exact height") {
    const std::vector<Settled> r = refine(contiguous_flip_usl, 3, {}, true, "neo-hookean");
    CHECK(r.back().stress <= 6e-3);
    CHECK(r.back().settlement <= 1.5e-4);
}

TEST_CASE("E2: plain ghost nodes cost a quarter of the base pressure, boundary splines do not") {
    for (const Choice& choice : {quadratic_apic_usl, cubic_flip_usl}) {
        const Settled plain = refine(choice, 2, {}, false).back();
        const Settled spline = refine(choice, 2).back();
        CHECK(plain.base >= 0.25);
        CHECK(spline.base <= 0.015);
        CHECK(spline.settlement <= 0.05 * plain.settlement);
    }
}

TEST_CASE("E2: long refinement studies and the hard case" * doctest::skip(!long_tests())) {
    for (const Choice& choice :
         {gimp_flip_usl, contiguous_flip_usl, quadratic_flip_usl, quadratic_apic_usl, cubic_flip_usl, cubic_apic_usl})
        refine(choice, 5);
    for (const Choice& choice : {contiguous_flip_usl, quadratic_apic_usl, cubic_flip_usl}) refine(choice, 3, hard);
    for (const Choice& choice : {gimp_flip_usl, quadratic_flip_usl}) refine(choice, 4, {}, false);
}
