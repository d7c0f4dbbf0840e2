#pragma once
// What the lab checks: the fused step against the program's, against sums of the host, and against itself.

#include <cmath>
#include <cstring>

#include "device_lab/fused_share.cuh"
#include "device_lab/present.cuh"

namespace moraine::gpu::lab {

/// Particles by their first number.
template <class Real>
using Particles = std::vector<CoreRows<Real, 3>>;

template <class Real>
std::vector<std::vector<Row<Real>>> rows_of(const Memory<Real>& memory) {
    std::vector<std::vector<Row<Real>>> rows;
    for (const auto& r : memory.row) rows.push_back(r.host());
    return rows;
}

template <class Real, class Law>
Particles<Real> particles_of(const Present<Real, Law>& share) {
    const auto rows = rows_of(share.memory());
    const auto id = share.memory().id.host();
    Particles<Real> p(id.size());
    for (std::size_t s = 0; s < id.size(); ++s)
        for (int r = 0; r < core_rows<3>; ++r) p[id[s]].row[r] = rows[r][s];
    return p;
}

/// Counts how often each particle is there: `found` must be all ones.
template <class Real, class Law, class Plan>
Particles<Real> particles_of(const FusedShare<Real, Law, Plan>& share, std::vector<std::uint8_t>& found) {
    const auto rows = rows_of(share.memory());
    const auto regions = share.regions();
    const auto homes = share.homes();
    Particles<Real> p(found.size());
    for (std::size_t b = 0; b < regions.size(); ++b)
        for (std::uint32_t e = 0; e < regions[b].count(); ++e) {
            const std::size_t s = b * share.region + regions[b].place(e);
            ++found[homes[s]];
            for (int r = 0; r < core_rows<3>; ++r) p[homes[s]].row[r] = rows[r][s];
        }
    return p;
}

/// Largest differences, each by the scale of its kind: places [cells], velocities and stresses by their largest.
struct Differences {
    double place = 0, velocity = 0, stress = 0;
};

template <class Real>
Differences compare(const Particles<Real>& a, const Particles<Real>& b) {
    using Signed = typename Fixed<Real>::Signed;
    Differences d;
    double speed = 0, stress = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
        for (int i = 0; i < 3; ++i) {
            const auto du = static_cast<Signed>(a[k].coordinate(i) - b[k].coordinate(i));  // modulo a block
            d.place = std::max(d.place, std::fabs(double(du)) / double(one_cell<Real>));
            speed = std::max(speed, std::fabs(double(a[k].velocity(i))));
            d.velocity = std::max(d.velocity, std::fabs(double(a[k].velocity(i)) - double(b[k].velocity(i))));
        }
        for (int i = 0; i < 6; ++i) {
            stress = std::max(stress, std::fabs(double(a[k].stress(i))));
            d.stress = std::max(d.stress, std::fabs(double(a[k].stress(i)) - double(b[k].stress(i))));
        }
    }
    d.velocity /= speed;
    if (stress > 0) d.stress /= stress;
    return d;
}

/// Largest difference of tiles, of each number by the largest of its kind; and that largest.
struct TileDifference {
    double mass = 0, momentum = 0, force = 0;
    double scale[3] = {0, 0, 0};
    void add(int lane, double x, double y) {
        const int kind = lane == 0 ? 0 : lane < 4 ? 1 : 2;
        double& d = kind == 0 ? mass : kind == 1 ? momentum : force;
        d = std::max(d, std::fabs(x - y)), scale[kind] = std::max(scale[kind], std::fabs(y));
    }
    void finish() {
        double* of[3] = {&mass, &momentum, &force};
        for (int k = 0; k < 3; ++k)
            if (scale[k] > 0) *of[k] /= scale[k];
    }
    double largest() const { return std::max({mass, momentum, force}); }
};

/// Tiles of the fused step against the program's; a tile that one lacks is zero.
template <class Real>
TileDifference compare_tiles(const Memory<Real>& fused, const Memory<Real>& present) {
    constexpr int reals = power<3>(tile_side(3)) * node_reals;
    const auto x = fused.tiles.host(), y = present.tiles.host();
    const auto x_of = fused.tile_of.host(), y_of = present.tile_of.host();
    TileDifference d;
    for (std::size_t b = 0; b < x_of.size(); ++b)
        for (int i = 0; i < reals; ++i)
            d.add(i % node_reals, x_of[b] < 0 ? 0 : double(x[std::size_t(x_of[b]) * reals + i]),
                  y_of[b] < 0 ? 0 : double(y[std::size_t(y_of[b]) * reals + i]));
    d.finish();
    return d;
}

/// Tiles of every so-many-th block against sums in double of the rows that its region holds.
template <class Real, class Law, class Plan>
TileDifference compare_with_host(const FusedShare<Real, Law, Plan>& share, int every) {
    constexpr int side = tile_side(3), nodes = power<3>(side);
    const auto rows = rows_of(share.memory());
    const auto regions = share.regions();
    const auto tiles = share.memory().tiles.host();
    TileDifference d;
    for (std::size_t b = 0; b < regions.size(); b += std::size_t(every)) {
        std::vector<double> sum(std::size_t(nodes) * node_reals, 0);
        for (std::uint32_t e = 0; e < regions[b].count(); ++e) {
            CoreRows<Real, 3> p;
            const std::size_t s = b * share.region + regions[b].place(e);
            for (int r = 0; r < core_rows<3>; ++r) p.row[r] = rows[r][s];
            double w[3][3], g[3][3];
            int cell[3];
            for (int a = 0; a < 3; ++a) {
                cell[a] = moraine::cell_of<Real>(p.coordinate(a));
                Quadratic::weights(double(fraction_of<Real>(p.coordinate(a))), 0.0, w[a], g[a]);
            }
            for (int n = 0; n < 27; ++n) {
                const int i = n % 3, j = n / 3 % 3, k = n / 9;
                double* at = &sum[std::size_t(cell[0] + i + side * (cell[1] + j + side * (cell[2] + k))) * node_reals];
                const double m = w[0][i] * w[1][j] * w[2][k] * p.mass();
                const double grad[3] = {g[0][i] * w[1][j] * w[2][k], w[0][i] * g[1][j] * w[2][k],
                                        w[0][i] * w[1][j] * g[2][k]};
                at[0] += m;
                for (int c = 0; c < 3; ++c) {
                    at[1 + c] += m * p.velocity(c);
                    for (int a = 0; a < 3; ++a) at[4 + c] -= p.volume() * p.stress(Sym<Real, 3>::index(c, a)) * grad[a];
                }
            }
        }
        for (int i = 0; i < nodes * node_reals; ++i)
            d.add(i % node_reals, double(tiles[b * nodes * node_reals + std::size_t(i)]), sum[std::size_t(i)]);
    }
    d.finish();
    return d;
}

/// Whether two shares are the same in every byte that has a meaning.
template <class Real, class Law, class Plan, class Other>
bool same_bits(const FusedShare<Real, Law, Plan>& a, const FusedShare<Real, Law, Other>& b) {
    const auto x = a.memory().tiles.host(), y = b.memory().tiles.host();
    if (std::memcmp(x.data(), y.data(), x.size() * sizeof(Real)) != 0) return false;
    const auto regions = a.regions(), others = b.regions();
    const auto homes = a.homes(), other_homes = b.homes();
    const auto rows = rows_of(a.memory()), other_rows = rows_of(b.memory());
    for (std::size_t k = 0; k < regions.size(); ++k) {
        if (std::memcmp(&regions[k], &others[k], sizeof(Region)) != 0) return false;
        for (std::uint32_t e = 0; e < regions[k].count(); ++e) {
            const std::size_t s = k * a.region + regions[k].place(e);
            if (homes[s] != other_homes[s]) return false;
            for (int r = 0; r < core_rows<3>; ++r)
                if (std::memcmp(&rows[r][s], &other_rows[r][s], sizeof(Row<Real>)) != 0) return false;
        }
    }
    return true;
}

}  // namespace moraine::gpu::lab
