#include "gpu/exchange/halo.hpp"
#include "gpu/kernels/scan.cuh"

namespace moraine::gpu {

namespace {

constexpr int plan_threads = scan_threads;
constexpr int copy_threads = 128;
constexpr std::uint32_t nowhere = 0xffffffffu;

__host__ __device__ constexpr std::size_t padded16(std::size_t bytes) {
    return (bytes + 15) / 16 * 16;
}

/// Places of a peer's tiles in its message; there(tile of the peer's list, tile of all) says whether there is one.
/// Returns the nodes of all.
template <class There>
__device__ __forceinline__ std::uint32_t place_tiles(const Route& route, int k, std::uint32_t* place,
                                                     const There& there) {
    const std::uint32_t begin = route.peer_first[k], end = route.peer_first[k + 1];
    std::uint32_t before = 0;
    for (std::uint32_t base = begin; base < end; base += plan_threads) {
        const std::uint32_t t = base + threadIdx.x;
        const bool here = t < end && there(t - begin, t);
        const std::uint32_t n = here ? route.node_first[t + 1] - route.node_first[t] : 0;
        std::uint32_t total = 0;
        const std::uint32_t at = before + scan_exclusive(n, total);
        if (t < end) place[t] = here ? at : nowhere;
        before += total;
    }
    return before;
}

template <class Real, int Dim>
__global__ void __launch_bounds__(plan_threads)
    plan_send_kernel(Route route, const std::int32_t* tile_of, std::byte* const* out, std::uint32_t* place,
                     Counters* counters) {
    const int k = static_cast<int>(blockIdx.x);
    auto* occupied = reinterpret_cast<std::uint8_t*>(out[k] + sizeof(MessageHead));
    const std::uint32_t nodes = place_tiles(route, k, place, [&](std::uint32_t i, std::uint32_t t) {
        const bool here = tile_of[route.block[t]] >= 0;
        occupied[i] = here;
        return here;
    });
    if (threadIdx.x > 0) return;
    const std::size_t tiles = route.peer_first[k + 1] - route.peer_first[k];
    const std::size_t bytes =
        sizeof(MessageHead) + padded16(tiles) + padded16(std::size_t(nodes) * node_sums<Dim> * sizeof(Real));
    *reinterpret_cast<MessageHead*>(out[k]) = {bytes, nodes};
    atomicAdd(reinterpret_cast<unsigned long long*>(&counters->halo_bytes), static_cast<unsigned long long>(bytes));
}

__global__ void __launch_bounds__(plan_threads)
    plan_receive_kernel(Route route, const std::byte* const* in, std::uint32_t* place, std::int32_t* ghost_tile) {
    const int k = static_cast<int>(blockIdx.x);
    const auto* occupied = reinterpret_cast<const std::uint8_t*>(in[k] + sizeof(MessageHead));
    place_tiles(route, k, place, [&](std::uint32_t i, std::uint32_t t) {
        const bool here = occupied[i] != 0;
        const std::int32_t ghost = route.block[t];
        ghost_tile[ghost] = here ? ghost : -1;
        return here;
    });
}

/// The values of a tile in its message.
template <class Real, int Dim, class Byte>
__device__ __forceinline__ auto* values_of(const Route& route, int t, Byte* const* mail, const std::uint32_t* place) {
    const int k = route.peer[t];
    const std::size_t tiles = route.peer_first[k + 1] - route.peer_first[k];
    Byte* at = mail[k] + sizeof(MessageHead) + padded16(tiles) + std::size_t(place[t]) * node_sums<Dim> * sizeof(Real);
    if constexpr (std::is_const_v<Byte>)
        return reinterpret_cast<const Real*>(at);
    else
        return reinterpret_cast<Real*>(at);
}

/// A thread per number: neighbours write neighbours, which the transport likes.
template <class Real, int Dim>
__global__ void __launch_bounds__(copy_threads)
    pack_kernel(Route route, TileView<Real> grid, int tile_reals, const std::uint32_t* place, std::byte* const* out) {
    constexpr int sums = node_sums<Dim>;
    const int t = static_cast<int>(blockIdx.x);
    if (place[t] == nowhere) return;
    const Real* from = grid.tiles + std::size_t(grid.tile_of[route.block[t]]) * std::size_t(tile_reals);
    Real* to = values_of<Real, Dim>(route, t, out, place);
    const std::uint32_t first = route.node_first[t];
    const int numbers = static_cast<int>(route.node_first[t + 1] - first) * sums;
    for (int i = static_cast<int>(threadIdx.x); i < numbers; i += copy_threads) {
        const int n = i / sums, q = i % sums;
        to[i] = from[route.node[first + n] * node_reals + (q <= Dim ? q : quad + q - Dim - 1)];
    }
}

template <class Real, int Dim>
__global__ void __launch_bounds__(copy_threads) unpack_kernel(Route route, TileView<Real> grid, int tile_reals,
                                                              const std::uint32_t* place, const std::byte* const* in) {
    constexpr int sums = node_sums<Dim>;
    const int t = static_cast<int>(blockIdx.x);
    if (place[t] == nowhere) return;
    Real* to = grid.tiles + std::size_t(route.block[t]) * std::size_t(tile_reals);
    const Real* from = values_of<Real, Dim>(route, t, in, place);
    const std::uint32_t first = route.node_first[t];
    const int numbers = static_cast<int>(route.node_first[t + 1] - first) * node_reals;
    for (int i = static_cast<int>(threadIdx.x); i < numbers; i += copy_threads) {
        const int n = i / node_reals, lane = i % quad, second = i % node_reals / quad;
        const bool sum = second ? lane < Dim : lane <= Dim;
        to[route.node[first + n] * node_reals + i % node_reals] =
            sum ? from[n * sums + (second ? Dim + 1 + lane : lane)] : Real(0);
    }
}

}  // namespace

template <class Real, int Dim>
void DeviceHalo<Real, Dim>::open(const EpochTables<Dim>& tables) {
    const auto capacity = [](const TileList& list) {
        return sizeof(MessageHead) + padded16(list.block.size()) +
               padded16(list.node.size() * node_sums<Dim> * sizeof(Real));
    };
    std::vector<TransportPeer> peers;
    std::size_t most = 0, tiles_out = 0, tiles_in = 0;
    for (const PeerHalo& peer : tables.peers) {
        peers.push_back({peer.rank, capacity(peer.send), capacity(peer.receive)});
        tiles_out += peer.send.block.size(), tiles_in += peer.receive.block.size();
    }
    most = std::max(tiles_out, tiles_in);
    place_.resize(most);
    transport_->open(peers);
}

template <class Real, int Dim>
void DeviceHalo<Real, Dim>::start(const Route& send, const TileView<Real>& grid, int tile_side, Counters* counters,
                                  cudaStream_t stream) {
    if (send.peers > 0) {
        std::byte* const* out = transport_->outgoing();
        plan_send_kernel<Real, Dim><<<static_cast<unsigned>(send.peers), plan_threads, 0, stream>>>(
            send, grid.tile_of, out, place_.data(), counters);
        pack_kernel<Real, Dim><<<static_cast<unsigned>(send.tiles), copy_threads, 0, stream>>>(
            send, grid, power<Dim>(tile_side) * node_reals, place_.data(), out);
        check(cudaGetLastError(), "Packing the halo");
    }
    transport_->start(stream);
}

template <class Real, int Dim>
void DeviceHalo<Real, Dim>::finish(const Route& receive, const TileView<Real>& grid, std::int32_t* tile_of, int own,
                                   int tile_side, cudaStream_t stream) {
    transport_->finish(stream);
    if (receive.peers == 0) return;
    const std::byte* const* in = transport_->incoming();
    plan_receive_kernel<<<static_cast<unsigned>(receive.peers), plan_threads, 0, stream>>>(receive, in, place_.data(),
                                                                                           tile_of + own);
    unpack_kernel<Real, Dim><<<static_cast<unsigned>(receive.tiles), copy_threads, 0, stream>>>(
        receive, grid, power<Dim>(tile_side) * node_reals, place_.data(), in);
    check(cudaGetLastError(), "Unpacking the halo");
}

template class DeviceHalo<float, 2>;
template class DeviceHalo<float, 3>;
template class DeviceHalo<double, 2>;
template class DeviceHalo<double, 3>;

}  // namespace moraine::gpu
