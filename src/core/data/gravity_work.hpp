#pragma once
// The work of gravity that changes (core/gravity.hpp): what a particle's potential energy gains, -m (g' - g) .
// (x - domain.min) [J]. Products are rounded, so that exact sums are the same wherever they are made.

#include <cstdint>

#include "core/data/plan_samples.hpp"
#include "core/data/rounded_product.hpp"
#include "core/data/vec.hpp"

namespace moraine {

/// change: g' - g [m/s2]; the particle is in block `at`, at `u` in it, and has mass m [kg]. u(axis).
template <class Real, int Dim, class Place>
MORAINE_HD double gravity_work(const PlanPlaces& places, const double (&change)[Dim], const Vec<std::int32_t, Dim>& at,
                               const Place& u, double m) {
    double sum = 0;
    for (int a = 0; a < Dim; ++a) sum += rounded_product(change[a], places.of<Real>(a, at[a], u(a)) - places.origin[a]);
    return -rounded_product(m, sum);
}

}  // namespace moraine
