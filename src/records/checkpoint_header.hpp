#pragma once
// A run's clock, budgets and stages to and from the header of a checkpoint: numbers by name, no particles.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>
#include <vector>

#include "core/structures/structure_set.hpp"
#include "core/transfer/totals.hpp"
#include "io/checkpoint.hpp"
#include "simulation/run_clock.hpp"

namespace moraine {

/// Names of the parts of a budget, and the parts.
template <int Dim, class F>
void each_budget_entry(Budget<Dim>& budget, const F& f) {
    f("work", budget.work);
    f("lost_mass", budget.lost_mass);
    for (std::size_t a = 0; a < Dim; ++a) {
        const std::string axis(1, "xyz"[a]);
        f("impulse_" + axis, budget.impulse[a]);
        f("lost_momentum_" + axis, budget.lost_momentum[a]);
        f("lost_pull_" + axis, budget.lost_gravity_impulse[a]);
    }
}

/// The same of what sleep took; only in scenes with sleep.
template <int Dim, class F>
void each_sleep_entry(Budget<Dim>& budget, const F& f) {
    f("slept_kinetic", budget.slept_kinetic);
    for (std::size_t a = 0; a < Dim; ++a) f("slept_momentum_" + std::string(1, "xyz"[a]), budget.slept_momentum[a]);
}

/// The same of tractions; only in scenes that have some.
template <int Dim, class F>
void each_load_entry(Budget<Dim>& budget, const F& f) {
    f("load_work", budget.load_work);
    for (std::size_t a = 0; a < Dim; ++a) f("load_impulse_" + std::string(1, "xyz"[a]), budget.load_impulse[a]);
}

/// The same of water in the ground; only in scenes that have some.
template <int Dim, class F>
void each_water_entry(Budget<Dim>& budget, const F& f) {
    f("water_drag", budget.water.drag);
    f("water_weight", budget.water.weight);
    for (std::size_t a = 0; a < Dim; ++a) {
        f("water_weight_impulse_" + std::string(1, "xyz"[a]), budget.water.weight_impulse[a]);
        f("water_flux_" + std::string(1, "xyz"[a]), budget.water.flux[a]);
    }
}

/// The same of the energy budget; only in scenes that want it. has_surfaces: they act where they are.
template <int Dim, class F>
void each_energy_entry(Budget<Dim>& budget, bool has_surfaces, const F& f) {
    EnergyAccount& energy = budget.energy;
    f("energy_gain", energy.nodes.gain);
    f("energy_fall", energy.nodes.fall);
    f("energy_contact", energy.nodes.contact);
    f("energy_damping", energy.nodes.damping);
    f("energy_walls", energy.nodes.walls);
    f("energy_put_out", energy.put_out);
    f("energy_lost_kinetic", energy.lost_kinetic);
    f("energy_lost_potential", energy.lost_potential);
    if (!has_surfaces) return;
    f("energy_slaves", energy.nodes.slaves);
    f("energy_pressures", energy.pressures);
}

/// A sum over ranks, as a checkpoint holds it.
inline std::vector<std::int64_t> stored_sum(const ExactSum& sum) {
    return {sum.high, std::bit_cast<std::int64_t>(sum.low)};
}
inline ExactSum sum_of_stored(const CheckpointReader& file, const std::string& name) {
    const auto& words = file.get<std::vector<std::int64_t>>(name);
    if (words.size() != 2) file.refuse(fmt::format("header/{} is no sum", name));
    return {words[0], std::bit_cast<std::uint64_t>(words[1])};
}

/// Gravity of the last step and the work of its changes; only in scenes in which it changes.
template <int Dim>
void save_gravity(const RunClock<Dim>& clock, Budget<Dim>& budget, CheckpointHeader& header) {
    header["gravity"] = std::vector<double>(clock.gravity.begin(), clock.gravity.end());
    header["gravity_work"] = stored_sum(budget.gravity_work);
}
template <int Dim>
void take_gravity(const CheckpointReader& file, RunClock<Dim>& clock, Budget<Dim>& budget) {
    const auto& gravity = file.get<std::vector<double>>("gravity");
    const auto finite = [](double x) { return std::isfinite(x); };
    if (gravity.size() != Dim || !std::all_of(gravity.begin(), gravity.end(), finite))
        file.refuse("no run has such a gravity");
    std::copy(gravity.begin(), gravity.end(), clock.gravity.begin());
    budget.gravity_work = sum_of_stored(file, "gravity_work");
}

/// Stages that have begun: what StageBegin holds of each; only in scenes that have stages.
inline std::vector<double> stored_stages(const std::vector<StageBegin>& stages) {
    std::vector<double> all;
    for (const StageBegin& s : stages)
        all.insert(all.end(), {s.time, static_cast<double>(s.step), s.removed_mass, s.removed_energy, s.added_mass});
    return all;
}
template <int Dim>
void take_stages(const CheckpointReader& file, std::size_t most, RunClock<Dim>& clock) {
    constexpr std::size_t words = 5;
    const auto& all = file.get<std::vector<double>>("stages");
    if (all.empty() || all.size() % words != 0 || all.size() / words > most) file.refuse("no run has such stages");
    double before = 0;
    for (std::size_t k = 0; k < all.size(); k += words) {
        const bool rises = all[k] >= before && all[k] <= clock.time;
        const bool counts = all[k + 1] >= 0 && all[k + 1] <= static_cast<double>(clock.step);
        if (!rises || !counts || !std::all_of(&all[k], &all[k] + words, [](double x) { return std::isfinite(x); }))
            file.refuse("no run has such stages");
        before = all[k];
        clock.stages.push_back({all[k], static_cast<std::int64_t>(all[k + 1]), all[k + 2], all[k + 3], all[k + 4]});
    }
}

/// Absorbing ends, number by number; only in scenes that have them.
template <int Dim>
std::vector<double> stored_ends(const EndNodes<Dim>& ends) {
    std::vector<double> all;
    for (const EndNode<Dim>& e : ends) {
        for (const int n : e.node) all.push_back(n);
        all.insert(all.end(), e.hold.begin(), e.hold.end());
        all.insert(all.end(), e.drag.begin(), e.drag.end());
    }
    return all;
}
template <int Dim>
void take_ends(const CheckpointReader& file, RunClock<Dim>& clock) {
    if (!file.header().contains("ends")) return;
    const auto& all = file.get<std::vector<double>>("ends");
    const auto fits = [](double x) { return std::isfinite(x) && std::fabs(x) < 1e30; };
    if (all.size() % (3 * Dim) != 0 || !std::all_of(all.begin(), all.end(), fits))
        file.refuse("no run has such absorbing ends");
    for (auto from = all.begin(); from != all.end(); from += 3 * Dim) {
        EndNode<Dim> e;
        for (std::size_t a = 0; a < Dim; ++a) {
            const double node = from[static_cast<std::ptrdiff_t>(a)];
            if (std::fabs(node) > 1 << 30 || node != std::floor(node)) file.refuse("no run has such absorbing ends");
            e.node[a] = static_cast<int>(node);
        }
        std::copy_n(from + Dim, Dim, e.hold.begin());
        std::copy_n(from + 2 * Dim, Dim, e.drag.begin());
        const bool rises = clock.ends.empty() || clock.ends.back().node < e.node;
        if (!rises || *std::min_element(e.drag.begin(), e.drag.end()) < 0)
            file.refuse("no run has such absorbing ends");
        clock.ends.push_back(e);
    }
}

/// Names of the sums of all structures, and the sums.
template <int Dim, class F>
void each_structure_sum(StructureSet<Dim>& set, const F& f) {
    for (std::size_t k = 0; k < set.size(); ++k) {
        StructureState<Dim>& state = set.states()[k];
        for (int q = 0; q < StructureSums<Dim>::count; ++q) {
            const std::string at = fmt::format("_{}_{}", set.spec(k).name, q);
            f("pending" + at, state.pending.sum[q]);
            f("felt" + at, state.felt.sum[q]);
            f("reported" + at, state.reported.sum[q]);
        }
        for (int q = 0; turns(set.spec(k).motion) && q < TurningSums<Dim>::count; ++q)
            f(fmt::format("turning_{}_{}", set.spec(k).name, q), state.pending_turning.sum[q]);
    }
}

/// What all structures are at, one after the other.
template <int Dim, class F>
void each_structure_value(StructureSet<Dim>& set, const F& f) {
    for (std::size_t k = 0; k < set.size(); ++k) {
        StructureState<Dim>& state = set.states()[k];
        for (double& value : state.displacement.e) f(value);
        for (double& value : state.velocity.e) f(value);
        for (double& value : state.carried.e) f(value);
        if (!turns(set.spec(k).motion)) continue;
        for (double& value : state.turned.e) f(value);
        for (double& value : state.spin.e) f(value);
        for (double& value : state.carried_spin.e) f(value);
    }
}

template <int Dim>
CheckpointHeader clock_header(const RunClock<Dim>& c) {
    CheckpointHeader h;
    h["step"] = c.step;
    h["round"] = c.round;
    h["clock"] = std::vector<double>{c.time,          c.dt,           c.signal,     c.mass_cutoff,
                                     c.quantum_scale, c.start_strain, c.start_mass, c.start_energy};
    if (c.square_speed > 0) std::get<std::vector<double>>(h["clock"]).push_back(c.square_speed);
    h["pull"] = std::vector<double>(c.gravity_impulse.begin(), c.gravity_impulse.end());
    h["start_momentum"] = std::vector<double>(c.start_momentum.begin(), c.start_momentum.end());
    return h;
}

/// What no run can have written, if anything is: a file can be forged, and the seal is no signature.
template <int Dim>
std::string clock_problem(const RunClock<Dim>& c, bool has_particles) {
    const auto finite = [](double x) { return std::isfinite(x); };
    const auto counts = [](std::int64_t n) { return n >= 0 && n < std::int64_t(1) << 53; };
    int exponent = 0;
    if (!counts(c.step) || !counts(c.round)) return fmt::format("step {}, round {}", c.step, c.round);
    if (!finite(c.time) || c.time < 0) return fmt::format("time {} s", c.time);
    if (!finite(c.dt) || c.dt < 0) return fmt::format("a step of {} s", c.dt);
    if (!finite(c.signal) || c.signal < 0 || (has_particles && c.signal == 0))
        return fmt::format("a signal speed of {} m/s", c.signal);
    if (!finite(c.square_speed) || c.square_speed < 0) return fmt::format("a speed of {} m2/s2", c.square_speed);
    if (has_particles && !(c.mass_cutoff >= 0 && c.mass_cutoff <= 1e-12 * c.start_mass))
        return fmt::format("nodes that count from {} kg on", c.mass_cutoff);
    if (std::frexp(c.quantum_scale, &exponent) != 0.5) return fmt::format("sums in units of 1/{}", c.quantum_scale);
    const auto all_finite = [&](const auto& list) { return std::all_of(list.begin(), list.end(), finite); };
    if (!all_finite(std::array{c.start_strain, c.start_mass, c.start_energy}) || !all_finite(c.gravity_impulse) ||
        !all_finite(c.start_momentum))
        return "a start that is not a number";
    return {};
}

template <int Dim>
RunClock<Dim> clock_of(const CheckpointReader& file) {
    RunClock<Dim> c;
    c.step = file.get<std::int64_t>("step");
    c.round = file.get<std::int64_t>("round");
    const auto& clock = file.get<std::vector<double>>("clock");
    const auto& pull = file.get<std::vector<double>>("pull");
    const auto& momentum = file.get<std::vector<double>>("start_momentum");
    if ((clock.size() != 8 && clock.size() != 9) || pull.size() != Dim || momentum.size() != Dim)
        file.refuse("it is of another number of dimensions");
    c.time = clock[0], c.dt = clock[1], c.signal = clock[2], c.mass_cutoff = clock[3], c.quantum_scale = clock[4];
    if (clock.size() == 9) c.square_speed = clock[8];
    c.start_strain = clock[5], c.start_mass = clock[6], c.start_energy = clock[7];
    std::copy(pull.begin(), pull.end(), c.gravity_impulse.begin());
    std::copy(momentum.begin(), momentum.end(), c.start_momentum.begin());
    const std::string problem = clock_problem(c, file.starts().back() > 0);
    if (!problem.empty()) file.refuse("no run has " + problem);
    return c;
}

/// When the last sleep check was.
template <int Dim>
void take_sleep_check(const CheckpointReader& file, RunClock<Dim>& clock) {
    const auto& time = file.get<std::vector<double>>("sleep_check");
    clock.sleep_step = file.get<std::int64_t>("sleep_step");
    if (time.size() != 1 || !(time[0] == -1 || (time[0] >= 0 && time[0] <= clock.time)) || clock.sleep_step < 0 ||
        clock.sleep_step > clock.step)
        file.refuse("no run has such a last sleep check");
    clock.sleep_check = time[0];
}

template <int Dim>
void take_start_potential(const CheckpointReader& file, RunClock<Dim>& clock) {
    const auto& potential = file.get<std::vector<double>>("start_potential");
    if (potential.size() != 1 || !std::isfinite(potential[0])) file.refuse("no run has such a potential energy");
    clock.start_potential = potential[0];
}

}  // namespace moraine
