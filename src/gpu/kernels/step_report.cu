#include "gpu/kernels/step_report.cuh"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

template <int Dim>
void fold_report(Account<Dim>* accounts, const std::uint32_t* particles, const std::uint32_t* occupied,
                 const std::uint32_t* in_guard_layer, Counters* counters, Report<Dim>* report, cudaStream_t stream) {
    report_kernel<<<1, 32, 0, stream>>>(accounts, particles, occupied, in_guard_layer, counters, report);
    check(cudaGetLastError(), "Folding the report");
}

template <int Dim>
void empty_accounts(Account<Dim>* accounts, cudaStream_t stream) {
    empty_kernel<<<1, account_parts, 0, stream>>>(accounts);
    check(cudaGetLastError(), "Emptying the accounts");
}

template void fold_report<2>(Account<2>*, const std::uint32_t*, const std::uint32_t*, const std::uint32_t*, Counters*,
                             Report<2>*, cudaStream_t);
template void fold_report<3>(Account<3>*, const std::uint32_t*, const std::uint32_t*, const std::uint32_t*, Counters*,
                             Report<3>*, cudaStream_t);
template void empty_accounts<2>(Account<2>*, cudaStream_t);
template void empty_accounts<3>(Account<3>*, cudaStream_t);

}  // namespace moraine::gpu
