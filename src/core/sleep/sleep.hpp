#pragma once
// Sleeping blocks: what has come to rest is left out of the step (docs/adr/0010).
//
// A tile is the private sum of one block, so that of a block whose particles do not change stays right: it stays in the
// sums of the nodes, and the block is left out of P2G and G2P. Support is exact, and no sum changes its order.
//
// At sleep checks, T apart, every block has a measure of activity, the largest of its particles':
//
//   u = max( |x - x'| / eps h,   |dp|, |dq| / (delta rho g 4 h),   |v| / v_w ),      v_w = w eps h / T
//
// with the places x' and the mean stress p and Mises stress q of the last check. U is the largest u of the block and
// its 3^d - 1 neighbours.
//   * An awake block with U < 1 falls asleep: velocities and C become zero. One ring of blocks at rest stays awake.
//   * A sleeper, whose own u is 0, wakes where U > w; in any step in which one of its nodes is faster than v_w, before
//     the gather; and where a particle walks in.
//   * Near structures that move all are awake (core/sleep/sleep_contact.hpp).
// All of it is maxima of block and node values that are equal on all ranks.
//
// T is a time and no number of steps: in it what is free falls half a cell, 100 eps at the default, however small the
// steps are; what begins to move is not taken for what rests.
//
// Two words a particle hold x' modulo a block, p and q, and whether it sleeps. All particles of a block sleep or none
// does; so blocks keep their state where they go: to other ranks, and through checkpoints. Host and device run the same
// lines: host/sleepers.hpp and gpu/kernels/sleep.

#include <bit>
#include <cmath>
#include <cstdint>

#include "core/data/grid_views.hpp"
#include "core/particles/particle_state.hpp"

namespace moraine {

/// Steps between sleep checks, at least: of fewer a displacement says nothing.
inline constexpr std::int64_t least_sleep_steps = 16;

namespace rest_word {
inline constexpr int bits = 21;  ///< of a place along an axis: of 4 cells
inline constexpr std::uint64_t mask = (std::uint64_t(1) << bits) - 1;
inline constexpr std::uint64_t asleep = std::uint64_t(1) << 63;
}  // namespace rest_word

/// A place in its block, awake.
template <class Real, int Dim>
MORAINE_HD std::uint64_t rest_place(const Vec<Coordinate<Real>, Dim>& u) {
    std::uint64_t word = 0;
    for (int a = 0; a < Dim; ++a)
        word |= static_cast<std::uint64_t>(u[a] >> (fraction_bits<Real> + 2 - rest_word::bits))
                << (a * rest_word::bits);
    return word;
}

/// Largest displacement along an axis between two places, of any two blocks, if it is below two cells [cells].
template <int Dim>
MORAINE_HD double displacement_between(std::uint64_t from, std::uint64_t to) {
    constexpr double unit = 4.0 / static_cast<double>(rest_word::mask + 1);
    double most = 0;
    for (int a = 0; a < Dim; ++a) {
        const std::uint64_t d = ((to >> (a * rest_word::bits)) - (from >> (a * rest_word::bits))) & rest_word::mask;
        const std::uint64_t back = (rest_word::mask + 1 - d) & rest_word::mask;
        const double moved = unit * static_cast<double>(d < back ? d : back);
        if (moved > most) most = moved;
    }
    return most;
}

/// Mean stress and Mises stress, in single [Pa].
template <class Real, int Dim>
MORAINE_HD std::uint64_t rest_stress(const Sym<Real, Dim>& stress) {
    using std::sqrt;
    const double mean = static_cast<double>(stress.trace()) / 3;
    double square = 0;
    for (int k = 0; k < Sym<Real, Dim>::size; ++k) {
        const double s = static_cast<double>(stress[k]) - (k < 3 ? mean : 0);
        square += (k < 3 ? 1.5 : 3) * s * s;
    }
    return std::uint64_t(std::bit_cast<std::uint32_t>(static_cast<float>(mean))) << 32 |
           std::bit_cast<std::uint32_t>(static_cast<float>(sqrt(square)));
}

/// The larger change of the two [Pa].
MORAINE_HD double stress_change(std::uint64_t from, std::uint64_t to) {
    using std::fabs;
    using std::fmax;
    const auto part = [](std::uint64_t word) {
        return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(word)));
    };
    return fmax(fabs(part(to >> 32) - part(from >> 32)), fabs(part(to) - part(from)));
}

/// The thresholds of a scene.
struct SleepRule {
    double displacement;  ///< eps [cells]
    double weight;        ///< delta g 4 h, of unit density [m2/s2]
    double speed;         ///< v_w [m/s]
    double wake;          ///< w [-]
    double interval;      ///< T [s]
};

/// What rest is measured by, of a particle.
template <class Real, int Dim>
struct RestSample {
    Vec<Coordinate<Real>, Dim> position;
    Vec<Real, Dim> velocity;
    Real mass, volume;
    Sym<Real, Dim> stress;
};

/// u by speed alone.
template <class Real, int Dim>
MORAINE_HD double activity_by_speed(const SleepRule& rule, const Vec<Real, Dim>& velocity) {
    using std::sqrt;
    double square = 0;
    for (int a = 0; a < Dim; ++a) square += static_cast<double>(velocity[a]) * static_cast<double>(velocity[a]);
    return sqrt(square) / rule.speed;
}

/// u of a particle that is awake, by the two words of the last check.
template <class Real, int Dim>
MORAINE_HD double activity_since(const SleepRule& rule, const RestSample<Real, Dim>& now, std::uint64_t place,
                                 std::uint64_t stress) {
    using std::fmax;
    const double moved = displacement_between<Dim>(place, rest_place<Real, Dim>(now.position));
    const double density = static_cast<double>(now.mass) / static_cast<double>(now.volume);
    const double by_stress = stress_change(stress, rest_stress(now.stress)) / (rule.weight * density);
    return fmax(fmax(moved / rule.displacement, by_stress), activity_by_speed(rule, now.velocity));
}

template <class Real, int Dim>
double activity_since(const SleepRule& rule, const ParticleView<Real, Dim>& p, std::uint32_t s, std::uint64_t place,
                      std::uint64_t stress) {
    return activity_since<Real, Dim>(rule, {p.position[s], p.velocity[s], p.mass[s], p.volume[s], p.stress[s]}, place,
                                     stress);
}

template <class Real, int Dim>
double activity_of(const SleepRule& rule, const ParticleView<Real, Dim>& p, std::uint32_t s) {
    return activity_since<Real, Dim>(rule, p, s, p.rest_place[s], p.rest_stress[s]);
}

enum class SleepChange { none, falls_asleep, wakes };

/// What a sleep check makes of a block with particles; around: U.
MORAINE_HD SleepChange sleep_change(const SleepRule& rule, bool asleep, double around) {
    if (asleep) return around > rule.wake ? SleepChange::wakes : SleepChange::none;
    return around < 1 ? SleepChange::falls_asleep : SleepChange::none;
}

/// Whether a node block has tiles, of sleepers alone. asleep: of own blocks, then ghosts.
template <int Dim>
MORAINE_HD bool has_tiles_of_sleepers_alone(const BlockTable<Dim>& table, const std::int32_t* tile_of,
                                            const std::uint8_t* asleep, int node_block) {
    bool any = false;
    for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
        const std::int32_t source = table.source[node_block * Block<Dim>::corners + delta];
        if (source < 0 || tile_of[source] < 0) continue;
        if (!asleep[source]) return false;
        any = true;
    }
    return any;
}

/// Node n of a tile: at which of the block's corners its node block is, and where in that.
struct CornerNode {
    int corner, at;
};
template <int Dim>
MORAINE_HD CornerNode corner_node(int n, int side) {
    CornerNode node{0, 0};
    for (int a = 0; a < Dim; ++a, n /= side) {
        const int x = n % side;
        node.corner |= (x >> 2) << a;
        node.at |= (x & 3) << (2 * a);
    }
    return node;
}

/// What some nodes of a sleeper's tile tell.
template <int Dim>
struct HeldByNodes {
    bool fast = false;       ///< some node is faster than sleepers bear
    double kinetic = 0;      ///< of the block's mass at the nodes' velocities [J]
    double momentum[Dim]{};  ///< likewise [kg m/s]

    /// A node of velocity v, where the tile has mass m.
    template <class Real>
    MORAINE_HD void add(const SleepRule& rule, double m, const Real* v) {
        double square = 0;
        for (int a = 0; a < Dim; ++a) {
            const double component = static_cast<double>(v[a]);
            momentum[a] += m * component;
            square += component * component;
        }
        kinetic += 0.5 * m * square;
        fast = fast || square > rule.speed * rule.speed;
    }
};

}  // namespace moraine
