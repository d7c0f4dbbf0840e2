#pragma once
// The state of a particle, declared once: a table of its variables. What follows from it: the columns of the host
// (core/particles/particles.hpp) and their bytes in messages, checkpoints, restarts and outputs, their first values
// (blocks/lattice_fill.hpp), the rows of a device, their packing and refresh (gpu/memory), what travels between devices
// (gpu/exchange) and the memory that a scene will need (predict/memory.cpp).
//
// A new variable is a pointer in ParticleView and an entry here; who needs it is said in core/transfer/method.hpp. The
// scalars of a law need neither: they are history[k], as many as the law says, at most max_history
// (core/material/point.hpp).
//
// A device keeps rows of four reals, one column each, so that a row is one or two 16-byte accesses: RowPlace says
// which lanes of which row hold a variable. A variable without any has a column of its own there (RowGroup::own).

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <utility>

#include "core/data/position.hpp"
#include "core/data/vec.hpp"
#include "core/material/point.hpp"

namespace moraine {

/// Tractions that a scene may have.
inline constexpr int most_tractions = 6;
template <class Real>
using LoadPlace = Vec<Real, most_tractions>;

/// Pointers to the columns; null: the scene has no such column.
template <class Real, int Dim>
struct ParticleView {
    std::uint64_t* id;
    std::uint16_t* body;
    Vec<Coordinate<Real>, Dim>* position;  ///< in the block, fixed point [cells]
    Vec<Real, Dim>* velocity;              ///< [m/s]
    Real* mass;                            ///< [kg]
    Real* volume;                          ///< V0 J [m3]
    Real* ln_J;                            ///< logarithm of the volume ratio [-]
    Sym<Real, Dim>* stress;                ///< Cauchy, tension positive [Pa]
    Mat<Real, Dim>* affine;                ///< C of APIC or TPIC [1/s]
    Sym<Real, Dim>* left_stretch;          ///< b - I, b = F Fᵀ [-]
    Vec<Real, Dim>* log_stretch;           ///< of a contiguous GIMP box, per axis [-]
    Real* history[max_history];            ///< scalars of the material
    Vec<Real, Dim>* body_force;            ///< manufactured acceleration of this step [m/s2]
    LoadPlace<Real>* load_place;           ///< under each traction's surface (core/particles/traction.hpp)
    Mat<Real, Dim>* deformation;           ///< F - I since the start, of scenes with tractions [-]
    Vec<Real, Dim>* load_force;            ///< of tractions in this step, and of water that came or went [N]
    Mat<Real, Dim>* load_couple;           ///< likewise, by axes of the force and the lever [N m]
    Real* pore_pressure;                   ///< of water in the soil, compression positive (fluid/water_cells.hpp) [Pa]
    Vec<Real, Dim>* darcy_velocity;        ///< w = n (v_w - v) [m/s]
    std::uint64_t* rest_place;             ///< place at the last sleep check, and whether asleep (core/sleep/sleep.hpp)
    std::uint64_t* rest_stress;            ///< measures of the stress then

    /// Asks the cache for what P2G reads of slot s. Lists follow memory only while it is fresh: with 5 % of the
    /// particles out of place a step took 1.4 times as long without this.
    MORAINE_HD void fetch(std::uint32_t s) const {
#if defined(__GNUC__) && !defined(__CUDACC__)
        __builtin_prefetch(position + s);
        __builtin_prefetch(velocity + s);
        __builtin_prefetch(mass + s);
        __builtin_prefetch(volume + s);
        __builtin_prefetch(stress + s);
        if (affine) __builtin_prefetch(affine + s);
#endif
    }

    /// And what the gather and the stress update read besides.
    MORAINE_HD void fetch_all(std::uint32_t s) const {
        fetch(s);
#if defined(__GNUC__) && !defined(__CUDACC__)
        __builtin_prefetch(ln_J + s);
        for (int k = 0; k < max_history; ++k)
            if (history[k]) __builtin_prefetch(history[k] + s);
        if (left_stretch) __builtin_prefetch(left_stretch + s);
#endif
    }
};

/// Which optional variables a scene needs.
struct ColumnNeeds {
    bool affine = false;
    bool left_stretch = false;
    bool log_stretch = false;
    int history = 0;
    bool body_force = false;
    bool sleep = false;
    bool loads = false;
    bool water = false;
};

/// Rows of a device that come and go together; own: no row but a column of the variable's own.
enum class RowGroup { core, affine, stretch, box, load, own };
inline constexpr int row_groups = 5;  ///< those that have rows
inline constexpr int most_group_rows = 5;

/// Where a device keeps some components of a variable.
struct RowPlace {
    RowGroup group = RowGroup::own;
    int row = 0;    ///< of the group
    int lane = 0;   ///< the first of the row
    int lanes = 0;  ///< 0: none
    int first = 0;  ///< the component in the first lane
};
using RowPlaces = std::array<RowPlace, 3>;

enum class FirstValue { seed, zero };  ///< the body's seeds have it, or it is zero
/// step: made anew in each, so it is no part of the state; host_run: devices do not have it.
enum class Lifetime { run, step, host_run };

/// One variable: its type, its column of a ParticleView, and all that is known of it.
template <class T, class Pointer>
struct StateVariable {
    using Type = T;
    const char* name;
    const char* unit;
    std::size_t scalar_bytes;
    bool (*present)(const ColumnNeeds&);
    FirstValue starts;
    Pointer pointer;  ///< (view) -> its pointer there
    RowPlaces places = {};
    Lifetime lives = Lifetime::run;

    constexpr int components() const { return static_cast<int>(sizeof(T) / scalar_bytes); }
};

namespace detail {

template <class T, class Pointer>
constexpr auto variable(const char* name, const char* unit, std::size_t scalar, bool (*present)(const ColumnNeeds&),
                        FirstValue starts, Pointer pointer, RowPlaces places = {}, Lifetime lives = Lifetime::run) {
    return StateVariable<T, Pointer>{name, unit, scalar, present, starts, pointer, places, lives};
}

template <int K>
inline constexpr char history_name[] = {'h', 'i', 's', 't', 'o', 'r', 'y', '_', char('0' + K), '\0'};

/// history_0 has a lane that the core rows leave, the others have columns of their own.
template <class Real, int Dim, int... K>
constexpr auto history_variables(std::integer_sequence<int, K...>) {
    static_assert(sizeof...(K) <= 10, "a name has one digit");
    constexpr RowPlaces spare{{{RowGroup::core, Dim == 3 ? 3 : 1, 3, 1}}};
    return std::tuple{variable<Real>(
        history_name<K>, "", sizeof(Real), [](const ColumnNeeds& n) { return n.history > K; }, FirstValue::zero,
        [](auto& v) -> auto& { return v.history[K]; }, K == 0 ? spare : RowPlaces{})...};
}

/// In files and messages behind all others.
template <class Real, int Dim>
constexpr auto sleep_variables() {
    constexpr auto present = [](const ColumnNeeds& n) { return n.sleep; };
    return std::tuple{
        variable<std::uint64_t>(
            "rest_place", "", 8, present, FirstValue::zero, [](auto& v) -> auto& { return v.rest_place; }),
        variable<std::uint64_t>(
            "rest_stress", "", 8, present, FirstValue::zero, [](auto& v) -> auto& { return v.rest_stress; })};
}

/// Of scenes with tractions: on a device six places in two rows, and F - I row by row (2-D: in one).
template <class Real, int Dim>
constexpr auto load_variables() {
    using enum FirstValue;
    using enum RowGroup;
    constexpr RowPlaces six{{{load, 0, 0, 4, 0}, {load, 1, 0, 2, 4}}};
    constexpr RowPlaces matrix = Dim == 3 ? RowPlaces{{{load, 2, 0, 3, 0}, {load, 3, 0, 3, 3}, {load, 4, 0, 3, 6}}}
                                          : RowPlaces{{{load, 2, 0, 4, 0}}};
    constexpr auto present = [](const ColumnNeeds& n) { return n.loads; };
    constexpr std::size_t real = sizeof(Real);
    return std::tuple{
        variable<LoadPlace<Real>>(
            "load_place", "m", real, present, zero, [](auto& v) -> auto& { return v.load_place; }, six),
        variable<Mat<Real, Dim>>(
            "deformation", "", real, present, zero, [](auto& v) -> auto& { return v.deformation; }, matrix),
        variable<Vec<Real, Dim>>(
            "load_force", "N", real, [](const ColumnNeeds& n) { return n.loads || n.water; }, zero,
            [](auto& v) -> auto& { return v.load_force; }, {}, Lifetime::step),
        variable<Mat<Real, Dim>>(
            "load_couple", "N m", real, present, zero, [](auto& v) -> auto& { return v.load_couple; }, {},
            Lifetime::step)};
}

/// Of scenes with water in the ground, which devices refuse.
template <class Real, int Dim>
constexpr auto water_variables() {
    using enum FirstValue;
    constexpr auto present = [](const ColumnNeeds& n) { return n.water; };
    constexpr std::size_t real = sizeof(Real);
    return std::tuple{variable<Real>(
                          "pore_pressure", "Pa", real, present, zero, [](auto& v) -> auto& { return v.pore_pressure; },
                          {}, Lifetime::host_run),
                      variable<Vec<Real, Dim>>(
                          "darcy_velocity", "m/s", real, present, zero,
                          [](auto& v) -> auto& { return v.darcy_velocity; }, {}, Lifetime::host_run)};
}

/// A symmetric tensor in one row of four, or in two of three, from a row of its group on.
template <int Dim>
constexpr RowPlaces tensor_places(RowGroup group, int row) {
    if (Dim == 2) return {{{group, row, 0, 4, 0}}};
    return {{{group, row, 0, 3, 0}, {group, row + 1, 0, 3, 3}}};
}

}  // namespace detail

/// The table: a tuple of StateVariable, in the order of files and messages.
///   3-D   core rows (x y z m) (v V) (sxx syy szz ln J) (sxy syz szx h0)
///   2-D   core rows (x y m V) (v ln J h0) (sxx syy szz sxy)
/// C row by row (2-D: one row), b as the stress, a box's ln stretch in one row.
template <class Real, int Dim>
constexpr auto particle_state() {
    using detail::variable;
    using enum RowGroup;
    using enum FirstValue;
    constexpr bool d3 = Dim == 3;
    constexpr std::size_t real = sizeof(Real);
    constexpr auto always = [](const ColumnNeeds&) { return true; };
    constexpr RowPlaces matrix = d3 ? RowPlaces{{{affine, 0, 0, 3, 0}, {affine, 1, 0, 3, 3}, {affine, 2, 0, 3, 6}}}
                                    : RowPlaces{{{affine, 0, 0, 4, 0}}};
    return std::tuple_cat(
        std::tuple{variable<std::uint64_t>(
                       "id", "", 8, always, seed, [](auto& v) -> auto& { return v.id; }),
                   variable<std::uint16_t>(
                       "body", "", 2, always, seed, [](auto& v) -> auto& { return v.body; }),
                   variable<Vec<Coordinate<Real>, Dim>>(
                       "position", "cell", real, always, seed, [](auto& v) -> auto& { return v.position; },
                       RowPlaces{{{core, 0, 0, Dim}}}),
                   variable<Vec<Real, Dim>>(
                       "velocity", "m/s", real, always, seed, [](auto& v) -> auto& { return v.velocity; },
                       RowPlaces{{{core, 1, 0, Dim}}}),
                   variable<Real>(
                       "mass", "kg", real, always, seed, [](auto& v) -> auto& { return v.mass; },
                       RowPlaces{{{core, 0, Dim, 1}}}),
                   variable<Real>(
                       "volume", "m3", real, always, seed, [](auto& v) -> auto& { return v.volume; },
                       RowPlaces{{{core, d3 ? 1 : 0, 3, 1}}}),
                   variable<Real>(
                       "ln_J", "", real, always, zero, [](auto& v) -> auto& { return v.ln_J; },
                       RowPlaces{{{core, d3 ? 2 : 1, d3 ? 3 : 2, 1}}}),
                   variable<Sym<Real, Dim>>(
                       "stress", "Pa", real, always, seed, [](auto& v) -> auto& { return v.stress; },
                       detail::tensor_places<Dim>(core, 2)),
                   variable<Mat<Real, Dim>>(
                       "affine", "1/s", real, [](const ColumnNeeds& n) { return n.affine; }, zero,
                       [](auto& v) -> auto& { return v.affine; }, matrix),
                   variable<Sym<Real, Dim>>(
                       "left_strain", "", real, [](const ColumnNeeds& n) { return n.left_stretch; }, zero,
                       [](auto& v) -> auto& { return v.left_stretch; }, detail::tensor_places<Dim>(stretch, 0)),
                   variable<Vec<Real, Dim>>(
                       "log_stretch", "", real, [](const ColumnNeeds& n) { return n.log_stretch; }, zero,
                       [](auto& v) -> auto& { return v.log_stretch; }, RowPlaces{{{box, 0, 0, Dim}}})},
        detail::history_variables<Real, Dim>(std::make_integer_sequence<int, max_history>{}),
        std::tuple{variable<Vec<Real, Dim>>(
            "body_force", "m/s2", real, [](const ColumnNeeds& n) { return n.body_force; }, zero,
            [](auto& v) -> auto& { return v.body_force; }, RowPlaces{}, Lifetime::step)},
        detail::sleep_variables<Real, Dim>(), detail::load_variables<Real, Dim>(),
        detail::water_variables<Real, Dim>());
}

/// Calls f(variable) for each entry of the table.
template <class Real, int Dim, class F>
constexpr void each_variable(const F& f) {
    constexpr auto table = particle_state<Real, Dim>();
    std::apply([&](const auto&... v) { (f(v), ...); }, table);
}

/// Rows of a group on a device.
template <int Dim>
consteval int rows_of(RowGroup group) {
    int rows = 0;
    each_variable<double, Dim>([&](const auto& v) {
        for (const RowPlace& p : v.places)
            if (p.lanes > 0 && p.group == group && p.row >= rows) rows = p.row + 1;
    });
    return rows;
}

/// The part-th place of a variable.
template <int Dim>
consteval RowPlace place_of(std::string_view name, std::size_t part = 0) {
    RowPlace found;
    each_variable<double, Dim>([&](const auto& v) {
        if (name == v.name) found = v.places[part];
    });
    return found;
}

/// Whether no two components share a lane, and each has one or its variable a column of its own.
template <int Dim>
consteval bool places_are_right() {
    bool taken[row_groups][most_group_rows][4] = {}, right = true;
    each_variable<double, Dim>([&](const auto& v) {
        int placed = 0;
        for (const RowPlace& p : v.places)
            for (int lane = p.lane; lane < p.lane + p.lanes; ++lane, ++placed) {
                bool& here = taken[static_cast<int>(p.group)][p.row][lane];
                right = right && !here;
                here = true;
            }
        right = right && (placed == v.components() || (placed == 0 && v.components() == 1) || v.lives != Lifetime::run);
    });
    return right;
}
static_assert(places_are_right<2>() && places_are_right<3>());

}  // namespace moraine
