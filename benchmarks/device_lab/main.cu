// device_lab: the fused step (fused.cuh) beside the program's kernels, on one device.
//
//   device_lab [--edge N] [--steps N] [--warm-up N] [--jitter CELLS] [--check-edge N] [--check-steps N]
//              [--precision single|double|both] [--only check|present|fused]
//
// JSON lines: checks on a small column, then times. Ends with 1 if a check failed.

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include "device_lab/checks.cuh"
#include "device_lab/measure.cuh"

namespace moraine::gpu::lab {

bool failed = false;

void tell(const char* precision, const char* what, bool right, const std::string& more) {
    std::printf("{\"precision\": \"%s\", \"check\": \"%s\", \"right\": %s%s%s}\n", precision, what,
                right ? "true" : "false", more.empty() ? "" : ", ", more.c_str());
    std::fflush(stdout);
    failed = failed || !right;
}
std::string text_of(const TileDifference& d) {
    return number("mass", d.mass) + ", " + number("momentum", d.momentum) + ", " + number("force", d.force) + ", " +
           number("largest_force_N", d.scale[2]);
}
std::string text_of(const Differences& d) {
    return number("place_cells", d.place) + ", " + number("velocity", d.velocity) + ", " + number("stress", d.stress);
}

template <class Real>
Plain<VonMises<Real>> law_of(const Motion& m) {
    const double values[] = {m.young, m.poisson, m.su, 0, 0, 0, 1, 1, 10};
    return Plain<VonMises<Real>>(VonMises<Real>(values));
}

template <class Real, class Plan, class TestPlan, class AheadPlan>
void check_steps(const char* precision, const Options& o) {
    using Law = Plain<VonMises<Real>>;
    const double rounding = sizeof(Real) == 8 ? 1e-12 : 1e-5;
    ColumnPlan plan = o.plan;
    plan.edge = o.check_edge;
    const Motion motion;
    const Column<Real> column(plan, motion);
    const Law law = law_of<Real>(motion);
    Present<Real, Law> present(column, motion, law);
    FusedShare<Real, Law, Plan> fused(column, motion, law), reversed(column, motion, law, true);
    FusedShare<Real, Law, TestPlan> crowded(column, motion, law);
    FusedShare<Real, Law, AheadPlan> ahead(column, motion, law);
    ahead.link(true);
    for (int i = 1; i <= o.check_steps; ++i) {
        present.step(unmarked), fused.step(unmarked), reversed.step(unmarked), crowded.step(unmarked);
        ahead.step(unmarked);
        if (i != 1 && i != 2 && i != o.check_steps) continue;
        present.p2g();
        check(cudaDeviceSynchronize(), "Checking");
        const double allowed = rounding * (i < 3 ? 1 : 1000);
        const TileDifference tiles = compare_tiles(fused.memory(), present.memory());
        tell(precision, "tiles as the program's", tiles.largest() < allowed, number("step", i) + ", " + text_of(tiles));
        std::vector<std::uint8_t> found(column.particle.size(), 0);
        const auto particles = particles_of(fused, found);
        tell(precision, "each particle once", std::count(found.begin(), found.end(), 1) == long(found.size()),
             number("step", i));
        const Differences d = compare(particles, particles_of(present));
        tell(precision, "particles as the program's", std::max({d.place, d.velocity, d.stress}) < allowed * 10,
             number("step", i) + ", " + text_of(d));
        const TileDifference host = compare_with_host(fused, 7);
        tell(precision, "tiles as sums of the host", host.largest() < rounding,
             number("step", i) + ", " + text_of(host));
    }
    tell(precision, "same bits in another order of blocks", same_bits(fused, reversed), "");
    tell(precision, "same bits with overfull blocks", same_bits(fused, crowded) && crowded.overfulls() > 0,
         number("overfull", crowded.overfulls()));
    tell(precision, "same bits ahead, and linked", same_bits(fused, ahead), number("overfull", ahead.overfulls()));
    tell(precision, "regions large enough", !fused.failed() && !crowded.failed(),
         number("overfull", fused.overfulls()));
}

template <class Real, class Plan>
void measure_fused(const char* name, const char* precision, const Column<Real>& column, const Options& o) {
    const Motion motion;
    using Law = Plain<VonMises<Real>>;
    FusedShare<Real, Law, Plan> fused(column, motion, law_of<Real>(motion));
    const std::string called = name;
    measure(called, precision, column.particle.size(), fused, o);
    if (!Plan::Clocks) {
        print_time((called + ", graph").c_str(), precision, column.particle.size(), time_graph(fused, o.steps), "");
        fused.link(true);
        print_time((called + ", linked").c_str(), precision, column.particle.size(), time_steps(fused, o.steps), "");
        print_time((called + ", linked, graph").c_str(), precision, column.particle.size(), time_graph(fused, o.steps),
                   "");
    }
    std::string shares;
    if (Plan::Clocks) {
        const auto clocks = fused.clocks();
        double sum = 0;
        for (auto c : clocks) sum += double(c);
        for (std::size_t k = 0; k < clocks.size(); ++k)
            shares += ", " + number(clock_names[k], double(clocks[k]) / sum);
    }
    cudaFuncAttributes a{};
    check(cudaFuncGetAttributes(&a, fused.kernel), "Asking");
    int resident = 0;
    check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&resident, fused.kernel, 192, fused.bytes), "Asking");
    tell(precision, "large column whole", !fused.failed(),
         number("overfull", fused.overfulls()) + ", " + number("registers", a.numRegs) + ", " +
             number("spilled_B", double(a.localSizeBytes)) + ", " + number("shared_B", double(fused.bytes)) + ", " +
             number("resident", resident) + shares);
}

template <class Real>
void measure_present(const char* precision, const Column<Real>& column, const Options& o) {
    const Motion motion;
    using Law = Plain<VonMises<Real>>;
    Present<Real, Law> present(column, motion, law_of<Real>(motion));
    measure("present", precision, column.particle.size(), present, o);
    present.refresh_never();
    print_time("present, no refresh", precision, column.particle.size(), time_steps(present, o.steps), "");
    print_time("present, no refresh, graph", precision, column.particle.size(), time_graph(present, o.steps), "");
}

void measure_single(const Column<float>& column, const Options& o) {
    if (o.only.empty() || o.only == "present") measure_present("single", column, o);
    if (!o.only.empty() && o.only != "fused") return;
    measure_fused<float, FusedPlan<768, 1, 3, 2816>>("fused-768x3", "single", column, o);
    measure_fused<float, FusedPlan<576, 1, 3, 2816, true>>("fused-576x3 ahead", "single", column, o);
    measure_fused<float, FusedPlan<576, 1, 4, 2816>>("fused-576x4", "single", column, o);
    measure_fused<float, FusedPlan<768, 1, 3, 2816, false, true>>("fused-768x3 by clocks", "single", column, o);
    measure_fused<float, FusedPlan<576, 1, 3, 2816, true, true>>("fused-576x3 ahead by clocks", "single", column, o);
}

void measure_double(const Column<double>& column, const Options& o) {
    if (o.only.empty() || o.only == "present") measure_present("double", column, o);
    if (!o.only.empty() && o.only != "fused") return;
    measure_fused<double, FusedPlan<640, 2, 2, 1472>>("fused-640x2", "double", column, o);
    measure_fused<double, FusedPlan<640, 2, 2, 1472, true>>("fused-640x2 ahead", "double", column, o);
    measure_fused<double, FusedPlan<640, 2, 2, 1472, false, true>>("fused-640x2 by clocks", "double", column, o);
}

void run(const Options& o) {
    cudaDeviceProp p{};
    check(cudaGetDeviceProperties(&p, 0), "Asking for the device");
    std::printf("{\"device\": \"%s\", \"steps\": %d, \"warm_up\": %d, \"jitter\": %g}\n", p.name, o.steps, o.warm_up,
                o.plan.jitter);
    const auto wants = [&](const char* what) { return o.only.empty() || o.only == what; };
    if (o.precision != "double" && wants("check"))
        check_steps<float, FusedPlan<768, 1, 3, 2816>, FusedPlan<480, 1, 3, 2816>, FusedPlan<576, 1, 3, 2816, true>>(
            "single", o);
    if (o.precision != "single" && wants("check"))
        check_steps<double, FusedPlan<640, 2, 2, 1472>, FusedPlan<480, 2, 2, 1472>, FusedPlan<640, 2, 2, 1472, true>>(
            "double", o);
    for (const int edge : o.edges) {
        ColumnPlan plan = o.plan;
        plan.edge = edge;
        if (o.precision != "double") measure_single(Column<float>(plan, Motion{}), o);
        if (o.precision != "single") measure_double(Column<double>(plan, Motion{}), o);
    }
}

Options options_of(int argc, char** argv) {
    Options o;
    for (int i = 1; i + 1 < argc; i += 2) {
        const std::string key = argv[i], value = argv[i + 1];
        if (key == "--edge")
            o.plan.edge = std::stoi(value);
        else if (key == "--steps")
            o.steps = std::stoi(value);
        else if (key == "--warm-up")
            o.warm_up = std::stoi(value);
        else if (key == "--jitter")
            o.plan.jitter = std::stod(value);
        else if (key == "--check-edge")
            o.check_edge = std::stoi(value);
        else if (key == "--check-steps")
            o.check_steps = std::stoi(value);
        else if (key == "--precision")
            o.precision = value;
        else if (key == "--only")
            o.only = value;
        else
            throw MachineError("No option " + key + ".");
    }
    return o;
}

}  // namespace moraine::gpu::lab

int main(int argc, char** argv) {
    try {
        moraine::gpu::lab::run(moraine::gpu::lab::options_of(argc, argv));
    } catch (const std::exception& e) {
        std::fprintf(stderr, "device_lab: %s\n", e.what());
        return 2;
    }
    return moraine::gpu::lab::failed ? 1 : 0;
}
