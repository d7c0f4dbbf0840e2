#pragma once
// The lab's scene: a cube of particles that slides through empty space, as the columns of device/cases.cpp slide over
// their floor, in a box of blocks of which all are own; no wall is near. Lengths in cells.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

#include "core/block.hpp"
#include "core/position.hpp"

namespace moraine::lab {

struct ColumnPlan {
    int edge = 128;       ///< of the cube [cells], 8 particles each
    double jitter = 0.1;  ///< of places, to both sides of a lattice's [cells]
};

/// Material and motion of device/cases.cpp's columns.
struct Motion {
    double density = 1500, young = 1e8, poisson = 0.4, su = 2e5;
    double speed = 12, wave = 3, wavelength = 16;
    double dt = 1.28e-3;  ///< half of the time in which a wave goes through a cell
};

/// Tables of core/grid_views.hpp for a box of blocks.
struct BoxTables {
    int side = 0, own = 0, node_blocks = 0;
    std::vector<Vec<std::int32_t, 3>> position, node_position;
    std::vector<std::int32_t> neighbour, node_block, source;

    static std::uint64_t morton(int x, int y, int z) {
        std::uint64_t key = 0;
        for (int bit = 0; bit < 20; ++bit)
            key |= (std::uint64_t(x >> bit & 1) | std::uint64_t(y >> bit & 1) << 1 | std::uint64_t(z >> bit & 1) << 2)
                   << (3 * bit);
        return key;
    }

    /// Places of a box of blocks in key order, and the number at each place.
    static std::vector<Vec<std::int32_t, 3>> in_order(int side, std::vector<std::int32_t>& number) {
        std::vector<std::pair<std::uint64_t, Vec<std::int32_t, 3>>> all;
        for (int z = 0; z < side; ++z)
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x) all.push_back({morton(x, y, z), {{x, y, z}}});
        std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
        std::vector<Vec<std::int32_t, 3>> place;
        number.resize(all.size());
        for (const auto& [key, at] : all) {
            number[std::size_t((at[2] * side + at[1]) * side + at[0])] = std::int32_t(place.size());
            place.push_back(at);
        }
        return place;
    }

    std::vector<std::int32_t> number, node_number;

    explicit BoxTables(int blocks_per_axis) : side(blocks_per_axis) {
        position = in_order(side, number);
        node_position = in_order(side + 1, node_number);
        own = int(position.size()), node_blocks = int(node_position.size());
        const auto at = [](const std::vector<std::int32_t>& n, int s, int x, int y, int z) {
            const bool in = x >= 0 && y >= 0 && z >= 0 && x < s && y < s && z < s;
            return in ? n[std::size_t((z * s + y) * s + x)] : -1;
        };
        for (const auto& p : position) {
            for (int code = 0; code < Block<3>::offsets; ++code)
                neighbour.push_back(at(number, side, p[0] + Block<3>::offset(code, 0), p[1] + Block<3>::offset(code, 1),
                                       p[2] + Block<3>::offset(code, 2)));
            for (int k = 0; k < Block<3>::corners; ++k)
                node_block.push_back(at(node_number, side + 1, p[0] + (k & 1), p[1] + (k >> 1 & 1), p[2] + (k >> 2)));
        }
        for (const auto& p : node_position)
            for (int k = 0; k < Block<3>::corners; ++k)
                source.push_back(at(number, side, p[0] - (k & 1), p[1] - (k >> 1 & 1), p[2] - (k >> 2)));
    }
};

template <class Real>
struct Seed {
    Vec<Coordinate<Real>, 3> u;
    float velocity_z;  ///< [m/s]
};

/// Particles in list order.
template <class Real>
struct Column {
    BoxTables box;
    std::vector<std::uint32_t> first, cell_first;  ///< as ListView has them
    std::vector<Seed<Real>> particle;

    Column(const ColumnPlan& plan, const Motion& motion) : box((plan.edge + 16 + 3) / 4) {
        constexpr int cells = Block<3>::cells;
        const int side = 2 * plan.edge;
        const std::size_t n = std::size_t(side) * side * side;
        std::vector<std::uint32_t> bin(n), count(std::size_t(box.own) * cells + 1, 0);
        std::vector<Seed<Real>> all(n);
        for (std::size_t k = 0; k < n; ++k) {
            const std::size_t at[3] = {k % side, k / side % side, k / side / side};
            int block[3], cell = 0;
            double x0 = 0;
            for (int a = 2; a >= 0; --a) {
                const double x = 6 + 0.5 * double(at[a]) + 0.25 + plan.jitter * (2 * random(3 * k + a) - 1);
                const Place<Real> p = place<Real>(x + 0.5);
                all[k].u[a] = p.u, block[a] = p.block;
                cell = 4 * cell + cell_of<Real>(p.u);
                x0 = x;
            }
            all[k].velocity_z = float(motion.wave * std::sin(2 * M_PI * x0 / motion.wavelength));
            const int b = box.number[std::size_t((block[2] * box.side + block[1]) * box.side + block[0])];
            bin[k] = std::uint32_t(b * cells + cell);
            ++count[bin[k] + 1];
        }
        std::partial_sum(count.begin(), count.end(), count.begin());
        first.resize(std::size_t(box.own) + 1), cell_first.resize(std::size_t(box.own) * (cells + 1));
        for (int b = 0; b <= box.own; ++b) first[b] = count[std::size_t(b) * cells];
        for (int b = 0; b < box.own; ++b)
            for (int c = 0; c <= cells; ++c)
                cell_first[std::size_t(b) * (cells + 1) + c] = count[std::size_t(b) * cells + c] - first[b];
        particle.resize(n);
        std::vector<std::uint32_t> to(count.begin(), count.end() - 1);
        for (std::size_t k = 0; k < n; ++k) particle[to[bin[k]]++] = all[k];
    }

    /// Between 0 and 1, of a number.
    static double random(std::uint64_t k) {
        k = (k + 1) * 0x9e3779b97f4a7c15u;
        k = (k ^ k >> 30) * 0xbf58476d1ce4e5b9u;
        k = (k ^ k >> 27) * 0x94d049bb133111ebu;
        return double((k ^ k >> 31) >> 11) * 0x1p-53;
    }
};

}  // namespace moraine::lab
