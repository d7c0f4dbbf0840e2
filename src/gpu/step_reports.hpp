#pragma once
// The reports of a device's steps: accounts that kernels add to, the report that a binning folds them into, and the
// stopwatch. The host waits for one event, behind the report.

#include <bit>

#include "engine/engine.hpp"
#include "gpu/kernels/binning/lists.hpp"
#include "gpu/kernels/step_report.hpp"
#include "gpu/memory/array.hpp"
#include "gpu/memory/stopwatch.hpp"
#include "gpu/memory/stream.hpp"

namespace moraine::gpu {

template <int Dim>
struct StepReports {
    Array<Account<Dim>> accounts;
    Array<Counters> counters;
    Pinned<Report<Dim>> report;
    Event reported;
    const Report<Dim>* of_lead = nullptr;  ///< the last report, where the device made the step by itself
    Stopwatch watch;                       ///< binning with P2G, nodes, G2P; not of waiting
    std::uint32_t faults = 0;              ///< of the last report
    std::uint64_t faulty_id = 0;
    bool timed = false;        ///< the watch runs since binning
    bool is_missing = false;   ///< the last step is binned, but not reported: the device has led
    bool is_of_epoch = false;  ///< no epoch has begun since the report was made

    void start(cudaStream_t stream) {
        counters.assign(std::vector<Counters>{{}});
        accounts.resize(account_parts);
        empty_accounts(accounts.data(), stream);
    }
    ReportWork<Dim> work(const Lists<Dim>& lists, Report<Dim>* to) const {
        return {accounts.data(), lists.particles(), lists.occupied(), lists.in_guard_layer(), counters.data(), to};
    }
    /// Of the last step that is binned; waits for it.
    const Report<Dim>& last() const {
        if (of_lead) return *of_lead;
        reported.wait();
        return *report;
    }
    /// The last report as the simulation takes it; notes its faults.
    StepReport<Dim> take() {
        const Report<Dim>& all = last();
        const Account<Dim>& account = all.account;
        faults = account.faults;
        faulty_id = account.faulty_id;
        StepReport<Dim> step;
        step.signal = std::bit_cast<double>(account.signal);
        step.moved = std::bit_cast<double>(account.moved);
        step.square_speed = std::bit_cast<double>(account.square_speed);
        step.faults = account.faults;
        step.in_guard_layer = all.in_guard_layer != 0;
        step.clamped = account.clamped;
        step.budget.work = account.work;
        step.budget.lost_mass = account.lost_mass;
        for (std::size_t i = 0; i < Dim; ++i) {
            step.budget.impulse[i] = account.impulse[i];
            step.budget.lost_momentum[i] = account.lost_momentum[i];
            step.budget.lost_gravity_impulse[i] = account.lost_gravity_impulse[i];
        }
        step.budget.lost_count = static_cast<std::int64_t>(account.lost_count);
        return step;
    }
};

}  // namespace moraine::gpu
