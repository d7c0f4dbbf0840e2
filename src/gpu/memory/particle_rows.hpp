#pragma once
// A particle on the device: rows of four reals, one column each, so that a row is one or two 16-byte accesses and a
// row of doubles one 32-byte sector: a particle read out of order costs no more bytes. Which lanes hold what is said
// by the table of core/particles/particle_state.hpp; what has no row there has a column of its own.
//
// x are the fixed-point places of core/data/position.hpp; their bits are kept in reals' clothes: a row is only copied.

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <type_traits>

#include "core/particles/particle_state.hpp"

namespace moraine::gpu {

template <class Real>
struct alignas(4 * sizeof(Real)) Row {
    Real e[4];
};

/// Rows that every particle has, and those of the others.
template <int Dim>
inline constexpr int core_rows = rows_of<Dim>(RowGroup::core);
template <int Dim>
inline constexpr int affine_rows = rows_of<Dim>(RowGroup::affine);
template <int Dim>
inline constexpr int stretch_rows = rows_of<Dim>(RowGroup::stretch);

template <int Dim>
inline constexpr int load_rows = rows_of<Dim>(RowGroup::load);

/// Rows of all groups.
template <int Dim>
inline constexpr int all_rows = core_rows<Dim> + affine_rows<Dim> + stretch_rows<Dim> +
                                rows_of<Dim>(RowGroup::box) + load_rows<Dim>;

/// A variable that the table gives no row has a column of its own here, if it is a real (or the id, or the body); what
/// else is whole numbers is apart (rest_words.hpp), or of scenes that devices do not have. Calls f(variable, number)
/// for those that are reals.
template <int Dim, class F>
constexpr void each_own_column(const F& f) {
    int number = 0;
    each_variable<double, Dim>([&](const auto& v) {
        constexpr bool integer = std::is_integral_v<typename std::decay_t<decltype(v)>::Type>;
        if (v.places[0].lanes == 0 && v.lives == Lifetime::run && !integer) f(v, number++);
    });
}

/// How many there are, or the number of one of them (-1: there is none of the name).
template <int Dim>
consteval int own_columns(std::string_view name = {}) {
    int count = 0, found = -1;
    each_own_column<Dim>([&](const auto& v, int number) {
        if (name == v.name) found = number;
        ++count;
    });
    return name.empty() ? count : found;
}

/// Whether every variable that has no row can do without.
template <int Dim>
consteval bool own_columns_are_reals() {
    bool right = true;
    each_own_column<Dim>(
        [&](const auto& v, int) { right = right && std::is_same_v<typename std::decay_t<decltype(v)>::Type, double>; });
    return right;
}
static_assert(own_columns_are_reals<2>() && own_columns_are_reals<3>());

/// The core rows by name. Which row a name lives in is known to the compiler: rows not used are not loaded.
template <class Real, int Dim>
struct CoreRows {
    Row<Real> row[core_rows<Dim>];

    static constexpr int place = place_of<Dim>("position").row, motion = place_of<Dim>("velocity").row;
    static constexpr int volume_row = place_of<Dim>("volume").row, ln_J_row = place_of<Dim>("ln_J").row;
    static constexpr int normal = place_of<Dim>("stress").row,
                         shear = Dim == 3 ? place_of<Dim>("stress", 1).row : normal;

    MORAINE_HD Coordinate<Real> coordinate(int a) const {
        Coordinate<Real> u;
        std::memcpy(&u, &row[place].e[a], sizeof(u));
        return u;
    }
    MORAINE_HD void set_coordinate(int a, Coordinate<Real> u) { std::memcpy(&row[place].e[a], &u, sizeof(u)); }

    MORAINE_HD Real mass() const { return row[mass_row].e[mass_lane]; }
    MORAINE_HD Real& mass() { return row[mass_row].e[mass_lane]; }
    MORAINE_HD Real velocity(int a) const { return row[motion].e[a]; }
    MORAINE_HD Real& velocity(int a) { return row[motion].e[a]; }
    MORAINE_HD Real volume() const { return row[volume_row].e[volume_lane]; }
    MORAINE_HD Real& volume() { return row[volume_row].e[volume_lane]; }
    MORAINE_HD Real ln_J() const { return row[ln_J_row].e[ln_J_lane]; }
    MORAINE_HD Real& ln_J() { return row[ln_J_row].e[ln_J_lane]; }
    MORAINE_HD Real history() const { return row[history_row].e[history_lane]; }
    MORAINE_HD Real& history() { return row[history_row].e[history_lane]; }
    /// Component k of Sym: xx yy zz xy (yz zx).
    MORAINE_HD Real stress(int k) const { return k < 3 ? row[normal].e[k] : row[shear].e[Dim == 3 ? k - 3 : k]; }
    MORAINE_HD Real& stress(int k) { return k < 3 ? row[normal].e[k] : row[shear].e[Dim == 3 ? k - 3 : k]; }

  private:
    static constexpr int mass_row = place_of<Dim>("mass").row, mass_lane = place_of<Dim>("mass").lane;
    static constexpr int volume_lane = place_of<Dim>("volume").lane;
    static constexpr int ln_J_lane = place_of<Dim>("ln_J").lane;
    static constexpr int history_row = place_of<Dim>("history_0").row, history_lane = place_of<Dim>("history_0").lane;
};

/// Columns by row; null: the scene has no such row.
template <class Real, int Dim>
struct Columns {
    Row<Real>* core[core_rows<Dim>];
    Row<Real>* affine[affine_rows<Dim>];
    Row<Real>* stretch[stretch_rows<Dim>];  ///< left stretch b
    Row<Real>* log_stretch;
    Row<Real>* load[load_rows<Dim>];  ///< places under tractions, then F - I
    Real* own[own_columns<Dim>()];    ///< reals without a row, in the order of the table
    std::uint64_t* id;
    std::uint16_t* body;  ///< two to a word: there is space for an even number

    /// Of the material's scalar k > 0; the scalar 0 is in the core rows.
    MORAINE_HD Real* history(int k) const { return own[first_history + k]; }

    /// Of row k of a group.
    Row<Real>*& row(RowGroup group, int k) {
        switch (group) {
            case RowGroup::affine:
                return affine[k];
            case RowGroup::stretch:
                return stretch[k];
            case RowGroup::box:
                return log_stretch;
            case RowGroup::load:
                return load[k];
            case RowGroup::core:
                return core[k];
            case RowGroup::own:
                break;
        }
        std::abort();  // it has no rows
    }

  private:
    static constexpr int first_history = own_columns<Dim>("history_1") - 1;
};

/// Calls f(group, row of the group, number of it) for every row that a particle can have, the core rows first.
template <int Dim, class F>
void each_row_of(const F& f) {
    constexpr int rows[row_groups] = {rows_of<Dim>(RowGroup::core), rows_of<Dim>(RowGroup::affine),
                                      rows_of<Dim>(RowGroup::stretch), rows_of<Dim>(RowGroup::box), load_rows<Dim>};
    int number = 0;
    for (int g = 0; g < row_groups; ++g)
        for (int k = 0; k < rows[g]; ++k) f(static_cast<RowGroup>(g), k, number++);
}

/// Whether a scene has a group's rows.
template <int Dim>
bool has_rows(const ColumnNeeds& needs, RowGroup group) {
    bool any = false;
    each_variable<double, Dim>(
        [&](const auto& v) { any = any || (v.places[0].lanes > 0 && v.places[0].group == group && v.present(needs)); });
    return any;
}

}  // namespace moraine::gpu
