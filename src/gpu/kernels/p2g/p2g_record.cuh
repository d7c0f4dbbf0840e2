#pragma once
// Records of particles in shared memory: the rows that one pass of a particle-to-grid kernel reads.
//
// A round holds `width` particles of each cell, each copied by one thread. Units of 16 bytes lie [unit][particle of
// the round][cell], so that the lanes of a warp, which read records of neighbouring cells, meet no bank twice.
// Gimp's box needs a look-up by body and perhaps an exponential: the thread that copied a record does it, once.

#include <type_traits>

#include "gpu/kernels/copy_async.cuh"
#include "gpu/kernels/p2g/p2g_case.cuh"

namespace moraine::gpu {

/// A particle as the sums read it; rows that a pass does not need are not set.
template <class Case>
struct Particle {
    CoreRows<typename Case::Real, Case::dim> core;
    Row<typename Case::Real> affine[affine_rows<Case::dim>];
    Row<typename Case::Real> half, quarter;  ///< of the box: l and 1 / (4 l) per axis [cells]

    __device__ typename Case::Real fraction(int a) const {
        return fraction_of<typename Case::Real>(core.coordinate(a));
    }
    __device__ typename Case::Real C(int a, int b) const {
        return Case::dim == 3 ? affine[a].e[b] : affine[0].e[2 * a + b];
    }
};

template <class Case, bool Momentum, bool Force>
struct Record {
    using Real = typename Case::Real;
    using Core = CoreRows<Real, Case::dim>;
    static constexpr int first_affine = core_rows<Case::dim>;
    static constexpr int half = first_affine + affine_rows<Case::dim>;
    static constexpr int quarter = half + 1;
    static constexpr int all = quarter + 1;

    static constexpr bool needed(int row) {
        if (row >= half) return Case::Shape::sized;
        if (row >= first_affine) return Case::affine && Momentum;
        return row == Core::place || (row == Core::motion ? Momentum : Force);
    }
    /// 3-D: the volume is in the motion row; where no other of that row is needed it comes alone.
    static constexpr bool volume_apart = Case::dim == 3 && !Momentum && !Case::mean;
    /// Or of the scalar of history, where the mass is needed too.
    static constexpr bool volume_for_history = Case::dim == 3 && !Momentum && Case::mean;
    /// Needed rows before this one.
    static constexpr int place_of(int row) {
        int n = 0;
        for (int r = 0; r < row; ++r) n += needed(r);
        return n;
    }
    static constexpr int per_row = 4 * int(sizeof(Real)) / 16;           ///< units of a row
    static constexpr int stride = Case::threads;                         ///< units from one of a record to the next
    static constexpr int volumes_at = place_of(all) * per_row * stride;  ///< units
    static constexpr int round_units = volumes_at + (volume_apart ? stride * int(sizeof(Real)) / 16 : 0);

    /// Copies the particle in slot s into record `number` of a round.
    static __device__ __forceinline__ void start(const View<Real, Case::dim>& v, std::uint32_t s, uint4* round,
                                                 unsigned number) {
        uint4* to = round + number;
        copy_row<Core::place>(v.p.core[Core::place], s, to);
        if constexpr (volume_apart)
            copy_async<int(sizeof(Real))>(reinterpret_cast<Real*>(round + volumes_at) + number,
                                          v.p.core[Core::motion][s].e + 3);
        each_row<1, first_affine>([&](auto r) {
            if constexpr (volume_for_history && r == Core::shear)
                copy_shear(v, s, to);
            else
                copy_row<r>(v.p.core[r], s, to);
        });
        each_row<first_affine, half>([&](auto r) { copy_row<r>(v.p.affine[r - first_affine], s, to); });
        if constexpr (Case::Shape::sized) {
            if (v.p.log_stretch) copy_row<half>(v.p.log_stretch, s, to);
            // The body is half a word, and copies are whole words: which half follows.
            uint4* word = to + unit_of<quarter>;
            copy_async<4>(word, v.p.body + (s & ~1u));
            word->y = 16 * (s & 1u);
        }
    }

    /// Makes the box of this thread's own record, once it is there.
    static __device__ __forceinline__ void finish(const View<Real, Case::dim>& v, uint4* own) {
        if constexpr (Case::Shape::sized) {
            const uint4 word = own[unit_of<quarter>];
            const auto* size = v.context.half_size + ((word.x >> word.y) & 0xffffu);
            Row<Real> l{}, q{};
            if (v.p.log_stretch) l = read_row<half>(own);
#pragma unroll
            for (int a = 0; a < Case::dim; ++a) {
                l.e[a] = held_half(v.p.log_stretch ? stretched_half((*size)[a], l.e[a]) : (*size)[a]);
                q.e[a] = Real(0.25) / l.e[a];
            }
            write_row<half>(l, own), write_row<quarter>(q, own);
        }
    }

    /// from: a record of the round.
    static __device__ __forceinline__ Particle<Case> read(const uint4* round, const uint4* from) {
        Particle<Case> p;
        each_row<0, first_affine>([&](auto r) { p.core.row[r] = read_row<r>(from); });
        if constexpr (volume_apart) p.core.volume() = reinterpret_cast<const Real*>(round + volumes_at)[from - round];
        if constexpr (volume_for_history) p.core.volume() = p.core.history();
        each_row<first_affine, half>([&](auto r) { p.affine[r - first_affine] = read_row<r>(from); });
        each_row<half, half + 1>([&](auto r) { p.half = read_row<r>(from); });
        each_row<quarter, all>([&](auto r) { p.quarter = read_row<r>(from); });
        return p;
    }

  private:
    template <int R>
    static constexpr int unit_of = (place_of(R) * per_row * stride);

    /// Calls f(integral constant) for the needed rows among [From, To).
    template <int From, int To, class F>
    static __device__ __forceinline__ void each_row(const F& f) {
        if constexpr (From < To) {
            if constexpr (needed(From)) f(std::integral_constant<int, From>{});
            each_row<From + 1, To>(f);
        }
    }

    static __device__ __forceinline__ void copy_shear(const View<Real, Case::dim>& v, std::uint32_t s, uint4* to) {
        constexpr int size = int(sizeof(Real)), last = 2 * size / 16 * stride;
        uint4* first = to + unit_of<Core::shear>;
        const Real* from = v.p.core[Core::shear][s].e;
        Real* end = reinterpret_cast<Real*>(first + last) + (size == 4 ? 2 : 0);
        copy_async<2 * size>(first, from);
        copy_async<size>(end, from + 2);
        copy_async<size>(end + 1, v.p.core[Core::motion][s].e + 3);
    }

    template <int R>
    static __device__ __forceinline__ void copy_row(const Row<Real>* column, std::uint32_t s, uint4* to) {
        const uint4* from = reinterpret_cast<const uint4*>(column + s);
#pragma unroll
        for (int u = 0; u < per_row; ++u) copy_async<16>(to + unit_of<R> + u * stride, from + u);
    }
    template <int R>
    static __device__ __forceinline__ Row<Real> read_row(const uint4* from) {
        Row<Real> r;
#pragma unroll
        for (int u = 0; u < per_row; ++u) reinterpret_cast<uint4*>(&r)[u] = from[unit_of<R> + u * stride];
        return r;
    }
    template <int R>
    static __device__ __forceinline__ void write_row(const Row<Real>& r, uint4* to) {
#pragma unroll
        for (int u = 0; u < per_row; ++u) to[unit_of<R> + u * stride] = reinterpret_cast<const uint4*>(&r)[u];
    }
};

}  // namespace moraine::gpu
