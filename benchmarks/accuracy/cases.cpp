#include "accuracy/cases.hpp"

#include <fmt/format.h>

#include "core/courant.hpp"
#include "method_name.hpp"

namespace moraine {

namespace {

constexpr double paper_cfl = 0.3;
constexpr double default_cfl = 0.688;  ///< of a scene that says neither method nor step: quadratic APIC USL

void add(std::vector<Configuration>& all, Shape shape, Transfer transfer, StressUpdate update, double cfl) {
    std::string name = method_name(shape, transfer, update);
    if (cfl != paper_cfl) name += fmt::format(" @{}", cfl);
    all.push_back({name, shape, transfer, update, cfl});
}

void add_on_cells(std::vector<Configuration>& all, Transfer transfer) {
    const std::string name = method_name(Shape::quadratic, transfer, StressUpdate::usl) + " on cells";
    all.push_back({name, Shape::quadratic, transfer, StressUpdate::usl,
                   0.8 * stable_courant(Shape::quadratic, transfer, StressUpdate::usl), 1, true});
}

void add_series(std::vector<Configuration>& all, Shape shape, int order) {
    all.push_back({method_name(shape, Transfer::fmpm, StressUpdate::usl, order), shape, Transfer::fmpm,
                   StressUpdate::usl, paper_cfl, order});
}

std::vector<Configuration> make_configurations() {
    using enum StressUpdate;
    std::vector<Configuration> all;
    add(all, Shape::gimp, Transfer::flip, usl, paper_cfl);  // B0
    add(all, Shape::gimp_contiguous, Transfer::flip, usl, paper_cfl);
    add(all, Shape::gimp_contiguous, Transfer::tpic, usl, paper_cfl);
    for (Shape shape : {Shape::quadratic, Shape::cubic})
        for (Transfer transfer : {Transfer::flip, Transfer::apic, Transfer::tpic})
            for (StressUpdate update : {usl, usf, musl}) add(all, shape, transfer, update, paper_cfl);
    add(all, Shape::gimp, Transfer::flip, usl, 2 * paper_cfl);
    add(all, Shape::gimp_contiguous, Transfer::tpic, usl, 2 * paper_cfl);
    add(all, Shape::quadratic, Transfer::flip, usl, 2 * paper_cfl);  // the default before, and nearly its step
    add(all, Shape::quadratic, Transfer::apic, usl, 2 * paper_cfl);
    add(all, Shape::quadratic, Transfer::apic, usl, default_cfl);
    add(all, Shape::quadratic, Transfer::apic, usf, 2 * paper_cfl);
    add(all, Shape::cubic, Transfer::apic, usl, 2 * paper_cfl);
    add(all, Shape::cubic, Transfer::apic, musl, 2 * paper_cfl);
    for (Transfer transfer : {Transfer::apic, Transfer::aflip}) add_on_cells(all, transfer);
    add_series(all, Shape::gimp_contiguous, 2);
    for (int order : {2, 3}) add_series(all, Shape::quadratic, order);
    add_series(all, Shape::cubic, 3);
    return all;
}

}  // namespace

bool is_for_long_runs(const Configuration& c) {
    const bool wave = c.shape == Shape::gimp_contiguous && c.transfer == Transfer::tpic;
    const bool stress = c.shape == Shape::quadratic && c.transfer != Transfer::tpic && c.update == StressUpdate::usl;
    return c.on_cells || c.name == "gimp FLIP USL" || (c.cfl > paper_cfl && (wave || stress));
}

const std::vector<Configuration>& configurations() {
    static const std::vector<Configuration> all = make_configurations();
    return all;
}

const std::vector<AccuracyCase>& accuracy_cases() {
    static const std::vector<AccuracyCase> all = {
        {.name = "E1",
         .message = "bar, fixed and free, 10 periods; the larger error of frequency and energy",
         .problem = Problem::bar,
         .cells = {16, 32, 64, 128}},
        {.name = "E1-drift",
         .message = "periodic bar adrift at Mach 0.05, 10 periods; the larger error of frequency and energy",
         .problem = Problem::bar,
         .cells = {16, 32, 64},
         .drifts = true},
        {.name = "E2",
         .message = "column under its own weight, k l0 = 0.04; L1 of stress over the base pressure",
         .problem = Problem::column,
         .cells = {4, 8, 16, 32}},
        {.name = "E3-small",
         .message = "manufactured displacement, A = 1e-4; rms displacement over A",
         .problem = Problem::manufactured,
         .cells = {16, 32, 64, 128},
         .amplitude = 1e-4},
        {.name = "E3-large",
         .message = "manufactured displacement, A = 0.05; rms displacement over A",
         .problem = Problem::manufactured,
         .cells = {16, 32, 64, 128, 256},
         .amplitude = 0.05},
        {.name = "E3-jitter",
         .message = "manufactured displacement, A = 0.05, particles jittered by a quarter of their spacing; rms over A",
         .problem = Problem::manufactured,
         .cells = {16, 32, 64, 128},
         .amplitude = 0.05,
         .jitter = 0.25},
        {.name = "E4",
         .message =
             "vortex, A = 1/3; rms place over the ring's middle radius; cells per metre; dt by the present wave speed",
         .problem = Problem::vortex,
         .cells = {16, 32, 64}},
        {.name = "SEED-1",
         .message =
             fmt::format("slurry runout; runout at {} s over that of the same configuration at H0 / {}; cells over "
                         "H0",
                         slurry_time, slurry_reference),
         .problem = Problem::slurry,
         .cells = {10, 20, 40},
         .long_runs = true},
        {.name = "SEED-1-rest",
         .message = fmt::format("slurry at rest; runout at {} s over that of three transfers at H0 / 200; cells over "
                                "H0",
                                slurry_rest_time),
         .problem = Problem::slurry_at_rest,
         .cells = {10, 20, 40},
         .long_runs = true},
        {.name = "dam-break",
         .message = "dam break without viscosity on a smooth bed; L1 of the depth against Ritter's at t sqrt(g / h0) = "
                    "7.5, steps by the program's rule; cells over h0",
         .problem = Problem::dam_break,
         .cells = {10, 20, 40},
         .long_runs = true},
        {.name = "R4",
         .message = "Huppert's viscous current; front at 30 s over the similarity solution's; cells over the block",
         .problem = Problem::current,
         .cells = {5, 10, 20},
         .long_runs = true},
    };
    return all;
}

}  // namespace moraine
