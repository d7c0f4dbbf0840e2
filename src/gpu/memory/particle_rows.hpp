#pragma once
// A particle on the device: rows of four reals, one column each, so that a row is one or two 16-byte accesses and a
// row of doubles one 32-byte sector: a particle read out of order costs no more bytes.
//
//   3-D   (x y z m)   (v V)             (sxx syy szz ln J)   (sxy syz szx h0)
//   2-D   (x y m V)   (v ln J h0)       (sxx syy szz sxy)
//   then, where the scene has them: C row by row (2-D: one row), b (3-D: normal, shear), ln stretch of a box
//
// x are the fixed-point places of core/position.hpp, h0 the material's first scalar. Bits of places are kept in
// reals' clothes: a row is only copied.

#include <cstdint>
#include <cstring>

#include "core/particles.hpp"

namespace moraine::gpu {

template <class Real>
struct alignas(4 * sizeof(Real)) Row {
    Real e[4];
};

/// Rows that every particle has.
template <int Dim>
inline constexpr int core_rows = Dim == 3 ? 4 : 3;
template <int Dim>
inline constexpr int affine_rows = Dim == 3 ? 3 : 1;
template <int Dim>
inline constexpr int stretch_rows = Dim == 3 ? 2 : 1;

/// The core rows by name. Which row a name lives in is known to the compiler: rows not used are not loaded.
template <class Real, int Dim>
struct CoreRows {
    Row<Real> row[core_rows<Dim>];

    static constexpr int place = 0, motion = 1, normal = 2, shear = Dim == 3 ? 3 : 2;

    MORAINE_HD Coordinate<Real> coordinate(int a) const {
        Coordinate<Real> u;
        std::memcpy(&u, &row[place].e[a], sizeof(u));
        return u;
    }
    MORAINE_HD void set_coordinate(int a, Coordinate<Real> u) { std::memcpy(&row[place].e[a], &u, sizeof(u)); }

    MORAINE_HD Real mass() const { return row[place].e[Dim]; }
    MORAINE_HD Real& mass() { return row[place].e[Dim]; }
    MORAINE_HD Real velocity(int a) const { return row[motion].e[a]; }
    MORAINE_HD Real& velocity(int a) { return row[motion].e[a]; }
    MORAINE_HD Real volume() const { return Dim == 3 ? row[motion].e[3] : row[place].e[3]; }
    MORAINE_HD Real& volume() { return Dim == 3 ? row[motion].e[3] : row[place].e[3]; }
    MORAINE_HD Real ln_J() const { return Dim == 3 ? row[normal].e[3] : row[motion].e[2]; }
    MORAINE_HD Real& ln_J() { return Dim == 3 ? row[normal].e[3] : row[motion].e[2]; }
    MORAINE_HD Real history() const { return Dim == 3 ? row[shear].e[3] : row[motion].e[3]; }
    MORAINE_HD Real& history() { return Dim == 3 ? row[shear].e[3] : row[motion].e[3]; }
    /// Component k of Sym: xx yy zz xy (yz zx).
    MORAINE_HD Real stress(int k) const { return k < 3 ? row[normal].e[k] : row[shear].e[Dim == 3 ? k - 3 : k]; }
    MORAINE_HD Real& stress(int k) { return k < 3 ? row[normal].e[k] : row[shear].e[Dim == 3 ? k - 3 : k]; }
};

/// Columns by row; null: the scene has no such row.
template <class Real, int Dim>
struct Columns {
    Row<Real>* core[core_rows<Dim>];
    Row<Real>* affine[affine_rows<Dim>];
    Row<Real>* stretch[stretch_rows<Dim>];  ///< left stretch b
    Row<Real>* log_stretch;
    Real* second_history;
    std::uint64_t* id;
    std::uint16_t* body;  ///< two to a word: there is space for an even number
};

}  // namespace moraine::gpu
