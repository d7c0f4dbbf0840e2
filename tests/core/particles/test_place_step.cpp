#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/particles/place_step.hpp"

using namespace moraine;

namespace {

/// A domain of 10 cells per axis, from 0 to 10, of stencils of three nodes: places are binned half a cell higher.
template <class Real>
DomainEnds<Real, 2> ends_of(bool still, bool open = false) {
    DomainEnds<Real, 2> ends{};
    for (int a = 0; a < 2; ++a)
        for (int s = 0; s < 2; ++s) {
            ends.cell[a][s] = 10 * s;
            ends.fraction[a][s] = Real(0.5);
            ends.open[a][s] = open;
            ends.still[a][s] = still;
        }
    return ends;
}

template <class Real>
struct Particle {
    Vec<std::int32_t, 2> block;
    Vec<Coordinate<Real>, 2> u;
    PlaceStep<Real> step{};

    Particle(double x, double y) {
        const double at[2] = {x, y};
        for (int a = 0; a < 2; ++a) {
            const Place<Real> p = place<Real>(at[a] + 0.5);
            block[a] = p.block, u[a] = p.u;
        }
    }
    void move(const DomainEnds<Real, 2>& ends, double x, double y) {
        const Vec<Real, 2> velocity{{Real(x), Real(y)}};
        step = advance_place(ends, block, true, velocity, Real(1), Real(1), u);
        const int code = move_code(step.move);
        if (code == Block<2>::gone) return;
        block[0] += code % 3 - 1, block[1] += code / 3 - 1;
    }
    double x(int a) const { return local_of<Real>(block[a], u[a]) - 0.5; }
};

}  // namespace

TEST_CASE_TEMPLATE("a step that would cross a folded wall ends half way there", Real, float, double) {
    const DomainEnds<Real, 2> ends = ends_of<Real>(true);
    for (double way : {0.02, 0.3, 0.99}) {
        Particle<Real> low(0.01, 5), high(5, 9.99);
        low.move(ends, -way, 0.25);
        high.move(ends, 0.25, way);
        CHECK(low.step.faults == fault_none);
        CHECK(low.x(0) == doctest::Approx(0.005).epsilon(1e-5));
        CHECK(low.x(1) == doctest::Approx(5.25));
        CHECK(high.x(1) == doctest::Approx(9.995).epsilon(1e-6));
        CHECK(high.x(0) == doctest::Approx(5.25));
        CHECK(low.step.moved == doctest::Approx(std::max(way, 0.25)));
    }
}

TEST_CASE_TEMPLATE("no motion brings a particle nearer to a folded wall than the least height", Real, float, double) {
    const DomainEnds<Real, 2> ends = ends_of<Real>(true);
    const double least = double(least_height<Real>);
    Particle<Real> particle(0.01, 5);
    for (int k = 0; k < 100; ++k) particle.move(ends, -0.7 * particle.x(0), 0);
    CHECK(particle.x(0) / least == doctest::Approx(1).epsilon(1e-2));
    particle.move(ends, 0.1 * least, 0);  // away from it
    CHECK(particle.x(0) / least == doctest::Approx(1.1).epsilon(1e-2));
    Particle<Real> low(0.1 * least, 5);  // where it began
    low.move(ends, -0.05 * least, 0.25);
    CHECK(low.x(0) / least == doctest::Approx(0.1).epsilon(1e-2));
    CHECK(low.x(1) == doctest::Approx(5.25));
    CHECK(low.step.faults == fault_none);
}

TEST_CASE_TEMPLATE("where the wall is not folded the run ends, and through an open face the particle is gone", Real,
                   float, double) {
    Particle<Real> kept(0.01, 5), gone(0.01, 5);
    kept.move(ends_of<Real>(false), -0.3, 0);
    CHECK(kept.step.faults == fault_left);
    CHECK(kept.x(0) == doctest::Approx(0.01));
    gone.move(ends_of<Real>(false, true), -0.3, 0);
    CHECK(move_code(gone.step.move) == Block<2>::gone);
}

TEST_CASE_TEMPLATE("near folded walls no step leaves the domain, and one that stays within is as without them", Real,
                   float, double) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> share(0, 1);
    const auto near = [&] {
        const double hair = std::pow(10, -10 * share(random));
        return share(random) < 0.5 ? hair : 10 - hair;
    };
    int crossing = 0;
    for (int n = 0; n < 20000; ++n) {
        Particle<Real> still(near(), near()), plain = still;
        const double way[2] = {1.98 * share(random) - 0.99, 1.98 * share(random) - 0.99};
        still.move(ends_of<Real>(true), way[0], way[1]);
        plain.move(ends_of<Real>(false), way[0], way[1]);
        CHECK(still.step.faults == fault_none);
        bool too_near = false;
        for (int a = 0; a < 2; ++a) {
            CHECK((still.x(a) >= 0 && still.x(a) <= 10));
            too_near = too_near || std::min(plain.x(a), 10 - plain.x(a)) < double(least_height<Real>);
        }
        if (plain.step.faults)
            ++crossing;
        else if (!too_near)
            CHECK((still.x(0) == plain.x(0) && still.x(1) == plain.x(1) && still.step.move == plain.step.move));
    }
    CHECK(crossing > 5000);
    CHECK(crossing < 19000);
}
