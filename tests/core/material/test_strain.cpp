#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "core/material/strain.hpp"

using namespace moraine;

// Problem E8 of the verification list: objectivity of the incremental form.

namespace {

/// A turn by `angle` [rad] about z, or in space about the axis (1, 2, 2) / 3 (Rodrigues).
template <int Dim>
Mat<double, Dim> turn(double angle) {
    const double axis[3] = {Dim == 2 ? 0 : 1.0 / 3, Dim == 2 ? 0 : 2.0 / 3, Dim == 2 ? 1 : 2.0 / 3};
    const double c = std::cos(angle), s = std::sin(angle);
    const double cross[3][3] = {{0, -axis[2], axis[1]}, {axis[2], 0, -axis[0]}, {-axis[1], axis[0], 0}};
    Mat<double, Dim> r;
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) r(i, j) = (i == j ? c : 0) + s * cross[i][j] + (1 - c) * axis[i] * axis[j];
    return r;
}

template <int Dim>
Mat<double, Dim> minus_identity(Mat<double, Dim> m) {
    for (int i = 0; i < Dim; ++i) m(i, i) -= 1;
    return m;
}

template <int Dim>
double largest(const Sym<double, Dim>& a, const Sym<double, Dim>& b) {
    double d = 0;
    for (int k = 0; k < Sym<double, Dim>::size; ++k) d = std::fmax(d, std::fabs(a[k] - b[k]));
    return d;
}

template <int Dim>
void turns_stress_with_body(double per_step) {
    CAPTURE(per_step);
    Sym<double, Dim> first;
    for (int k = 0; k < Sym<double, Dim>::size; ++k) first[k] = 0.3 + 0.2 * k - 0.1 * k * k;
    const double turns = 10 * 2 * std::acos(-1.0);
    const int steps = int(std::ceil(turns / per_step));
    const Mat<double, Dim> r = turn<Dim>(turns / steps);
    Sym<double, Dim> stress = first;
    Mat<double, Dim> whole = identity<double, Dim>();
    double strain = 0;
    for (int n = 0; n < steps; ++n) {
        const StrainIncrement<double, Dim> s = strain_increment(minus_identity(r), 1.0);
        stress = rotated(stress, s.rotation);
        whole = r * whole;
        strain = std::fmax(strain, largest(s.strain, zero_sym<double, Dim>()));
        if (n % 37 == 0) CHECK(largest(stress, rotated(first, whole)) <= 1e-12);
        CHECK(std::fabs(s.volumetric) <= 1e-15);
        CHECK(std::fabs(s.stretch - 1) <= 1e-15);
    }
    CHECK(largest(stress, first) <= 1e-12);
    CHECK(strain <= 1e-16);
}

/// Stress / G after simple shear by gamma in n steps of linear hypoelasticity (no volume change: G only).
template <int Dim>
Sym<double, Dim> sheared(double gamma, int n) {
    Mat<double, Dim> dL = zero_mat<double, Dim>();
    dL(0, 1) = gamma / n;  // v_x = rate y: the gradient is the same in the deformed body
    Sym<double, Dim> stress = zero_sym<double, Dim>();
    for (int i = 0; i < n; ++i) {
        const StrainIncrement<double, Dim> s = strain_increment(dL, 1.0);
        stress = rotated(stress, s.rotation);
        for (int k = 0; k < Sym<double, Dim>::size; ++k) stress[k] += 2 * s.strain[k];
    }
    return stress;
}

template <int Dim>
double shear_error(double gamma, int n) {
    const Sym<double, Dim> s = sheared<Dim>(gamma, n);
    Sym<double, Dim> exact = zero_sym<double, Dim>();
    exact[0] = 1 - std::cos(gamma), exact[1] = -exact[0], exact[3] = std::sin(gamma);
    return largest(s, exact);
}

template <int Dim>
Mat<double, Dim> random_gradient(std::mt19937& random, double size) {
    std::uniform_real_distribution<double> uniform(-size, size);
    Mat<double, Dim> m;
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) m(i, j) = uniform(random);
    return m;
}

}  // namespace

TEST_CASE("E8a: ten rigid turns turn the stress with the body to 1e-12 and strain nothing") {
    for (double per_step : {0.1, 0.05, 0.0123}) {
        turns_stress_with_body<2>(per_step);
        turns_stress_with_body<3>(per_step);
    }
}

TEST_CASE("E8b: simple shear follows G sin(gamma), G (1 - cos gamma), in second order") {
    CHECK(shear_error<2>(4, 4000) <= 1e-6);
    CHECK(shear_error<3>(4, 4000) <= 1e-6);
    const double order = std::log2(shear_error<3>(4, 100) / shear_error<3>(4, 200));
    CHECK(order == doctest::Approx(2).epsilon(0.01));
}

TEST_CASE("mean stress times mid-step strain is the work, in second order") {
    double error[2];
    for (int level = 0; level < 2; ++level) {
        const int n = 100 << level;
        Mat<double, 3> dL = zero_mat<double, 3>();
        dL(0, 1) = 1.0 / n, dL(1, 0) = -0.5 / n, dL(2, 0) = 0.3 / n;
        Sym<double, 3> stress = zero_sym<double, 3>();
        double work = 0, energy = 0;
        for (int i = 0; i < n; ++i) {
            const StrainIncrement<double, 3> s = strain_increment(dL, 1.0);
            const Sym<double, 3> before = stress;
            stress = rotated(stress, s.rotation);
            for (int k = 0; k < 6; ++k) {
                stress[k] += 2 * s.strain[k];
                work += (k < 3 ? 0.5 : 1.0) * (before[k] + stress[k]) * s.middle[k];
            }
        }
        for (int k = 0; k < 6; ++k) energy += (k < 3 ? 0.25 : 0.5) * stress[k] * stress[k];  // G = 1
        error[level] = std::fabs(work - energy);
    }
    CHECK(error[0] <= 1e-4);
    CHECK(error[0] / error[1] == doctest::Approx(4).epsilon(0.05));
}

TEST_CASE("E8c: a closed square of stretch and shear leaves a small residual stress, as hypoelasticity does") {
    // Stretch by a, shear by a, unstretch, unshear: F returns to I. The residual is of order a^3 here.
    double residual[2];
    for (int level = 0; level < 2; ++level) {
        const double a = 0.1 / (1 << level);
        const int n = 2000;
        Sym<double, 2> stress = zero_sym<double, 2>();
        Mat<double, 2> f = identity<double, 2>();
        const double corners[5][2] = {{0, 0}, {a, 0}, {a, a}, {0, a}, {0, 0}};  // (F_xx - 1, F_xy)
        for (int side = 0; side < 4; ++side)
            for (int i = 0; i < n; ++i) {
                Mat<double, 2> step = zero_mat<double, 2>();
                step(0, 0) = (corners[side + 1][0] - corners[side][0]) / n;
                step(0, 1) = (corners[side + 1][1] - corners[side][1]) / n;
                const StrainIncrement<double, 2> s = strain_increment(step * inverse(f), 1.0);
                stress = rotated(stress, s.rotation);
                for (int k = 0; k < 4; ++k) stress[k] += 2 * s.strain[k] + (k < 3 ? 1.0 * s.strain.trace() : 0);
                for (int k = 0; k < 2; ++k) f(0, k) += step(0, k);
            }
        residual[level] = largest(stress, zero_sym<double, 2>());
    }
    MESSAGE("residual stress / G after a closed cycle of strain 0.1: ", residual[0]);
    CHECK(residual[0] <= 2e-2);
    CHECK(residual[1] <= 0.5 * residual[0]);
}

TEST_CASE("the closed form of the rotation is Hughes and Winget's, and orthogonal") {
    std::mt19937 random(7);
    for (int n = 0; n < 200; ++n) {
        const Mat<double, 3> H = random_gradient<3>(random, 1.5);
        const Mat<double, 3> q = cayley_rotation(H, 1.0);
        Mat<double, 3> plus = identity<double, 3>(), minus = plus;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                plus(i, j) += 0.25 * (H(i, j) - H(j, i));
                minus(i, j) -= 0.25 * (H(i, j) - H(j, i));
            }
        const Mat<double, 3> expected = inverse(minus) * plus;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                CHECK(std::fabs(q(i, j) - expected(i, j)) <= 1e-14);
                double product = 0;
                for (int k = 0; k < 3; ++k) product += q(i, k) * q(j, k);
                CHECK(std::fabs(product - (i == j)) <= 1e-15 * 4);
            }
        const Mat<double, 2> p = cayley_rotation(Mat<double, 2>{{{0, -H(1, 0)}, {H(1, 0), 0}}}, 1.0);
        CHECK(std::atan2(p(1, 0), p(0, 0)) == doctest::Approx(2 * std::atan(H(1, 0) / 2)).epsilon(1e-14));
    }
}

TEST_CASE("the volumetric increment is the change of ln J to fifth order") {
    std::mt19937 random(11);
    for (int n = 0; n < 100; ++n) {
        const double size = 0.02;
        const auto solid = strain_increment(random_gradient<3>(random, size), 1.0);
        const auto plane = strain_increment(random_gradient<2>(random, size), 1.0);
        CHECK(std::fabs(solid.volumetric - std::log(solid.stretch)) <= 10 * std::pow(size, 5));
        CHECK(std::fabs(plane.volumetric - std::log(plane.stretch)) <= 10 * std::pow(size, 5));
    }
}
