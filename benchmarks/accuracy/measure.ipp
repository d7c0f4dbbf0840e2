// One level of each problem. An .ipp: one source per precision includes it, so that both are compiled at once.

#include "accuracy/cases.hpp"
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

/// A run of a flow at the configuration's own fixed step, to `time`.
template <class Real>
void flow(Run<Real>& run, double time) {
    run.steps(static_cast<std::int64_t>(std::ceil(time / run.sim.scene().dt)));
}

inline double fixed_step(const Configuration& c, const Scene& scene) {
    const auto& p = scene.materials[0].parameters;  // young, poisson
    const double modulus = p[0] * (1 - p[1]) / ((1 + p[1]) * (1 - 2 * p[1]));
    return c.cfl * scene.cell / std::sqrt(modulus / scene.materials[0].density);
}

template <class Real>
Measured measure_slurry(const Configuration& c, int cells) {
    Scene scene = slurry_scene(choice_of(c), cells);
    scene.dt = fixed_step(c, scene);
    Run<Real> run(scene);
    flow(run, slurry_time);
    const double runout = front(run.sim) - gate;
    const double error = cells == slurry_reference ? NAN : std::fabs(runout / finest_slurry(c) - 1);
    return measured(run, {{"error", error}, {"runout_m", runout}});
}

template <class Real>
Measured measure_current(const Configuration& c, int cells) {
    Scene scene = current_scene(choice_of(c), cells);
    scene.dt = fixed_step(c, scene);
    Run<Real> run(scene);
    flow(run, current_end);
    const double signed_error = front(run.sim) / huppert_front(run.time()) - 1;
    return measured(run, {{"error", std::fabs(signed_error)}, {"front", signed_error}});
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
            return accuracy::measure_slurry<Real>(c, cells);
        case Problem::current:
            return accuracy::measure_current<Real>(c, cells);
        case Problem::vortex:
            return accuracy::measure_vortex<Real>(c, cells);
        default:
            return accuracy::measure_manufactured<Real>(c, cells, problem.amplitude, problem.jitter);
    }
}

}  // namespace moraine
