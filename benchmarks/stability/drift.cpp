// S6: what is left of a motion that should go on for ever: a bar that rings for 1000 periods (E1) and a square that
// turns 100 times (E7).
//
// Each at the program's step and, a tenth as long, at a quarter of it: what PIC and its like take is taken per step, so
// at a quarter of the step four times as much goes in the same time. What grows adrift is looked at with half of the
// step as well. The bar has 64 cells per wave and so small an amplitude that waves do not steepen. The square is that
// of the test of E7, ten cells along a side, but softer (fewer steps per turn), and drifts by 113 cells in 100 turns.
// E19 (a million steps at rest) is S15; E12 is in S16.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/courant.hpp"
#include "stability/cases.hpp"
#include "verification/problem_bar.hpp"
#include "verification/problem_rotation.hpp"

namespace moraine {

namespace {

using namespace verification;

constexpr double goal = 0.01;  ///< of the energy, after 100 periods or turns
constexpr int cells_per_wave = 64;
constexpr double heard = 1e-4;  ///< E / E0 below which no frequency is given
constexpr Spin square{.drift = 0.018};
constexpr double young = 1e5;  ///< of the square [Pa]
constexpr double square_cell = 0.1;

struct Method : Choice {
    double flip = 1;  ///< share of FLIP
};

constexpr Method quadratic_aflip{{quadratic_aflip_usl}, standard_flip(Transfer::aflip)};
constexpr Method quadratic_aflip_all{
    {"quadratic AFLIP USL, all of FLIP", Shape::quadratic, Transfer::aflip, StressUpdate::usl}, 1};

constexpr std::initializer_list<Method> methods = {
    {quadratic_flip_usl},
    {{"quadratic FLIP USL, 0.99 of FLIP", Shape::quadratic, Transfer::flip, StressUpdate::usl}, 0.99},
    {{"quadratic FLIP USL, 0.95 of FLIP", Shape::quadratic, Transfer::flip, StressUpdate::usl}, 0.95},
    {{"quadratic PIC USL", Shape::quadratic, Transfer::pic, StressUpdate::usl}, 0},
    {quadratic_apic_usl},
    {quadratic_tpic_usl},
    quadratic_aflip,
    quadratic_aflip_all,
    {{quadratic_aflip_usf}, standard_flip(Transfer::aflip)},
    {{cubic_aflip_usl}, standard_flip(Transfer::aflip)},
    {quadratic_apic_usf},
    {quadratic_fmpm2},
    {quadratic_fmpm3},
    {quadratic_fmpm4},
    {gimp_flip_usl},
    {contiguous_tpic_usl},
};

/// Those that gain energy adrift at the program's step, after some hundred periods.
constexpr std::initializer_list<Method> growing = {
    {quadratic_flip_usl},
    {{"quadratic FLIP USL, 0.99 of FLIP", Shape::quadratic, Transfer::flip, StressUpdate::usl}, 0.99},
    {quadratic_apic_usl},
    {quadratic_tpic_usl},
    quadratic_aflip,
    quadratic_aflip_all,
};

/// A problem at a share of the program's step.
struct Bars {
    const char* name;
    const Motion& motion;
    double share;
    std::vector<double> moments;  ///< [periods]
};

struct Squares {
    const char* name;
    double share;
    std::vector<double> moments;  ///< [turns]
};

const Bars bars[] = {
    {"E1 at rest", faint_free_end, 1, {100, 1000}},
    {"E1 at rest, a quarter of the step", faint_free_end, 0.25, {100}},
    {"E1 adrift", faint_adrift, 1, {100, 1000}},
    {"E1 adrift, a quarter of the step", faint_adrift, 0.25, {100}},
};

const Bars halved[] = {{"E1 adrift, half of the step", faint_adrift, 0.5, {100, 1000}}};

const Squares squares[] = {{"E7", 1, {10, 100}}, {"E7, a quarter of the step", 0.25, {10}}};

/// dt (c + |v|) / h of the program, times the share.
double courant_of(Scene scene, double share) {
    scene.cfl = share * standard_courant(scene);
    return courant_number(scene);
}

void judge(Finding& finding, double energy, const std::string& when) {
    finding.pass = std::fabs(energy - 1) <= goal;
    if (!*finding.pass) finding.why = fmt::format("{:.2g} of the energy {}", energy, when);
}

void ring_on(Finding& finding, const Bars& story, const Method& method) {
    const Bar bar{.speed = story.motion.speed};
    Scene scene = bar_scene(bar, method, story.motion, cells_per_wave, 1);
    scene.flip = method.flip;
    const double longest = scene.dt * courant_of(scene, story.share) / (1 + story.motion.drift / bar.wave_speed());
    scene.dt = bar.period() / std::ceil(bar.period() / longest);
    finding.numbers.emplace_back("dt c / h", scene.dt * bar.wave_speed() / scene.cell);
    Run<> run(scene);
    double at_goal = NAN;
    ring(run, bar, story.moments, story.motion, [&](double periods, const Ringing& r) {
        finding.numbers.emplace_back(fmt::format("E / E0 after {} periods", periods), r.energy);
        finding.numbers.emplace_back(fmt::format("frequency error, {} periods", periods),
                                     r.energy > heard ? r.frequency_error : NAN);
        if (periods == 100) at_goal = r.energy;
    });
    judge(finding, at_goal, "after 100 periods");
}

void turn_on(Finding& finding, const Squares& story, const Method& method) {
    Scene scene = spin_scene(square, method, square_cell, young);
    scene.flip = method.flip;
    scene.cfl = story.share * standard_courant(scene);
    finding.numbers.emplace_back("dt c / h", courant_number(scene));
    const double D = affine_moment(scene);
    Run<> run(scene);
    turn(run, square);
    const double momentum = angular_momentum(run, D)[1], energy = spin_energy(run, D);
    for (double turns : story.moments) {
        while (run.time() < 2 * pi / square.rate * turns) run.steps(20);
        finding.numbers.emplace_back(fmt::format("L / L0 after {} turns", turns),
                                     angular_momentum(run, D)[1] / momentum);
        finding.numbers.emplace_back(fmt::format("E / E0 after {} turns", turns), spin_energy(run, D) / energy);
    }
    judge(finding, spin_energy(run, D) / energy, fmt::format("after {} turns", story.moments.back()));
}

}  // namespace

void drift_on(const Wanted& wanted, const Report& report) {
    tell(wanted, report, bars, methods, ring_on);
    tell(wanted, report, halved, growing, ring_on);
    tell(wanted, report, squares, methods, turn_on);
}

}  // namespace moraine
