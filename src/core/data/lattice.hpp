#pragma once
// Particles of boxes that a lattice fills, told by their axes: a lattice is a product, so what a cell of a block holds
// is the product of what its three intervals hold. Along each axis a table has the lattice's points in the order
// (block, cell, index), with their fixed-point places; who wants the n-th particle of a cell looks it up.
//
// Tables are made on the host (seeding/lattice_seeds.hpp) by the arithmetic of seeding/seed.hpp; here nothing is
// computed but indices, so that any thread of any device finds the same bits. A 2 000 000 000 particle box has tables
// of 100 kB.
//
// Order of a cell: by id, that is by body, then by the last axis, ..., then by the first (seeding/seed.hpp).

#include <cstdint>
#include <vector>

#include "core/data/block.hpp"
#include "core/data/position.hpp"

namespace moraine {

/// One box. Entries of the tables of LatticeView that are its own begin at the places given here.
template <class Real, int Dim>
struct LatticeBody {
    std::int32_t block[Dim];     ///< the first that holds points along the axis
    std::int32_t blocks[Dim];    ///< from there on, empty ones included
    std::uint32_t bound[Dim];    ///< 4 blocks + 1 entries: points before a cell, from the axis's first on
    std::uint32_t point[Dim];    ///< entries of index and u
    std::uint64_t stride[Dim];   ///< of ids
    std::uint64_t id;            ///< of the first point
    Real mass;                   ///< of a particle [kg]
    Real volume;                 ///< [m3]
    std::int32_t up, wave;       ///< axes along which stress and velocity differ
    std::uint32_t stress, flow;  ///< where they begin, by index along up and wave
    std::uint16_t body;
};

/// A particle as it begins; all else of it is zero.
template <class Real, int Dim>
struct LatticeParticle {
    std::uint64_t id;
    std::uint16_t body;
    Vec<Coordinate<Real>, Dim> u;  ///< in its block
    Vec<Real, Dim> velocity;       ///< [m/s]
    Vec<Real, 3> stress;           ///< normal components [Pa]
    Real mass, volume;             ///< [kg, m3]
};

template <class Real, int Dim>
struct LatticeView {
    const LatticeBody<Real, Dim>* body;  ///< ascending
    int bodies;
    const std::uint32_t* bound;
    const std::uint32_t* index;  ///< along the axis, ascending in each cell
    const Coordinate<Real>* u;   ///< of the same points
    const Vec<Real, 3>* stress;  ///< normal components [Pa]
    const Vec<Real, Dim>* flow;  ///< velocity [m/s]

    /// Points of a body along the axes: the first in the order of the tables, and how many; in all their product.
    struct Points {
        std::uint32_t first[Dim], n[Dim], all;
    };

    /// Those in cells [cell, cell + cells) along each axis of a block.
    MORAINE_HD Points points(const LatticeBody<Real, Dim>& b, const Vec<std::int32_t, Dim>& block, const int* cell,
                             int cells) const {
        Points p{};
        p.all = 1;
        for (int a = 0; a < Dim; ++a) {
            const std::int32_t at = block[a] - b.block[a];
            if (at >= 0 && at < b.blocks[a]) {
                const std::uint32_t* from = bound + b.bound[a] + 4 * at + cell[a];
                p.first[a] = from[0];
                p.n[a] = from[cells] - from[0];
            }
            p.all *= p.n[a];
        }
        return p;
    }

    /// Particles of a block.
    MORAINE_HD std::uint32_t count(const Vec<std::int32_t, Dim>& block) const {
        const int none[3] = {0, 0, 0};
        std::uint32_t sum = 0;
        for (int b = 0; b < bodies; ++b) sum += points(body[b], block, none, 4).all;
        return sum;
    }

    /// Particles of a cell of it.
    MORAINE_HD std::uint32_t count(const Vec<std::int32_t, Dim>& block, int cell) const {
        const int at[3] = {cell & 3, (cell >> 2) & 3, cell >> 4};
        std::uint32_t sum = 0;
        for (int b = 0; b < bodies; ++b) sum += points(body[b], block, at, 1).all;
        return sum;
    }

    /// The k-th of a cell, k < count(block, cell).
    MORAINE_HD LatticeParticle<Real, Dim> particle(const Vec<std::int32_t, Dim>& block, int cell,
                                                   std::uint32_t k) const {
        const int at[3] = {cell & 3, (cell >> 2) & 3, cell >> 4};
        int b = 0;
        for (; b + 1 < bodies; ++b) {
            const std::uint32_t here = points(body[b], block, at, 1).all;
            if (k < here) break;
            k -= here;
        }
        return particle_of(body[b], points(body[b], block, at, 1), k);
    }

  private:
    MORAINE_HD LatticeParticle<Real, Dim> particle_of(const LatticeBody<Real, Dim>& b, const Points& along,
                                                      std::uint32_t k) const {
        LatticeParticle<Real, Dim> p{};
        p.id = b.id;
        p.body = b.body;
        p.mass = b.mass;
        p.volume = b.volume;
        for (int a = 0; a < Dim; ++a) {
            const std::uint32_t point = b.point[a] + along.first[a] + k % along.n[a];
            k /= along.n[a];
            const std::uint32_t i = index[point];
            p.id += i * b.stride[a];
            p.u[a] = u[point];
            if (a == b.up) p.stress = stress[b.stress + i];
            if (a == b.wave) p.velocity = flow[b.flow + i];
        }
        return p;
    }
};

/// The same, with memory of its own.
template <class Real, int Dim>
struct LatticeTables {
    std::vector<LatticeBody<Real, Dim>> body;
    std::vector<std::uint32_t> bound, index;
    std::vector<Coordinate<Real>> u;
    std::vector<Vec<Real, 3>> stress;
    std::vector<Vec<Real, Dim>> flow;

    LatticeView<Real, Dim> view() const {
        return {body.data(), static_cast<int>(body.size()), bound.data(), index.data(), u.data(), stress.data(),
                flow.data()};
    }
};

}  // namespace moraine
