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

/// Places of a peer's tiles in its message; there(tile of the peer's list, tile of all) says how often the tile's nodes
/// are in it. Returns the nodes of all.
template <class There>
__device__ __forceinline__ std::uint32_t place_tiles(const Route& route, int k, std::uint32_t* place,
                                                     const There& there) {
    const std::uint32_t begin = route.peer_first[k], end = route.peer_first[k + 1];
    std::uint32_t before = 0;
    for (std::uint32_t base = begin; base < end; base += plan_threads) {
        const std::uint32_t t = base + threadIdx.x;
        const std::uint32_t here = t < end ? there(t - begin, t) : 0;
        const std::uint32_t n = here > 0 ? here * (route.node_first[t + 1] - route.node_first[t]) : 0;
        std::uint32_t total = 0;
        const std::uint32_t at = before + scan_exclusive(n, total);
        if (t < end) place[t] = here > 0 ? at : nowhere;
        before += total;
    }
    return before;
}

/// Where the gaps of a message go: their places by tile, and the tiles. None in rounds without.
struct GapRoute {
    GapTiles gaps;    ///< structures: 0 where there are none
    NodeGap* tiles;   ///< the same tiles, to write
    int first_block;  ///< of the route's blocks, among own and ghosts
    std::uint32_t* place;
};

/// Structures near the block of a tile.
__device__ __forceinline__ std::uint32_t near_tile(const GapRoute& g, const Route& route, std::uint32_t t) {
    std::uint32_t near = 0;
    for (int k = 0; k < g.gaps.structures; ++k)
        near += g.gaps.tile_of[std::size_t(g.first_block + route.block[t]) * std::size_t(g.gaps.structures) + k] >= 0;
    return near;
}

/// Reals of a node; with a mean it is the last of them.
template <int Dim, bool Mean>
inline constexpr int node_reals_sent = node_sums<Dim> + (Mean ? 1 : 0);

template <class Real, int Dim, bool Mean>
__host__ __device__ constexpr std::size_t bytes_before_gaps(std::size_t tiles, std::size_t nodes) {
    return sizeof(MessageHead) + padded16(tiles) + padded16(nodes * node_reals_sent<Dim, Mean> * sizeof(Real));
}

__device__ __forceinline__ HaloTile what_of(const HaloSleepers& sleepers, const std::int32_t* tile_of, int block) {
    if (tile_of[block] < 0) return HaloTile::none;
    if (!sleepers.asleep || !sleepers.asleep[block]) return HaloTile::awake;
    return sleepers.kept && sleepers.kept[block] ? HaloTile::kept : HaloTile::asleep;
}

__device__ __forceinline__ bool comes(HaloTile tile) {
    return tile == HaloTile::awake || tile == HaloTile::asleep;
}

template <class Real, int Dim, bool Mean>
__global__ void __launch_bounds__(plan_threads)
    plan_send_kernel(Route route, const std::int32_t* tile_of, GapRoute g, HaloSleepers sleepers, std::byte* const* out,
                     std::uint32_t* place, Counters* counters) {
    const int k = static_cast<int>(blockIdx.x);
    auto* says = reinterpret_cast<HaloTile*>(out[k] + sizeof(MessageHead));
    const std::uint32_t nodes = place_tiles(route, k, place, [&](std::uint32_t i, std::uint32_t t) {
        says[i] = what_of(sleepers, tile_of, route.block[t]);
        return std::uint32_t(comes(says[i]));
    });
    std::uint32_t gaps = 0;
    if (g.gaps.structures > 0)
        gaps = place_tiles(route, k, g.place, [&](std::uint32_t, std::uint32_t t) {
            return tile_of[route.block[t]] >= 0 ? near_tile(g, route, t) : 0u;
        });
    if (threadIdx.x > 0) return;
    const std::size_t tiles = route.peer_first[k + 1] - route.peer_first[k];
    const std::size_t bytes =
        bytes_before_gaps<Real, Dim, Mean>(tiles, nodes) + padded16(std::size_t(gaps) * sizeof(NodeGap));
    *reinterpret_cast<MessageHead*>(out[k]) = {bytes, nodes};
    atomicAdd(reinterpret_cast<unsigned long long*>(&counters->halo_bytes), static_cast<unsigned long long>(bytes));
}

__global__ void __launch_bounds__(plan_threads)
    plan_receive_kernel(Route route, GapRoute g, HaloSleepers sleepers, const std::byte* const* in,
                        std::uint32_t* place, std::int32_t* tile_of, int own) {
    const int k = static_cast<int>(blockIdx.x);
    const auto* says = reinterpret_cast<const HaloTile*>(in[k] + sizeof(MessageHead));
    place_tiles(route, k, place, [&](std::uint32_t i, std::uint32_t t) {
        const std::int32_t ghost = route.block[t];
        tile_of[own + ghost] = says[i] == HaloTile::none ? -1 : ghost;
        if (sleepers.asleep) sleepers.asleep[own + ghost] = says[i] == HaloTile::asleep || says[i] == HaloTile::kept;
        return std::uint32_t(comes(says[i]));
    });
    if (g.gaps.structures > 0)
        place_tiles(route, k, g.place, [&](std::uint32_t i, std::uint32_t t) {
            return says[i] == HaloTile::none ? 0u : near_tile(g, route, t);
        });
}

/// Calls f(a gap of tile t, its place in the message from `mail`) for each.
template <class Real, int Dim, bool Mean, class Byte, class F>
__device__ __forceinline__ void each_gap(const Route& route, const GapRoute& g, int t, int tile_nodes,
                                         Byte* const* mail, const F& f) {
    const int k = route.peer[t];
    const std::size_t tiles = route.peer_first[k + 1] - route.peer_first[k];
    const auto nodes = static_cast<std::size_t>(reinterpret_cast<const MessageHead*>(mail[k])->count);
    std::size_t at = bytes_before_gaps<Real, Dim, Mean>(tiles, nodes) + std::size_t(g.place[t]) * sizeof(NodeGap);
    const std::uint32_t first = route.node_first[t], count = route.node_first[t + 1] - first;
    for (int s = 0; s < g.gaps.structures; ++s) {
        const std::size_t block = static_cast<std::size_t>(g.first_block + route.block[t]);
        const std::int32_t tile = g.gaps.tile_of[block * std::size_t(g.gaps.structures) + std::size_t(s)];
        if (tile < 0) continue;
        NodeGap* of_tile = g.tiles + std::size_t(tile) * std::size_t(tile_nodes);
        for (std::uint32_t n = threadIdx.x; n < count; n += copy_threads)
            f(of_tile[route.node[first + n]], mail[k] + at + n * sizeof(NodeGap));
        at += count * sizeof(NodeGap);
    }
}

template <class Real, int Dim, bool Mean>
__global__ void __launch_bounds__(copy_threads)
    pack_gaps_kernel(Route route, GapRoute g, int tile_nodes, std::byte* const* out) {
    const int t = static_cast<int>(blockIdx.x);
    if (g.place[t] == nowhere) return;
    each_gap<Real, Dim, Mean>(route, g, t, tile_nodes, out,
                              [](const NodeGap& gap, std::byte* to) { *reinterpret_cast<NodeGap*>(to) = gap; });
}

template <class Real, int Dim, bool Mean>
__global__ void __launch_bounds__(copy_threads)
    unpack_gaps_kernel(Route route, GapRoute g, int tile_nodes, const std::byte* const* in) {
    const int t = static_cast<int>(blockIdx.x);
    if (g.place[t] == nowhere) return;
    each_gap<Real, Dim, Mean>(route, g, t, tile_nodes, in, [](NodeGap& gap, const std::byte* from) {
        gap = *reinterpret_cast<const NodeGap*>(from);
    });
}

/// The values of a tile in its message.
template <class Real, int Dim, bool Mean, class Byte>
__device__ __forceinline__ auto* values_of(const Route& route, int t, Byte* const* mail, const std::uint32_t* place) {
    const int k = route.peer[t];
    const std::size_t tiles = route.peer_first[k + 1] - route.peer_first[k];
    Byte* at = mail[k] + sizeof(MessageHead) + padded16(tiles) +
               std::size_t(place[t]) * node_reals_sent<Dim, Mean> * sizeof(Real);
    if constexpr (std::is_const_v<Byte>)
        return reinterpret_cast<const Real*>(at);
    else
        return reinterpret_cast<Real*>(at);
}

/// A thread per number: neighbours write neighbours, which the transport likes.
template <class Real, int Dim, bool Mean>
__global__ void __launch_bounds__(copy_threads)
    pack_kernel(Route route, TileView<Real> grid, int tile_reals, const std::uint32_t* place, std::byte* const* out) {
    constexpr int sums = node_reals_sent<Dim, Mean>;
    const int t = static_cast<int>(blockIdx.x);
    if (place[t] == nowhere) return;
    const Real* from = grid.tiles + std::size_t(grid.tile_of[route.block[t]]) * std::size_t(tile_reals);
    Real* to = values_of<Real, Dim, Mean>(route, t, out, place);
    const std::uint32_t first = route.node_first[t];
    const int numbers = static_cast<int>(route.node_first[t + 1] - first) * sums;
    for (int i = static_cast<int>(threadIdx.x); i < numbers; i += copy_threads) {
        const int n = i / sums, q = i % sums;
        const int second = Mean && q == node_sums<Dim> ? quad - 1 : q - Dim - 1;
        to[i] = from[route.node[first + n] * node_reals + (q <= Dim ? q : quad + second)];
    }
}

template <class Real, int Dim, bool Mean>
__global__ void __launch_bounds__(copy_threads) unpack_kernel(Route route, TileView<Real> grid, int tile_reals,
                                                              const std::uint32_t* place, const std::byte* const* in) {
    constexpr int sums = node_reals_sent<Dim, Mean>;
    const int t = static_cast<int>(blockIdx.x);
    if (place[t] == nowhere) return;
    Real* to = grid.tiles + std::size_t(route.block[t]) * std::size_t(tile_reals);
    const Real* from = values_of<Real, Dim, Mean>(route, t, in, place);
    const std::uint32_t first = route.node_first[t];
    const int numbers = static_cast<int>(route.node_first[t + 1] - first) * node_reals;
    for (int i = static_cast<int>(threadIdx.x); i < numbers; i += copy_threads) {
        const int n = i / node_reals, lane = i % quad, second = i % node_reals / quad;
        const bool sum = second ? lane < Dim : lane <= Dim;
        const bool mean = Mean && second && lane == quad - 1;
        to[route.node[first + n] * node_reals + i % node_reals] =
            mean  ? from[n * sums + node_sums<Dim>]
            : sum ? from[n * sums + (second ? Dim + 1 + lane : lane)]
                  : Real(0);
    }
}

}  // namespace

template <class Real, int Dim>
void DeviceHalo<Real, Dim>::open(const EpochTables<Dim>& tables, std::size_t structures, cudaStream_t stream) {
    const auto capacity = [&](const TileList& list) {
        const std::size_t tiles = list.block.size(), nodes = list.node.size();
        return (with_mean_ ? bytes_before_gaps<Real, Dim, true>(tiles, nodes)
                           : bytes_before_gaps<Real, Dim, false>(tiles, nodes)) +
               padded16(list.node.size() * structures * sizeof(NodeGap));
    };
    std::vector<TransportPeer> peers;
    std::size_t most = 0, tiles_out = 0, tiles_in = 0;
    for (const PeerHalo& peer : tables.peers) {
        peers.push_back({peer.rank, capacity(peer.send), capacity(peer.receive)});
        tiles_out += peer.send.block.size(), tiles_in += peer.receive.block.size();
    }
    most = std::max(tiles_out, tiles_in);
    place_.resize(most, stream);
    if (structures > 0) gap_place_.resize(most, stream);
    transport_->open(peers);
}

namespace {

template <int Dim>
GapRoute gap_route(const DeviceGaps<Dim>* gaps, int first_block, const PoolArray<std::uint32_t>& place) {
    if (!gaps) return {};
    return {gaps->view(), gaps->tiles(), first_block, place.data()};
}

}  // namespace

template <class Real, int Dim>
template <bool Mean>
void DeviceHalo<Real, Dim>::pack(const Route& send, const TileView<Real>& grid, const DeviceGaps<Dim>* gaps,
                                 const HaloSleepers& sleepers, int tile_side, Counters* counters, cudaStream_t stream) {
    std::byte* const* out = transport_->outgoing();
    const GapRoute g = gap_route(gaps, 0, gap_place_);
    const int tile_nodes = power<Dim>(tile_side);
    plan_send_kernel<Real, Dim, Mean><<<static_cast<unsigned>(send.peers), plan_threads, 0, stream>>>(
        send, grid.tile_of, g, sleepers, out, place_.data(), counters);
    pack_kernel<Real, Dim, Mean><<<static_cast<unsigned>(send.tiles), copy_threads, 0, stream>>>(
        send, grid, tile_nodes * node_reals, place_.data(), out);
    if (gaps)
        pack_gaps_kernel<Real, Dim, Mean>
            <<<static_cast<unsigned>(send.tiles), copy_threads, 0, stream>>>(send, g, tile_nodes, out);
    check(cudaGetLastError(), "Packing the halo");
}

template <class Real, int Dim>
void DeviceHalo<Real, Dim>::start(const Route& send, const TileView<Real>& grid, const DeviceGaps<Dim>* gaps,
                                  const HaloSleepers& sleepers, int tile_side, Counters* counters,
                                  cudaStream_t stream) {
    if (send.peers > 0)
        with_mean_ ? pack<true>(send, grid, gaps, sleepers, tile_side, counters, stream)
                   : pack<false>(send, grid, gaps, sleepers, tile_side, counters, stream);
    transport_->start(stream);
}

template <class Real, int Dim>
template <bool Mean>
void DeviceHalo<Real, Dim>::unpack(const Route& receive, const TileView<Real>& grid, const DeviceGaps<Dim>* gaps,
                                   const HaloSleepers& sleepers, std::int32_t* tile_of, int own, int tile_side,
                                   cudaStream_t stream) {
    const std::byte* const* in = transport_->incoming();
    const GapRoute g = gap_route(gaps, own, gap_place_);
    const int tile_nodes = power<Dim>(tile_side);
    plan_receive_kernel<<<static_cast<unsigned>(receive.peers), plan_threads, 0, stream>>>(receive, g, sleepers, in,
                                                                                           place_.data(), tile_of, own);
    unpack_kernel<Real, Dim, Mean><<<static_cast<unsigned>(receive.tiles), copy_threads, 0, stream>>>(
        receive, grid, tile_nodes * node_reals, place_.data(), in);
    if (gaps)
        unpack_gaps_kernel<Real, Dim, Mean>
            <<<static_cast<unsigned>(receive.tiles), copy_threads, 0, stream>>>(receive, g, tile_nodes, in);
    check(cudaGetLastError(), "Unpacking the halo");
}

template <class Real, int Dim>
void DeviceHalo<Real, Dim>::finish(const Route& receive, const TileView<Real>& grid, const DeviceGaps<Dim>* gaps,
                                   const HaloSleepers& sleepers, std::int32_t* tile_of, int own, int tile_side,
                                   cudaStream_t stream) {
    transport_->finish(stream);
    if (receive.peers == 0) return;
    with_mean_ ? unpack<true>(receive, grid, gaps, sleepers, tile_of, own, tile_side, stream)
               : unpack<false>(receive, grid, gaps, sleepers, tile_of, own, tile_side, stream);
}

template class DeviceHalo<float, 2>;
template class DeviceHalo<float, 3>;
template class DeviceHalo<double, 2>;
template class DeviceHalo<double, 3>;

}  // namespace moraine::gpu
