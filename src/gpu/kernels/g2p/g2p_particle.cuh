#pragma once
// What both gather kernels do with a particle: its way through the list, its motion, its velocity. The formulas are
// those of core/grid/particle_update.hpp and core/particles/place_step.hpp; here is where its rows are.

#include "core/grid/particle_update.hpp"
#include "core/particles/place_step.hpp"
#include "gpu/kernels/g2p/gather.cuh"
#include "gpu/kernels/g2p/gather_args.hpp"
#include "gpu/kernels/seen.cuh"

namespace moraine::gpu {

/// A block in work.
struct Work {
    int block;
    std::uint32_t begin, end;  ///< its list
};

template <int Dim>
__device__ __forceinline__ Work work_on(const ListView<Dim>& list, const Chosen& chosen, std::uint32_t item) {
    const int b = chosen.block[item];
    return {b, list.first[b], list.first[b + 1]};
}

/// Each thread of the team goes through its entries of a list, the next particle's rows on their way: start(half, k, s)
/// asks for the rows of slot s and returns what use(k, s, half, tag) gets as its tag; meanwhile() is between the first
/// rows' start and their use.
template <int Dim, class Start, class Meanwhile, class Use>
__device__ __forceinline__ void each_entry(const std::uint32_t* slot, const Work& work, const Start& start,
                                           const Meanwhile& meanwhile, const Use& use) {
    constexpr std::uint32_t threads = Team<Dim>::threads;
    const auto slot_at = [&](std::uint32_t k) { return k < work.end ? slot[k] : 0; };
    std::uint32_t k = work.begin + unsigned(Team<Dim>::rank());
    std::uint32_t s = slot_at(k), next = slot_at(k + threads), tag = 0, next_tag = 0;
    if (k < work.end) tag = start(0, k, s);
    commit_async();
    meanwhile();
    int half = 0;
#pragma unroll 1
    for (; k < work.end; k += threads) {
        if (k + threads < work.end) next_tag = start(half ^ 1, k + threads, next);
        commit_async();
        const std::uint32_t after = slot_at(k + 2 * threads);
        wait_async<1>();
        use(k, s, half, tag);
        s = next, next = after, tag = next_tag, half ^= 1;
    }
}

template <class Real, int Dim>
__device__ __forceinline__ Vec<Coordinate<Real>, Dim> place_of(const CoreRows<Real, Dim>& p) {
    Vec<Coordinate<Real>, Dim> u;
#pragma unroll
    for (int a = 0; a < Dim; ++a) u[a] = p.coordinate(a);
    return u;
}

/// Number of the cell, and of its lowest node in a tile of `side` nodes.
template <int Side, class Real, int Dim>
__device__ __forceinline__ int number_of(const Vec<Coordinate<Real>, Dim>& u) {
    int at = 0;
#pragma unroll
    for (int a = Dim - 1; a >= 0; --a) at = at * Side + cell_of<Real>(u[a]);
    return at;
}

/// Moves the particle of list entry k by dt v, notes where it is to be binned next and whether that is another cell.
/// Called by the lanes of a warp that have an entry. Light: it may be stopped at walls, where light nodes are fast.
template <bool Light, class Real, int Dim>
__device__ __forceinline__ PlaceStep<Real> move_particle(const View<Real, Dim>& v, const GatherArgs<Real, Dim>& g,
                                                         const Work& work, std::uint32_t k, const Real (&velocity)[Dim],
                                                         Vec<Coordinate<Real>, Dim>& u) {
    const int from = number_of<4, Real, Dim>(u);
    const PlaceStep<Real> step =
        advance_place<Light>(g.ends, v.table.position[work.block], v.table.border[work.block] != 0, velocity, g.dt,
                             v.context.inverse_cell, u);
    v.moves[k] = step.move;
    const bool changed = changes_cell<Dim>(step.move, from);
    const std::uint32_t lane = threadIdx.x % 32, here = work.end - (k - lane);
    const unsigned bits = __ballot_sync(here >= 32 ? 0xffffffffu : (1u << here) - 1, changed);
    if (lane == 0) v.changed[work.begin / 32 + unsigned(work.block) + (k - work.begin) / 32] = bits;
    return step;
}

template <class Real, int Dim, bool Affine>
__device__ __forceinline__ void take_velocity(Real flip, const Gathered<Real, Dim, Affine>& g, CoreRows<Real, Dim>& p) {
#pragma unroll
    for (int a = 0; a < Dim; ++a) p.velocity(a) = blended_velocity(flip, p.velocity(a), g.change[a], g.velocity[a]);
}

/// Whether along axis a of a particle at u the affine field is the velocity gradient.
template <class Shape, class Real, int Dim>
__device__ __forceinline__ bool takes_gradient(const View<Real, Dim>& v, const GatherArgs<Real, Dim>& g, int block,
                                               const Vec<Coordinate<Real>, Dim>& u, int a) {
    return affine_is_gradient<Shape>(g.tpic, [&] {
        return v.table.border[block] &&
               reaches_ghost<Shape>(v.context.walls, a, v.table.position[block][a], cell_of<Real>(u[a]));
    });
}

/// slopes: per cell, [axis][component], as Gathered has them.
template <class Real, int Dim>
__device__ __forceinline__ void store_affine(const View<Real, Dim>& v, const Real (&slopes)[Dim][Dim],
                                             std::uint32_t s) {
    const Mat<Real, Dim> C = tensor_of<Dim>(v.context.inverse_cell, slopes);
    Row<Real> row[affine_rows<Dim>];
#pragma unroll
    for (int i = 0; i < Dim; ++i)
#pragma unroll
        for (int j = 0; j < Dim; ++j) row[Dim == 3 ? i : 0].e[Dim == 3 ? j : 2 * i + j] = C(i, j);
#pragma unroll
    for (int i = 0; i < affine_rows<Dim>; ++i) {
        if (Dim == 3) row[i].e[3] = Real(0);
        store_row(v.p.affine[i] + s, row[i]);
    }
}

/// Faults, and particles that left: rare, so what they need is read again.
template <class Real, int Dim>
__device__ __forceinline__ void report(const View<Real, Dim>& v, const GatherArgs<Real, Dim>& g, std::uint32_t s,
                                       std::uint32_t faults, std::uint16_t move) {
    if (faults) note_fault(account_of(v), faults, v.p.id[s]);
    if (move_code(move) != Block<Dim>::gone) return;
    CoreRows<Real, Dim> p;
    p.row[p.place] = load_row(v.p.core[p.place] + s);
    p.row[p.motion] = load_row(v.p.core[p.motion] + s);
    double velocity[Dim];
#pragma unroll
    for (int a = 0; a < Dim; ++a) velocity[a] = double(p.velocity(a));
    note_loss<Dim>(account_of(v), g.quantum, double(p.mass()), velocity, g.gravity_impulse);
}

}  // namespace moraine::gpu
