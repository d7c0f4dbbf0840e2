#pragma once
// The particles of the laboratory: a cube of full blocks, 8 jittered particles per cell, in list order.
//
// All variants read the same columns and lists, and must bring the same sums to the nodes of the cube:
// (mass, momentum, -) and (force, -) per node, on a grid of 4 blocks + 2 nodes per axis.

#include <cstring>
#include <vector>

#include "core/hash.hpp"
#include "core/host.hpp"
#include "core/p2g.hpp"

namespace moraine {

template <class Real>
struct Sample {
    static constexpr int dim = 3;
    static constexpr int per_cell = 8;
    using Shape = Quadratic;
    static constexpr int tile_nodes = power<dim>(tile_side(Shape::width));

    explicit Sample(int blocks_per_axis);

    int blocks() const { return side * side * side; }
    int particles() const { return blocks() * Block<dim>::cells * per_cell; }
    int grid_side() const { return 4 * side + 2; }
    std::size_t grid_nodes() const { return static_cast<std::size_t>(grid_side()) * grid_side() * grid_side(); }

    /// Place of the lowest node of a block on the grid.
    std::size_t corner(int block) const {
        return node(4 * (block % side), 4 * (block / side % side), 4 * (block / side / side));
    }
    std::size_t node(int x, int y, int z) const {
        return static_cast<std::size_t>(x) +
               static_cast<std::size_t>(grid_side()) *
                   (static_cast<std::size_t>(y) + static_cast<std::size_t>(grid_side()) * static_cast<std::size_t>(z));
    }

    ParticleView<Real, dim> view() {
        ParticleView<Real, dim> p{};
        p.position = position.data(), p.velocity = velocity.data(), p.mass = mass.data(), p.volume = volume.data();
        p.stress = stress.data();
        return p;
    }
    ListView<dim> list() const { return {first.data(), cell_first.data(), slot.data()}; }
    BlockTable<dim> table() const {
        BlockTable<dim> t{};
        t.own = blocks(), t.position = block_position.data(), t.border = border.data();
        return t;
    }
    StencilContext<Real, dim> context() const {
        StencilContext<Real, dim> c{};
        c.inverse_cell = Real(1);
        return c;
    }

    int side;
    std::vector<Vec<Coordinate<Real>, dim>> position;
    std::vector<Vec<Real, dim>> velocity;
    std::vector<Real> mass, volume;
    std::vector<Sym<Real, dim>> stress;
    std::vector<std::uint32_t> first, cell_first, slot;
    std::vector<Vec<std::int32_t, dim>> block_position;
    std::vector<std::uint8_t> border;
    std::vector<std::int32_t> tile_of, every_block;
};

template <class Real>
Sample<Real>::Sample(int blocks_per_axis) : side(blocks_per_axis) {
    const auto n = static_cast<std::size_t>(particles());
    position.resize(n), velocity.resize(n), mass.assign(n, Real(187.5)), volume.assign(n, Real(0.125)),
        stress.resize(n);
    slot.resize(n), border.assign(static_cast<std::size_t>(blocks()), 0);
    const auto uniform = [](std::uint64_t i) { return static_cast<double>(mix(i) >> 11) * 0x1p-53; };
    for (int b = 0; b < blocks(); ++b) {
        block_position.push_back({{b % side, b / side % side, b / side / side}});
        tile_of.push_back(b), every_block.push_back(b);
        first.push_back(static_cast<std::uint32_t>(b * Block<dim>::cells * per_cell));
        for (int c = 0; c <= Block<dim>::cells; ++c) cell_first.push_back(static_cast<std::uint32_t>(c * per_cell));
    }
    first.push_back(static_cast<std::uint32_t>(n));
    for (std::size_t s = 0; s < n; ++s) {
        slot[s] = static_cast<std::uint32_t>(s);
        const int cell = static_cast<int>(s / per_cell) % Block<dim>::cells;
        for (int a = 0; a < dim; ++a) {
            const auto axis = static_cast<std::size_t>(a);
            const double lattice = 0.25 + 0.5 * static_cast<double>((s >> a) & 1);
            const double f = lattice + 0.4 * (uniform(16 * s + axis) - 0.5);
            position[s][a] =
                static_cast<Coordinate<Real>>((cell_coordinate<dim>(cell, a) + f) * double(one_cell<Real>));
            velocity[s][a] = static_cast<Real>(1 + uniform(16 * s + 3 + axis));
        }
        for (int k = 0; k < 6; ++k)
            stress[s][k] =
                static_cast<Real>((k < 3 ? -1e4 : 0) + 2e3 * uniform(16 * s + 6 + static_cast<std::size_t>(k)));
    }
}

/// Sums on the grid of the cube, node_reals per node.
template <class Real>
using GridSums = std::vector<Real>;

/// What all variants need to sum: stencil, (m, m v) and the columns of -V sigma.
template <class Real>
struct Brought {
    Weights<Real, 3, Quadratic> n;
    Quad<Real> carried;
    Quad<Real> traction[3];

    MORAINE_HD Brought(const StencilContext<Real, 3>& context, const ParticleView<Real, 3>& p, std::uint32_t s) {
        n = stencil<Real, 3, Quadratic>(context, p, s);
        carried = Quad<Real>::zero();
        carried[0] = p.mass[s];
        for (int a = 0; a < 3; ++a) carried[1 + a] = p.mass[s] * p.velocity[s][a];
        for (int b = 0; b < 3; ++b) {
            traction[b] = Quad<Real>::zero();
            for (int a = 0; a < 3; ++a) traction[b][a] = -p.volume[s] * p.stress[s](a, b);
        }
    }
};

}  // namespace moraine
