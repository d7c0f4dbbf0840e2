#pragma once
// Gather and stress update in one kernel: hats or quadratic splines, with splines also an affine field; one material.
//
// One thread per particle; its gradient never leaves the registers, and its rows are read and written once. A case with
// means of cells (volumetric.cuh) is an instance of its own: a branch cost the others a register too many. So are those
// of blocks with light nodes (light.cuh), which ask at run time whether means are wanted.

#include "gpu/kernels/g2p/gather_affine.cuh"
#include "gpu/kernels/g2p/stress_particle.cuh"
#include "gpu/kernels/g2p/terms_of.cuh"

namespace moraine::gpu {

/// A particle as terms see it: its rows are in registers and written at the end; what they were before the step is
/// still in shared memory. All bodies are of one material.
template <class Case, class Rows>
struct FusedPoint {
    using Real = typename Case::Real;
    using Core = CoreRows<Real, Case::dim>;
    const BlockInWork<Case>& in;
    const Rows& rows;
    const int half;
    const std::uint32_t entry, slot;  ///< entry: of the list
    Core& p;

    __device__ __forceinline__ typename Case::U place() const {
        Core before;
        before.row[before.place] = rows.take(half, Case::T::rank(), before.place);
        return place_of<Real, Case::dim>(before);
    }
    __device__ __forceinline__ Vec<Real, Case::dim> half_sizes() const { return zero_vec<Real, Case::dim>(); }
    __device__ __forceinline__ FluidTerms<Real> fluid() const { return in.g.fluid.all; }
    __device__ __forceinline__ Real bulk() const { return in.g.bulk[0]; }
    __device__ __forceinline__ bool averaged() const { return true; }
    __device__ __forceinline__ void load(int) const {}
    __device__ __forceinline__ void load_pressure() const {}
    __device__ __forceinline__ void load_all() const {}
    __device__ __forceinline__ void store(int) const {}
    __device__ __forceinline__ void store_pressure() const {}
};

template <class Case, class Law>
struct FusedGather {
    using Real = typename Case::Real;
    using Shape = typename Case::Shape;
    static constexpr int Dim = Case::dim;
    static constexpr bool affine = Case::affine;
    static_assert(!affine || Shape::width == 3);
    using T = typename Case::T;
    using Terms = TermsOf<Case>;
    using In = BlockInWork<Case>;
    using U = typename Case::U;
    using Seen = typename Case::Seen;
    using Tile = GatherTile<Real, Dim, Shape::width, !affine>;
    using Rows = RowsAhead<Real, law_rows<Law, Dim>, 0, T::threads>;
    struct Shared {
        Rows rows;
        Tile tile;
        double sums[T::warps];
        typename Terms::Shared terms;
    };

    MORAINE_TEAM Gathered<Real, Dim, affine> sums_of(const In& in, const U& u, const Tile& tile) {
        const int at = number_of<Case::side, Real, Dim>(u);
        if constexpr (affine) {
            SplineAxis<Real> n[Dim];
#pragma unroll
            for (int a = 0; a < Dim; ++a)
                n[a] = spline_axis(fraction_of<Real>(u[a]), takes_gradient<Shape>(in.v, in.g, in.work.block, u, a));
            return gather_affine<Real, Dim>(tile, at, n);
        } else {
            AxisWeights<Real, Shape, false> n[Dim];
#pragma unroll
            for (int a = 0; a < Dim; ++a) n[a] = axis_weights<Shape, false>(fraction_of<Real>(u[a]), Real(0), false);
            return gather<Shape, false, Real, Dim>(tile, at, n);
        }
    }

    /// Less what light nodes cannot bear.
    MORAINE_TEAM auto limited_sums(const In& in, std::uint32_t s, const U& u, Shared& shared) {
        return gather_limited<Case, affine>(in, shared.terms, s, [&] { return sums_of(in, u, shared.tile); });
    }

    /// The nodes of the block, and what terms make of them.
    MORAINE_TEAM void prepare(const In& in, Shared& shared) {
        Terms::template each<hook_block>(shared.terms, [&](auto term, auto& own) { term.at_block(in, own); });
        load_tile<Shape>(in.v, in.work.block, shared.tile);
        Terms::template each<hook_cell>(shared.terms, [&](auto term, auto& own) {
            term.at_cell(in, own, [&](std::uint32_t s, const U& u) { return limited_sums(in, s, u, shared); });
        });
    }

    /// The particle of list entry k in slot s.
    MORAINE_TEAM void update(const In& in, const Law& law, Real inverse_density, std::uint32_t k, std::uint32_t s,
                             int half, Shared& shared, Seen& tally, double& power) {
        const auto row = [&](int r) { return shared.rows.take(half, T::rank(), r); };
        CoreRows<Real, Dim> p;
        FusedPoint<Case, Rows> point{in, shared.rows, half, k, s, p};
        Terms::template each<hook_gather>(shared.terms,
                                          [&](auto term, auto& own) { term.before_gather(in, point, own); });
        p.row[p.place] = row(p.place);
        U u = place_of<Real, Dim>(p);
        auto sums = limited_sums(in, s, u, shared);
        if constexpr (affine) store_affine(in.v, sums.affine, s);
        Terms::template each<hook_rate>(shared.terms,
                                        [&](auto term, auto& own) { term.on_rate(in, point, u, sums, own, tally); });

        Real velocity[Dim];
#pragma unroll
        for (int a = 0; a < Dim; ++a) velocity[a] = sums.velocity[a];
        Terms::template each<hook_velocity>(
            shared.terms, [&](auto term, auto& own) { term.on_velocity(in, point, u, velocity, own); });
        const PlaceStep<Real> step = move_particle<Case::light>(in.v, in.g, in.work, k, velocity, u);
        if (step.moved > tally.moved) tally.moved = step.moved;
#pragma unroll
        for (int a = 0; a < Dim; ++a) p.set_coordinate(a, u[a]);
        if constexpr (Dim == 3) store_row(in.v.p.core[p.place] + s, p.row[p.place]);

        p.row[p.motion] = row(p.motion);
        if constexpr (affine)
            for (int a = 0; a < Dim; ++a) p.velocity(a) = sums.velocity[a];
        else
            take_velocity(in.g.flip, sums, p);
        p.row[p.normal] = row(p.normal);
        p.row[p.shear] = row(p.shear);
        Row<Real> b[stretch_rows<Dim>];
        if constexpr (Law::uses_left_stretch)
            for (int r = 0; r < stretch_rows<Dim>; ++r) b[r] = row(core_rows<Dim> + r);
        Mat<Real, Dim> dL = tensor_of<Dim>(in.g.dt * in.v.context.inverse_cell, sums.gradient);
        Terms::template each<hook_stress>(
            shared.terms, [&](auto term, auto& own) { term.before_stress(in, point, dL, own, tally, power); });
        const std::uint32_t faults =
            step.faults | update_stress(law, inverse_density, dL, in.g.dt, in.v.p, s, p, b, tally, power);
#pragma unroll
        for (int r = Dim == 3 ? 1 : 0; r < core_rows<Dim>; ++r) store_row(in.v.p.core[r] + s, p.row[r]);
        report(in.v, in.g, s, faults, step.move);
    }
};

template <class Case, class Law, int MinBlocks>
__global__ void __launch_bounds__(Case::T::block_threads, MinBlocks)
    g2p_fused(const __grid_constant__ View<typename Case::Real, Case::dim> v, const Chosen chosen,
              const __grid_constant__ typename Case::Args g, const __grid_constant__ Law law,
              const typename Case::Real inverse_density) {
    using T = typename Case::T;
    using F = FusedGather<Case, Law>;
    extern __shared__ __align__(32) unsigned char memory[];
    auto& shared = reinterpret_cast<typename F::Shared*>(memory)[T::index()];
    typename Case::Seen tally;
    const std::uint32_t count = *chosen.count;
#pragma unroll 1
    for (std::uint32_t item = T::first(); item < count; item += T::stride()) {
        const Work work = work_on(v.list, chosen, item);
        if (!Case::light && is_limited(g, work.block)) continue;
        const BlockInWork<Case> in{v, g, work};
        double power = 0;
        each_entry<Case::dim>(
            v.list.slot, work,
            [&](int half, std::uint32_t, std::uint32_t s) {
#pragma unroll
                for (int r = 0; r < law_rows<Law, Case::dim>; ++r)
                    shared.rows.start(half, T::rank(), r, law_row<Law>(v.p, r, s));
                return 0u;
            },
            [&] { F::prepare(in, shared); },
            [&](std::uint32_t k, std::uint32_t s, int half, std::uint32_t) {
                F::update(in, law, inverse_density, k, s, half, shared, tally, power);
            });
        power = T::sum(power, shared.sums);
        if (T::rank() == 0) add_exact(&account_of(v).work, g.quantum.of(power));
    }
    tally.fold_into(account_of(v));
}

/// Thread blocks of a multiprocessor: as many as leave a thread the registers it needs.
template <class Case, class Law>
constexpr int fused_blocks() {
    constexpr bool large = sizeof(typename Case::Real) == 8;
    if (Case::light) return light_blocks;
    if (Case::pressure) return large ? 2 : 4;
    constexpr DeviceBlocks blocks = device_blocks_of<Law>();
    if (large) return blocks.double_fused;
    if (Case::affine) return Case::means ? blocks.affine_averaged : blocks.affine;
    return Case::means ? blocks.averaged : blocks.plain;
}

}  // namespace moraine::gpu
