#pragma once
// Sleeping blocks on the device (core/sleep/sleep.hpp has the rules and formulas): launchers of what a step and a sleep
// check need. A warp per block of particles, but where a thread is enough.
//
// Whether a block sleeps is known from the bit of its particles, and kept by own block from binning to binning. P2G and
// the gather run over lists that are made anew in each step: of blocks whose tiles are not right, and of those that are
// awake. The order of a list has no meaning. The host asks for nothing: counts and accounts go with the step's report.

#include <cuda_runtime.h>

#include "core/sleep/sleep_contact.hpp"
#include "gpu/kernels/g2p/g2p.hpp"
#include "gpu/kernels/step_report.hpp"
#include "gpu/memory/rest_words.hpp"

namespace moraine::gpu {

/// Where the tile of a sleeper was made, and when: the number of what made it, anew whenever tiles are lost.
struct TileMark {
    std::int32_t tile, made;  ///< -1: it is not right
};

/// What sleep takes; account_parts of them, as of Account.
template <int Dim>
struct SleepAccount {
    ExactSum taken[1 + Dim];  ///< kinetic energy [J] and momentum [kg m/s]
    std::uint64_t particles;  ///< that sleep
};

/// The state by block.
template <int Dim>
struct SleepView {
    RestWords rest;
    SleepRule rule;
    std::uint8_t* asleep;  ///< own, then ghosts
    std::uint8_t* binned;  ///< own: as it was after the last binning; null: this is no binning
    double* activity;      ///< own, then ghosts
    double* wave;          ///< own: of sleepers [m/s]
    TileMark* made;        ///< own
    std::uint8_t* kept;    ///< own: the tile is that of the step before
    const std::uint8_t*
        kept_awake;  ///< own: a structure that moves is near (core/sleep/sleep_contact.hpp); null: none moves
    SleepAccount<Dim>* accounts;
};

/// Wakes blocks that a binning has brought particles to; former_first: the lists' bounds before it. find_sleepers()
/// does as much: this is for lists whose tables change at once.
template <class Real, int Dim>
void wake_entered(const View<Real, Dim>& view, const SleepView<Dim>& sleep, const std::uint32_t* former_first,
                  cudaStream_t stream);

/// Who sleeps, by the particles, and how many these are. former_first: as for wake_entered(), which it does first;
/// null: nobody has moved.
template <class Real, int Dim>
void find_sleepers(const View<Real, Dim>& view, const SleepView<Dim>& sleep, const std::uint32_t* former_first,
                   cudaStream_t stream);

/// u of every own block.
template <class Real, int Dim>
void find_activity(const View<Real, Dim>& view, const SleepView<Dim>& sleep, cudaStream_t stream);

/// Who falls asleep and who wakes, by the activity around each; all that is awake is marked. first: nobody does either.
template <class Real, int Dim>
void change_sleepers(const View<Real, Dim>& view, const SleepView<Dim>& sleep, bool first, const Quantum& quantum,
                     cudaStream_t stream);

/// A list to make: `count` is zero.
struct ListToMake {
    std::int32_t* block;
    std::uint32_t* count;
    std::uint32_t* emptied;  ///< another count, which becomes zero
};

/// Lists those of the chosen blocks whose tiles P2G has to make, and counts them as made, by the number `made`. all: of
/// sleepers too.
template <class Real, int Dim>
void choose_sums(const View<Real, Dim>& view, const SleepView<Dim>& sleep, const Chosen& chosen, std::int32_t made,
                 bool all, const ListToMake& list, const Launch& launch);

/// Keeps the masses of the sleepers' tiles, before others write there: masses is [tile][node].
template <class Real, int Dim>
void keep_masses(const View<Real, Dim>& view, const SleepView<Dim>& sleep, int width, Real* masses,
                 cudaStream_t stream);

/// How sleepers are held by their nodes.
template <class Real>
struct HoldArgs {
    int width;         ///< of the shape
    bool still_nodes;  ///< node blocks of sleepers alone wake nobody: all there is to them is a part of their weight
    const std::uint8_t* near;  ///< node blocks near structures, which are none of those; null: there are none
    const Real* masses;        ///< [tile][node]; null: the tiles have them yet
    Quantum quantum;
};

/// Those that are awake.
struct AwakeLists {
    const std::uint8_t* boundary;  ///< own: 1 where some peer needs the block
    ListToMake of[2];              ///< of the boundary, of the interior
};

/// kept_awake[b], of own blocks: a structure that moves is near. window: T [s].
template <int Dim>
void find_kept_awake(const BlockTable<Dim>& table, const ContactField<Dim>& field, double window,
                     std::uint8_t* kept_awake, cudaStream_t stream);

/// Between nodes and gather: wakes the sleepers that are kept awake or have a fast node, lists all that are awake, and
/// does for the others what a gather would leave: all stay, their waves count, and what the nodes would have given them
/// is taken.
template <class Real, int Dim>
void hold_sleepers(const View<Real, Dim>& view, const SleepView<Dim>& sleep, const HoldArgs<Real>& args,
                   const AwakeLists& lists, cudaStream_t stream);

/// How many sleep goes to the report, and begins anew.
template <int Dim>
void count_sleepers(SleepAccount<Dim>* accounts, SleepAccount<Dim>* report, cudaStream_t stream);

/// So does what was taken; and the step's report is made (gpu/kernels/step_report.hpp).
template <int Dim>
void fold_reports(const ReportWork<Dim>& step, SleepAccount<Dim>* accounts, SleepAccount<Dim>* report,
                  cudaStream_t stream);

}  // namespace moraine::gpu
