#include <doctest/doctest.h>

#include <random>
#include <type_traits>

#include "core/light_bound.hpp"
#include "core/shape.hpp"

using namespace moraine;

namespace {

/// A particle in a cell at a wall or not, and the masses of its nodes.
template <class Shape, int Dim>
struct Sample {
    LightStencil<double, Dim, Shape::width> n;
    unsigned ghosts[Dim];
    double mass[Dim == 2 ? Shape::width * Shape::width : Shape::width * Shape::width * Shape::width];
    double around = 0;
    LayerMasses<double, Dim, Shape::width> layers;

    static int place(int i, int j, int k) { return i + Shape::width * (j + Shape::width * k); }

    /// ghost: by axis, whether its lowest node is behind a wall. mass_of(i, j, k) [full nodes].
    template <class Mass>
    Sample(const double (&f)[Dim], const bool (&ghost)[Dim], const Mass& mass_of) {
        for (int a = 0; a < Dim; ++a) {
            ghosts[a] = ghost[a];
            Shape::weights(f[a], 0.25, n.w[a], n.dw[a]);
        }
        fold_stencil<Shape, false>(ghosts, false, f, 1.0, n);
        for (auto& axis : layers.least)
            for (double& m : axis) m = 1e30;
        each_node<Dim, Shape::width>([&](int, int i, int j, int k) {
            const bool inside = is_inside<Dim>(ghosts, i, j, k);
            const double m = inside ? mass_of(i, j, k) : 0;
            mass[place(i, j, k)] = m;
            around += m;
            const int at[3] = {i, j, k};
            for (int a = 0; inside && a < Dim; ++a) layers.least[a][at[a]] = std::min(layers.least[a][at[a]], m);
        });
    }

    Vec<double, Dim> reactions() const {
        return moraine::reactions(n, around, 1.0, [&](int, int i, int j, int k) {
            const double m = mass[place(i, j, k)];
            return m > 0 ? 1 / m : 0;
        });
    }
    bool is_whole(double squared, const ReactionLimits<double>& limits) const {
        Vec<double, Dim> r = reactions();
        for (int a = 0; a < Dim; ++a) r[a] *= squared;
        return light_share(limits, r, n.folded, 1.0).whole;
    }
    bool is_cleared(double squared, const ReactionLimits<double>& limits) const {
        return surely_whole(n, layers, 1.0, squared, 1.0, limits);
    }
};

/// Of random particles: how many are whole, are cleared by the bound, and are cleared though they are not whole.
struct Counts {
    int whole = 0, cleared = 0, wrong = 0;
};

template <class Shape, int Dim>
Counts try_random(int samples) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> share(0, 1);
    Counts counts;
    for (int s = 0; s < samples; ++s) {
        double f[Dim];
        bool ghost[Dim];
        for (int a = 0; a < Dim; ++a) {
            ghost[a] = share(random) < 0.4;
            f[a] = share(random) < 0.2 ? 1e-6 : share(random);
            if (ghost[a] && Shape::width == 3) f[a] = 0.5 + 0.5 * f[a];  // behind the wall there is none
        }
        const double heavy = share(random);
        const Sample<Shape, Dim> sample(f, ghost, [&](int, int, int) {
            return share(random) < heavy ? 0.4 + 0.7 * share(random) : std::pow(10, -6 * share(random));
        });
        const double squared = 0.1 + 0.6 * share(random);
        const ReactionLimits<double> limits{1.6, share(random) < 0.5 ? 1.6 : 2.5, false};
        const bool whole = sample.is_whole(squared, limits), cleared = sample.is_cleared(squared, limits);
        counts.whole += whole;
        counts.cleared += cleared;
        counts.wrong += cleared && !whole;
    }
    return counts;
}

/// A lattice of two particles per cell and axis, at rest on a wall: the particle next to it. depth: cells.
template <int Dim>
Sample<Quadratic, Dim> at_the_floor() {
    double f[Dim];
    bool ghost[Dim];
    for (int a = 0; a < Dim; ++a) f[a] = 0.75, ghost[a] = false;  // binned by the lowest node: half a cell behind
    ghost[Dim - 1] = true;
    return {f, ghost, [](int i, int j, int k) { return (Dim == 3 ? k : j) == 1 ? 13.0 / 24 : 1.0 + 0 * i; }};
}

}  // namespace

TEST_CASE_TEMPLATE("what the bound clears is whole", Shape, Quadratic, Cubic, Gimp) {
    for (const Counts& c : {try_random<Shape, 2>(20000), try_random<Shape, 3>(20000)}) {
        CHECK(c.wrong == 0);
        CHECK(c.whole > c.cleared);
        CHECK(c.cleared > 500);
    }
}

TEST_CASE("the bound clears a body at rest, at its floor and at its surface") {
    const ReactionLimits<double> flip{1.6, 1.6, false};
    const double squared = 0.608 * 0.608;
    CHECK(at_the_floor<2>().is_cleared(squared, flip));
    CHECK(at_the_floor<3>().is_cleared(squared, flip));
    const double f[3] = {0.75, 0.75, 0.75};
    const bool none[3] = {false, false, false};
    const Sample<Quadratic, 3> top(f, none, [](int, int, int k) { return k == 2 ? 0.156 : k == 1 ? 0.84 : 1.0; });
    CHECK(top.is_cleared(squared, flip));
}

TEST_CASE("the bound does not clear a lone layer on a wall") {
    const double f[2] = {0.75, 0.5 + 1e-4};
    const bool ghost[2] = {false, true};
    const Sample<Quadratic, 2> layer(f, ghost, [](int, int j, int) { return j == 1 ? 0.5 : 5e-5; });
    const ReactionLimits<double> flip{1.6, 1.6, false};
    CHECK_FALSE(layer.is_whole(0.37, flip));
    CHECK_FALSE(layer.is_cleared(0.37, flip));
}
