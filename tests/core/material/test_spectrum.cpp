#include <random>

#include "core/material/drive.hpp"
#include "core/material/spectrum.hpp"

using namespace moraine;
using namespace moraine::testing;

namespace {

/// Taking every principal value away must leave nothing.
template <class C>
double left_over(const typename C::Strain& s) {
    using Real = typename C::Real;
    const Spectrum<Real, C::dim> spectrum(s);
    Real change[3];
    for (int k = 0; k < 3; ++k) change[k] = -spectrum.value[k];
    typename C::Strain rest = s;
    spectrum.add(rest, change);
    double largest = 0;
    for (int k = 0; k < C::Strain::size; ++k) largest = std::max(largest, std::fabs(double(rest[k])));
    return largest;
}

}  // namespace

TEST_CASE_TEMPLATE("principal values and directions give the tensor back", C, EVERY_CASE) {
    using Real = typename C::Real;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const double rounding = sizeof(Real) == 8 ? 1e-14 : 1e-5;
    for (int n = 0; n < 1000; ++n) {
        typename C::Strain s;
        for (int k = 0; k < C::Strain::size; ++k) s[k] = Real(uniform(random) * std::pow(10, -3 * (n % 3) * (k % 2)));
        CHECK(left_over<C>(s) <= rounding);
        const Spectrum<Real, C::dim> spectrum(s);
        CHECK(double(spectrum.value[0] + spectrum.value[1] + spectrum.value[2]) == near(double(s.trace()), rounding));
    }
}

TEST_CASE_TEMPLATE("equal principal values and zero are no trouble", C, EVERY_CASE) {
    using Real = typename C::Real;
    typename C::Strain s = zero_sym<Real, C::dim>();
    CHECK(left_over<C>(s) == 0);
    for (int k = 0; k < 3; ++k) s[k] = Real(7);
    CHECK(left_over<C>(s) == 0);
    s[3] = Real(1e-20);
    CHECK(left_over<C>(s) <= 1e-6);
    s[0] = s[1] = Real(1), s[2] = Real(2), s[3] = Real(1);  // 0, 2, 2
    const Spectrum<Real, C::dim> spectrum(s);
    const Ordered<Real> sorted(spectrum.value);
    const double rounding = sizeof(Real) == 8 ? 1e-15 : 1e-6;
    CHECK(double(sorted.first) == near(2, rounding));
    CHECK(double(sorted.second) == near(2, rounding));
    CHECK(std::fabs(double(sorted.third)) <= rounding);
    CHECK(left_over<C>(s) <= rounding);
}

TEST_CASE("three numbers are put in order, whatever their order") {
    const double ways[6][3] = {{1, 2, 3}, {1, 3, 2}, {2, 1, 3}, {2, 3, 1}, {3, 1, 2}, {3, 2, 1}};
    for (const auto& way : ways) {
        const Ordered<double> o(way);
        CHECK(o.first == 3);
        CHECK(o.second == 2);
        CHECK(o.third == 1);
    }
    const double tie[3] = {2, 1, 2};
    const Ordered<double> o(tie);
    CHECK(o.second == 2);
    CHECK(o.third == 1);
}
