#pragma once
// S22: a run of a random scene and what is held against it. A scene stands if no step is refused, no particle is lost
// but through an open wall, momentum balances to 1e-10 of M c, and no energy comes from nowhere.
//
// Velocities are half a step older than the places of a step, so its energy is kinetic + work of the stresses - work
// of gravity, the works in the middle of the step; USF's stress is one step older. What is in excess of the start is
// created; of that the mean over the last quarter of the steps less the mean over the quarter before the middle,
// per step between them, over the largest energy that moved. What leaves takes kinetic
// energy away and gives none. S23 counts the energy that C holds as kinetic (affine_energy.hpp); S22's figures are
// without it.

#include <algorithm>
#include <string>
#include <vector>

#include "core/data/error.hpp"
#include "records/time_series.hpp"
#include "verification/affine_energy.hpp"
#include "verification/pressure_noise.hpp"
#include "verification/random_scene.hpp"

namespace moraine::verification {

struct Verdict {
    std::string fault;      ///< the program's words; empty: it ran to the end
    std::int64_t lost = 0;  ///< particles that are neither there nor counted as gone
    double momentum = 0;    ///< largest error over M c
    double created = 0;     ///< energy per step, over what moved [-]
    double noise = 0;       ///< of pore pressure at the end: checkerboard() [-]
    double particles = 0;
    bool stands() const { return fault.empty() && lost == 0 && momentum <= 1e-10 && created <= 1e-6 && noise <= 0.5; }
};

/// The energy of a run, step by step.
class EnergyWatch {
  public:
    explicit EnergyWatch(StressUpdate update) : late_(update == StressUpdate::usf) {}

    /// affine: what C holds [J].
    template <int Dim>
    void look(const TimeSeriesRow<Dim>& row, const Triple& gravity, double affine) {
        double pull = 0;  // gravity's work in this step [J]
        for (std::size_t a = 0; a < Dim; ++a) pull += gravity[a] * row.totals.momentum[a] * row.dt;
        const double kinetic = row.totals.kinetic + affine;
        const double drag = row.water ? row.water->drag : 0, weight = row.water ? row.water->weight : 0;
        kinetic_.push_back(kinetic + drag - weight - fallen_ - 0.5 * pull);
        fallen_ += pull;
        work_.push_back(row.totals.strain + row.dissipated);
        moved_ = std::max(moved_, kinetic + row.totals.strain + drag + std::fabs(row.dissipated));
    }
    double created() const {
        std::vector<double> energy;
        for (std::size_t k = 1; k + 1 < work_.size(); ++k)
            energy.push_back(kinetic_[k] + 0.5 * (work_[k] + work_[late_ ? k + 1 : k - 1]));
        const std::size_t n = energy.size(), quarter = n / 4;
        double before = 0, after = 0;
        for (std::size_t k = 0; k < quarter; ++k)
            before += energy[n / 2 - quarter + k], after += energy[n - quarter + k];
        const double steps = static_cast<double>(n - n / 2) * static_cast<double>(quarter);
        return moved_ > 0 && quarter > 0 ? (after - before) / steps / moved_ : 0;
    }

  private:
    bool late_;
    std::vector<double> kinetic_, work_;
    double moved_ = 0, fallen_ = 0;
};

/// What counts as kinetic energy.
enum class Kinetic { of_velocities, with_affine };

template <class Real, int Dim>
Verdict judge(const Scene& scene, int steps, Kinetic kinetic = Kinetic::of_velocities) {
    const Comm comm(MPI_COMM_WORLD);
    Verdict verdict;
    try {
        Simulation<Real, Dim> sim(scene, comm);
        sim.seed();
        const TimeSeriesRow<Dim> start = observe(sim, comm);
        verdict.particles = static_cast<double>(start.particles);
        EnergyWatch watch(scene.stress_update);
        double signal = 0;  // gone when all have left
        for (int k = 0; k < steps; ++k) {
            sim.step();
            sim.balance();
            sim.conclude();
            const TimeSeriesRow<Dim> row = observe(sim, comm);
            watch.look(row, scene.gravity, kinetic == Kinetic::with_affine ? affine_energy(sim) : 0);
            verdict.lost = std::max(verdict.lost, std::abs(start.particles - row.particles - row.lost_particles));
            signal = std::max(signal, sim.clock().signal);
            for (double error : row.momentum_error)
                verdict.momentum = std::max(verdict.momentum, std::fabs(error) / (start.totals.mass * signal));
        }
        verdict.created = watch.created();
        if (scene.water.on) verdict.noise = checkerboard(sim);
    } catch (const PhysicsError& e) {
        verdict.fault = e.what();
    }
    return verdict;
}

}  // namespace moraine::verification
