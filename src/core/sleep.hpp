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
// All of it is maxima of block and node values that are equal on all ranks.
//
// T is a time and no number of steps: in it what is free falls half a cell, 100 eps at the default, however small the
// steps are; what begins to move is not taken for what rests.
//
// Two words a particle hold x' modulo a block, p and q, and whether it sleeps. All particles of a block sleep or none
// does; so blocks keep their state where they go: to other ranks, and through checkpoints.

#include <bit>
#include <cmath>
#include <cstdint>

#include "core/particle_state.hpp"
#include "core/scene_spec.hpp"

namespace moraine {

/// Between sleep checks [s]; 0: there is no gravity, and the scene says nothing.
inline double sleep_interval(const Scene& scene) {
    const double g = std::hypot(scene.gravity[0], scene.gravity[1], scene.gravity[2]);
    if (scene.sleep.interval > 0) return scene.sleep.interval;
    return g > 0 ? std::sqrt(scene.cell / g) : 0;
}

/// Whether a record of block loads says who would sleep (records/sleep_forecast.hpp).
inline bool forecasts_sleep(const Scene& scene) {
    return scene.output.sleep_forecast && !scene.sleep.on;
}

/// Steps between sleep checks, at least: of fewer a displacement says nothing.
inline constexpr std::int64_t least_sleep_steps = 16;

namespace rest_word {
inline constexpr int bits = 21;  ///< of a place along an axis: of 4 cells
inline constexpr std::uint64_t mask = (std::uint64_t(1) << bits) - 1;
inline constexpr std::uint64_t asleep = std::uint64_t(1) << 63;
}  // namespace rest_word

/// A place in its block, awake.
template <class Real, int Dim>
std::uint64_t rest_place(const Vec<Coordinate<Real>, Dim>& u) {
    std::uint64_t word = 0;
    for (int a = 0; a < Dim; ++a)
        word |= static_cast<std::uint64_t>(u[a] >> (fraction_bits<Real> + 2 - rest_word::bits))
                << (a * rest_word::bits);
    return word;
}

/// Largest displacement along an axis between two places, of any two blocks, if it is below two cells [cells].
template <int Dim>
double displacement_between(std::uint64_t from, std::uint64_t to) {
    double most = 0;
    for (int a = 0; a < Dim; ++a) {
        const std::uint64_t d = ((to >> (a * rest_word::bits)) - (from >> (a * rest_word::bits))) & rest_word::mask;
        const std::uint64_t back = (rest_word::mask + 1 - d) & rest_word::mask;
        most = std::fmax(most, std::ldexp(static_cast<double>(d < back ? d : back), 2 - rest_word::bits));
    }
    return most;
}

/// Mean stress and Mises stress, in single [Pa].
template <class Real, int Dim>
std::uint64_t rest_stress(const Sym<Real, Dim>& stress) {
    const double mean = static_cast<double>(stress.trace()) / 3;
    double square = 0;
    for (int k = 0; k < Sym<Real, Dim>::size; ++k) {
        const double s = static_cast<double>(stress[k]) - (k < 3 ? mean : 0);
        square += (k < 3 ? 1.5 : 3) * s * s;
    }
    return std::uint64_t(std::bit_cast<std::uint32_t>(static_cast<float>(mean))) << 32 |
           std::bit_cast<std::uint32_t>(static_cast<float>(std::sqrt(square)));
}

/// The larger change of the two [Pa].
inline double stress_change(std::uint64_t from, std::uint64_t to) {
    const auto part = [](std::uint64_t word) {
        return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(word)));
    };
    return std::fmax(std::fabs(part(to >> 32) - part(from >> 32)), std::fabs(part(to) - part(from)));
}

/// The thresholds of a scene.
struct SleepRule {
    double displacement;  ///< eps [cells]
    double weight;        ///< delta g 4 h, of unit density [m2/s2]
    double speed;         ///< v_w [m/s]
    double wake;          ///< w [-]
};

inline SleepRule sleep_rule(const Scene& scene) {
    const SleepSpec& s = scene.sleep;
    const double g = std::hypot(scene.gravity[0], scene.gravity[1], scene.gravity[2]);
    return {s.displacement, s.stress * g * 4 * scene.cell, s.wake * s.displacement * scene.cell / sleep_interval(scene),
            s.wake};
}

/// u of a particle by its speed alone.
template <class Real, int Dim>
double activity_by_speed(const SleepRule& rule, const ParticleView<Real, Dim>& p, std::uint32_t s) {
    double square = 0;
    for (int a = 0; a < Dim; ++a)
        square += static_cast<double>(p.velocity[s][a]) * static_cast<double>(p.velocity[s][a]);
    return std::sqrt(square) / rule.speed;
}

/// u of a particle that is awake, by the two words of the last check.
template <class Real, int Dim>
double activity_since(const SleepRule& rule, const ParticleView<Real, Dim>& p, std::uint32_t s, std::uint64_t place,
                      std::uint64_t stress) {
    const double moved = displacement_between<Dim>(place, rest_place<Real, Dim>(p.position[s]));
    const double density = static_cast<double>(p.mass[s]) / static_cast<double>(p.volume[s]);
    const double by_stress = stress_change(stress, rest_stress(p.stress[s])) / (rule.weight * density);
    return std::fmax(std::fmax(moved / rule.displacement, by_stress), activity_by_speed<Real, Dim>(rule, p, s));
}

template <class Real, int Dim>
double activity_of(const SleepRule& rule, const ParticleView<Real, Dim>& p, std::uint32_t s) {
    return activity_since<Real, Dim>(rule, p, s, p.rest_place[s], p.rest_stress[s]);
}

}  // namespace moraine
