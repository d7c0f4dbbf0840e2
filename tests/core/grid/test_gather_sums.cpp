#include <doctest/doctest.h>

#include <array>
#include <cstring>
#include <random>
#include <vector>

#include "core/grid/gather_sums.hpp"

using namespace moraine;

namespace {

template <class R, int D, class S, bool A>
struct Case {
    using Real = R;
    using Shape = S;
    static constexpr int dim = D;
    static constexpr bool affine = A;
};

template <class C>
struct CellOfParticles {
    using Real = typename C::Real;
    static constexpr int dim = C::dim, count = 9;
    std::vector<Quad<Real>> nodes;
    std::array<Vec<Coordinate<Real>, dim>, count> position;
    StencilContext<Real, dim> context{};
    ParticleView<Real, dim> p{};

    CellOfParticles() : nodes(std::size_t(2 * power<dim>(tile_side(C::Shape::width)))) {
        std::mt19937_64 random(7);
        std::uniform_real_distribution<double> number(-1, 1);
        for (Quad<Real>& q : nodes)
            for (int i = 0; i < quad; ++i) q[i] = static_cast<Real>(number(random));
        for (auto& u : position)
            for (int a = 0; a < dim; ++a) u[a] = static_cast<Coordinate<Real>>(random());
        context.inverse_cell = Real(7);
        p.position = position.data();
    }

    /// Sums of all particles, as bytes, Count at a time.
    template <int Count>
    std::vector<Real> sums() {
        using T = Together<Real, Count>;
        const bool plain[] = {true, false, false};
        std::vector<Real> all;
        for (int k = 0; k < count; k += Count) {
            std::uint32_t slots[Count];
            for (int i = 0; i < Count; ++i) slots[i] = std::uint32_t(k + i < count ? k + i : count - 1);
            const auto n = stencils<T, typename C::Shape>(context, p, slots);
            auto g = sum_nodes<C::affine, T, typename C::Shape, Real, dim>(n, nodes.data(), plain, Real(7));
            for (int i = 0; i < Count && k + i < count; ++i) {
                const GatheredPart<T, dim> part(g, i);
                for (int lane = 0; lane < quad; ++lane) {
                    all.push_back(part.velocity()[lane]);
                    all.push_back(part.change()[lane]);
                    for (int a = 0; a < dim; ++a) all.push_back(part.gradient(a)[lane]);
                    for (int a = 0; C::affine && a < dim; ++a) all.push_back(part.affine(a)[lane]);
                }
                const auto one = part_of<T, Real, dim, typename C::Shape>(n, i);
                for (int a = 0; a < dim; ++a) all.insert(all.end(), {one.f[a], one.w[a][0], one.dw[a][0]});
            }
        }
        return all;
    }
};

template <class Real>
bool same_bytes(const std::vector<Real>& a, const std::vector<Real>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Real)) == 0;
}

}  // namespace

TEST_CASE_TEMPLATE("what a particle gathers does not depend on how many go together, to the bit", C,
                   Case<double, 3, Quadratic, false>, Case<float, 3, Quadratic, true>, Case<double, 2, Quadratic, true>,
                   Case<float, 2, Cubic, false>, Case<double, 3, Cubic, true>, Case<float, 3, Linear, false>) {
    CellOfParticles<C> cell;
    const auto alone = cell.template sums<1>();
    CHECK(same_bytes(alone, cell.template sums<2>()));
    CHECK(same_bytes(alone, cell.template sums<4>()));
}
