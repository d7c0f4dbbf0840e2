#include "step/report.hpp"

#include <fmt/format.h>

namespace moraine {

namespace {

double nanoseconds(double seconds_per_step, const Measured& m) {
    return 1e9 * seconds_per_step / m.particles;
}

double phase(const Measured& m, Phase p) {
    return nanoseconds(m.phases[static_cast<std::size_t>(p)], m);
}

/// Balance looks, agreement, bookkeeping: all of a step that is not named in the table.
double rest(const Measured& m) {
    return nanoseconds(m.step_seconds, m) - phase(m, Phase::p2g) - phase(m, Phase::nodes) - phase(m, Phase::g2p) -
           phase(m, Phase::migrate);
}

}  // namespace

std::string json_line(const Case& c, const Runs& plan, const Measured& m, std::int64_t empty_bytes,
                      const Machine& machine) {
    std::string phases;
    for (std::size_t k = 0; k < Phases::count; ++k)
        phases += fmt::format("{}\"{}\": {:.3f}", k ? ", " : "", Phases::names[k], nanoseconds(m.phases[k], m));
    return fmt::format(
        R"({{"benchmark": "step", "scene": "{}", {}, "ranks": 1, "threads": 1, "work_items": {:.0f}, )"
        R"("runs": {}, "steps_per_run": {}, "median_s": {:.6f}, "spread_s": {:.6f}, "processor_median_s": {:.6f}, )"
        R"("processor_spread_s": {:.6f}, "particle_steps_per_s": {:.0f}, "ns_per_particle_step": {:.3f}, )"
        R"("phase_ns": {{{}}}, "bytes": {}, "seeded_bytes": {}, "bytes_per_particle": {:.1f}, "column_bytes": {:.0f}, )"
        R"("moved_cells": {:.4f}, "yielded": {:.3f}}})",
        c.name, machine_json(machine), m.particles, plan.runs, plan.steps, m.wall.median, m.wall.deviation,
        m.processor.median, m.processor.deviation, m.rate(m.wall, plan), 1e9 / m.rate(m.wall, plan), phases,
        m.peak_bytes, m.seeded_bytes, bytes_per_particle(m, empty_bytes), m.row_bytes, m.moved, m.yielded);
}

std::string table_head() {
    return "| scene | particles | million particle-steps/s | spread | by processor time | ns per particle-step | p2g | "
           "nodes | g2p | binning | rest | bytes per particle | of these columns | moved per step [cells] | yielded "
           "|\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
}

std::string table_row(const Case& c, const Runs& plan, const Measured& m, std::int64_t empty_bytes) {
    const double rate = m.rate(m.wall, plan);
    return fmt::format(
        "| {} | {:.0f} | {:.2f} | {:.1f} % | {:.2f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.0f} | "
        "{:.0f} | {:.3f} | {:.2f} |",
        c.name, m.particles, 1e-6 * rate, 100 * m.wall.deviation / m.wall.median, 1e-6 * m.rate(m.processor, plan),
        1e9 / rate, phase(m, Phase::p2g), phase(m, Phase::nodes), phase(m, Phase::g2p), phase(m, Phase::migrate),
        rest(m), bytes_per_particle(m, empty_bytes), m.row_bytes, m.moved, m.yielded);
}

std::string table_notes(const Runs& plan) {
    return fmt::format(
        "One rank, one thread. Rates are medians of {} runs of {} steps after {} steps of warm-up, spread is the "
        "median "
        "distance from the median; \"by processor time\" is what counts where others used the machine. Phases are "
        "means "
        "over all runs [ns per particle-step]: g2p includes the stress update, binning is the making of the lists. "
        "Bytes "
        "per particle: peak resident memory of the whole program, seeding included, above that of the same scene with "
        "one cell of particles; columns are the state itself.\n",
        plan.runs, plan.steps, plan.warm_up);
}

}  // namespace moraine
