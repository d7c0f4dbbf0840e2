#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <map>

#include "app/device.hpp"
#include "particle_pressures.hpp"
#include "sample_scenes.hpp"
#include "scene/read_scene.hpp"
#include "simulation/diagnostics.hpp"

// Whole runs on the host and on the device side by side: every field of every particle, the budget, and over-filling.

namespace moraine::test {

struct Values {
    std::string name;
    std::map<std::uint64_t, std::vector<double>> of;  ///< by id
    double scale = 0;                                 ///< largest magnitude
};

/// All real columns and the places [m], by id.
template <class Real, int Dim>
std::vector<Values> values_of(Simulation<Real, Dim>& sim) {
    sim.conclude();
    std::vector<Values> all;
    const auto* id = sim.patch().particles.view().id;
    Values places{"place", {}, 0};
    each_particle(sim, [&](std::uint32_t s, const std::array<double, Dim>& x) {
        places.of[id[s]].assign(x.begin(), x.end());
        for (double v : x) places.scale = std::max(places.scale, std::fabs(v));
    });
    all.push_back(places);
    for (const ColumnBytes& c : sim.patch().particles.columns()) {
        if (c.name == "id" || c.name == "position" || c.name == "body" || c.name.starts_with("rest_")) continue;
        // b - I of a body that nothing strains, and what a law remembers of one that hardly yields, is rounding of
        // about 1e-17: a microstrain is scale enough
        Values column{c.name, {}, c.name == "left_strain" || c.name.starts_with("history") ? 1e-6 : 0};
        each_particle(sim, [&](std::uint32_t s, const std::array<double, Dim>&) {
            const auto* row = reinterpret_cast<const Real*>(c.data + s * c.row_bytes);
            for (std::size_t k = 0; k < c.row_bytes / sizeof(Real); ++k) {
                column.of[id[s]].push_back(static_cast<double>(row[k]));
                column.scale = std::max(column.scale, std::fabs(static_cast<double>(row[k])));
            }
        });
        all.push_back(column);
    }
    return all;
}

struct Outcome {
    std::vector<Values> values;
    std::uint64_t hash;
    double time;
    std::vector<double> budget;
    std::vector<double> over_filling;  ///< on the way, every 20 steps, and at the end
    std::vector<double> felt;          ///< by each structure: the largest of its sums [kg m/s, kg m2/s]
};

template <class Real, int Dim>
void advance(Simulation<Real, Dim>& sim, int steps) {
    for (int k = 0; k < steps; ++k) sim.step(), sim.balance();
    sim.conclude();
}

template <class Real, int Dim>
Outcome run(const Scene& scene, int steps, bool on_device) {
    const Comm comm(MPI_COMM_WORLD);
    const DeviceChoice device = on_device ? choose_device("cuda", comm) : DeviceChoice{};
    Simulation<Real, Dim> sim(scene, comm, on_device ? device_engine_maker<Real, Dim>(scene, comm, device) : nullptr);
    sim.seed();
    std::vector<double> over_filling;
    const auto observe = [&] {
        sim.conclude();
        over_filling.push_back(comm.exact_sum(sim.answer(VolumeQuery{}).volumes).over_filling());
    };
    for (int k = 0; k < steps; ++k) {
        if (k > 0 && k % 20 == 0) observe();
        sim.step(), sim.balance();
    }
    observe();
    Outcome out{values_of(sim), state_hash(sim, true), sim.clock().time, {}, over_filling, {}};
    const Budget<Dim>& budget = sim.budget();
    for (const ExactSum& s : {budget.work, budget.impulse[0], budget.impulse[1], budget.lost_mass,
                              budget.lost_momentum[0], budget.lost_gravity_impulse[1]})
        out.budget.push_back(sim.quantum().value(s));
    out.budget.push_back(static_cast<double>(budget.lost_count));
    for (const ExactSum& s : {budget.load_work, budget.load_impulse[0], budget.load_impulse[Dim - 1]})
        out.budget.push_back(sim.quantum().value(s));
    for (std::size_t k = 0; k < scene.structures.size(); ++k) {
        out.felt.push_back(0);
        for (const ExactSum& s : sim.structures().state(k).felt.sum)
            out.felt[k] = std::max(out.felt[k], std::fabs(sim.quantum().value(s)));
    }
    return out;
}

/// Worst difference of a field over its scale. 1: other particles.
inline double difference(const Values& a, const Values& b) {
    if (a.of.size() != b.of.size()) return 1;
    double worst = 0;
    for (const auto& [id, mine] : a.of) {
        const auto other = b.of.find(id);
        if (other == b.of.end()) return 1;
        for (std::size_t k = 0; k < mine.size(); ++k)
            worst = std::max(worst, std::isfinite(mine[k]) ? std::fabs(mine[k] - other->second[k]) : HUGE_VAL);
    }
    return a.scale > 0 ? worst / a.scale : worst;
}

/// Returns the host's.
template <class Real, int Dim>
Outcome compare_runs(const Scene& scene, int steps, double tolerance) {
    const Outcome host = run<Real, Dim>(scene, steps, false);
    const Outcome device = run<Real, Dim>(scene, steps, true);
    const Outcome again = run<Real, Dim>(scene, steps, true);
    CHECK(device.hash == again.hash);
    CHECK(device.time == doctest::Approx(host.time).epsilon(tolerance));
    for (std::size_t k = 0; k < host.values.size(); ++k) {
        CAPTURE(host.values[k].name);
        const double d = difference(host.values[k], device.values[k]);
        MESSAGE(scene.name << " " << host.values[k].name << ": " << d);
        CHECK(d <= tolerance);
    }
    for (std::size_t k = 0; k < host.over_filling.size(); ++k) {
        CAPTURE(k);
        CHECK(device.over_filling[k] == doctest::Approx(host.over_filling[k]).epsilon(1e3 * tolerance).scale(1));
        CHECK(again.over_filling[k] == device.over_filling[k]);
    }
    for (std::size_t k = 0; k < host.budget.size(); ++k) {
        CAPTURE(k);
        CHECK(device.budget[k] ==
              doctest::Approx(host.budget[k]).epsilon(1e3 * tolerance).scale(std::fabs(host.budget[0])));
    }
    return host;
}

inline Outcome compare(const Scene& scene, int steps, double tolerance) {
    const bool single = scene.precision == Precision::single_;
    if (scene.dimensions == 2)
        return single ? compare_runs<float, 2>(scene, steps, tolerance)
                      : compare_runs<double, 2>(scene, steps, tolerance);
    return single ? compare_runs<float, 3>(scene, steps, tolerance) : compare_runs<double, 3>(scene, steps, tolerance);
}

/// A slurry's pressures are its particles' unless `sets` says otherwise.
inline Scene input(const std::string& name, const std::vector<std::string>& sets) {
    return read_scene(std::string(MORAINE_INPUTS) + "/" + name + ".toml",
                      name.starts_with("slurry") ? particle_pressures(sets) : sets);
}

}  // namespace moraine::test
