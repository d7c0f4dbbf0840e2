#pragma once
// What hazard maps and sections (records/) ask of particles, on the host and on devices: sums over the columns of a map
// in plan, and who is near a line.
//
//   column   floor((x - corner) / a) along x and y, a: side of a map cell, corner: of the map
//   layer    floor((z - lowest ground of the column) / h), the last one is all above
//   sums     V_p, m_p and m_p v_p as whole numbers of a unit: the same in any order, by any thread and on any rank
//
// Products that a device would contract with a sum are rounded first, so that both find the same column.

#include <cmath>
#include <cstdint>

#include "core/data/position.hpp"
#include "core/data/rounded_product.hpp"
#include "core/data/vec.hpp"

namespace moraine {

/// Where the particles of a scene are.
struct PlanPlaces {
    double origin[3];  ///< the domain's lower corner [m]
    double cell;       ///< h [m]
    double offset;     ///< Stencil::offset() [cells]

    /// Of a block's coordinate along an axis [m]; cells: from the block's lower end.
    MORAINE_HD double at(int axis, std::int32_t block, double cells) const {
        return origin[axis] + rounded_product(cell, 4.0 * block + cells - offset);
    }
    template <class Real>
    MORAINE_HD double of(int axis, std::int32_t block, Coordinate<Real> u) const {
        return at(axis, block, double(u) / double(one_cell<Real>));
    }
};

/// Layers of a column, a bit each from the ground up.
using Layers = std::uint64_t;

/// Those of `occupied` that do not fly: what is up to layer `ground`, in which the column's highest ground may be, and
/// above it all up to the first two layers in turn that nobody is in.
inline Layers resting_layers(Layers occupied, int ground) {
    Layers resting = 0;
    int empty = 0;
    for (int k = 0; k < 64 && empty < 2; ++k) {
        const Layers bit = Layers(1) << k;
        resting |= occupied & bit;
        if (occupied & bit)
            empty = 0;
        else if (k > ground)
            ++empty;
    }
    return resting;
}

/// Columns of a map, and the tiles of them that are summed.
struct PlanColumns {
    static constexpr int sums = 5;                               ///< of a column: volume, mass, momentum
    static constexpr std::int64_t edge = 16, in_tile = 16 * 16;  ///< columns along a tile, and in it
    static constexpr std::size_t kept_bytes = 64;                ///< of a column in hazard maps, where soil has been

    PlanPlaces places;
    double corner[2];                    ///< lower corner of the map [m]
    double side;                         ///< a [m]
    std::int64_t size[2];                ///< columns of the map along x and y
    std::int64_t first[2], count[2];     ///< of the rectangle around these tiles, in tiles
    double volume_unit, mass_unit;       ///< [m3, kg]
    double momentum_unit;                ///< [kg m/s]
    std::int64_t tiles = 0;              ///< so many
    const std::int32_t* tile = nullptr;  ///< which each tile of the rectangle is; < 0: none
    const double* floor = nullptr;       ///< lowest ground of each column of the tiles [m]
    const Layers* resting = nullptr;     ///< the layers of each that are summed; null: all

    MORAINE_HD std::int64_t along(int axis, double x) const {
        using std::floor;
        const double at = floor((x - corner[axis]) / side), last = double(size[axis] - 1);
        return static_cast<std::int64_t>(at < 0 ? 0.0 : (at > last ? last : at));
    }
    /// Place of the sums of column (i, j) of the map.
    MORAINE_HD std::size_t place(std::int64_t i, std::int64_t j) const { return std::size_t(sums) * column(i, j); }
    /// Place of column (i, j) of the map among those of the tiles.
    MORAINE_HD std::size_t column(std::int64_t i, std::int64_t j) const {
        const std::int64_t at = (i / edge - first[0]) + count[0] * (j / edge - first[1]);
        return static_cast<std::size_t>(tile[at] * in_tile + edge * (j % edge) + i % edge);
    }
    std::size_t all_tiles() const { return static_cast<std::size_t>(count[0] * count[1]); }  ///< of the rectangle
    std::size_t all() const { return static_cast<std::size_t>(tiles * in_tile); }
    std::size_t all_sums() const { return std::size_t(sums) * all(); }
    /// The layer of a particle as a bit.
    MORAINE_HD Layers layer(std::size_t column, double z) const {
        using std::floor;
        const double k = floor((z - this->floor[column]) / places.cell);
        return Layers(1) << static_cast<int>(k < 0 ? 0.0 : (k > 63 ? 63.0 : k));
    }
    MORAINE_HD bool is_summed(std::size_t column, double z) const {
        return !resting || (resting[column] & layer(column, z));
    }

    MORAINE_HD static std::int64_t whole(double value) {
        using std::llround;
        const double most = 9e15;
        return llround(value < -most ? -most : (value > most ? most : value));
    }
    template <class Real>
    static MORAINE_HD double square_of(const Vec<Real, 3>& v) {
        double square = 0;
        for (int a = 0; a < 3; ++a) square += rounded_product(double(v[a]), double(v[a]));
        return square;
    }
    /// Calls add(sum, whole number) for a particle of volume V, mass m and velocity v.
    template <class Real, class Add>
    MORAINE_HD void add_particle(double V, double m, const Vec<Real, 3>& v, const Add& add) const {
        add(0, whole(V / volume_unit));
        add(1, whole(m / mass_unit));
        for (int a = 0; a < 3; ++a) add(2 + a, whole(rounded_product(m, double(v[a])) / momentum_unit));
    }
};

/// A straight piece of a line in plan.
struct PlanSegment {
    double from[2], to[2];  ///< [m]
};

/// Pieces of all lines, and how near to one of them is near.
struct PlanLines {
    PlanPlaces places;
    const PlanSegment* segment;
    int count;
    double reach;  ///< [m]

    MORAINE_HD bool is_near(double x, double y, double within) const {
        for (int k = 0; k < count; ++k) {
            const PlanSegment& s = segment[k];
            const double ex = s.to[0] - s.from[0], ey = s.to[1] - s.from[1];
            const double px = x - s.from[0], py = y - s.from[1];
            const double along = rounded_product(px, ex) + rounded_product(py, ey);
            double t = along / (rounded_product(ex, ex) + rounded_product(ey, ey));
            t = t < 0 ? 0 : (t > 1 ? 1 : t);
            const double dx = px - rounded_product(t, ex), dy = py - rounded_product(t, ey);
            if (rounded_product(dx, dx) + rounded_product(dy, dy) < rounded_product(within, within)) return true;
        }
        return false;
    }
    /// Whether a particle of the block at `position` may be near.
    template <int Dim>
    MORAINE_HD bool is_near_block(const Vec<std::int32_t, Dim>& position) const {
        const double half_diagonal = 2.8285 * places.cell;
        return is_near(places.at(0, position[0], 2), places.at(1, position[1], 2), reach + half_diagonal);
    }
};

/// A particle near a line.
struct NearParticle {
    std::uint64_t id;
    double x[2];          ///< [m]
    double volume, mass;  ///< [m3, kg]
};

}  // namespace moraine
