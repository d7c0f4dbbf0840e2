#include <doctest/doctest.h>

#include <random>

#include "core/courant.hpp"
#include "core/fluid/find_pressures.hpp"
#include "core/fluid/grid_pressure.hpp"
#include "core/transfer/method.hpp"

using namespace moraine;

namespace {

constexpr double h = 0.25;

struct Point {
    double volume, f[3];
};

std::vector<Point> points(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(0, 1), volume(0.5, 1.5);
    std::vector<Point> all(5);
    for (Point& p : all) p = {volume(random), {place(random), place(random), place(random)}};
    return all;
}

/// Folded weights of one axis, as the transfers make them.
void weights_at(unsigned ghosts, double f, double* w, double* dw) {
    Quadratic::weights(f, 0.0, w, dw);
    fold_weights<3>(ghosts, w, dw);
}

template <int Dim>
void compare_with_sums(const unsigned* ghosts) {
    CellMoments<double, Dim> moments;
    moments.clear();
    CellBasis<double> basis[Dim];
    for (int a = 0; a < Dim; ++a) basis[a] = cell_basis<double>(ghosts[a]);
    const std::vector<Point> all = points(3);
    for (const Point& p : all) moments.add(p.volume, p.f);
    CellNode<double, Dim> found[power<Dim>(3)];
    all_cell_nodes(moments, basis, 1 / h, found);
    for (int n = 0; n < power<Dim>(3); ++n) {
        const int at[3] = {n % 3, n / 3 % 3, n / 9};
        double gradient[3] = {};
        for (const Point& p : all) {
            double w[3][3], dw[3][3];
            for (int a = 0; a < Dim; ++a) weights_at(ghosts[a], p.f[a], w[a], dw[a]);
            for (int b = 0; b < Dim; ++b) {
                double term = p.volume / h;
                for (int a = 0; a < Dim; ++a) term *= a == b ? dw[a][at[a]] : w[a][at[a]];
                gradient[b] += term;
            }
        }
        for (int b = 0; b < Dim; ++b) CHECK(std::fabs(found[n].gradient[b] - gradient[b]) < 1e-12 / h);
    }
}

Scene slurry(int substeps) {
    Scene scene;
    scene.cell = h;
    scene.cfl = 0.5;
    scene.substeps = substeps;
    return scene;
}

}  // namespace

TEST_CASE("moments say what the sums over particles say, also where walls fold the splines") {
    for (unsigned x : {0u, 1u, 2u << 1, 1u | 2u << 1})
        for (unsigned y : {0u, 2u << 1}) {
            CAPTURE(x);
            CAPTURE(y);
            const unsigned ghosts[3] = {x, y, x};
            compare_with_sums<2>(ghosts);
            compare_with_sums<3>(ghosts);
        }
}

TEST_CASE_TEMPLATE("a whole cell takes no force from a constant pressure and gives linear fields their divergence",
                   Real, float, double) {
    const double tolerance = sizeof(Real) == 8 ? 1e-14 : 1e-6;
    CellNode<Real, 3> node[27];
    whole_cell<Real, 3>(Real(1 / h), node);
    double force[3] = {}, slope[3][3] = {};
    for (int n = 0; n < 27; ++n) {
        const double x[3] = {h * (n % 3), h * (n / 3 % 3), h * (n / 9)};
        for (int b = 0; b < 3; ++b) force[b] += double(node[n].gradient[b]);
        for (int b = 0; b < 3; ++b)
            for (int a = 0; a < 3; ++a) slope[a][b] += double(node[n].gradient[b]) * x[a];
    }
    const double whole = h * h * h;
    for (int b = 0; b < 3; ++b) {
        CHECK(std::fabs(force[b]) < tolerance * h * h);
        for (int a = 0; a < 3; ++a) CHECK(std::fabs(slope[a][b] / whole - (a == b)) < tolerance);
    }
}

TEST_CASE("exact integrals come in between 80 and 95 % of filling") {
    CHECK(share_of_integral(0.5) == 0);
    CHECK(share_of_integral(0.875) == doctest::Approx(0.5));
    CHECK(share_of_integral(1.2) == 1);
}

TEST_CASE("the modulus falls with the square of the substep, and only where nodes are light") {
    const double free = bounded_bulk<2>(1e6, 0.1, 1e-6, 1e-3, 0.0);
    CHECK(free == 1e6);
    const double one = bounded_bulk<2>(1e6, 0.1, 10.0, 1e-3, 0.0), half = bounded_bulk<2>(1e6, 0.1, 10.0, 5e-4, 0.0);
    CHECK(one < 1e6);
    CHECK(half == doctest::Approx(4 * one));
    CHECK(bounded_bulk<2>(1e6, 0.1, 10.0, 1e-3, 0.5) == doctest::Approx(one / 2));
}

TEST_CASE_TEMPLATE("a cell whose modulus is bounded is loose, and bears its share of the pressure", Real, float,
                   double) {
    PressureFinder<Real, 2> finder{};
    finder.dt = 1e-3;
    for (bool light : {false, true}) {
        CAPTURE(light);
        CellPressure<Real> cell{};
        cell.volume = Real(0.1), cell.pressure = Real(-2000), cell.bulk = Real(1e6);
        finder.close_cell(zero_mat<Real, 2>(), light ? Real(10) : Real(1e-6), cell);
        CHECK(cell.loose == light);
        const double share = double(cell.bulk) / 1e6;
        CHECK((share < 0.2) == light);
        CHECK(double(cell.pressure) == doctest::Approx(-2000 * share));
        CHECK(borne_share(cell.loose ? cell.bulk : Real(0), Real(1e6)) == doctest::Approx(share));
    }
    static_assert(sizeof(CellPressure<double>) == 64);
}

TEST_CASE_TEMPLATE("hydrostatic pressures are the head of their cell, wherever its particles are", Real, float,
                   double) {
    PressureFinder<Real, 3> finder{};
    finder.context.stencil.inverse_cell = Real(1 / h);
    finder.context.stencil.gravity_slope = {Real(300), Real(0), Real(-2000)};  // rho g h [Pa]
    const int base[3] = {7, 3, 11};
    const double head = 50000;
    for (bool whole : {false, true}) {
        CAPTURE(whole);
        typename PressureFinder<Real, 3>::Found found{};
        found.cell.whole = whole;
        CellMoments<Real, 3> moments;
        moments.clear();
        for (int a = 0; a < 3; ++a) found.at.base[a] = base[a];
        for (const Point& p : points(3)) {
            const Real f[3] = {Real(p.f[0]), Real(p.f[1]), Real(p.f[2])}, volume = Real(p.volume);
            const Real pressure = Real(head) - gravity_pressure<Real, 3>(finder.context.stencil.gravity_slope, base, f);
            finder.add(volume, volume * pressure, volume * Real(1e6), f, found);
            moments.add(volume, f);
        }
        REQUIRE(finder.close_sums(found, moments));
        CHECK(double(found.cell.head) == doctest::Approx(head).epsilon(sizeof(Real) == 8 ? 1e-13 : 1e-6));
    }
}

TEST_CASE("particles of a soft cell count no more of their modulus than the cell bears") {
    CellPressure<double> cell{};
    cell.source = 100;
    CHECK(CellStep<double>::of(cell).modulus(400) == 400);
    cell.soft = true;
    CHECK(CellStep<double>::of(cell).modulus(400) == 100);
    CHECK(CellStep<double>::of(cell).modulus(50) == 50);
}

TEST_CASE("beyond zero pressure particles take of a loose cell what the grid bears") {
    CellPressure<double> cell{};
    cell.bulk = 100;
    const double borne = borne_share(cell.bulk, 400.0);
    CHECK(borne == 0.25);
    CHECK(borne_share(0.0, 400.0) == 1);
    CHECK(borne_share(100.0, 50.0) == 1);  // of two materials in a cell, the softer one
    const auto taken = [&](double start, double increment) {
        cell.increment = increment;
        cell.pressure = cell.bulk * (start + increment);
        return taken_increment(increment, increment_in_tension(cell), borne);
    };
    for (bool loose : {false, true}) {
        CAPTURE(loose);
        cell.loose = loose;
        CHECK(taken(-0.5, -0.25) == -0.25);
        CHECK(taken(-0.5, 0.25) == 0.25);
        CHECK(taken(-0.125, 0.625) == (loose ? 0.25 : 0.625));  // 0.125 to zero, a quarter of the rest
        CHECK(taken(0, 0.5) == (loose ? 0.125 : 0.5));
        CHECK(taken(0.5, 0.25) == (loose ? 0.0625 : 0.25));
        CHECK(taken(0.5, -0.25) == (loose ? -0.0625 : -0.25));
        CHECK(taken(0.125, -0.25) == -0.25);
    }
}

TEST_CASE_TEMPLATE("an isochoric increment keeps deviator and rotation, and takes the volume", Mat3, Mat<double, 3>,
                   Mat<double, 2>) {
    constexpr int Dim = std::is_same_v<Mat3, Mat<double, 2>> ? 2 : 3;
    Mat3 dL = zero_mat<double, Dim>();
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) dL(i, j) = 0.03 * (i + 1) - 0.11 * j + 0.02 * i * j;
    double cubic = 1;
    const auto whole = strain_increment(dL, 1.0), rest = strain_increment(increment_of_trace(dL, 0.0, cubic), 1.0);
    CHECK(std::fabs(rest.middle.trace()) < 1e-15);
    CHECK(rest.volumetric == doctest::Approx(cubic).epsilon(1e-9));
    for (int i = 0; i < Dim; ++i)
        for (int j = 0; j < Dim; ++j) CHECK(rest.rotation(i, j) == doctest::Approx(whole.rotation(i, j)));
    CHECK(rest.middle[0] - rest.middle[1] == doctest::Approx(whole.middle[0] - whole.middle[1]));
    CHECK(rest.middle[3] == doctest::Approx(whole.middle[3]));
}

TEST_CASE("a step takes as many substeps as the flow's own speed allows") {
    const double signal = 75, shear = 0.1, wave = 0.5 * h / signal;
    const StepChoice plain = choose_step(slurry(1), signal, 0, shear);
    CHECK(plain.substeps == 1);
    CHECK(plain.dt == wave);
    const StepChoice most = choose_step(slurry(10), signal, 0, shear);  // 10 by the shear wave
    CHECK(most.substeps == 10);
    CHECK(most.dt == doctest::Approx(10 * wave));
    const StepChoice fast = choose_step(slurry(10), signal, 15, shear);  // 6 + 15 m/s
    CHECK(fast.substeps == 4);
    CHECK(fast.dt == doctest::Approx(0.5 * h / 21));
    const StepChoice supersonic = choose_step(slurry(10), signal, 74, shear);
    CHECK(supersonic.dt == doctest::Approx(wave).epsilon(0.02));
    CHECK(choose_step(slurry(4), signal, 0, shear).substeps == 4);
}
