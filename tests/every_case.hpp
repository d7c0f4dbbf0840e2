#pragma once
// Precision and dimension of a templated test: 2-D and 3-D, float and double.

#include <doctest/doctest.h>

namespace moraine::test {

template <class R, int D>
struct Case {
    using Real = R;
    static constexpr int dim = D;
    static constexpr double tolerance = sizeof(R) == 8 ? 1e-12 : 1e-5;
};

}  // namespace moraine::test

TYPE_TO_STRING_AS("2-D float", moraine::test::Case<float, 2>);
TYPE_TO_STRING_AS("2-D double", moraine::test::Case<double, 2>);
TYPE_TO_STRING_AS("3-D float", moraine::test::Case<float, 3>);
TYPE_TO_STRING_AS("3-D double", moraine::test::Case<double, 3>);

#define EVERY_CASE                                                                                \
    moraine::test::Case<float, 2>, moraine::test::Case<double, 2>, moraine::test::Case<float, 3>, \
        moraine::test::Case<double, 3>
