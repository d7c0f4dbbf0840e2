#include "gpu/kernels/step_report.cuh"
#include "gpu/memory/array.hpp"

namespace moraine::gpu {

template <int Dim>
void fold_report(const ReportWork<Dim>& work, cudaStream_t stream) {
    report_kernel<<<1, 32, 0, stream>>>(work);
    check(cudaGetLastError(), "Folding the report");
}

template <int Dim>
void empty_accounts(Account<Dim>* accounts, cudaStream_t stream) {
    empty_kernel<<<1, account_parts, 0, stream>>>(accounts);
    check(cudaGetLastError(), "Emptying the accounts");
}

template void fold_report<2>(const ReportWork<2>&, cudaStream_t);
template void fold_report<3>(const ReportWork<3>&, cudaStream_t);
template void empty_accounts<2>(Account<2>*, cudaStream_t);
template void empty_accounts<3>(Account<3>*, cudaStream_t);

}  // namespace moraine::gpu
