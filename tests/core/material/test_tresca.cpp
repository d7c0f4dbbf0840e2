#include <random>

#include "core/material/drive.hpp"
#include "core/material/tresca.hpp"

using namespace moraine;
using namespace moraine::testing;

namespace {
constexpr double su = 500, young = 500 * su, poisson = 0.49;
constexpr double G = young / (2 * (1 + poisson)), K = young / (3 * (1 - 2 * poisson));

template <class Real>
Tresca<Real> clay() {
    return make_law<Tresca<Real>>({{"young", young}, {"poisson", poisson}, {"su", su}});
}

/// A turn of the axes: about z in the plane, about a skew axis in space.
template <class C>
Mat<typename C::Real, C::dim> turned_axes() {
    Mat<typename C::Real, C::dim> spin = zero_mat<typename C::Real, C::dim>();
    const double axial[3] = {-0.7, 0.4, 1.1};
    for (int i = 0; i < C::dim; ++i) {
        const int j = (i + 1) % C::dim;
        const int axis = C::dim == 2 ? 2 : 3 - i - j;
        spin(i, j) = typename C::Real(-axial[axis]);
        spin(j, i) = typename C::Real(axial[axis]);
    }
    return cayley_rotation(spin, typename C::Real(1));
}
}  // namespace

TEST_CASE_TEMPLATE("simple shear is elastic to tau = su and stays there", C, EVERY_CASE) {
    const auto law = clay<typename C::Real>();
    auto state = virgin_state<C>();
    const double yield = su / G;
    strain_path<C>(law, state, plane_strain<C>(0, 0, yield / 100), 1, 99);
    CHECK(double(state.stress[3]) == near(0.99 * su, C::tolerance));
    CHECK(double(state.history[0]) == 0);
    strain_path<C>(law, state, plane_strain<C>(0, 0, yield / 100), 1, 401);
    CHECK(double(state.stress[3]) == near(su, C::tolerance));
    CHECK(std::fabs(double(state.stress[0])) <= C::tolerance * su);
    CHECK(double(state.history[0]) == near(4 * yield, C::tolerance, 0));
}

TEST_CASE_TEMPLATE("uniaxial strain ends in a corner: a stress difference of 2 su, also in turned axes", C,
                   EVERY_CASE) {
    using Real = typename C::Real;
    const auto law = clay<Real>();
    const auto q = turned_axes<C>();
    for (double sign : {-1.0, 1.0}) {
        auto state = virgin_state<C>();
        strain_path<C>(law, state, rotated(plane_strain<C>(sign * 1e-4, 0, 0), q), 1, 100);
        const Sym<Real, C::dim> stress = rotated(state.stress, inverse(q));
        const double mean = sign * 1e-2 * K;
        CHECK(double(stress[0]) == near(mean + sign * 4 * su / 3, 10 * C::tolerance));
        CHECK(double(stress[1]) == near(mean - sign * 2 * su / 3, 10 * C::tolerance));
        CHECK(double(stress[2]) == near(mean - sign * 2 * su / 3, 10 * C::tolerance));
        CHECK(std::fabs(double(stress[3])) <= 100 * C::tolerance * su);
    }
}

TEST_CASE_TEMPLATE("on the plane the middle principal stress stays elastic", C, EVERY_CASE) {
    using Real = typename C::Real;
    const auto law = clay<Real>();
    const auto q = turned_axes<C>();
    auto state = virgin_state<C>();
    // de = (3, -2, 0) 1e-4: the middle stress is zz, which no plastic flow touches.
    strain_path<C>(law, state, rotated(plane_strain<C>(3e-4, -2e-4, 0), q), 1, 10);
    const Sym<Real, C::dim> stress = rotated(state.stress, inverse(q));
    const double lambda = K - 2 * G / 3;
    const double middle = lambda * 1e-3;
    const double centre = (lambda + G) * 1e-3;
    CHECK(double(stress[2]) == near(middle, 10 * C::tolerance));
    CHECK(double(stress[0]) == near(centre + std::min(su, 2.5e-3 * 2 * G), 10 * C::tolerance));
    CHECK(double(stress[1]) == near(centre - std::min(su, 2.5e-3 * 2 * G), 10 * C::tolerance));
}

TEST_CASE("the return is the closest point in energy, and admissible, from any trial stress") {
    using C = Case<double, 3>;
    const auto law = clay<double>();
    std::mt19937 random(5);
    std::normal_distribution<double> normal(0, 1);
    for (int n = 0; n < 2000; ++n) {
        auto state = virgin_state<C>();
        Sym<double, 3> e;
        for (int k = 0; k < 6; ++k) e[k] = 0.01 * normal(random);
        if (n % 4 == 1) e[1] = e[0], e[3] = 1e-13 * normal(random), e[4] = e[5] = 0;  // nearly a corner
        strain_path<C>(law, state, e, 1, 1);
        const Spectrum<double, 3> principal(state.stress);
        const Ordered<double> sigma(principal.value);
        CHECK(sigma.first - sigma.third <= 2 * su * (1 + 1e-9));
        CHECK(state.stress.trace() == near(3 * K * e.trace(), 1e-10, su));
        // Maximum dissipation: (sigma - tau) : eps_p >= 0 for every admissible tau, where the plastic
        // strain is (trial - sigma) / 2G. The corners of the surface in the trial's axes suffice.
        auto elastic = virgin_state<C>();
        strain_path<C>(make_law<LinearElastic<double>>({{"young", young}, {"poisson", poisson}}), elastic, e, 1, 1);
        const double mean = state.stress.trace() / 3;
        const double corners[6][3] = {{4, -2, -2}, {-2, 4, -2}, {-2, -2, 4}, {-4, 2, 2}, {2, -4, 2}, {2, 2, -4}};
        const Spectrum<double, 3> axes(elastic.stress);
        for (const auto& corner : corners) {
            double change[3];
            for (int k = 0; k < 3; ++k) change[k] = mean + corner[k] * su / 3;
            Sym<double, 3> tau = zero_sym<double, 3>();
            axes.add(tau, change);
            double work = 0;
            for (int k = 0; k < 6; ++k)
                work += (k < 3 ? 1 : 2) * (state.stress[k] - tau[k]) * (elastic.stress[k] - state.stress[k]);
            CHECK(work >= -1e-8 * su * su);
        }
    }
}
