#include <algorithm>
#include <utility>

#include "gpu/exchange/migration.hpp"
#include "gpu/exchange/particle_record.cuh"
#include "gpu/kernels/binning/binning.cuh"
#include "gpu/kernels/scan.cuh"

namespace moraine::gpu {

namespace {

constexpr int threads = scan_threads;
constexpr int warps = threads / 32;

/// What it is to be when it was `had` and is to be at least `least`: a growing bound does not grow capacities at each
/// step.
constexpr std::int64_t grown(std::int64_t had, std::int64_t least) {
    return least > had ? least + least / 4 + 32 : had;
}

/// Whether outgoing particles of block b at offset `code` go to peer k.
template <int Dim>
__device__ __forceinline__ bool goes_to(const Route& route, const BlockTable<Dim>& table, int k, int b, int code) {
    const std::int32_t ghost = table.neighbour[std::size_t(b) * Block<Dim>::offsets + std::size_t(code)] - table.own;
    return code != Block<Dim>::centre && ghost >= route.ghost_first[k] && ghost < route.ghost_first[k + 1];
}

/// Outgoing particles of block b to peer k.
template <int Dim>
__device__ __forceinline__ std::uint32_t outgoing_to(const Route& route, const Binning<Dim>& f, int k, int b) {
    if (f.outgoing.count[b] == 0) return 0;
    const std::uint32_t* bound = f.outgoing.bound + std::size_t(b) * outgoing_bounds<Dim>;
    std::uint32_t n = 0;
    for (int code = 0; code < Block<Dim>::offsets; ++code)
        if (bound[code + 1] > bound[code] && goes_to(route, f.table, k, b, code)) n += bound[code + 1] - bound[code];
    return n;
}

/// Of block b, those that stand where less than a cell leads to peer k. A warp's work; the sum is in all lanes.
template <int Dim>
__device__ __forceinline__ std::uint32_t facing_of(const Route& route, const BlockTable<Dim>& table,
                                                   const ListView<Dim>& list, int k, int b) {
    const std::uint32_t exits =
        __ballot_sync(all_lanes, lane_id() < Block<Dim>::offsets && goes_to(route, table, k, b, lane_id()));
    const std::uint32_t* bound = list.cell_first + std::size_t(b) * (Block<Dim>::cells + 1);
    std::uint32_t mine = 0;
    for (int c = lane_id(); c < Block<Dim>::cells; c += 32)
        if (Block<Dim>::reach(c) & exits) mine += bound[c + 1] - bound[c];
    const std::uint32_t sum = __reduce_add_sync(all_lanes, mine);
    return list.count(b) > 0 ? sum : 0;
}

/// The largest of the sums so far is the largest sum. facing: zeros.
__device__ __forceinline__ void add_facing(std::uint32_t n, int k, std::uint32_t* facing, Counters* counters) {
    if (n > 0) atomicMax(&counters->migration_bound[1], atomicAdd(&facing[k], n) + n);
}

/// A warp per block that a peer needs. Those of a thread block mostly share a peer: they are added up there first.
template <int Dim>
__global__ void __launch_bounds__(threads)
    migration_bound_kernel(Route route, BlockTable<Dim> table, ListView<Dim> list, std::uint32_t* facing,
                           Counters* counters) {
    __shared__ std::uint32_t most, sum;
    if (threadIdx.x == 0) most = sum = 0;
    __syncthreads();
    const int first = static_cast<int>(blockIdx.x) * warps, t = first + static_cast<int>(threadIdx.x) / 32;
    const int usual = route.peer[first];
    if (t < route.tiles) {
        const int k = route.peer[t];
        const std::uint32_t n = facing_of(route, table, list, k, route.block[t]);
        if (lane_id() == 0 && n > 0) atomicMax(&most, n);
        if (lane_id() == 0 && k == usual) atomicAdd(&sum, n);
        if (lane_id() == 0 && k != usual) add_facing(n, k, facing, counters);
    }
    __syncthreads();
    if (threadIdx.x > 0) return;
    if (most > 0) atomicMax(&counters->migration_bound[0], most);
    add_facing(sum, usual, facing, counters);
}

/// A thread block per peer: where each source block's records stand, and the head.
template <int Dim>
__global__ void __launch_bounds__(threads)
    plan_kernel(Route route, const __grid_constant__ Binning<Dim> f, int record_units, std::uint32_t* place,
                std::byte* const* out, Counters* counters) {
    const int k = static_cast<int>(blockIdx.x);
    const std::uint32_t begin = route.peer_first[k], end = route.peer_first[k + 1];
    std::uint32_t before = 0;
    for (std::uint32_t base = begin; base < end; base += threads) {
        const std::uint32_t t = base + threadIdx.x;
        const std::uint32_t n = t < end ? outgoing_to(route, f, k, route.block[t]) : 0;
        std::uint32_t total = 0;
        const std::uint32_t at = before + scan_exclusive(n, total);
        if (t < end) place[t] = at;
        before += total;
    }
    if (threadIdx.x > 0) return;
    *reinterpret_cast<MessageHead*>(out[k]) = {sizeof(MessageHead) + std::size_t(before) * record_units * 16, before};
    atomicAdd(reinterpret_cast<unsigned long long*>(&counters->crossed), static_cast<unsigned long long>(before));
}

/// A warp per source block.
template <int Dim>
__global__ void __launch_bounds__(threads)
    pack_kernel(Route route, const __grid_constant__ Binning<Dim> f, const __grid_constant__ RecordLayout layout,
                const std::uint32_t* place, std::byte* const* out) {
    const int t = static_cast<int>(blockIdx.x) * warps + static_cast<int>(threadIdx.x) / 32;
    if (t >= route.tiles) return;
    const int k = route.peer[t], b = route.block[t];
    if (f.outgoing.count[b] == 0) return;
    const std::uint32_t* bound = f.outgoing.bound + std::size_t(b) * outgoing_bounds<Dim>;
    auto* records = reinterpret_cast<uint4*>(out[k] + sizeof(MessageHead));
    std::uint32_t at = place[t];
    for (int code = 0; code < Block<Dim>::offsets; ++code) {
        const std::uint32_t n = bound[code + 1] - bound[code];
        if (n == 0 || !goes_to(route, f.table, k, b, code)) continue;
        const std::uint32_t first = f.list.first[b] + bound[code];
        const std::uint32_t units = n * static_cast<std::uint32_t>(layout.units);
        for (std::uint32_t i = static_cast<std::uint32_t>(lane_id()); i < units; i += 32) {
            const std::uint32_t j = i / layout.units, u = i % layout.units;
            const std::uint32_t slot = f.outgoing.slot[first + j];
            uint4 unit;
            if (u == 0) {
                const RecordHead head{layout.id[slot], layout.body[slot], static_cast<std::uint8_t>(code),
                                      f.outgoing.cell[first + j], static_cast<std::uint32_t>(t) - route.peer_first[k]};
                memcpy(&unit, &head, sizeof(unit));
            } else {
                unit = record_unit(layout, static_cast<int>(u), slot);
            }
            records[std::size_t(at) * layout.units + i] = unit;
        }
        at += n;
    }
}

__device__ __forceinline__ std::uint32_t count_of(const std::byte* const* in, int k) {
    return static_cast<std::uint32_t>(reinterpret_cast<const MessageHead*>(in[k])->count);
}

/// Incoming particles from peers before k.
__device__ __forceinline__ std::uint32_t incoming_before(const std::byte* const* in, int k) {
    std::uint32_t n = 0;
    for (int i = 0; i < k; ++i) n += count_of(in, i);
    return n;
}

__device__ __forceinline__ RecordHead head_of(const std::byte* message, int units, std::uint32_t i) {
    return *reinterpret_cast<const RecordHead*>(message + sizeof(MessageHead) + std::size_t(i) * units * 16);
}

/// First of the records [from, to) that is not below (tile, exit).
__device__ __forceinline__ std::uint32_t find_record(const std::byte* message, int units, std::uint32_t from,
                                                     std::uint32_t to, std::uint32_t tile, int exit) {
    while (from < to) {
        const std::uint32_t middle = (from + to) / 2;
        const RecordHead h = head_of(message, units, middle);
        if (h.tile < tile || (h.tile == tile && h.exit < exit))
            from = middle + 1;
        else
            to = middle;
    }
    return from;
}

/// A warp per ghost block: its outgoing particles are a range of the peer's records, each exit a range of that.
template <int Dim>
__global__ void __launch_bounds__(threads) ghosts_kernel(Route route, const __grid_constant__ Binning<Dim> f, int units,
                                                         const std::byte* const* in, std::uint32_t* ghost_start) {
    const int t = static_cast<int>(blockIdx.x) * warps + static_cast<int>(threadIdx.x) / 32;
    if (t >= route.tiles) return;
    const int k = route.peer[t], ghost = route.block[t], at = f.table.own + ghost;
    const std::uint32_t tile = static_cast<std::uint32_t>(t) - route.peer_first[k], all = count_of(in, k);
    const int exit = min(lane_id(), Block<Dim>::offsets);
    const std::uint32_t bound = find_record(in[k], units, 0, all, tile, exit);
    const std::uint32_t first = __shfl_sync(all_lanes, bound, 0);
    const std::uint32_t count = __shfl_sync(all_lanes, bound, 31) - first;
    if (lane_id() == 0) {
        f.outgoing.count[at] = count;
        ghost_start[ghost] = f.list.first[f.table.own] + incoming_before(in, k) + first;
    }
    if (lane_id() < outgoing_bounds<Dim>)
        f.outgoing.bound[std::size_t(at) * outgoing_bounds<Dim> + std::size_t(lane_id())] = bound - first;
}

/// Rows to free slots; outgoing particles behind the own ones. A thread block row (y) per peer.
template <int Dim>
__global__ void __launch_bounds__(threads)
    unpack_kernel(const __grid_constant__ Binning<Dim> f, const __grid_constant__ RecordLayout layout,
                  const std::byte* const* in, const Counters* counters) {
    const int k = static_cast<int>(blockIdx.y);
    const std::uint32_t n = count_of(in, k), before = incoming_before(in, k);
    const auto* message = reinterpret_cast<const uint4*>(in[k] + sizeof(MessageHead));
    const std::uint64_t units = std::uint64_t(n) * layout.units;
    for (std::uint64_t i = blockIdx.x * threads + threadIdx.x; i < units; i += std::uint64_t(gridDim.x) * threads) {
        const auto j = static_cast<std::uint32_t>(i / layout.units);
        const int u = static_cast<int>(i % layout.units);
        const std::uint32_t slot = counters->stored + before + j;
        set_record_unit(layout, u, slot, message[i]);
        if (u > 0) continue;
        const std::uint32_t to = f.list.first[f.table.own] + before + j;
        f.outgoing.slot[to] = slot;
        f.outgoing.cell[to] = head_of(in[k], layout.units, j).cell;
    }
}

__global__ void stored_kernel(int peers, const std::byte* const* in, Counters* counters, std::uint32_t* facing) {
    counters->stored += incoming_before(in, peers);
    for (int k = 0; k < peers; ++k) facing[k] = 0;
}

unsigned blocks_for(int items, int per_block) {
    return static_cast<unsigned>((items + per_block - 1) / per_block);
}

}  // namespace

template <int Dim>
void DeviceMigration<Dim>::begin_epoch(const EpochTables<Dim>& tables, cudaStream_t stream) {
    peers_.clear();
    std::size_t tiles = 0;
    for (const PeerHalo& peer : tables.peers) {
        peers_.push_back({peer.rank, peer.send.block.size(), peer.receive.block.size()});
        tiles += peer.send.block.size();
    }
    place_.resize(tiles, stream);
    facing_.resize(peers_.size(), stream);
    if (!peers_.empty())
        check(cudaMemsetAsync(facing_.data(), 0, peers_.size() * sizeof(std::uint32_t), stream), "Beginning an epoch");
    const std::size_t record = std::exchange(record_, 0);
    if (record > 0) expect(migration_bound_, record);
}

template <int Dim>
void DeviceMigration<Dim>::expect(const MigrationBound& bound, std::size_t record) {
    if (record == record_ && bound.block <= migration_bound_.block && bound.pair <= migration_bound_.pair) return;
    migration_bound_ = {grown(migration_bound_.block, bound.block), grown(migration_bound_.pair, bound.pair)};
    record_ = record;
    std::vector<TransportPeer> peers;
    most_incoming_ = 0;
    for (const Peer& p : peers_) {
        const std::size_t out = most_from(p.tiles_out), in = most_from(p.tiles_in);
        peers.push_back({p.rank, sizeof(MessageHead) + out * record, sizeof(MessageHead) + in * record});
        most_incoming_ += in;
    }
    transport_->open(peers);
}

/// Outgoing particles of so many blocks to one peer.
template <int Dim>
std::size_t DeviceMigration<Dim>::most_from(std::size_t tiles) const {
    return std::min(tiles * static_cast<std::size_t>(migration_bound_.block),
                    static_cast<std::size_t>(migration_bound_.pair));
}

template <int Dim>
void DeviceMigration<Dim>::count_migration_bound(const Route& send, const BlockTable<Dim>& table,
                                                 const ListView<Dim>& list, Counters* counters, cudaStream_t stream) {
    if (send.tiles == 0) return;
    migration_bound_kernel<<<blocks_for(send.tiles, warps), threads, 0, stream>>>(send, table, list, facing_.data(),
                                                                                  counters);
    check(cudaGetLastError(), "Counting the migration bound");
}

template <int Dim>
void DeviceMigration<Dim>::start(const Route& send, const Binning<Dim>& binning, const RecordLayout& layout,
                                 Counters* counters, cudaStream_t stream) {
    if (send.peers > 0) {
        std::byte* const* out = transport_->outgoing();
        plan_kernel<<<static_cast<unsigned>(send.peers), threads, 0, stream>>>(send, binning, layout.units,
                                                                               place_.data(), out, counters);
        pack_kernel<<<blocks_for(send.tiles, warps), threads, 0, stream>>>(send, binning, layout, place_.data(), out);
        check(cudaGetLastError(), "Packing particles that leave");
    }
    transport_->start(stream);
}

template <int Dim>
void DeviceMigration<Dim>::finish(const Route& receive, const Binning<Dim>& binning, const RecordLayout& layout,
                                  Counters* counters, cudaStream_t stream) {
    transport_->finish(stream);
    if (receive.peers == 0) return;
    const std::byte* const* in = transport_->incoming();
    const auto peers = static_cast<unsigned>(receive.peers);
    ghosts_kernel<<<blocks_for(receive.tiles, warps), threads, 0, stream>>>(
        receive, binning, layout.units, in, const_cast<std::uint32_t*>(binning.outgoing.ghost_start));
    unpack_kernel<<<dim3(64, peers), threads, 0, stream>>>(binning, layout, in, counters);
    stored_kernel<<<1, 1, 0, stream>>>(receive.peers, in, counters, facing_.data());
    check(cudaGetLastError(), "Taking incoming particles in");
}

template class DeviceMigration<2>;
template class DeviceMigration<3>;

}  // namespace moraine::gpu
