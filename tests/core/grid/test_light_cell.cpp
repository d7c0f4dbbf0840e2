#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "core/grid/light_cell.hpp"

using namespace moraine;

namespace {

template <class R, int D, int W>
struct Case {
    using Real = R;
    static constexpr int dim = D, width = W;
};

}  // namespace

TEST_CASE_TEMPLATE("reactions by what a cell's particles share are those of one particle alone, to the bit", C,
                   Case<double, 3, 3>, Case<float, 3, 3>, Case<double, 2, 3>, Case<float, 2, 4>, Case<double, 3, 4>,
                   Case<float, 3, 2>) {
    using Real = typename C::Real;
    constexpr int Dim = C::dim, width = C::width;
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> number(0, 1);
    int held = 0, empty = 0;
    for (int trial = 0; trial < 200; ++trial) {
        std::vector<Quad<Real>> nodes(std::size_t(2 * power<Dim>(tile_side(width))));
        for (Quad<Real>& q : nodes) {
            for (int i = 0; i < quad; ++i) q[i] = static_cast<Real>(number(random) - (i < quad - 1 ? 0.5 : 0.1));
            if (random() % 4 == 0) q[int(random() % Dim)] = Real(0), ++held;  // a wall holds it
            if (q[quad - 1] < 0) q[quad - 1] = Real(0), ++empty;
        }
        LightCell<Real, Dim, width> cell{};
        cell.ghosts[trial % Dim] = trial % 3 == 0 && width > 2 ? 1u : 0u;
        LightStencil<Real, Dim, width> n{};
        for (int a = 0; a < Dim; ++a)
            for (int i = 0; i < width; ++i) {
                n.w[a][i] = cell.ghosts[a] && i == 0 ? Real(0) : static_cast<Real>(number(random));
                n.dw[a][i] = static_cast<Real>(number(random) - 0.5);
            }
        weigh_nodes(nodes.data(), cell);
        const Real full = static_cast<Real>(4 * number(random));

        std::vector<Real> inverse;
        Real around = Real(0), least = nodes[0][quad - 1];
        each_node<Dim, width>([&](int at, int i, int j, int k) {
            const Real m = is_inside<Dim>(cell.ghosts, i, j, k) ? nodes[std::size_t(2 * at)][quad - 1] : Real(0);
            around += m;
            inverse.push_back(m > Real(0) ? Real(1) / m : Real(0));
            least = std::min(least, Real(nodes[std::size_t(2 * at)][quad - 1]));
        });
        const Vec<Real, Dim> expected = reactions(
            n, around, full,
            [&](int, int i, int j, int k) { return inverse[std::size_t(i + width * (j + width * k))]; },
            [&](int at, int b) { return moves_along<Real, Dim>(nodes[std::size_t(2 * at)], b); });
        const Vec<Real, Dim> found = reactions(n, full, cell);
        for (int b = 0; b < Dim; ++b) REQUIRE(found[b] == expected[b]);
        CHECK(cell.around == around);
        CHECK(least_mass<Dim, width>(nodes.data()) == least);
    }
    CHECK(held > 100);
    CHECK(empty > 100);
}
