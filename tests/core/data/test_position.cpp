#include <doctest/doctest.h>

#include <random>

#include "core/data/position.hpp"

using namespace moraine;

namespace {

/// Block and place as one integer, in units of the fraction.
template <class Real>
__int128 whole(std::int64_t block, Coordinate<Real> u) {
    return static_cast<__int128>(block) * 4 * static_cast<__int128>(one_cell<Real>) + static_cast<__int128>(u);
}

}  // namespace

TEST_CASE_TEMPLATE("a particle that passes a face of its block carries into the next one", Real, float, double) {
    Coordinate<Real> u = 3 * one_cell<Real> + one_cell<Real> / 4 * 3;
    CHECK(advance<Real>(u, Real(0.5)) == 1);
    CHECK(cell_of<Real>(u) == 0);
    CHECK(fraction_of<Real>(u) == Real(0.25));
    CHECK(advance<Real>(u, Real(-0.5)) == -1);
    CHECK(cell_of<Real>(u) == 3);
    CHECK(fraction_of<Real>(u) == Real(0.75));
    CHECK(advance<Real>(u, Real(-0.875)) == 0);
    CHECK(cell_of<Real>(u) == 2);
    CHECK(fraction_of<Real>(u) == Real(0.875));
}

TEST_CASE_TEMPLATE("the lower face of a block belongs to it and the upper one does not", Real, float, double) {
    Coordinate<Real> u = one_cell<Real>;
    CHECK(advance<Real>(u, Real(-0.5)) == 0);
    CHECK(advance<Real>(u, Real(-0.5)) == 0);
    CHECK(u == 0);
    CHECK(advance<Real>(u, Real(0)) == 0);
    u = static_cast<Coordinate<Real>>(3 * one_cell<Real> + one_cell<Real> / 2);
    CHECK(advance<Real>(u, Real(0.5)) == 1);
    CHECK(u == 0);
}

TEST_CASE_TEMPLATE("place and local_of are inverses wherever the fraction can say it", Real, float, double) {
    std::mt19937_64 random(1);
    for (int k = 0; k < 10000; ++k) {
        const double local =
            static_cast<double>(static_cast<std::int64_t>(random() % (1u << 28)) - (1 << 27)) / (1 << 20);
        const Place<Real> at = place<Real>(local);
        REQUIRE(local_of<Real>(at.block, at.u) == local);
        REQUIRE(4 * at.block + cell_of<Real>(at.u) == static_cast<int>(std::floor(local)));
        REQUIRE(static_cast<double>(fraction_of<Real>(at.u)) == local - std::floor(local));
    }
}

TEST_CASE_TEMPLATE("a place is rounded to the nearest fraction and the upper face goes to the next block", Real, float,
                   double) {
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> anywhere(-1000, 1000);
    for (int k = 0; k < 10000; ++k) {
        const double local = anywhere(random);
        const Place<Real> at = place<Real>(local);
        REQUIRE(std::fabs(local_of<Real>(at.block, at.u) - local) <= 0.5 / double(one_cell<Real>) + 2.3e-13);
    }
    const Place<Real> edge = place<Real>(4 - (sizeof(Real) == 4 ? 1e-11 : 0));
    CHECK(edge.block == 1);
    CHECK(edge.u == 0);
}

TEST_CASE_TEMPLATE("the smallest displacement that the fraction can say is never lost", Real, float, double) {
    const int n = 100000;
    const Real smallest = Real(1) / Real(one_cell<Real>);
    Coordinate<Real> u = 2 * one_cell<Real> + 12345;
    const Coordinate<Real> start = u;
    for (int k = 0; k < n; ++k) REQUIRE(advance<Real>(u, smallest) == 0);
    CHECK(u - start == Coordinate<Real>(n));
    for (int k = 0; k < n; ++k) REQUIRE(advance<Real>(u, -smallest) == 0);
    CHECK(u == start);
}

TEST_CASE("a billionth of a cell per step moves a double by a billionth of a cell per step") {
    Coordinate<double> u = 3 * one_cell<double> + one_cell<double> / 2;
    const Coordinate<double> start = u;
    for (int k = 0; k < 1000000; ++k) advance<double>(u, 1e-9);
    CHECK(static_cast<double>(u - start) / double(one_cell<double>) == doctest::Approx(1e-3).epsilon(1e-9));
}

TEST_CASE_TEMPLATE("a million random moves never lose the block", Real, float, double) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> step(-0.999, 0.999);
    std::int64_t block = 0;
    Coordinate<Real> u = one_cell<Real> / 3;
    const __int128 start = whole<Real>(block, u);
    __int128 sum = 0;
    long double walked = 0;
    for (int k = 0; k < 1000000; ++k) {
        const Real cells = static_cast<Real>(k % 3 == 0 ? step(random) * 1e-6 : step(random));
        block += advance<Real>(u, cells);
        sum +=
            static_cast<__int128>(llrintl(static_cast<long double>(cells) * static_cast<long double>(one_cell<Real>)));
        walked += static_cast<long double>(cells);
    }
    CHECK((whole<Real>(block, u) - start == sum));
    const long double moved = static_cast<long double>(whole<Real>(block, u) - start) / one_cell<Real>;
    CHECK(std::fabs(static_cast<double>(moved - walked)) <= 0.5e6 / double(one_cell<Real>) + 1e-12);
}
