#pragma once
// S1 as a run: a cloud of elastic particles at rest or adrift, each given a random velocity of 1e-9 c. A step is
// unstable if that grows more than a thousandfold. h, c and rho are 1, so scene.dt is the Courant number dt c / h.
//
// Frozen clouds stand still at some offset to the nodes; drifting ones pass all offsets, obliquely to the grid. A full
// cloud fills a periodic domain; a free one has surfaces, whose nodes are light. The strip varies along x alone.

#include "core/data/error.hpp"
#include "verification/run.hpp"

namespace moraine::verification {

struct Cloud {
    const char* name;
    int dimensions;
    bool strip;
    bool free;
    double mach;        ///< of the drift
    double jitter = 0;  ///< share of the particle spacing
    int per_axis = 2;   ///< particles per cell and axis
    double poisson = 0.3;
};

inline constexpr double cloud_perturbation = 1e-9;  ///< [c]
inline constexpr double cloud_growth = 1e3;         ///< of what is unstable

inline Scene cloud_scene(const Cloud& cloud, const Choice& choice, double courant) {
    Scene scene;
    scene.dimensions = cloud.dimensions;
    scene.cell = 1;
    scene.dt = courant;
    scene.limits_light_nodes = false;  // the limits of the method itself
    choose(scene, choice);
    const double nu = cloud.strip ? 0 : cloud.poisson;
    const double young = (1 + nu) * (1 - 2 * nu) / (1 - nu);
    scene.materials.push_back(material("linear-elastic", 1, {{"young", young}, {"poisson", nu}}));
    BodySpec body;
    const double side = cloud.strip ? 16 : (cloud.dimensions == 2 ? 8 : 4);
    for (std::size_t a = 0; a < static_cast<std::size_t>(cloud.dimensions); ++a) {
        const bool across = cloud.strip && a > 0;
        scene.max[a] = across ? 4 : (cloud.free ? 2 * side : side);
        body.max[a] = across ? 4 : side;
        body.particles_per_cell[a] = across ? 1 : cloud.per_axis;
        make_periodic(scene, a);
    }
    if (cloud.jitter > 0) body.seeding = Seeding::jittered, body.jitter = cloud.jitter;
    scene.bodies.push_back(body);
    return scene;
}

/// Velocity of the drift, along x in a strip [c].
template <int Dim>
Vec<double, Dim> drift_of(const Cloud& cloud) {
    constexpr double direction[3] = {0.81, 0.5, 0.305};  // no ratio of small integers
    Vec<double, Dim> v;
    for (int a = 0; a < Dim; ++a) v[a] = cloud.strip ? (a == 0 ? cloud.mach : 0) : cloud.mach * direction[a];
    return v;
}

/// In [-1, 1) by particle and axis (splitmix64).
inline double random_of(std::uint64_t id, int axis) {
    std::uint64_t z = id * 4 + static_cast<std::uint64_t>(axis) + 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return std::ldexp(static_cast<double>((z ^ (z >> 31)) >> 11), -52) - 1;
}

template <class Real, int Dim>
void perturb(Run<Real, Dim>& run, const Cloud& cloud) {
    const Vec<double, Dim> drift = drift_of<Dim>(cloud);
    run.start_with([&](const auto& p, std::uint32_t s, const auto&) {
        for (int a = 0; a < Dim; ++a) {
            const double noise = cloud.strip && a > 0 ? 0 : cloud_perturbation * random_of(p.id[s], a);
            p.velocity[s][a] = static_cast<Real>(drift[a] + noise);
        }
    });
}

/// Largest deviation from the drift over what was given, after so many steps or when it is beyond doubt.
template <int Dim>
double cloud_grows(const Cloud& cloud, const Scene& scene, int steps, double offset) {
    Run<double, Dim> run(scene);
    if (offset > 0) {  // all are moved there in one step
        run.start_with([&](const auto& p, std::uint32_t s, const auto&) {
            for (int a = 0; a < Dim; ++a) p.velocity[s][a] = cloud.strip && a > 0 ? 0 : offset / scene.dt;
        });
        run.steps(1);
    }
    perturb(run, cloud);
    const Vec<double, Dim> drift = drift_of<Dim>(cloud);
    double grown = 0;
    try {
        for (int done = 0; done < steps && grown < cloud_growth; done += 100) {
            run.steps(100);
            const double most = run.largest([&](const auto& p, std::uint32_t s, const auto&, const auto&) {
                double off = 0;
                for (int a = 0; a < Dim; ++a) off = std::max(off, std::fabs(p.velocity[s][a] - drift[a]));
                return off;
            });
            grown = std::isfinite(most) ? most / cloud_perturbation : cloud_growth;
        }
    } catch (const PhysicsError&) {
        return cloud_growth;
    }
    return grown;
}

/// Over 2000 steps at the worst of three offsets, or over 4000 adrift.
inline bool cloud_is_stable(const Cloud& cloud, const Scene& scene) {
    const auto grows = [&](int steps, double offset) {
        return cloud.dimensions == 2 ? cloud_grows<2>(cloud, scene, steps, offset)
                                     : cloud_grows<3>(cloud, scene, steps, offset);
    };
    if (cloud.mach > 0) return grows(4000, 0) < cloud_growth;
    for (double offset : {0.0, 0.125, 0.25})
        if (!(grows(2000, offset) < cloud_growth)) return false;
    return true;
}

inline bool cloud_is_stable(const Cloud& cloud, const Choice& choice, double courant) {
    return cloud_is_stable(cloud, cloud_scene(cloud, choice, courant));
}

}  // namespace moraine::verification
