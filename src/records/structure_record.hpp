#pragma once
// structures.csv: one row per structure and interval; and what summary.json says of each at the end.
//
// Force and moment [N, N m; 2-D per metre] are means over the time since the row before: impulses over time, exact on
// any number of ranks. A row's displacement and velocity are those at its time. The moment is about the structure's
// reference point (centre, middle, or the plane's point) as it moves.
// impulse_* is what it felt since the start of the run: the momentum that the soil lost to it. work [J] is that of the
// soil on it since then: each node's impulse times the velocity that the structure had in that step. What the soil
// loses besides (friction, the normal blow of a contact) is heat. Where a structure of the scene turns there are
// columns of its orientation and angular velocity: in 2-D an angle [rad], in 3-D a unit quaternion from its axes at the
// start.

#include <string>
#include <vector>

#include "io/csv_log.hpp"
#include "io/json_text.hpp"
#include "simulation/simulation.hpp"

namespace moraine {

template <int Dim>
std::vector<std::string> structure_columns(bool turn) {
    std::vector<std::string> names{"step", "time_s", "structure"};
    const auto per_axis = [&](const std::string& name, const std::string& unit) {
        for (int a = 0; a < Dim; ++a) names.push_back(name + "_" + "xyz"[a] + "_" + unit);
    };
    per_axis("force", "N");
    if (Dim == 2)
        names.push_back("moment_z_N_m");
    else
        per_axis("moment", "N_m");
    per_axis("displacement", "m");
    per_axis("velocity", "m_s");
    per_axis("impulse", "N_s");
    if (!turn) return names;
    if (Dim == 2) {
        names.insert(names.end(), {"angle_rad", "angular_velocity_rad_s"});
        return names;
    }
    for (const char part : {'w', 'x', 'y', 'z'}) names.push_back(std::string("quaternion_") + part);
    per_axis("angular_velocity", "rad_s");
    return names;
}

/// Writes a row per structure. After conclude() only. Collective.
template <class Real, int Dim>
void record_structures(Simulation<Real, Dim>& sim, CsvLog& log) {
    StructureSet<Dim>& set = sim.structures();
    std::vector<StructureSums<Dim>> sums;  // what was felt until now, and until the row before
    for (const StructureState<Dim>& state : set.states()) sums.insert(sums.end(), {state.felt, state.reported});
    sums = sim.comm().exact_sums(sums);
    const double time = sim.clock().time - set.reported_time;
    std::vector<std::vector<CsvCell>> rows;
    for (std::size_t k = 0; k < set.size(); ++k) {
        StructureState<Dim>& state = set.states()[k];
        const StructureSums<Dim>&now = sums[2 * k], &then = sums[2 * k + 1];
        std::vector<CsvCell> row{static_cast<double>(sim.clock().step), sim.clock().time, set.spec(k).name};
        for (std::size_t q = 0; q < Dim + moments<Dim>; ++q) {
            ExactSum gain = then.sum[q];
            gain.negate();
            gain.add(now.sum[q]);
            row.emplace_back(time > 0 ? sim.quantum().value(gain) / time : 0.0);
        }
        for (int a = 0; a < Dim; ++a) row.emplace_back(state.displacement[a]);
        for (int a = 0; a < Dim; ++a) row.emplace_back(state.velocity[a]);
        for (int a = 0; a < Dim; ++a) row.emplace_back(sim.quantum().value(now.sum[a]));
        if (set.any_turns()) {
            row.insert(row.end(), state.turned.e, state.turned.e + Rotation<Dim>::count);
            row.insert(row.end(), state.spin.e, state.spin.e + moments<Dim>);
        }
        rows.push_back(std::move(row));
        state.reported = state.felt;
    }
    log.rows(rows);
    set.reported_time = sim.clock().time;
}

/// What all ranks' nodes gave to each structure since the start of the run. Collective.
template <class Real, int Dim>
std::vector<StructureSums<Dim>> felt_by_structures(const Simulation<Real, Dim>& sim) {
    std::vector<StructureSums<Dim>> mine;
    for (std::size_t k = 0; k < sim.structures().size(); ++k) mine.push_back(sim.structures().state(k).felt);
    return sim.comm().exact_sums(mine);
}

/// Of summary.json, by name. After conclude() only. Collective.
template <class Real, int Dim>
Json structures_in_summary(const Simulation<Real, Dim>& sim) {
    const StructureSet<Dim>& set = sim.structures();
    const std::vector<StructureSums<Dim>> felt = felt_by_structures(sim);
    const double time = sim.clock().time;
    Json::Named all;
    for (std::size_t k = 0; k < set.size(); ++k) {
        const StructureState<Dim>& state = set.state(k);
        std::vector<double> impulse, force, displacement, velocity;
        for (int a = 0; a < Dim; ++a) {
            impulse.push_back(sim.quantum().value(felt[k].sum[a]));
            force.push_back(time > 0 ? impulse.back() / time : 0.0);
            displacement.push_back(state.displacement[a]);
            velocity.push_back(state.velocity[a]);
        }
        Json::Named one{{"impulse_N_s", impulse},
                        {"mean_force_N", force},
                        {"displacement_m", displacement},
                        {"velocity_m_s", velocity},
                        {"work_J", sim.quantum().value(felt[k].sum[StructureSums<Dim>::work])}};
        if (turns(set.spec(k).motion)) {
            const auto turned = std::vector<double>(state.turned.e, state.turned.e + Rotation<Dim>::count);
            one.emplace_back(Dim == 2 ? "angle_rad" : "quaternion", turned);
            one.emplace_back("angular_velocity_rad_s", std::vector<double>(state.spin.e, state.spin.e + moments<Dim>));
        }
        all.emplace_back(set.spec(k).name, one);
    }
    return all;
}

}  // namespace moraine
