#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "core/data/exact_sum.hpp"

using namespace moraine;

namespace {

__int128 quanta_of(const ExactSum& s) {
    return static_cast<__int128>(static_cast<unsigned __int128>(static_cast<std::uint64_t>(s.high)) << 64 | s.low);
}

/// The nearest whole number of quanta; exact, because scaling is by a power of two.
__int128 rounded(double value, const Quantum& quantum) {
    const double quanta = value * quantum.scale;
    return std::fabs(quanta) < 4e15 ? static_cast<__int128>(std::llround(quanta)) : static_cast<__int128>(quanta);
}

/// Terms of both signs from 1e-40 to `largest`.
std::vector<double> wild_terms(int n, double largest, unsigned seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> magnitude(-40, std::log10(largest)), sign(-1, 1);
    std::vector<double> terms;
    for (int k = 0; k < n; ++k) terms.push_back(std::copysign(std::pow(10.0, magnitude(random)), sign(random)));
    return terms;
}

ExactSum sum_of(const std::vector<double>& terms, const Quantum& quantum) {
    ExactSum sum;
    for (double t : terms) sum.add(quantum.of(t));
    return sum;
}

}  // namespace

TEST_CASE("a sum of wild terms does not depend on their order or grouping") {
    std::vector<double> terms = wild_terms(100000, 1000, 1);
    const Quantum quantum = Quantum::for_largest(1000);
    const ExactSum first = sum_of(terms, quantum);
    std::mt19937_64 random(2);
    for (int k = 0; k < 5; ++k) {
        std::shuffle(terms.begin(), terms.end(), random);
        ExactSum grouped;
        std::size_t at = 0;
        while (at < terms.size()) {
            const std::size_t n = std::min<std::size_t>(1 + random() % 1000, terms.size() - at);
            const auto from = terms.begin() + static_cast<std::ptrdiff_t>(at);
            grouped.add(sum_of({from, from + static_cast<std::ptrdiff_t>(n)}, quantum));
            at += n;
        }
        CHECK(grouped.high == first.high);
        CHECK(grouped.low == first.low);
    }
}

TEST_CASE("each term is rounded to the nearest quantum, whatever its sign") {
    const Quantum quantum = Quantum::for_largest(1000);
    double worst = 0;
    for (double t : wild_terms(100000, 1000, 3)) {
        const __int128 off = quanta_of(quantum.of(t)) - rounded(t, quantum);
        worst = std::max(worst, std::fabs(static_cast<double>(off)));
    }
    CHECK(worst <= 1);
}

TEST_CASE("a term and its negative cancel to the last quantum") {
    const Quantum quantum = Quantum::for_largest(1);
    const double one = 1 / quantum.scale;
    for (double t : {1.0, 1e-3, 1.0 / 3, 0x1p-40, 1e-20, 1e-25, 1024 * one, 7 * one, one}) {
        CAPTURE(t);
        ExactSum sum = quantum.of(t);
        CHECK(quantum.value(sum) == doctest::Approx(t).epsilon(1e-9));
        sum.add(quantum.of(-t));
        CHECK(std::fabs(quantum.value(sum)) <= one);
    }
}

TEST_CASE("a small negative term has a small negative value") {
    const Quantum quantum = Quantum::for_largest(1);
    const double one = 1 / quantum.scale;
    for (double n : {1.0, 2.0, 3.0, 1000.0, 1024.0, 1025.0, 4097.0, 1e9}) {
        CAPTURE(n);
        CHECK(quanta_of(quantum.of(-n * one)) == -static_cast<std::int64_t>(n));
    }
    CHECK(quanta_of(quantum.of(-0.25 * one)) == 0);
}

TEST_CASE("the value of a sum is that of the exact sum of its rounded terms") {
    const std::vector<double> terms = wild_terms(100000, 1e6, 4);
    const Quantum quantum = Quantum::for_largest(1e6);
    __int128 exact = 0;
    for (double t : terms) exact += rounded(t, quantum);
    const double expected = static_cast<double>(exact) / quantum.scale;
    const double bound = 1e-15 * std::fabs(expected) + 2e5 / quantum.scale;
    CHECK(std::fabs(quantum.value(sum_of(terms, quantum)) - expected) <= bound);
}

TEST_CASE("a term of the scale keeps all its bits, and so does one of 1e-13 of it") {
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> near(0.5, 1);
    for (double scale : {1e-6, 1.0, 3.7e12}) {
        const Quantum quantum = Quantum::for_largest(scale);
        for (int k = 0; k < 1000; ++k) {
            const double t = scale * near(random);
            REQUIRE(quantum.value(quantum.of(t)) == t);
            REQUIRE(quantum.value(quantum.of(-t)) == -t);
            REQUIRE(quantum.value(quantum.of(2e-13 * t)) == 2e-13 * t);
            REQUIRE(quantum.value(quantum.of(-2e-13 * t)) == -2e-13 * t);
        }
    }
}

TEST_CASE("a thousand million terms of the scale fit") {
    const Quantum quantum = Quantum::for_largest(0.999);
    for (double sign : {1.0, -1.0}) {
        ExactSum sum = quantum.of(sign * 0.999);
        for (int k = 0; k < 30; ++k) sum.add(ExactSum{sum});
        CHECK(quantum.value(sum) == sign * 0.999 * 1073741824.0);
    }
}

TEST_CASE("what is not a number, or more than fits, adds nothing") {
    const Quantum quantum = Quantum::for_largest(1);
    for (double t : {std::nan(""), HUGE_VAL, -HUGE_VAL, 1e30, -1e30}) {
        CHECK(quantum.of(t).high == 0);
        CHECK(quantum.of(t).low == 0);
    }
}
