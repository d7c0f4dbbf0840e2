#pragma once
// history.csv: what the flow did, at each output time.

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/gravity.hpp"
#include "records/structure_record.hpp"
#include "simulation/diagnostics.hpp"
#include "simulation/gravity_step.hpp"

namespace moraine {

/// Of the unaccounted energy, who took it [J] (core/nodes/node_energy.hpp). What is left of it is the error of the step
/// in time. Negative: gave it.
struct EnergyBudget {
    double transfer = 0;  ///< on the way from particles to nodes and back
    double shift = 0;     ///< by places that changed without a velocity: particle shifting; it lifts mass
    double wall = 0, contact = 0, damping = 0;  ///< contact: less the work on structures, with what is put out of them
    double lost = 0;                            ///< left through open ends, kinetic and potential
    bool has_surfaces = false;                  ///< surfaces act where they are, and the next two are known
    double slave = 0, pressure = 0;             ///< nodes deep in a surface; pressures of cells beside surfaces

    static std::vector<std::string> columns(bool has_surfaces) {
        std::vector<std::string> names{"transfer_J", "shift_J", "wall_J", "contact_J", "damping_J", "lost_J"};
        if (has_surfaces) names.insert(names.end(), {"slave_J", "pressure_J"});
        return names;
    }
    std::vector<double> values() const {
        std::vector<double> v{transfer, shift, wall, contact, damping, lost};
        if (has_surfaces) v.insert(v.end(), {slave, pressure});
        return v;
    }
};

/// What tractions gave.
template <int Dim>
struct TractionRow {
    std::array<double, Dim> impulse{};  ///< [kg m/s]
    double work = 0;                    ///< [J]
};

/// What water in the ground did (core/nodes/water_account.hpp).
template <int Dim>
struct WaterRow {
    std::array<double, Dim> flux{}, weight_impulse{};  ///< momentum that Darcy's flux has gained [kg m/s]
    double drag = 0, weight = 0;                       ///< taken by Darcy's drag, and given by weight [J]

    WaterRow(const WaterAccount<Dim>& account, const Quantum& quantum)
        : drag(quantum.value(account.drag)), weight(quantum.value(account.weight)) {
        for (std::size_t a = 0; a < Dim; ++a) {
            flux[a] = quantum.value(account.flux[a]);
            weight_impulse[a] = quantum.value(account.weight_impulse[a]);
        }
    }
};

/// Numbers of one output time, in the order of their columns.
template <int Dim>
struct TimeSeriesRow {
    std::int64_t step = 0;
    double time = 0, dt = 0;
    Totals<Dim> totals;
    double potential = 0;      ///< -sum m g . (x - domain.min) [J]
    bool falls_round = false;  ///< gravity along a periodic axis: the potential energy jumps where particles come round
    double dissipated = 0;     ///< work of the stresses less what is stored [J]
    double unaccounted = 0;    ///< start energy, with the work of changing gravity, less all of the above and work on
                               ///< structures: transfer, friction on walls, what left [J]
    double front = 0;          ///< see front_of [m]
    std::array<double, Dim> wall_impulse{}, gravity_impulse{}, momentum_error{};
    std::optional<double> gravity_work;     ///< of who changes gravity (core/gravity.hpp); none: it stays [J]
    std::optional<double> base_velocity;    ///< of one that shakes [m/s]
    std::optional<TractionRow<Dim>> loads;  ///< none: the scene has no tractions
    std::optional<WaterRow<Dim>> water;     ///< none: no water in the ground
    std::size_t stage = 0;                  ///< its number, from 1 on; 0: the scene has none
    double slept = 0;                       ///< kinetic energy that sleep took [J]
    double lost_mass = 0;
    std::int64_t lost_particles = 0, particles = 0;
    std::int64_t asleep = -1;  ///< particles; -1: none can in this scene
    double over_filling =
        std::numeric_limits<double>::quiet_NaN();  ///< core/fluid/over_filling.hpp; not a number: not observed
    std::optional<EnergyBudget> energy;            ///< none: the scene does not want it

    static std::vector<std::string> columns(const Scene& scene) {
        std::vector<std::string> names{"step", "time_s", "dt_s", "particles", "mass_kg"};
        const auto per_axis = [&](const std::string& name, const std::string& unit) {
            for (int a = 0; a < Dim; ++a) names.push_back(name + "_" + "xyz"[a] + "_" + unit);
        };
        per_axis("momentum", "kg_m_s");
        for (const char* n :
             {"kinetic_J", "strain_J", "potential_J", "dissipated_J", "unaccounted_J", "front_m", "max_x_m"})
            names.push_back(n);
        per_axis("centre", "m");
        for (const char* n : {"max_speed_m_s", "min_J", "max_J"}) names.push_back(n);
        per_axis("wall_impulse", "kg_m_s");
        per_axis("gravity_impulse", "kg_m_s");
        for (const char* n : {"lost_particles", "lost_mass_kg"}) names.push_back(n);
        per_axis("momentum_error", "kg_m_s");
        names.push_back("over_filling");
        if (scene.sleep.on) names.insert(names.end(), {"asleep", "slept_J"});
        if (!scene.course.stages.empty()) names.emplace_back("stage");
        if (gravity_changes(scene)) names.emplace_back("gravity_work_J");
        if (!scene.course.shaking.table.empty()) names.emplace_back("base_velocity_m_s");
        if (!scene.course.tractions.empty()) {
            per_axis("traction_impulse", "kg_m_s");
            names.emplace_back("traction_work_J");
        }
        if (scene.water.on) {
            per_axis("flux_momentum", "kg_m_s");
            names.insert(names.end(), {"drag_J", "water_weight_J"});
        }
        if (scene.output.energy_budget) {
            const std::vector<std::string> more = EnergyBudget::columns(scene.bed == Bed::surface);
            names.insert(names.end(), more.begin(), more.end());
        }
        return names;
    }

    std::vector<double> values() const {
        std::vector<double> v{static_cast<double>(step), time, dt, static_cast<double>(particles), totals.mass};
        const auto add = [&](const std::array<double, Dim>& x) { v.insert(v.end(), x.begin(), x.end()); };
        add(totals.momentum);
        v.insert(v.end(), {totals.kinetic, totals.strain, potential, dissipated, unaccounted, front, totals.max_x});
        std::array<double, Dim> centre = totals.centre;
        for (double& x : centre) x /= totals.mass > 0 ? totals.mass : 1;
        add(centre);
        v.insert(v.end(), {totals.speed.value, totals.min_J, totals.max_J});
        add(wall_impulse);
        add(gravity_impulse);
        v.insert(v.end(), {static_cast<double>(lost_particles), lost_mass});
        add(momentum_error);
        v.push_back(over_filling);
        if (asleep >= 0) v.insert(v.end(), {static_cast<double>(asleep), slept});
        if (stage > 0) v.push_back(static_cast<double>(stage));
        if (gravity_work) v.push_back(*gravity_work);
        if (base_velocity) v.push_back(*base_velocity);
        if (loads) add(loads->impulse), v.push_back(loads->work);
        if (water) add(water->flux), v.insert(v.end(), {water->drag, water->weight});
        if (energy) {
            const auto more = energy->values();
            v.insert(v.end(), more.begin(), more.end());
        }
        return v;
    }
};

/// Upper end of the last column of cells along x that holds at least a quarter of a cell's volume [m]:
/// stray particles ahead of the flow do not count.
inline double front_of(const std::vector<double>& columns, const Scene& scene) {
    const double least = 0.25 * std::pow(scene.cell, scene.dimensions);
    for (std::size_t c = columns.size(); c > 0; --c)
        if (columns[c - 1] >= least) return std::min(scene.max[0], scene.min[0] + scene.cell * static_cast<double>(c));
    return scene.min[0];
}

/// What the ranks add up for a row, all in one reduction.
template <int Dim>
struct RowSums {
    TotalSums<Dim> totals;
    Budget<Dim> budget;
    NodeVolumes volumes;
    std::int64_t particles = 0, asleep = 0;

    void add(const RowSums& o) {
        totals.add(o.totals);
        volumes.add(o.volumes);
        budget.add(o.budget);
        particles += o.particles;
        asleep += o.asleep;
    }
};

/// work: done on structures [J].
template <int Dim>
EnergyBudget energy_budget_of(const TimeSeriesRow<Dim>& row, const RunClock<Dim>& clock, const Quantum& quantum,
                              const EnergyAccount& account, double work) {
    const auto value = [&](const ExactSum& sum) { return quantum.value(sum); };
    const double lost_kinetic = value(account.lost_kinetic), lost_potential = value(account.lost_potential);
    const double start_kinetic = clock.start_energy - clock.start_strain - clock.start_potential;
    const double put_out = value(account.put_out);
    EnergyBudget energy;
    energy.transfer = start_kinetic + value(account.nodes.gain) - row.totals.kinetic - lost_kinetic;
    energy.shift = clock.start_potential + row.gravity_work.value_or(0) - row.potential - lost_potential -
                   value(account.nodes.fall) - put_out;
    energy.wall = value(account.nodes.walls);
    energy.contact = value(account.nodes.contact) - work + put_out;
    energy.damping = value(account.nodes.damping);
    energy.lost = lost_kinetic + lost_potential;
    energy.slave = value(account.nodes.slaves);
    energy.pressure = value(account.pressures);
    return energy;
}

/// What has changed the momentum, and what is left unexplained. felt: by structures.
template <class Real, int Dim>
void observe_momentum(TimeSeriesRow<Dim>& row, const Simulation<Real, Dim>& sim, const Budget<Dim>& budget,
                      const std::vector<StructureSums<Dim>>& felt) {
    const RunClock<Dim>& clock = sim.clock();
    const auto value = [quantum = sim.quantum()](const ExactSum& sum) { return quantum.value(sum); };
    for (std::size_t a = 0; a < Dim; ++a) {
        row.wall_impulse[a] = value(budget.impulse[a]);
        const double unfelt = row.lost_mass * clock.gravity_impulse[a] - value(budget.lost_gravity_impulse[a]);
        row.gravity_impulse[a] = clock.start_mass * clock.gravity_impulse[a] - unfelt;
        row.momentum_error[a] = row.totals.momentum[a] + value(budget.lost_momentum[a]) - clock.start_momentum[a] -
                                row.gravity_impulse[a] - row.wall_impulse[a];
        if (row.loads) row.momentum_error[a] -= row.loads->impulse[a] = value(budget.load_impulse[a]);
        for (const StructureSums<Dim>& s : felt) row.momentum_error[a] += value(s.sum[a]);
        if (sim.scene().sleep.on) row.momentum_error[a] += value(budget.slept_momentum[a]);
        if (row.water) row.momentum_error[a] += row.water->flux[a] - row.water->weight_impulse[a];
    }
}

/// Binned state only. Three reductions at most. Collective.
template <class Real, int Dim>
TimeSeriesRow<Dim> observe(Simulation<Real, Dim>& sim, const Comm& comm) {
    const Scene& scene = sim.scene();
    const RunClock<Dim>& clock = sim.clock();
    const NodeVolumes volumes = sim.answer(VolumeQuery{}).volumes;
    const Census census = sim.engine().census();
    const RowSums<Dim> all =
        comm.exact_sum(RowSums<Dim>{share_totals(sim), sim.budget(), volumes, census.particles, census.asleep});
    const Budget<Dim>& budget = all.budget;
    const auto value = [quantum = sim.quantum()](const ExactSum& sum) { return quantum.value(sum); };
    TimeSeriesRow<Dim> row;
    row.step = clock.step;
    row.time = clock.time;
    row.dt = clock.dt;
    row.totals = all.totals.value(sim.quantum());
    row.particles = all.particles;
    row.over_filling = all.volumes.over_filling();
    row.lost_particles = budget.lost_count;
    row.lost_mass = value(budget.lost_mass);
    row.front = front_of(column_volumes(sim), scene);
    row.potential = potential_energy(scene, clock.gravity, row.totals);
    for (std::size_t a = 0; a < Dim; ++a) row.falls_round |= scene.periodic[a] && may_fall(scene, a);
    row.dissipated = value(budget.work) - (row.totals.strain - clock.start_strain);
    if (!scene.course.tractions.empty()) row.loads = TractionRow<Dim>{{}, value(budget.load_work)};
    if (scene.water.on) row.water = WaterRow<Dim>(budget.water, sim.quantum());
    const std::vector<StructureSums<Dim>> felt = felt_by_structures(sim);
    observe_momentum(row, sim, budget, felt);
    row.stage = clock.stages.size();
    if (gravity_changes(scene)) row.gravity_work = value(budget.gravity_work);
    if (!scene.course.shaking.table.empty())
        row.base_velocity = base_velocity(scene.course.shaking, shaking_begin(scene, clock), clock.time);
    row.unaccounted = clock.start_energy - row.totals.kinetic - row.totals.strain - row.potential - row.dissipated;
    if (row.gravity_work) row.unaccounted += *row.gravity_work;
    if (row.loads) row.unaccounted += row.loads->work;
    if (row.water) row.unaccounted += row.water->weight - row.water->drag;
    if (scene.sleep.on) {
        row.asleep = all.asleep;
        row.slept = value(budget.slept_kinetic);
        row.unaccounted -= row.slept;
    }
    double work = 0;
    for (const StructureSums<Dim>& s : felt) {
        row.unaccounted -= value(s.sum[StructureSums<Dim>::work]);
        work += value(s.sum[StructureSums<Dim>::work]);
    }
    if (scene.output.energy_budget) {
        row.energy = energy_budget_of(row, clock, sim.quantum(), budget.energy, work);
        row.energy->has_surfaces = scene.bed == Bed::surface;
    }
    return row;
}

}  // namespace moraine
