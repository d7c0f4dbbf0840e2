// R9: films of slurry on an incline find their exact velocity profile from rest, and rest below yield.
#include "verification/drive.hpp"
#include "verification/exact_film.hpp"

using namespace moraine;
using namespace moraine::verification;

namespace {

constexpr double young = 2e6;    ///< [Pa]
constexpr double poisson = 0.3;  ///< wave speed 52 m/s: Mach number of the films below 0.02

struct Profile {
    double velocity;  ///< rms error over the surface velocity
    double largest;   ///< largest error over the surface velocity
    double stress;    ///< mean |shear stress - exact| over that at the base
};

Scene film_scene(const Film& film, int cells, const Choice& choice, bool spline = true) {
    Scene scene;
    scene.dimensions = 2;
    scene.cell = film.depth / cells;
    scene.max = {4 * scene.cell, film.depth + 4 * scene.cell, 0};
    scene.boundary_spline = spline;
    scene.cfl = 0.4;
    scene.gravity = {film.pull, -film.press, 0};
    choose(scene, choice);
    make_periodic(scene, 0);
    scene.walls[1][0].kind = WallKind::no_slip;
    scene.materials.push_back(material("herschel-bulkley", film.density,
                                       {{"young", young},
                                        {"poisson", poisson},
                                        {"consistency", film.consistency},
                                        {"yield_stress", film.yield_stress},
                                        {"exponent", film.exponent}}));
    BodySpec body;
    body.max = {scene.max[0], film.depth, 0};
    body.geostatic = true;
    body.geostatic_surface = film.depth;
    scene.bodies.push_back(body);
    return scene;
}

/// From rest under geostatic stress to `end` [s].
Profile flow(const Film& film, int cells, const Choice& choice, double end, bool spline = true) {
    const Scene scene = film_scene(film, cells, choice, spline);
    Run<> run(scene);
    while (run.time() < end) run.steps(50);
    const double volume = scene.max[0] * film.depth;
    const double particle = 0.25 * scene.cell * scene.cell;
    const auto error = [&](const auto& p, std::uint32_t s, const auto&, const auto& x) {
        return std::fabs(p.velocity[s][0] - film.velocity(x[1])) / film.surface_velocity();
    };
    Profile profile;
    profile.largest = run.largest(error);
    profile.velocity = run.sum([&](const auto& p, std::uint32_t s, const auto& X, const auto& x) {
        const double e = error(p, s, X, x);
        return particle * e * e;
    });
    profile.velocity = std::sqrt(profile.velocity / volume);
    profile.stress = run.sum([&](const auto& p, std::uint32_t s, const auto&, const auto& x) {
        return particle * std::fabs(p.stress[s](0, 1) - film.shear_stress(x[1]));
    });
    profile.stress /= volume * film.shear_stress(0);
    return profile;
}

constexpr Film newton{.consistency = 4000};
constexpr Film bingham{.consistency = 2000, .yield_stress = 3200};
constexpr Film herschel_bulkley{.consistency = 3200, .yield_stress = 2400, .exponent = 0.5};

}  // namespace

TEST_CASE("explore") {
    for (const Choice& c : {quadratic_flip_usl, quadratic_apic_usl, gimp_flip_usl, cubic_apic_usf})
        for (bool spline : {true, false})
            for (const Film& f : {newton, bingham, herschel_bulkley}) {
                auto t0 = std::chrono::steady_clock::now();
                for (int n : {10, 20}) {
                Profile r = flow(f, n, c, 3, spline);
                MESSAGE(fmt::format("R9 {} spline {} ty {} n {} cells {} us {:.3f}: v {:.3e} max {:.3e} stress {:.3e} {:.1f}s", c.name, spline, f.yield_stress, f.exponent, n, f.surface_velocity(), r.velocity, r.largest, r.stress, std::chrono::duration<double>(std::chrono::steady_clock::now() - t0).count()));
                }
            }
}
