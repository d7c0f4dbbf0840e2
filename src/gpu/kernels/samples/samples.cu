#include "core/data/gravity_work.hpp"
#include "gpu/kernels/samples/samples.hpp"
#include "gpu/kernels/seen.cuh"

namespace moraine::gpu {

namespace {

constexpr int sample_threads = 128;
constexpr int most_columns = 64;  ///< over a block, in shared memory

template <class Real, int Dim>
__device__ __forceinline__ CoreRows<Real, Dim> load_sampled(const View<Real, Dim>& v, std::uint32_t s) {
    using Core = CoreRows<Real, Dim>;
    Core core;
    core.row[Core::place] = load_row(v.p.core[Core::place] + s);
    if constexpr (Core::motion != Core::place) core.row[Core::motion] = load_row(v.p.core[Core::motion] + s);
    if constexpr (Core::volume_row != Core::place && Core::volume_row != Core::motion)
        core.row[Core::volume_row] = load_row(v.p.core[Core::volume_row] + s);
    return core;
}

__device__ __forceinline__ void add_whole(std::int64_t* to, std::int64_t whole) {
    atomicAdd(reinterpret_cast<unsigned long long*>(to), static_cast<unsigned long long>(whole));
}

template <class Real>
__global__ void __launch_bounds__(sample_threads, 1)
    columns_kernel(const __grid_constant__ View<Real, 3> v, const __grid_constant__ PlanColumns columns,
                   std::int64_t* sums, std::uint64_t* fastest) {
    constexpr int q = PlanColumns::sums;
    __shared__ std::int64_t here[most_columns * q];
    const int block = static_cast<int>(blockIdx.x);
    const std::uint32_t begin = v.list.first[block], end = v.list.first[block + 1];
    if (begin == end) return;
    const Vec<std::int32_t, 3> at = v.table.position[block];
    std::int64_t low[2], span[2];
    for (int a = 0; a < 2; ++a) {
        low[a] = columns.along(a, columns.places.at(a, at[a], 0));
        span[a] = columns.along(a, columns.places.at(a, at[a], 4)) - low[a] + 1;
    }
    const bool shared = span[0] * span[1] <= most_columns;
    const int mine = shared ? static_cast<int>(span[0] * span[1]) * q : 0;
    for (int k = static_cast<int>(threadIdx.x); k < mine; k += sample_threads) here[k] = 0;
    __syncthreads();
    double most = 0;
    for (std::uint32_t k = begin + threadIdx.x; k < end; k += sample_threads) {
        const CoreRows<Real, 3> p = load_sampled(v, v.list.slot[k]);
        const std::int64_t i = columns.along(0, columns.places.of<Real>(0, at[0], p.coordinate(0)));
        const std::int64_t j = columns.along(1, columns.places.of<Real>(1, at[1], p.coordinate(1)));
        std::int64_t* to = shared ? here + q * ((i - low[0]) + span[0] * (j - low[1])) : sums + columns.place(i, j);
        const Vec<Real, 3> velocity{{p.velocity(0), p.velocity(1), p.velocity(2)}};
        const double square = PlanColumns::square_of(velocity);
        most = square > most ? square : most;
        const double z = columns.places.of<Real>(2, at[2], p.coordinate(2));
        if (!columns.is_summed(columns.column(i, j), z)) continue;
        columns.add_particle<Real>(double(p.volume()), double(p.mass()), velocity,
                                   [&](int n, std::int64_t whole) { add_whole(to + n, whole); });
    }
    most = warp_max(most);
    if (threadIdx.x % 32 == 0 && most > 0) raise(*fastest, most);
    __syncthreads();
    for (int k = static_cast<int>(threadIdx.x); k < mine; k += sample_threads) {
        const std::int64_t column = k / q;
        const std::size_t place = columns.place(low[0] + column % span[0], low[1] + column / span[0]);
        if (here[k] != 0) add_whole(sums + place + k % q, here[k]);
    }
}

/// Most particles find their bit set already.
template <class Real>
__global__ void __launch_bounds__(sample_threads, 1)
    layers_kernel(const __grid_constant__ View<Real, 3> v, const __grid_constant__ PlanColumns columns,
                  Layers* layers) {
    const int block = static_cast<int>(blockIdx.x);
    const Vec<std::int32_t, 3> at = v.table.position[block];
    for (std::uint32_t k = v.list.first[block] + threadIdx.x; k < v.list.first[block + 1]; k += sample_threads) {
        const CoreRows<Real, 3> p = load_sampled(v, v.list.slot[k]);
        const std::size_t column = columns.column(columns.along(0, columns.places.of<Real>(0, at[0], p.coordinate(0))),
                                                  columns.along(1, columns.places.of<Real>(1, at[1], p.coordinate(1))));
        const Layers layer = columns.layer(column, columns.places.of<Real>(2, at[2], p.coordinate(2)));
        if (!(*reinterpret_cast<volatile Layers*>(layers + column) & layer))
            atomicOr(reinterpret_cast<unsigned long long*>(layers + column), static_cast<unsigned long long>(layer));
    }
}

template <class Real>
__global__ void __launch_bounds__(sample_threads, 1)
    near_kernel(const __grid_constant__ View<Real, 3> v, const PlanLines lines, NearParticle* near,
                const std::uint32_t capacity, std::uint32_t* count) {
    const int block = static_cast<int>(blockIdx.x);
    const std::uint32_t begin = v.list.first[block], end = v.list.first[block + 1];
    if (begin == end) return;
    const Vec<std::int32_t, 3> at = v.table.position[block];
    if (!lines.is_near_block(at)) return;
    for (std::uint32_t k = begin + threadIdx.x; k < end; k += sample_threads) {
        const std::uint32_t s = v.list.slot[k];
        const CoreRows<Real, 3> p = load_sampled(v, s);
        const double x = lines.places.of<Real>(0, at[0], p.coordinate(0));
        const double y = lines.places.of<Real>(1, at[1], p.coordinate(1));
        if (!lines.is_near(x, y, lines.reach)) continue;
        const std::uint32_t to = atomicAdd(count, 1u);
        if (to < capacity) near[to] = {v.p.id[s], {x, y}, double(p.volume()), double(p.mass())};
    }
}

template <int Dim>
struct GravityChange {
    PlanPlaces places;
    double change[Dim];  ///< [m/s2]
    Quantum quantum;
};

template <class Real, int Dim>
__global__ void __launch_bounds__(sample_threads, 1)
    gravity_kernel(const __grid_constant__ View<Real, Dim> v, const __grid_constant__ GravityChange<Dim> of,
                   ExactSum* work) {
    const int block = static_cast<int>(blockIdx.x);
    const Vec<std::int32_t, Dim> at = v.table.position[block];
    ExactSum mine[1];
    for (std::uint32_t k = v.list.first[block] + threadIdx.x; k < v.list.first[block + 1]; k += sample_threads) {
        const CoreRows<Real, Dim> p = load_sampled(v, v.list.slot[k]);
        mine[0].add(of.quantum.of(gravity_work<Real>(
            of.places, of.change, at, [&](int a) { return p.coordinate(a); }, double(p.mass()))));
    }
    fold_sums(mine, work);
}

}  // namespace

template <class Real, int Dim>
void sum_gravity_work(const View<Real, Dim>& view, const PlanPlaces& places, const double (&change)[Dim],
                      const Quantum& quantum, ExactSum* work, cudaStream_t stream) {
    if (view.table.own == 0) return;
    GravityChange<Dim> of{places, {}, quantum};
    for (int a = 0; a < Dim; ++a) of.change[a] = change[a];
    gravity_kernel<Real, Dim><<<static_cast<unsigned>(view.table.own), sample_threads, 0, stream>>>(view, of, work);
    check(cudaGetLastError(), "Summing the work of gravity");
}

template <class Real>
void find_layers(const View<Real, 3>& view, const PlanColumns& columns, Layers* layers, cudaStream_t stream) {
    if (view.table.own == 0) return;
    layers_kernel<Real><<<static_cast<unsigned>(view.table.own), sample_threads, 0, stream>>>(view, columns, layers);
    check(cudaGetLastError(), "Finding layers");
}

template <class Real>
void sum_columns(const View<Real, 3>& view, const PlanColumns& columns, std::int64_t* sums, std::uint64_t* fastest,
                 cudaStream_t stream) {
    if (view.table.own == 0) return;
    columns_kernel<Real>
        <<<static_cast<unsigned>(view.table.own), sample_threads, 0, stream>>>(view, columns, sums, fastest);
    check(cudaGetLastError(), "Summing columns");
}

template <class Real>
void find_near(const View<Real, 3>& view, const PlanLines& lines, NearParticle* near, std::uint32_t capacity,
               std::uint32_t* count, cudaStream_t stream) {
    if (view.table.own == 0) return;
    near_kernel<Real>
        <<<static_cast<unsigned>(view.table.own), sample_threads, 0, stream>>>(view, lines, near, capacity, count);
    check(cudaGetLastError(), "Finding particles near sections");
}

/// Of one precision.
#define MORAINE_SAMPLES(Real)                                                                                         \
    template void find_layers(const View<Real, 3>&, const PlanColumns&, Layers*, cudaStream_t);                       \
    template void sum_columns(const View<Real, 3>&, const PlanColumns&, std::int64_t*, std::uint64_t*, cudaStream_t); \
    template void find_near(const View<Real, 3>&, const PlanLines&, NearParticle*, std::uint32_t, std::uint32_t*,     \
                            cudaStream_t);
MORAINE_SAMPLES(float)
MORAINE_SAMPLES(double)

/// Of one precision and dimension.
#define MORAINE_GRAVITY_WORK(Real, Dim)                                                                             \
    template void sum_gravity_work(const View<Real, Dim>&, const PlanPlaces&, const double(&)[Dim], const Quantum&, \
                                   ExactSum*, cudaStream_t);
MORAINE_GRAVITY_WORK(float, 2)
MORAINE_GRAVITY_WORK(float, 3)
MORAINE_GRAVITY_WORK(double, 2)
MORAINE_GRAVITY_WORK(double, 3)

}  // namespace moraine::gpu
