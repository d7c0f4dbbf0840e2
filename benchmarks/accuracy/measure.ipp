// One level of each problem. An .ipp: one source per precision includes it, so that both are compiled at once.

#include "accuracy/cases.hpp"
#include "stability/cures.hpp"
#include "verification/problem_bar.hpp"
#include "verification/problem_column.hpp"
#include "verification/problem_flow.hpp"
#include "verification/problem_manufactured.hpp"
#include "verification/problem_vortex.hpp"

namespace moraine {

namespace accuracy {

using namespace verification;

inline Choice choice_of(const Configuration& c) {
    return {"", c.shape, c.transfer, c.update, c.order};
}

template <class Real>
Measured measured(const Run<Real>& run, Norms norms) {
    const RunCounts counts = run.sim.counts_so_far();
    return {std::move(norms),
            static_cast<double>(run.particles()),
            static_cast<double>(counts.steps),
            counts.particle_steps,
            run.spent().wall,
            run.spent().processor};
}

template <class Real>
Measured measure_bar(const Configuration& c, int cells, const Motion& motion) {
    const Bar bar;
    const Scene scene = bar_scene(bar, choice_of(c), motion, cells, c.cfl);
    Run<Real> run(scene);
    const Ringing r = ring(run, bar, 10, motion);
    const double frequency = std::fabs(r.frequency_error), energy = std::fabs(r.energy - 1);
    const double error = frequency > energy || !std::isfinite(frequency) ? frequency : energy;
    return measured(run, {{"error", error}, {"frequency", r.frequency_error}, {"energy", r.energy - 1}});
}

template <class Real>
Measured measure_column(const Configuration& c, int cells) {
    const Column column;
    Scene scene = column_scene(column, cells, choice_of(c), "linear-elastic", true);
    scene.dt = c.cfl * scene.cell / column.wave_speed();
    Run<Real> run(scene);
    const Settled s = settle(run, column, 15);
    return measured(run, {{"stress", s.stress}, {"place", s.settlement}, {"base", s.base}, {"speed_left", s.speed}});
}

template <class Real>
Measured measure_manufactured(const Configuration& c, int cells, double amplitude, double jitter) {
    const Manufactured exact{.amplitude = amplitude, .poisson = 0, .axes = 1};
    Scene scene = square(exact, cells, choice_of(c), true, c.cfl);
    if (jitter > 0) {
        scene.bodies[0].seeding = Seeding::jittered;
        scene.bodies[0].jitter = jitter;
    }
    Run<Real> run(scene, push(exact));
    const Deviation e = manufacture(run, exact);
    return measured(run, {{"displacement", e.displacement}, {"stress", e.stress}});
}

template <class Real>
Measured measure_vortex(const Configuration& c, int cells) {
    const Vortex exact;
    const Scene scene = vortex_scene(exact, cells, choice_of(c), c.cfl);
    Run<Real> run(scene, push(exact));
    return measured(run, {{"place", turn(run, exact)}});
}

inline double fixed_step(const Configuration& c, const Scene& scene) {
    const auto& p = scene.materials[0].parameters;  // young, poisson
    const double modulus = p[0] * (1 - p[1]) / ((1 + p[1]) * (1 - 2 * p[1]));
    return c.cfl * scene.cell / std::sqrt(modulus / scene.materials[0].density);
}

/// Whether a step is fixed, or goes by the program's rule, cfl h / (c + |v|), as fast flows want it.
enum class Steps { fixed, by_rule };

/// A flow by a configuration, on cells as the shipped slurries. Steps are at most `longest`.
template <class Real>
class Flow {
  public:
    Flow(const Scene& scene, const Configuration& c, Steps steps = Steps::fixed)
        : scene_(ready(scene, c, steps)),
          longest_(fixed_step(c, scene) * (c.on_cells ? most_substeps : 1)),
          run_(scene_) {}

    /// To the first step at `time` or after it; where the front is then, between the two steps about it [m].
    double front_at(double time) {
        double place = 0, before = 0;
        while (run_.time() < time) {
            const double left = time - run_.time();
            if (left <= longest_) place = front(run_.sim), before = run_.time();
            run_.steps(std::max<std::int64_t>(1, static_cast<std::int64_t>(left / longest_)));
        }
        return place + (front(run_.sim) - place) * (time - before) / (run_.time() - before);
    }

    Run<Real>& run() { return run_; }

  private:
    static Scene ready(Scene scene, const Configuration& c, Steps steps) {
        scene.cfl = c.cfl;
        if (c.on_cells) cure_fluid(scene, shipped);
        if (!c.on_cells && steps == Steps::fixed) scene.dt = fixed_step(c, scene);
        return scene;
    }

    Scene scene_;     ///< to which the run refers
    double longest_;  ///< [s]
    Run<Real> run_;
};

/// Runout of SEED-1 at `time` over `reference(c)` [m].
template <class Real, class Reference>
Measured measure_slurry(const Configuration& c, int cells, double time, const Reference& reference) {
    Flow<Real> flow(slurry_scene(choice_of(c), cells), c);
    const double runout = flow.front_at(time) - gate;
    return measured(flow.run(), {{"error", std::fabs(runout / reference(c) - 1)}, {"runout_m", runout}});
}

template <class Real>
Measured measure_current(const Configuration& c, int cells) {
    Flow<Real> flow(current_scene(choice_of(c), cells), c);
    const double signed_error = flow.front_at(current_end) / huppert_front(current_end) - 1;
    return measured(flow.run(), {{"error", std::fabs(signed_error)}, {"front", signed_error}});
}

template <class Real>
Measured measure_dam_break(const Configuration& c, int cells) {
    Flow<Real> flow(dam_break_scene(choice_of(c), cells), c, Steps::by_rule);
    const double front = flow.front_at(dam_break_end) - dam_gate;
    return measured(flow.run(), {{"error", ritter_error(flow.run())}, {"front_m", front}});
}

}  // namespace accuracy

template <class Real>
Measured measure(const AccuracyCase& problem, const Configuration& c, int cells) {
    switch (problem.problem) {
        case Problem::bar:
            return accuracy::measure_bar<Real>(c, cells,
                                               problem.drifts ? verification::adrift : verification::free_end);
        case Problem::column:
            return accuracy::measure_column<Real>(c, cells);
        case Problem::slurry:
            return accuracy::measure_slurry<Real>(c, cells, slurry_time, [cells](const Configuration& same) {
                return cells == slurry_reference ? NAN : finest_slurry(same);
            });
        case Problem::slurry_at_rest:
            return accuracy::measure_slurry<Real>(c, cells, slurry_rest_time,
                                                  [](const auto&) { return slurry_rests_at - verification::gate; });
        case Problem::dam_break:
            return accuracy::measure_dam_break<Real>(c, cells);
        case Problem::current:
            return accuracy::measure_current<Real>(c, cells);
        case Problem::vortex:
            return accuracy::measure_vortex<Real>(c, cells);
        default:
            return accuracy::measure_manufactured<Real>(c, cells, problem.amplitude, problem.jitter);
    }
}

}  // namespace moraine
