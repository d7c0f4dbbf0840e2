#pragma once
// Gather without stress: any shape, with or without an affine field, whatever a round of a scheme takes.
//
// dL goes to a buffer by list entry, component by component: written and read in full lines, and free of the order in
// which particles lie in memory.

#include "gpu/kernels/g2p/terms_of.cuh"

namespace moraine::gpu {

/// Rows of a particle on their way.
inline constexpr int place_ahead = 0, motion_ahead = 1, box_ahead = 2;

/// A particle as terms see it: rows that they ask for are loaded, and stored again, one by one; those not used are
/// dropped by the compiler.
template <class Case, class Rows>
struct SplitPoint {
    using Real = typename Case::Real;
    using Core = CoreRows<Real, Case::dim>;
    const BlockInWork<Case>& in;
    const Rows& rows;
    const int half;
    const std::uint32_t entry, slot, body;  ///< entry: of the list; body: of sized shapes
    Core p;

    __device__ __forceinline__ typename Case::U place() const {
        Core before;
        before.row[before.place] = rows.take(half, Case::T::rank(), place_ahead);
        return place_of<Real, Case::dim>(before);
    }
    __device__ __forceinline__ Row<Real> stretch() const {
        Row<Real> row;
        if (in.v.p.log_stretch) row = rows.take(half, Case::T::rank(), box_ahead);
        return row;
    }
    __device__ __forceinline__ Vec<Real, Case::dim> half_sizes() const {
        Vec<Real, Case::dim> size = zero_vec<Real, Case::dim>();
        if constexpr (Case::Shape::sized) {
            const Row<Real> now = stretch();
            for (int a = 0; a < Case::dim; ++a) size[a] = half_size(in.v, body, now, a);
        }
        return size;
    }
    __device__ __forceinline__ FluidTerms<Real> fluid() const {
        return in.g.fluid.by_body ? in.g.fluid.by_body[in.v.p.body[slot]] : in.g.fluid.all;
    }
    __device__ __forceinline__ Real bulk() const { return in.g.bulk[in.v.p.body[slot]]; }
    __device__ __forceinline__ bool averaged() const { return !in.g.averaged || in.g.averaged[in.v.p.body[slot]]; }

    __device__ __forceinline__ void load(int r) { p.row[r] = load_row(in.v.p.core[r] + slot); }
    __device__ __forceinline__ void load_pressure() {
        load(p.normal);
        if (p.ln_J_row != p.normal) load(p.ln_J_row);
    }
    /// All but the place.
    __device__ __forceinline__ void load_all() {
#pragma unroll
        for (int r = 1; r < core_rows<Case::dim>; ++r) load(r);
        p.row[p.place] = rows.take(half, Case::T::rank(), place_ahead);
    }
    __device__ __forceinline__ void store(int r) const {
        store_row(in.v.p.core[r] + slot, p.row[r]);
    }
    __device__ __forceinline__ void store_pressure() const {
        store(p.normal);
        if (p.ln_J_row != p.normal) store(p.ln_J_row);
    }
};

template <class Case>
struct SplitGather {
    using Real = typename Case::Real;
    using Shape = typename Case::Shape;
    static constexpr int Dim = Case::dim;
    static constexpr bool levers = Case::affine && Shape::width > 2;  ///< C of hats is the velocity gradient
    static constexpr bool rolled = Case::light && Shape::width > 3;   ///< or registers spill in double
    using T = typename Case::T;
    using Terms = TermsOf<Case>;
    using In = BlockInWork<Case>;
    using U = typename Case::U;
    using Sums = Gathered<Real, Dim, levers>;
    using Tile = GatherTile<Real, Dim, Shape::width>;
    using Rows = RowsAhead<Real, Shape::sized ? 3 : 2, 0, T::threads>;
    using Point = SplitPoint<Case, Rows>;
    struct Shared {
        Rows rows;
        Tile tile;
        typename Terms::Shared terms;
        double sums[Case::pressure ? T::warps : 1];
    };

    /// Asks for the particle's rows; returns its body.
    MORAINE_TEAM std::uint32_t start(const In& in, int half, std::uint32_t s, Shared& shared) {
        const auto& p = in.v.p;
        shared.rows.start(half, T::rank(), place_ahead, p.core[0] + s);
        if (in.g.gather & gather_velocity) shared.rows.start(half, T::rank(), motion_ahead, p.core[1] + s);
        if constexpr (Shape::sized) {
            if (p.log_stretch) shared.rows.start(half, T::rank(), box_ahead, p.log_stretch + s);
            return p.body[s];
        }
        return 0;
    }

    /// Sums of the particle in slot s at u, less what light nodes cannot bear. half(a): of its box.
    template <bool Levers, bool Rolled, class Half>
    MORAINE_TEAM auto limited_sums(const In& in, std::uint32_t s, const U& u, Shared& shared, const Half& half) {
        return gather_limited<Case, Levers>(in, shared.terms, s, [&] {
            AxisWeights<Real, Shape, Levers> n[Dim];
#pragma unroll
            for (int a = 0; a < Dim; ++a)
                n[a] = axis_weights<Shape, Levers>(fraction_of<Real>(u[a]), half(a),
                                                   Levers && takes_gradient<Shape>(in.v, in.g, in.work.block, u, a));
            return gather<Shape, Levers, Real, Dim, Rolled>(shared.tile, number_of<Case::side, Real, Dim>(u), n);
        });
    }

    /// The nodes of the block, and what terms make of them.
    MORAINE_TEAM void prepare(const In& in, Shared& shared) {
        Terms::template each<hook_block>(shared.terms, [&](auto term, auto& own) { term.at_block(in, own); });
        load_tile<Shape>(in.v, in.work.block, shared.tile);
        if (!(in.g.gather & gather_gradient)) return;
        Terms::template each<hook_cell>(shared.terms, [&](auto term, auto& own) {
            term.at_cell(in, own, [&](std::uint32_t s, const U& u) {
                Row<Real> stretch;
                if constexpr (Shape::sized)
                    if (in.v.p.log_stretch) stretch = load_row(in.v.p.log_stretch + s);
                return limited_sums<false, false>(in, s, u, shared, [&](int a) {
                    return Shape::sized ? half_size(in.v, in.v.p.body[s], stretch, a) : Real(0);
                });
            });
        });
    }

    MORAINE_TEAM void store_gradient(const typename Case::Args& g, const Mat<Real, Dim>& dL, std::uint32_t k) {
#pragma unroll
        for (int i = 0; i < Dim; ++i)
#pragma unroll
            for (int j = 0; j < Dim; ++j) g.gradient[std::uint64_t(Dim * i + j) * g.gradient_stride + k] = dL(i, j);
    }

    MORAINE_TEAM void move(const In& in, std::uint32_t k, const Point& point, const Sums& sums, U& u, Shared& shared,
                           CoreRows<Real, Dim>& p, typename Case::Seen& tally) {
        Real velocity[Dim];
#pragma unroll
        for (int a = 0; a < Dim; ++a) velocity[a] = moving_velocity(in.g.gather, sums.velocity[a], sums.change[a]);
        Terms::template each<hook_velocity>(
            shared.terms, [&](auto term, auto& own) { term.on_velocity(in, point, u, velocity, own); });
        const PlaceStep<Real> step = move_particle<Case::light>(in.v, in.g, in.work, k, velocity, u);
        if (step.moved > tally.moved) tally.moved = step.moved;
#pragma unroll
        for (int a = 0; a < Dim; ++a) p.set_coordinate(a, u[a]);
        store_row(in.v.p.core[p.place] + point.slot, p.row[p.place]);
        report(in.v, in.g, point.slot, step.faults, step.move);
    }

    /// The particle of list entry k in slot s.
    MORAINE_TEAM void take(const In& in, std::uint32_t k, std::uint32_t s, int half, std::uint32_t body, Shared& shared,
                           typename Case::Seen& tally, double& power) {
        Point point{in, shared.rows, half, k, s, body, {}};
        Terms::template each<hook_gather>(shared.terms,
                                          [&](auto term, auto& own) { term.before_gather(in, point, own); });
        CoreRows<Real, Dim> p;
        p.row[p.place] = shared.rows.take(half, T::rank(), place_ahead);
        U u = place_of<Real, Dim>(p);
        Row<Real> stretch;
        if constexpr (Shape::sized) stretch = point.stretch();
        Sums sums = limited_sums<levers, rolled>(
            in, s, u, shared, [&](int a) { return Shape::sized ? half_size(in.v, body, stretch, a) : Real(0); });

        if (in.g.gather & gather_velocity) {
            p.row[p.motion] = shared.rows.take(half, T::rank(), motion_ahead);
            take_velocity(in.g.flip, sums, p);
            store_row(in.v.p.core[p.motion] + s, p.row[p.motion]);
            if constexpr (levers)
                store_affine(in.v, sums.affine, s);
            else if constexpr (Case::affine)
                store_affine(in.v, sums.gradient, s);
        }
        if (in.g.gather & gather_gradient) {
            Terms::template each<hook_rate>(
                shared.terms, [&](auto term, auto& own) { term.on_rate(in, point, point.place(), sums, own, tally); });
            Mat<Real, Dim> dL = tensor_of<Dim>(in.g.dt * in.v.context.inverse_cell, sums.gradient);
            Terms::template each<hook_stress>(
                shared.terms, [&](auto term, auto& own) { term.before_stress(in, point, dL, own, tally, power); });
            store_gradient(in.g, dL, k);
        }
        if (moves_particles(in.g.gather)) move(in, k, point, sums, u, shared, p, tally);
    }
};

template <class Case, int MinBlocks>
__global__ void __launch_bounds__(Case::T::block_threads, MinBlocks)
    g2p_split(const __grid_constant__ View<typename Case::Real, Case::dim> v, const Chosen chosen,
              const __grid_constant__ typename Case::Args g) {
    using T = typename Case::T;
    using S = SplitGather<Case>;
    extern __shared__ __align__(32) unsigned char memory[];
    auto& shared = reinterpret_cast<typename S::Shared*>(memory)[T::index()];
    typename Case::Seen tally;
    const std::uint32_t count = *chosen.count;
#pragma unroll 1
    for (std::uint32_t item = T::first(); item < count; item += T::stride()) {
        const Work work = work_on(v.list, chosen, item);
        if (!Case::light && is_limited(g, work.block)) continue;
        const BlockInWork<Case> in{v, g, work};
        double power = 0;
        each_entry<Case::dim>(
            v.list.slot, work, [&](int half, std::uint32_t, std::uint32_t s) { return S::start(in, half, s, shared); },
            [&] { S::prepare(in, shared); },
            [&](std::uint32_t k, std::uint32_t s, int half, std::uint32_t body) {
                S::take(in, k, s, half, body, shared, tally, power);
            });
        if constexpr (Case::pressure) {
            power = T::sum(power, shared.sums);
            if (T::rank() == 0) add_exact(&account_of(v).work, g.quantum.of(power));
        }
        T::sync();
    }
    tally.fold_into(account_of(v));
}

/// Thread blocks of a multiprocessor: as many as leave a thread the registers it needs, on sm_80 too.
template <class Case>
constexpr int split_blocks() {
    constexpr bool twice = sizeof(typename Case::Real) == 8, affine = Case::affine, fluid = Case::fluid;
    if (Case::light) return light_blocks;
    if (Case::pressure) return twice ? 2 : 3;
    constexpr bool large = Case::Shape::sized || Case::Shape::width > 3;
    if (twice) return affine || ((Case::means || fluid) && large) ? 2 : 3;
    return 5 - (large || (fluid && !affine) ? 1 : 0) - (affine ? 1 : 0);
}

}  // namespace moraine::gpu
