#pragma once
// Where the time of a run went, for its closing lines and for summary.json: what was lost to imbalance and to
// balancing.
//
//   wall = computing + lost to imbalance + exchange + balancing + output + the rest
//
// computing   mean of the ranks: P2G, nodes, G2P
// imbalance   sum over steps of (slowest rank - mean): all others wait for it, in whichever exchange comes next
// exchange    halo, agreement and migration of the mean rank, binning included, beyond that wait and, on devices,
//             beyond the wait for their kernels, which are counted as computing
// balancing   imbalance checks, plans, and moves of blocks, mean of the ranks

#include <fmt/format.h>

#include "io/json_text.hpp"
#include "simulation/simulation.hpp"

namespace moraine {

struct TimeReport {
    double wall = 0, computing = 0, imbalance = 0, exchange = 0, balancing = 0, output = 0;  ///< [s]
    std::int64_t repartitions = 0;
    int ranks = 1;

    double rest() const { return wall - computing - imbalance - exchange - balancing - output; }

    Json json() const {
        return Json::Named{{"computing", computing}, {"lost_to_imbalance", imbalance},
                           {"exchange", exchange},   {"balancing", balancing},
                           {"output", output},       {"rest", rest()}};
    }

    std::string text() const {
        const auto line = [&](const char* what, double seconds, const std::string& of) {
            return fmt::format("  {:<18}{:6.1f} %  {}\n", what, wall > 0 ? 100 * seconds / wall : 0, of);
        };
        return fmt::format("Time of the run: {:.2f} s on {} rank{}\n", wall, ranks, ranks == 1 ? "" : "s") +
               line("computing", computing, "mean of the ranks") +
               line("lost to imbalance", imbalance, "slowest rank less mean, step by step") +
               line("exchange", exchange, "halo, binning, migration, agreement") +
               line("lost to balancing", balancing,
                    fmt::format("checks, plans, {} repartition{}", repartitions, repartitions == 1 ? "" : "s")) +
               line("output", output, "records, output frames, checkpoints") + line("rest", rest(), "start and end");
    }
};

/// `wall`: of this process since the run began [s]. Collective.
template <class Real, int Dim>
TimeReport time_report(Simulation<Real, Dim>& sim, const Comm& comm, double wall) {
    const auto mean = [&](double seconds) { return comm.sum(seconds) / comm.size(); };
    const Phases& phases = sim.phases();
    TimeReport report;
    report.wall = comm.max(wall);
    report.computing = mean(phases.computing());
    report.imbalance = sim.counts().seconds_lost;
    const double exchange =
        mean(phases.seconds(Phase::halo) + phases.seconds(Phase::agree) + phases.seconds(Phase::migrate));
    const bool on_device = sim.engine().device().name != "cpu";  // there the host waits for the kernels in the exchange
    report.exchange = std::max(0.0, exchange - report.imbalance - (on_device ? report.computing : 0.0));
    report.balancing = mean(phases.seconds(Phase::balance));
    report.output = mean(phases.seconds(Phase::output));
    report.repartitions = sim.counts().repartitions;
    report.ranks = comm.size();
    return report;
}

}  // namespace moraine
