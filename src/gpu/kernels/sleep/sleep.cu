#include "gpu/kernels/launch.hpp"
#include "gpu/kernels/sleep/hold.cuh"

namespace moraine::gpu {

namespace {

constexpr unsigned thread_blocks(int items, unsigned each) {
    return (static_cast<unsigned>(items) + each - 1) / each;
}

/// A kernel with a warp per own block.
template <class Kernel, class Real, int Dim, class... Arguments>
void run_over_own(Kernel kernel, const char* name, const View<Real, Dim>& view, cudaStream_t stream,
                  const Arguments&... arguments) {
    if (view.table.own == 0) return;
    kernel<<<thread_blocks(view.table.own, sleep_warps), sleep_threads, 0, stream>>>(view, arguments...);
    check(cudaGetLastError(), name);
}

/// Of a launch over about so many items.
unsigned some_blocks(int items, unsigned each) {
    return static_cast<unsigned>(few_blocks((items > 0 ? items : 0) / static_cast<int>(each) + 1));
}

}  // namespace

template <class Real, int Dim>
void wake_entered(const View<Real, Dim>& view, const SleepView<Dim>& sleep, const std::uint32_t* former_first,
                  cudaStream_t stream) {
    run_over_own(wake_entered_kernel<Real, Dim>, "Waking blocks", view, stream, sleep, former_first);
}

template <class Real, int Dim>
void find_sleepers(const View<Real, Dim>& view, const SleepView<Dim>& sleep, const std::uint32_t* former_first,
                   cudaStream_t stream) {
    if (view.table.own == 0) return;
    find_sleepers_kernel<<<thread_blocks(view.table.own, sleep_threads), sleep_threads, 0, stream>>>(view, sleep,
                                                                                                     former_first);
    check(cudaGetLastError(), "Looking for sleepers");
}

template <class Real, int Dim>
void find_activity(const View<Real, Dim>& view, const SleepView<Dim>& sleep, cudaStream_t stream) {
    run_over_own(find_activity_kernel<Real, Dim>, "A sleep check", view, stream, sleep);
}

template <class Real, int Dim>
void change_sleepers(const View<Real, Dim>& view, const SleepView<Dim>& sleep, bool first, const Quantum& quantum,
                     cudaStream_t stream) {
    run_over_own(change_kernel<Real, Dim>, "A sleep check", view, stream, sleep, first, quantum);
}

template <class Real, int Dim>
void choose_sums(const View<Real, Dim>& view, const SleepView<Dim>& sleep, const Chosen& chosen, std::int32_t made,
                 bool all, const ListToMake& list, const Launch& launch) {
    choose_sums_kernel<<<some_blocks(launch.blocks, sleep_threads), sleep_threads, 0, launch.stream>>>(
        view, sleep, chosen, made, all, list);
    check(cudaGetLastError(), "Listing blocks to sum");
}

template <class Real, int Dim>
void keep_masses(const View<Real, Dim>& view, const SleepView<Dim>& sleep, int width, Real* masses,
                 cudaStream_t stream) {
    run_over_own(keep_masses_kernel<Real, Dim>, "Keeping masses", view, stream, sleep.asleep,
                 power<Dim>(tile_side(width)), masses);
}

template <class Real, int Dim>
void hold_sleepers(const View<Real, Dim>& view, const SleepView<Dim>& sleep, const HoldArgs<Real>& args,
                   const AwakeLists& lists, cudaStream_t stream) {
    run_over_own(hold_kernel<Real, Dim>, "Asking what wakes", view, stream, sleep, args, lists);
}

template <int Dim>
void find_kept_awake(const BlockTable<Dim>& table, const ContactField<Dim>& field, double window,
                     std::uint8_t* kept_awake, cudaStream_t stream) {
    if (table.own == 0) return;
    kept_awake_kernel<Dim>
        <<<thread_blocks(table.own, sleep_threads), sleep_threads, 0, stream>>>(table, field, window, kept_awake);
    check(cudaGetLastError(), "Looking for structures that move");
}

template <int Dim>
void count_sleepers(SleepAccount<Dim>* accounts, SleepAccount<Dim>* report, cudaStream_t stream) {
    count_sleepers_kernel<<<1, 32, 0, stream>>>(accounts, report);
    check(cudaGetLastError(), "Counting sleepers");
}

template <int Dim>
void fold_reports(const ReportWork<Dim>& step, SleepAccount<Dim>* accounts, SleepAccount<Dim>* report,
                  cudaStream_t stream) {
    fold_reports_kernel<<<2, 32, 0, stream>>>(step, accounts, report);
    check(cudaGetLastError(), "Folding the reports");
}

template void find_kept_awake(const BlockTable<2>&, const ContactField<2>&, double, std::uint8_t*, cudaStream_t);
template void find_kept_awake(const BlockTable<3>&, const ContactField<3>&, double, std::uint8_t*, cudaStream_t);
template void count_sleepers(SleepAccount<2>*, SleepAccount<2>*, cudaStream_t);
template void count_sleepers(SleepAccount<3>*, SleepAccount<3>*, cudaStream_t);
template void fold_reports(const ReportWork<2>&, SleepAccount<2>*, SleepAccount<2>*, cudaStream_t);
template void fold_reports(const ReportWork<3>&, SleepAccount<3>*, SleepAccount<3>*, cudaStream_t);

#define MORAINE_SLEEP(Real, Dim)                                                                                      \
    template void wake_entered(const View<Real, Dim>&, const SleepView<Dim>&, const std::uint32_t*, cudaStream_t);    \
    template void find_sleepers(const View<Real, Dim>&, const SleepView<Dim>&, const std::uint32_t*, cudaStream_t);   \
    template void find_activity(const View<Real, Dim>&, const SleepView<Dim>&, cudaStream_t);                         \
    template void change_sleepers(const View<Real, Dim>&, const SleepView<Dim>&, bool, const Quantum&, cudaStream_t); \
    template void choose_sums(const View<Real, Dim>&, const SleepView<Dim>&, const Chosen&, std::int32_t, bool,       \
                              const ListToMake&, const Launch&);                                                      \
    template void keep_masses(const View<Real, Dim>&, const SleepView<Dim>&, int, Real*, cudaStream_t);               \
    template void hold_sleepers(const View<Real, Dim>&, const SleepView<Dim>&, const HoldArgs<Real>&,                 \
                                const AwakeLists&, cudaStream_t);
MORAINE_SLEEP(float, 2)
MORAINE_SLEEP(float, 3)
MORAINE_SLEEP(double, 2)
MORAINE_SLEEP(double, 3)
#undef MORAINE_SLEEP

}  // namespace moraine::gpu
