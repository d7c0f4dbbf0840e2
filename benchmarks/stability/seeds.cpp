// S9: does a result depend on how the particles lie at the start? A slurry (SEED-1), sand (R8, a = 2) and the
// manufactured displacement (E3, A = 0.05), filled by a lattice, by lattices turned against the grid, and at random.
//
// All particles of a filling have one volume, so the density that nodes see at the start is not even: its noise is the
// rms over nodes with the body all around of (sum m w / (rho h^2) - 1), by the quadratic spline.

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/data/error.hpp"
#include "core/grid/shape.hpp"
#include "stability/cases.hpp"
#include "stability/seeding.hpp"
#include "verification/problem_flow.hpp"
#include "verification/problem_manufactured.hpp"

namespace moraine {

namespace {

using namespace verification;

constexpr int seeds = 10;
constexpr double goal = 0.01;  ///< coefficient of variation of the runout
constexpr int slurry_cells = 20, sand_cells = 10, wave_cells = 64;
constexpr Filling fillings[] = {{Filling::lattice, 0},     {Filling::rotated, 17},    {Filling::rotated, 30},
                                {Filling::rotated, 45},    {Filling::jittered, 0.25}, {Filling::jittered, 0.5},
                                {Filling::poisson_disk, 0}};

/// One run: what it gives, and the noise of its density at the start.
struct Seeded {
    double result = NAN;
    double noise = NAN;
};

double density_noise(Simulation<double, 2>& sim) {
    const Scene& scene = sim.scene();
    const BodySpec& body = scene.bodies[0];
    const double h = scene.cell;
    const int n[2] = {static_cast<int>(std::lround(scene.max[0] / h)) + 3,
                      static_cast<int>(std::lround(scene.max[1] / h)) + 3};
    std::vector<double> mass(static_cast<std::size_t>(n[0] * n[1]));
    const ParticleView<double, 2> p = sim.patch().particles.view();
    each_particle(sim, [&](std::uint32_t s, const std::array<double, 2>& x) {
        double w[2][3], dw[3];
        int base[2];
        for (std::size_t a = 0; a < 2; ++a) {
            const double u = x[a] / h + 0.5;  // the stencil begins a node before the nearest one
            base[a] = static_cast<int>(u);
            Quadratic::weights<double>(u - base[a], 0, w[a], dw);
        }
        for (int j = 0; j < 3; ++j)
            for (int i = 0; i < 3; ++i)
                mass[static_cast<std::size_t>(base[0] + i + n[0] * (base[1] + j))] += p.mass[s] * w[0][i] * w[1][j];
    });
    const double full = scene.materials[0].density * h * h;
    double square = 0, count = 0;
    for (int j = 0; j < n[1] - 1; ++j)
        for (int i = 0; i < n[0] - 1; ++i) {
            const double x = (i - 1) * h, y = (j - 1) * h, around = 1.49 * h;  // node 0 is one before the domain
            if (x - around < body.min[0] || x + around > body.max[0]) continue;
            if (y - around < body.min[1] || y + around > body.max[1]) continue;
            square += std::pow(mass[static_cast<std::size_t>(i + n[0] * j)] / full - 1, 2), ++count;
        }
    return std::sqrt(square / count);
}

Seeded run_out(const Scene& scene, double beyond) {
    const Comm comm(MPI_COMM_WORLD);
    Simulation<double, 2> sim(scene, comm);
    sim.seed();
    Seeded out;
    out.noise = density_noise(sim);
    while (sim.clock().time < scene.end) sim.step(), sim.balance();
    sim.conclude();
    out.result = front(sim) - beyond;
    return out;
}

Seeded slurry(const Choice& choice, const Filling& filling, std::uint64_t seed, const std::string& folder) {
    Scene scene = slurry_scene(choice, slurry_cells);
    fill_body(scene, filling, seed, folder);
    return run_out(scene, gate);
}

Seeded sand(const Choice& choice, const Filling& filling, std::uint64_t seed, const std::string& folder) {
    Scene scene = sand_scene(choice, sand_cells, WallKind::friction);
    fill_body(scene, filling, seed, folder);
    return run_out(scene, column_width);
}

/// The largest rms error over A.
Seeded wave(const Choice& choice, const Filling& filling, std::uint64_t seed, const std::string& folder) {
    const Manufactured exact{.amplitude = 0.05, .poisson = 0, .axes = 1};
    Scene scene = square(exact, wave_cells, choice, true, 0.3);
    scene.bodies[0].particles_per_cell = {2, 2, 1};
    fill_body(scene, filling, seed, folder);
    Run<double> run(scene, push(exact));
    Seeded out;
    out.noise = density_noise(run.sim);
    out.result = manufacture(run, exact).displacement;
    return out;
}

struct Problem {
    const char* name;
    const Choice& choice;
    Seeded (*run)(const Choice&, const Filling&, std::uint64_t, const std::string&);
    bool has_goal;
};

constexpr Problem problems[] = {{"SEED-1, 20 s, H0 / 20: runout [m]", quadratic_flip_usl, slurry, true},
                                {"SEED-1, 20 s, H0 / 20: runout [m]", quadratic_apic_usl, slurry, true},
                                {"R8, a = 2, L0 / 10: runout [m]", quadratic_apic_usl, sand, true},
                                {"E3, A = 0.05, 64 cells: error", quadratic_flip_usl, wave, false},
                                {"E3, A = 0.05, 64 cells: error", quadratic_apic_usl, wave, false}};

Finding spread(const Problem& problem, const Filling& filling, const std::string& folder, double& of_lattice) {
    std::vector<double> results;
    double noise = 0;
    std::string why;
    for (int k = 1; k <= (filling.is_random() ? seeds : 1); ++k) {
        try {
            const Seeded one = problem.run(problem.choice, filling, static_cast<std::uint64_t>(k), folder);
            results.push_back(one.result);
            noise = std::max(noise, one.noise);
        } catch (const PhysicsError& e) {
            why = fmt::format("seed {}: {}", k, e.what());
        }
    }
    double mean = 0, square = 0;
    for (double r : results) mean += r / static_cast<double>(results.size());
    for (double r : results) square += (r - mean) * (r - mean);
    if (filling.kind == Filling::lattice) of_lattice = mean;
    const bool random = results.size() > 1;
    const double varies = random ? std::sqrt(square / static_cast<double>(results.size() - 1)) / mean : NAN;
    const bool met = why.empty() && varies <= goal;
    if (why.empty() && filling.is_random() && problem.has_goal && !met) why = "varies by more than 1 %";
    return {fmt::format("{}, {}: {}", problem.name, problem.choice.name, filling.name()),
            {{"runs", static_cast<double>(results.size())},
             {"density noise", noise},
             {"mean", results.empty() ? NAN : mean},
             {"coefficient of variation", varies},
             {"mean over the lattice's", results.empty() ? NAN : mean / of_lattice}},
            filling.is_random() && problem.has_goal ? std::optional(met)
                                                    : (why.empty() ? std::nullopt : std::optional(false)),
            why};
}

}  // namespace

void vary_seeds(const Wanted& wanted, const Report& report) {
    const auto folder = std::filesystem::temp_directory_path() / fmt::format("moraine-seeds-{}", getpid());
    std::filesystem::create_directories(folder);
    for (const Problem& problem : problems) {
        double of_lattice = NAN;
        if (!wanted.names(std::string(problem.name) + ", " + problem.choice.name)) continue;
        for (const Filling& filling : fillings) report(spread(problem, filling, folder.string(), of_lattice));
    }
    std::filesystem::remove_all(folder);
}

}  // namespace moraine
