#pragma once
// The laboratory's scenes: a body in a box, periodic in x and y, walls below and above in z.
//
// Eight particles per cell, one at a random place of each half-cell, flowing: 2 % of a cell per step in x and y,
// sheared over z and x, so that all particles move and cells exchange neighbours. Topology as in an epoch of the
// program: every block of the box, sorted by Morton key, and the nodes above them.

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/morton.hpp"
#include "view.cuh"

namespace lab {

struct SceneSpec {
    const char* name;
    int cells[3];       ///< domain
    int body;           ///< height of the body [cells]
    double stride = 2;  ///< displacement per step [per cent of a cell]
    bool fold = true;
    static constexpr double h = 0.1, density = 1000, young = 3e5, poisson = 0.3, su = 500;
    static constexpr double dt = 1e-3;
    MORAINE_HD double speed() const { return stride * 0.01 * h / dt; }
    long long particles() const { return 8ll * cells[0] * cells[1] * body; }
};

struct Topology {
    int blocks = 0;
    std::vector<Vec<std::int32_t, 3>> position;  ///< node blocks, blocks first
    std::vector<std::int32_t> neighbour, node_block, source;
    std::vector<std::uint8_t> border;
    std::vector<std::uint32_t> first;
};

/// Half-cells of the body within filing cell `at` (0 .. 2) along an axis: bit per half.
__host__ __device__ inline int halves(int at, bool periodic, int body) {
    if (periodic) return 3;
    int bits = 0;
    for (int s = 0; s < 2; ++s) {
        const int half = 2 * at + s - 1;
        if (half >= 0 && half < 2 * body) bits |= 1 << s;
    }
    return bits;
}

inline Topology make_topology(const SceneSpec& s) {
    int n[3];
    for (int a = 0; a < 3; ++a) n[a] = s.cells[a] / 4;
    n[2] = std::min(s.cells[2], s.body + 4) / 4 + 1;
    const auto wrap = [&](int a, int x) { return a < 2 ? (x + n[a]) % n[a] : x; };
    struct Keyed {
        std::uint64_t key;
        Vec<std::int32_t, 3> at;
    };
    std::vector<Keyed> all;
    const auto spread = [](std::uint64_t x) {
        std::uint64_t r = 0;
        for (int i = 0; i < 20; ++i) r |= ((x >> i) & 1) << (3 * i);
        return r;
    };
    for (int z = 0; z <= n[2]; ++z)
        for (int y = 0; y < n[1]; ++y)
            for (int x = 0; x < n[0]; ++x)
                all.push_back({spread(std::uint64_t(x)) | spread(std::uint64_t(y)) << 1 |
                                   spread(std::uint64_t(z)) << 2 | (z == n[2] ? 1ull << 63 : 0),
                               {x, y, z}});
    std::sort(all.begin(), all.end(), [](const Keyed& a, const Keyed& b) { return a.key < b.key; });
    Topology t;
    t.blocks = n[0] * n[1] * n[2];
    std::vector<std::int32_t> index(all.size());
    const auto cell = [&](int x, int y, int z) {
        return std::size_t(x) + std::size_t(n[0]) * (std::size_t(y) + std::size_t(n[1]) * std::size_t(z));
    };
    for (std::size_t i = 0; i < all.size(); ++i) {
        t.position.push_back(all[i].at);
        index[cell(all[i].at[0], all[i].at[1], all[i].at[2])] = std::int32_t(i);
    }
    const auto find = [&](const Vec<std::int32_t, 3>& p, int dx, int dy, int dz) {
        const int z = p[2] + dz;
        return z < 0 || z > n[2] ? -1 : index[cell(wrap(0, p[0] + dx), wrap(1, p[1] + dy), z)];
    };
    t.first.push_back(0);
    for (std::size_t i = 0; i < all.size(); ++i) {
        const Vec<std::int32_t, 3>& p = t.position[i];
        t.border.push_back(p[2] == 0 || 4 * p[2] + 5 >= s.cells[2]);
        for (int d = 0; d < 8; ++d) {
            const int b = find(p, -(d & 1), -((d >> 1) & 1), -(d >> 2));
            t.source.push_back(b < t.blocks ? b : -1);
        }
        if (int(i) >= t.blocks) continue;
        for (int c = 0; c < offsets; ++c) {
            const int b = find(p, Block<3>::offset(c, 0), Block<3>::offset(c, 1), Block<3>::offset(c, 2));
            t.neighbour.push_back(b < t.blocks ? b : -1);
        }
        for (int d = 0; d < 8; ++d) t.node_block.push_back(find(p, d & 1, (d >> 1) & 1, d >> 2));
        std::uint32_t count = 0;
        for (int z = 0; z < 4; ++z)
            count += 64u * std::uint32_t(__builtin_popcount(unsigned(halves(4 * p[2] + z, false, s.body))));
        t.first.push_back(t.first.back() + count);
    }
    return t;
}

template <class Real>
Walls<Real, 3> walls_of(const SceneSpec& s) {
    Walls<Real, 3> w{};
    for (int a = 0; a < 3; ++a) {
        const int far = 1 << 29;
        w.plane[a][0] = a < 2 ? -far : 0;
        w.plane[a][1] = a < 2 ? far : s.cells[2];
        for (int e = 0; e < 2; ++e) {
            w.kind[a][e] = a < 2 ? WallKind::periodic : WallKind::free_slip;
            w.fold[a][e] = a == 2 && s.fold;
        }
    }
    return w;
}

template <class Real>
VonMises<Real> law_of() {
    const double values[] = {SceneSpec::young, SceneSpec::poisson, SceneSpec::su, 0, 0, 0, 1, 1, 10};
    return VonMises<Real>(values);
}

__device__ inline double random_of(std::uint64_t x) {
    x += 0x9e3779b97f4a7c15ull;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
    return double((x ^ (x >> 31)) >> 11) * 0x1p-53;
}

/// One thread block of 64 threads per block of the scene: particles, lists and cell bounds, sorted by cell.
template <class Real>
__global__ void seed(View<Real> v, SceneSpec s, std::uint32_t* cell_first, std::uint32_t* slot) {
    const int b = int(blockIdx.x), c = int(threadIdx.x);
    const Vec<std::int32_t, 3> at = v.position[b];
    const int low = halves(4 * at[2] + (c >> 4), false, s.body);
    std::uint32_t before = 0;
    for (int z = 0; z < (c >> 4); ++z) before += 64u * __popc(unsigned(halves(4 * at[2] + z, false, s.body)));
    before += 4u * __popc(unsigned(low)) * unsigned(c & 15);
    std::uint32_t* bound = cell_first + std::size_t(b) * bounds + c;
    bound[0] = before;
    if (c == 63) bound[1] = before + 4u * __popc(unsigned(low));
    std::uint32_t k = v.first[b] + before;
    for (int m = 0; m < 8; ++m) {
        if (!((low >> (m >> 2)) & 1)) continue;
        const int cell[3] = {c & 3, (c >> 2) & 3, c >> 4};
        const int half[3] = {m & 1, (m >> 1) & 1, m >> 2};
        double local[3];
        Place<Real> x;
        for (int a = 0; a < 3; ++a) {
            const double jitter = 0.02 + 0.96 * random_of(3ull * k + unsigned(a));
            local[a] = cell[a] + 0.5 * (half[a] + jitter);
            x.u[a] = Coordinate<Real>(local[a] * double(one_cell<Real>));
            local[a] += 4 * at[a];
        }
        x.mass = Real(SceneSpec::density * SceneSpec::h * SceneSpec::h * SceneSpec::h / 8);
        const double tau = 6.283185307179586, U = s.speed();
        const double px = tau * local[0] / s.cells[0], pz = tau * (local[2] - 0.5) / s.body;
        Row<Real> u, n, t;
        u.e[0] = Real(U * (1 + 0.3 * sin(pz)));
        u.e[1] = Real(U * (0.9 + 0.2 * cos(px) * cos(pz)));
        u.e[2] = Real(U * (s.body < 32 ? 0.02 : 0.2) * sin(0.5 * pz) * cos(px));
        u.w = x.mass * v.inverse_density;
        for (int q = 0; q < 3; ++q) n.e[q] = t.e[q] = Real(0);
        n.w = t.w = Real(0);
        v.p.place[k] = x, v.p.motion[k] = u, v.p.normal[k] = n, v.p.shear[k] = t;
        v.p.id[k] = k, v.p.body[k] = 0;
        slot[k] = k;
        ++k;
    }
}

}  // namespace lab
