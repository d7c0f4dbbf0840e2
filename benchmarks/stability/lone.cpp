// S2: what steps a particle alone and a droplet of 2 per axis allow, flying over a grid that is empty but for them.
//
// A particle alone is its own spring. Its pressure p makes velocities dv_i at its nodes, which add to nothing in its
// own velocity and to a gradient in its own strain: with S = sum over the nodes of an axis of (h dN_i)^2 / N_i
//
//   FLIP USL   p <- p (1 - k S),                        k = dt^2 (d lambda + 2 G) / (rho h^2), d axes
//   TPIC USL   C <- C - S p dt / rho h^2, p from C:     a spring with its mass,  k S < 4
//   APIC USL   C <- C - p dt / (rho D h^2), D = 1/4 (quadratic), 1/3 (cubic):  k (2 S - 1 / D) < 4
//
// FLIP keeps no gradient: it is unstable above k S = 2, and never with USF or MUSL, where the gradient is that of a
// velocity without one. h, c and rho are 1; all places lie on the diagonal.

#include <algorithm>
#include <cmath>

#include "core/courant.hpp"
#include "core/data/error.hpp"
#include "core/grid/shape.hpp"
#include "method_name.hpp"
#include "stability/bisect.hpp"
#include "stability/cases.hpp"
#include "verification/problem_cloud.hpp"

namespace moraine {

namespace {

using namespace verification;

constexpr double pressure = 1e-6;  ///< at the start [rho c^2]
constexpr double grows = 1e3;      ///< what is unstable
constexpr double poisson = 0.495;  ///< the slurry's: K is near rho c^2
constexpr double lambda = poisson / (1 - poisson), shear = (1 - 2 * poisson) / (2 * (1 - poisson));
constexpr double young = (1 + poisson) * (1 - 2 * poisson) / (1 - poisson);
constexpr double middle = 0.499;  ///< the light node to be still has some mass there

struct Lone {
    Choice choice;
    int dimensions;
    const char* law;
    int per_axis;  ///< particles: 1 alone, 2 a droplet in one cell
};

MaterialSpec law_of(const Lone& lone) {
    // Bingham: inputs/slurry_runout.toml, with c = 75 m/s and h = 0.1 m.
    return material(lone.law, 1,
                    {{"young", young}, {"poisson", poisson}, {"viscosity", 0.0045}, {"yield_stress", young / 500}});
}

Scene scene_of(const Lone& lone, double place, double courant) {
    Scene scene;
    scene.dimensions = lone.dimensions;
    scene.cell = 1;
    scene.dt = courant;
    scene.limits_light_nodes = false;  // the limits of the method itself
    choose(scene, lone.choice);
    scene.materials.push_back(law_of(lone));
    BodySpec body;
    for (std::size_t a = 0; a < static_cast<std::size_t>(lone.dimensions); ++a) {
        scene.max[a] = 8;
        body.min[a] = 4 + place - 0.25 * lone.per_axis;
        body.max[a] = 4 + place + 0.25 * lone.per_axis;
        make_periodic(scene, a);
    }
    scene.bodies.push_back(body);
    return scene;
}

/// Largest stress or velocity off the drift over the pressure at the start, until it is beyond doubt.
template <int Dim>
double growth(const Lone& lone, double courant, double place, double mach, int steps) {
    Run<double, Dim> run(scene_of(lone, place, courant));
    const Vec<double, Dim> drift = drift_of<Dim>({"", Dim, false, true, mach});
    run.start_with([&](const auto& p, std::uint32_t s, const auto&) {
        p.velocity[s] = drift;
        for (int a = 0; a < 3; ++a) p.stress[s][a] = -pressure * (1 + 0.3 * random_of(p.id[s], 0));
    });
    double most = 0;
    try {
        for (int done = 0; done < steps && most < grows; done += 20) {
            run.steps(20);
            most = run.largest([&](const auto& p, std::uint32_t s, const auto&, const auto&) {
                double size = 0;
                for (int a = 0; a < Dim; ++a) size = std::max(size, std::fabs(p.velocity[s][a] - drift[a]));
                for (int k = 0; k < Sym<double, Dim>::size; ++k) size = std::max(size, std::fabs(p.stress[s][k]));
                return size / pressure;
            });
            if (!std::isfinite(most)) return grows;
        }
    } catch (const PhysicsError&) {
        return grows;
    }
    return most;
}

double limit(const Lone& lone, const std::vector<double>& places, double mach, double guess) {
    const auto stable = [&](double courant) {
        return std::all_of(places.begin(), places.end(), [&](double place) {
            const int steps = mach > 0 ? 4000 : 2000;
            return (lone.dimensions == 2 ? growth<2>(lone, courant, place, mach, steps)
                                         : growth<3>(lone, courant, place, mach, steps)) < grows;
        });
    };
    return largest_stable(stable, guess);
}

/// From a node to the middle: 0, 0.049, 0.099 to 0.499 h.
std::vector<double> all_places() {
    std::vector<double> places{0};
    for (int k = 1; k <= 10; ++k) places.push_back(0.05 * k - 0.001);
    return places;
}

/// S of one axis at a place 0 to 1/2 off a node.
template <class Kind>
double stiffness(double place) {
    double w[Kind::width], dw[Kind::width], sum = 0;
    Kind::weights(place + Kind::template reach<double> - (Kind::width == 4 ? 1 : 0), 0.25, w, dw);
    for (int i = 0; i < Kind::width; ++i) sum += w[i] > 1e-12 ? dw[i] * dw[i] / w[i] : 0;
    return sum;
}

/// The limit above, the least of these places [dt c / h]; NaN: no formula.
double derived(const Lone& lone, const std::vector<double>& places) {
    const Choice& c = lone.choice;
    if (lone.per_axis > 1 || c.update != StressUpdate::usl) return NAN;
    double least = most_courant;
    for (double place : places) {
        const double S = c.shape == Shape::cubic       ? stiffness<Cubic>(place)
                         : c.shape == Shape::quadratic ? stiffness<Quadratic>(place)
                                                       : stiffness<Gimp>(place);
        const double inverse_D = c.shape == Shape::cubic ? 3 : 4;
        const double squared = c.transfer == Transfer::flip   ? 2 / S
                               : c.transfer == Transfer::tpic ? 4 / S
                                                              : 4 / (2 * S - inverse_D);
        least = std::min(least, std::sqrt(squared / (lone.dimensions * lambda + 2 * shear)));
    }
    return least;
}

Finding measure(const Lone& lone) {
    const std::vector<double> all = all_places();
    const double node = limit(lone, {0}, 0, 0.5);
    const double between = limit(lone, {middle}, 0, node);
    const double worst = limit(lone, all, 0, std::min(node, between));
    const double own = 0.8 * stable_courant(lone.choice.shape, lone.choice.transfer, lone.choice.update);
    const double quick = limit(lone, {0}, 0.05, worst), slow = limit(lone, {0}, 0.005, worst);
    return {std::string(lone.choice.name) + (lone.dimensions == 2 ? ", 2-D, " : ", 3-D, ") + lone.law +
                (lone.per_axis > 1 ? ", droplet" : ", alone"),
            {{"at a node", node},
             {"derived at a node", derived(lone, {0})},
             {"in the middle", between},
             {"derived in the middle", derived(lone, {middle})},
             {"worst of 11 places", worst},
             {"derived worst", derived(lone, all)},
             {"adrift at Mach 0.05", quick},
             {"adrift at Mach 0.005", slow},
             {"default step", own}},
            std::nullopt,
            own > std::min({worst, quick, slow}) ? "the default step is above the least of them" : ""};
}

}  // namespace

void find_lone_limits(const Wanted& wanted, const Report& report) {
    const Choice choices[] = {
        quadratic_flip_usl,
        {"quadratic FLIP USF", Shape::quadratic, Transfer::flip, StressUpdate::usf},
        quadratic_flip_musl,
        quadratic_apic_usl,
        quadratic_tpic_usl,
        gimp_flip_usl,
        cubic_flip_usl,
        quadratic_apic_musl,
        {"quadratic TPIC MUSL", Shape::quadratic, Transfer::tpic, StressUpdate::musl},
        cubic_apic_usl,
    };
    for (int per_axis : {1, 2})
        for (int dimensions : {2, 3})
            for (const char* law : {"linear-elastic", "bingham"})
                for (const Choice& choice : choices)
                    if (wanted.names(choice.name)) report(measure({choice, dimensions, law, per_axis}));
}

}  // namespace moraine
