#pragma once
// What particles tell the step control and the budget, folded into an Account (gpu/kernels/view.hpp) by integer
// atomics: no order matters. A double that is not negative orders as its bits do.

#include "gpu/kernels/account.cuh"

namespace moraine::gpu {

/// The part of the accounts that this thread block folds into.
template <class Real, int Dim>
__device__ __forceinline__ Account<Dim>& account_of(const View<Real, Dim>& v) {
    return v.accounts[blockIdx.x % account_parts];
}

/// Looks before it asks: most are not larger than what is there.
__device__ __forceinline__ void raise(std::uint64_t& to, double value) {
    const auto bits = static_cast<std::uint64_t>(__double_as_longlong(value));
    if (bits > *static_cast<volatile std::uint64_t*>(&to)) atomicMax(word(&to), static_cast<unsigned long long>(bits));
}

template <int Dim>
__device__ __forceinline__ void note_fault(Account<Dim>& account, std::uint32_t faults, std::uint64_t id) {
    atomicOr(&account.faults, faults);
    atomicMin(word(&account.faulty_id), static_cast<unsigned long long>(id));
}

/// A particle of mass m [kg] and velocity v [m/s] that left through an open wall. gravity_impulse: integral of gravity
/// [m/s].
template <int Dim>
__device__ __forceinline__ void note_loss(Account<Dim>& account, const Quantum& quantum, double m,
                                          const double (&v)[Dim], const double (&gravity_impulse)[Dim]) {
    add_exact(&account.lost_mass, quantum.of(m));
    for (int a = 0; a < Dim; ++a) {
        add_exact(&account.lost_momentum[a], quantum.of(m * v[a]));
        add_exact(&account.lost_gravity_impulse[a], quantum.of(m * gravity_impulse[a]));
    }
    atomicAdd(word(&account.lost_count), 1ull);
}

__device__ __forceinline__ float warp_max(float x) {
    return __uint_as_float(__reduce_max_sync(0xffffffffu, __float_as_uint(x)));
}
__device__ __forceinline__ double warp_max(double x) {
#pragma unroll
    for (int d = 16; d > 0; d /= 2) {
        const double other = __shfl_xor_sync(0xffffffffu, x, d);
        x = other > x ? other : x;
    }
    return x;
}

/// What one thread has seen; none of it is negative.
template <class Real>
struct Seen {
    Real signal = 0;            ///< [m/s]
    Real moved = 0;             ///< [cells]
    std::uint32_t clamped = 0;  ///< boxes

    /// By whole warps.
    template <int Dim>
    __device__ __forceinline__ void fold_into(Account<Dim>& account) const {
        const auto s = double(warp_max(signal)), m = double(warp_max(moved));
        const std::uint32_t c = __reduce_add_sync(0xffffffffu, clamped);
        if (threadIdx.x % 32 != 0) return;
        if (s > 0) raise(account.signal, s);
        if (m > 0) raise(account.moved, m);
        if (c > 0) atomicAdd(&account.clamped, c);
    }
};

/// And where steps depend on it (core/fluid/grid_pressure.hpp).
template <class Real>
struct SeenWithSpeed : Seen<Real> {
    Real square_speed = 0;  ///< [m2/s2]

    template <int Dim>
    __device__ __forceinline__ void fold_into(Account<Dim>& account) const {
        Seen<Real>::fold_into(account);
        const auto square = double(warp_max(square_speed));
        if (threadIdx.x % 32 == 0 && square > 0) raise(account.square_speed, square);
    }
};
template <class Real, bool Speed>
using SeenOf = std::conditional_t<Speed, SeenWithSpeed<Real>, Seen<Real>>;

}  // namespace moraine::gpu
