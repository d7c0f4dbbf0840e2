#pragma once
// What a step tells the host: the accounts folded into one, and the counts of the last binning, in one small kernel.
//
// It is written to pinned memory that the device sees: no copy is launched, and whoever waits for the stream or an
// event behind the kernel may read it. The accounts are empty again afterwards.

#include <cuda_runtime.h>

#include "gpu/exchange/routes.hpp"
#include "gpu/kernels/view.hpp"

namespace moraine::gpu {

template <int Dim>
struct Report {
    Account<Dim> account;
    std::uint32_t particles;           ///< in the lists
    std::uint32_t boundary;            ///< occupied blocks that some peer needs
    std::uint32_t interior;            ///< the other occupied ones
    std::uint32_t stored;              ///< slots in use
    std::uint32_t migration_bound[2];  ///< of a block, of a pair (engine/agreement.hpp)
    std::uint32_t in_guard_layer;      ///< 1: some particle is in a cell of the guard layer

    MORAINE_HD std::uint32_t occupied() const { return boundary + interior; }
};

/// What a report is made of, and where it goes.
template <int Dim>
struct ReportWork {
    Account<Dim>* accounts;
    const std::uint32_t* particles;       ///< first[own]
    const std::uint32_t* occupied;        ///< both counts of gpu/kernels/binning/binning.hpp
    const std::uint32_t* in_guard_layer;  ///< its flag
    Counters* counters;
    Report<Dim>* report;
};

/// Folds and empties the accounts, and the counters' migration bound.
template <int Dim>
void fold_report(const ReportWork<Dim>& work, cudaStream_t stream);

/// Empties the accounts at the start of a run.
template <int Dim>
void empty_accounts(Account<Dim>* accounts, cudaStream_t stream);

}  // namespace moraine::gpu
