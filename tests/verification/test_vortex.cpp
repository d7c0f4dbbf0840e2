// E4: a ring of a neo-Hookean body is turned and turned back; who can follow a shear of 2 over many cells?
#include "verification/drive.hpp"
#include "verification/problem_vortex.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

double turn(const Choice& choice, int cells, double cfl = 0.2) {
    const Vortex exact;
    const Scene scene = vortex_scene(exact, cells, choice, cfl);
    Run<> run(scene, push(exact));
    const double error = turn(run, exact);
    say(fmt::format("E4 A = 1/3, {}, {} cells per m: rms place {:.2e} m", choice.name, cells, error));
    return error;
}

}  // namespace

TEST_CASE("E4: the body force is the acceleration less that of the stress, by differences of the exact motion") {
    const Vortex exact;
    const double d = 1e-4, t = 0.37;
    for (const auto& X : {Vortex::Point{0.83, 0.41}, Vortex::Point{-0.3, 1.02}}) {
        const auto stress = [&](const Vortex::Point& at) {  // P = mu (F - F^-T), J = 1
            std::array<std::array<double, 2>, 2> F{};
            for (std::size_t b = 0; b < 2; ++b) {
                Vortex::Point up = at, down = at;
                up[b] += d, down[b] -= d;
                const auto high = exact.place(up, t), low = exact.place(down, t);
                for (std::size_t a = 0; a < 2; ++a) F[a][b] = (high[a] - low[a]) / (2 * d);
            }
            const double m = exact.mu();
            return std::array{std::array{m * (F[0][0] - F[1][1]), m * (F[0][1] + F[1][0])},
                              std::array{m * (F[1][0] + F[0][1]), m * (F[1][1] - F[0][0])}};
        };
        for (std::size_t a = 0; a < 2; ++a) {
            double divergence = 0;
            for (std::size_t b = 0; b < 2; ++b) {
                Vortex::Point up = X, down = X;
                up[b] += d, down[b] -= d;
                divergence += (stress(up)[a][b] - stress(down)[a][b]) / (2 * d);
            }
            const double acceleration =
                (exact.place(X, t + d)[a] - 2 * exact.place(X, t)[a] + exact.place(X, t - d)[a]) / (d * d);
            CHECK(exact.body_force(X, t)[a] ==
                  doctest::Approx(acceleration - divergence / exact.density).epsilon(1e-4));
        }
    }
}

TEST_CASE("E4: cubic splines with APIC converge while the ring is sheared over many cells") {
    const double coarse = turn(cubic_apic_usl, 16), fine = turn(cubic_apic_usl, 32);
    CHECK(fine <= 6e-3);
    CHECK(order(coarse, fine) >= 1.8);
}

TEST_CASE("E4: long refinement studies" * doctest::skip(!long_tests())) {
    for (const Choice& choice :
         {cubic_apic_usl, quadratic_apic_usl, contiguous_tpic_usl, contiguous_fmpm2, quadratic_fmpm2, gimp_flip_usl})
        for (int cells : {16, 32, 64}) turn(choice, cells);
    CHECK(turn(cubic_apic_usl, 64, 0.1) <= 2e-3);
}
