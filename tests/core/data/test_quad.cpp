#include <doctest/doctest.h>

#include <cstring>
#include <limits>
#include <random>
#include <type_traits>

#include "core/data/quad_pair.hpp"

using namespace moraine;

namespace {

/// Numbers of all magnitudes and signs.
template <class Real>
Real wild(std::mt19937_64& random) {
    std::uniform_real_distribution<double> mantissa(-1, 1);
    return static_cast<Real>(std::ldexp(mantissa(random), static_cast<int>(random() % 60) - 30));
}

template <class Real>
Quad<Real> wild_quad(std::mt19937_64& random) {
    return Quad<Real>::of(wild<Real>(random), wild<Real>(random), wild<Real>(random), wild<Real>(random));
}

}  // namespace

TEST_CASE_TEMPLATE("each lane of the fused multiply-add is the ordinary one, to the bit", Real, float, double) {
    std::mt19937_64 random(1);
    for (int n = 0; n < 10000; ++n) {
        const Real s = wild<Real>(random);
        const Quad<Real> a = wild_quad<Real>(random);
        Quad<Real> b = wild_quad<Real>(random);
        if (n % 2) b[0] = -(s * a[0]);  // what is left is the rounding: only a fused one has it
        const Quad<Real> r = fma(s, a, b);
        for (int i = 0; i < quad; ++i) REQUIRE(r[i] == std::fma(s, a[i], b[i]));
    }
}

TEST_CASE_TEMPLATE("sums and products of quads are those of their lanes", Real, float, double) {
    std::mt19937_64 random(2);
    for (int n = 0; n < 1000; ++n) {
        const Real s = wild<Real>(random);
        const Quad<Real> a = wild_quad<Real>(random);
        const Quad<Real> b = wild_quad<Real>(random);
        for (int i = 0; i < quad; ++i) {
            REQUIRE((a + b)[i] == a[i] + b[i]);
            REQUIRE((s * a)[i] == s * a[i]);
            REQUIRE(Quad<Real>::all(s)[i] == s);
            REQUIRE(Quad<Real>::zero()[i] == 0);
        }
    }
}

TEST_CASE_TEMPLATE("a quad is loaded from and stored to any place of memory", Real, float, double) {
    Real memory[12];
    for (int i = 0; i < 12; ++i) memory[i] = Real(i);
    for (int from = 0; from < 4; ++from) {
        Real to[12] = {};
        Quad<Real>::load(memory + from).store(to + 3 - from);
        for (int i = 0; i < 12; ++i) {
            const int k = i - (3 - from);
            CHECK(to[i] == (k >= 0 && k < quad ? Real(from + k) : Real(0)));
        }
    }
}

TEST_CASE_TEMPLATE("what is done to one quad of a pair leaves the other, in one register as in two", Real, float,
                   double) {
    std::mt19937_64 random(5);
    const auto check = [&]<bool InOne>(std::bool_constant<InOne>) {
        using Pair = QuadPair<Real, InOne>;
        using Factors = typename Pair::Factors;
        const Real infinite = std::numeric_limits<Real>::infinity();
        const Quad<Real> a = Quad<Real>::of(Real(-0.0), infinite, Real(1), Real(-0.0)), b = wild_quad<Real>(random);
        const Quad<Real> c = wild_quad<Real>(random), d = Quad<Real>::all(infinite);
        const Real s = wild<Real>(random);
        const auto number = Factors::each([&](int) { return s; });
        const auto is = [](const Pair& found, const Quad<Real>& first, const Quad<Real>& second) {
            Real memory[2 * quad];
            found.store(memory);
            return std::memcmp(memory, &first, sizeof(first)) == 0 &&
                   std::memcmp(memory + quad, &second, sizeof(second)) == 0;
        };
        CHECK(is(Pair::of(a, b).second_plus(number, Pair::of(d, c)), a, fma(s, c, b)));
        CHECK(is(Pair::of(b, a).first_plus(number, Pair::of(c, d)), fma(s, c, b), a));
        CHECK(is(Pair::of(b, a).first_plus(Pair::of(c, d)), b + c, a));
        CHECK(is(Pair::of(b, c).plus(number, Pair::of(c, b)), fma(s, c, b), fma(s, b, c)));
        CHECK(is(Pair::of(b, c).times(number, Factors::each([](int) { return Real(3); })), s * b, Real(3) * c));
    };
    check(std::false_type{});
    check(std::bool_constant<2 * quad* int(sizeof(Real)) <= register_bytes>{});
}
