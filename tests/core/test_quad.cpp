#include <doctest/doctest.h>

#include <random>

#include "core/quad.hpp"

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
