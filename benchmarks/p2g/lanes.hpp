#pragma once
// Particles as lanes: a register holds one number of several particles, and a node's sum is as wide as
// a register until the cell is done.

#include "p2g/tiles.hpp"

namespace moraine {

template <class Real>
struct LaneSums {
    static constexpr int lanes = 32 / sizeof(Real);
    typedef Real Register __attribute__((vector_size(32)));

    static Register fused(Register a, Register b, Register c) {
#if defined(MORAINE_QUAD_INTRINSICS)
        if constexpr (sizeof(Real) == 8)
            return _mm256_fmadd_pd(a, b, c);
        else
            return _mm256_fmadd_ps(a, b, c);
#else
        return a * b + c;
#endif
    }

    /// Numbers of `lanes` particles: w[3][3], dw[3][3], carried[4], traction[3][3] by component.
    struct Group {
        Register w[3][3], dw[3][3], carried[4], traction[3][3];
    };

    static void put(Group& g, int lane, const Brought<Real>& b) {
        for (int a = 0; a < 3; ++a)
            for (int i = 0; i < 3; ++i) {
                g.w[a][i][lane] = b.n.w[a][i];
                g.dw[a][i][lane] = b.n.dw[a][i];
                g.traction[a][i][lane] = b.traction[a][i];
            }
        for (int a = 0; a < 4; ++a) g.carried[a][lane] = b.carried[a];
    }

    static void add(const Group& g, Register (*sums)[7]) {
        for (int n = 0; n < 27; ++n) {
            const int i = n % 3, j = n / 3 % 3, k = n / 9;
            const Register wyz = g.w[1][j] * g.w[2][k];
            const Register w = g.w[0][i] * wyz;
            const Register d[3] = {g.dw[0][i] * wyz, g.w[0][i] * (g.dw[1][j] * g.w[2][k]),
                                   g.w[0][i] * (g.w[1][j] * g.dw[2][k])};
            for (int a = 0; a < 4; ++a) sums[n][a] = fused(w, g.carried[a], sums[n][a]);
            for (int a = 0; a < 3; ++a)
                for (int c = 0; c < 3; ++c) sums[n][4 + a] = fused(d[c], g.traction[c][a], sums[n][4 + a]);
        }
    }
};

template <class Real>
void sum_lanes(Tiles<Real>& tiles) {
    using L = LaneSums<Real>;
    const auto p = tiles.sample.view();
    const auto context = tiles.sample.context();
    tiles.each_cell([&](std::uint32_t from, std::uint32_t end, Real* to) {
        typename L::Register sums[27][7] = {};
        for (std::uint32_t k = from; k < end; k += L::lanes) {
            typename L::Group group{};
            for (int lane = 0; lane < L::lanes && k + static_cast<std::uint32_t>(lane) < end; ++lane)
                L::put(group, lane, Brought<Real>(context, p, tiles.sample.slot[k + static_cast<std::uint32_t>(lane)]));
            L::add(group, sums);
        }
        each_node<3, 3>([&](int at, int i, int j, int k) {
            for (int a = 0; a < 7; ++a) {
                Real sum = 0;
                for (int lane = 0; lane < L::lanes; ++lane) sum += sums[i + 3 * (j + 3 * k)][a][lane];
                to[at * node_reals + a] += sum;
            }
        });
    });
}

}  // namespace moraine
