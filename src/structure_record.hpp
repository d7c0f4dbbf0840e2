#pragma once
// structures.csv: one row per structure and interval.
//
// Force and moment [N, N m; 2-D per metre] are means over the time since the row before: impulses over time, exact on
// any number of ranks. A row's displacement and velocity are those at its time. The moment is about the structure's
// reference point (centre, middle, or the plane's point) as it moves.
// impulse_* is what it felt since the start of the run: the momentum that the soil lost to it.

#include <string>
#include <vector>

#include "io/records.hpp"
#include "simulation.hpp"

namespace moraine {

template <int Dim>
std::vector<std::string> structure_columns() {
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
    return names;
}

/// Writes a row per structure. After conclude() only. Collective.
template <class Real, int Dim>
void record_structures(Simulation<Real, Dim>& sim, CsvLog& log) {
    StructureSet<Dim>& set = sim.structures();
    std::vector<StructureSums<Dim>> felt, before;
    for (const StructureState<Dim>& state : set.states()) {
        felt.push_back(state.felt);
        before.push_back(state.reported);
    }
    const auto now = sim.sum_of(felt), then = sim.sum_of(before);
    const double time = sim.clock().time - set.reported_time;
    constexpr std::size_t sums = Dim + moments<Dim>;
    for (std::size_t k = 0; k < set.size(); ++k) {
        StructureState<Dim>& state = set.states()[k];
        std::vector<CsvCell> row{static_cast<double>(sim.clock().step), sim.clock().time, set.spec(k).name};
        for (std::size_t q = 0; q < sums; ++q) {
            ExactSum gain = then[k].sum[q];
            gain.negate();
            gain.add(now[k].sum[q]);
            row.emplace_back(time > 0 ? sim.quantum().value(gain) / time : 0.0);
        }
        for (int a = 0; a < Dim; ++a) row.emplace_back(state.displacement[a]);
        for (int a = 0; a < Dim; ++a) row.emplace_back(state.velocity[a]);
        for (int a = 0; a < Dim; ++a) row.emplace_back(sim.quantum().value(now[k].sum[a]));
        log.row(row);
        state.reported = state.felt;
    }
    set.reported_time = sim.clock().time;
}

}  // namespace moraine
