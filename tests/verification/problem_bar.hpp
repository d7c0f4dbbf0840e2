#pragma once
// E1 as a run: a bar that rings in its first mode, fixed and free or periodic, at rest or adrift; its frequency and
// energy over whole periods. The velocity starts half a step before, the stress of USF a whole one: at t = 0 the
// error would be of first order in dt.

#include <vector>

#include "verification/exact_bar.hpp"
#include "verification/run.hpp"

namespace moraine::verification {

struct Motion {
    const char* name;
    bool periodic;
    double drift;        ///< [m/s]
    double speed = 0.1;  ///< v0 [m/s]; at a strain of 1 % a wave steepens over 100 periods
};
inline constexpr Motion free_end{"fixed-free", false, 0};
inline constexpr Motion standing{"periodic", true, 0};
inline constexpr Motion adrift{"periodic, drift at Mach 0.05", true, 0.5};
inline constexpr Motion faint_free_end{"fixed-free, v0 = c / 10 000", false, 0, 1e-3};
inline constexpr Motion faint_adrift{"periodic, drift at Mach 0.05, v0 = c / 10 000", true, 0.5, 1e-3};

/// Frequency and energy of the mode over whole periods, against the exact ones.
struct Ringing {
    double frequency_error;  ///< w / w_exact - 1
    double energy;           ///< E / E0, mean over the last period
};

inline Scene bar_scene(const Bar& bar, const Choice& choice, const Motion& motion, int cells_per_wave, double cfl) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = 4 * bar.length / cells_per_wave;
    const bool periodic = motion.periodic;
    const double length = periodic ? 4 * bar.length : bar.length;
    scene.max = {periodic ? length : 1.25 * length, 4 * scene.cell, 0};
    choose(scene, choice);
    make_periodic(scene, 1);
    if (periodic) make_periodic(scene, 0);
    if (!periodic) scene.walls[0][0].kind = WallKind::free_slip;
    scene.dt = cfl * scene.cell / bar.wave_speed();
    scene.materials.push_back(material("linear-elastic", bar.density, {{"young", bar.young}, {"poisson", 0}}));
    BodySpec body;
    body.max = {length, scene.max[1], 0};
    body.particles_per_cell = {2, 1, 1};
    body.velocity[0] = motion.drift;
    scene.bodies.push_back(body);
    return scene;
}

template <class Real>
void pluck(Run<Real>& run, const Bar& bar, double drift) {
    const Scene& scene = run.sim.scene();
    run.start_with([&](const auto& p, std::uint32_t s, const auto& X) {
        p.velocity[s][0] = static_cast<Real>(drift + bar.velocity(X[0], -scene.dt / 2));
        if (p.affine)  // the gradient of that velocity
            p.affine[s](0, 0) = static_cast<Real>(bar.speed * bar.wave_number() * std::cos(bar.wave_number() * X[0]));
        if (scene.stress_update == StressUpdate::usf) p.stress[s][0] = static_cast<Real>(bar.stress(X[0], -scene.dt));
    });
}

/// Rings on to each of the moments [periods], in their order, and then calls heard(moment, Ringing).
template <class Real, class F>
void ring(Run<Real>& run, const Bar& bar, const std::vector<double>& moments, const Motion& motion, const F& heard) {
    const Scene& scene = run.sim.scene();
    const double drift = motion.drift;
    pluck(run, bar, drift);
    const double steps_per_period = bar.period() / scene.dt;
    const double volume = (motion.periodic ? 4 : 1) * bar.length * scene.max[1];
    double before = 1, crossings = 0, first_crossing = 0, last_crossing = 0;
    std::int64_t step = 0;
    for (double periods : moments) {
        const auto last = static_cast<std::int64_t>(std::lround(periods * steps_per_period));
        double energy = 0;
        while (++step <= last) {
            run.steps(1);
            const double amplitude = run.sum([&](const auto& p, std::uint32_t s, const auto& X, const auto&) {
                return p.mass[s] * (p.velocity[s][0] - drift) * bar.shape(X[0]);
            });
            const double t = (static_cast<double>(step) - 0.5) * scene.dt;
            if ((before < 0) != (amplitude < 0)) {
                last_crossing = t - scene.dt * amplitude / (amplitude - before);
                if (crossings++ == 0) first_crossing = last_crossing;
            }
            before = amplitude;
            if (static_cast<double>(last - step) >= steps_per_period - 0.5) continue;
            const auto totals = totals_of(run.sim);
            energy += totals.kinetic + totals.strain - drift * totals.momentum[0] + 0.5 * drift * drift * totals.mass;
        }
        --step;
        const double frequency = pi * (crossings - 1) / (last_crossing - first_crossing);
        heard(periods,
              Ringing{frequency / bar.frequency() - 1, energy / std::round(steps_per_period) / bar.energy(volume)});
    }
}

template <class Real>
Ringing ring(Run<Real>& run, const Bar& bar, double periods, const Motion& motion) {
    Ringing at_end;
    ring(run, bar, {periods}, motion, [&](double, const Ringing& r) { at_end = r; });
    return at_end;
}

}  // namespace moraine::verification
