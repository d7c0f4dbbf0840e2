#include <algorithm>

#include "core/data/position.hpp"
#include "gpu/exchange/block_moves.hpp"
#include "gpu/exchange/particle_record.cuh"
#include "gpu/kernels/warp.cuh"

namespace moraine::gpu {

namespace {

constexpr int threads = 256;
constexpr std::size_t most_bytes = std::size_t(64) << 20;  ///< of a message: rounds of 64 MiB fill any transport

__global__ void __launch_bounds__(threads)
    list_kernel(const ListCopy* copies, const std::uint32_t* lists, std::uint32_t* to) {
    const ListCopy c = copies[blockIdx.x];
    for (std::uint32_t i = threadIdx.x; i < c.count; i += threads)
        to[c.to + i] = c.arrived ? c.start + i : lists[c.start + i];
}

/// n records of the particles in slot[0 ...], with their head, as the message to peer k.
__global__ void __launch_bounds__(threads)
    pack_kernel(std::uint32_t n, const std::uint32_t* slot, const __grid_constant__ RecordLayout layout,
                std::byte* const* out, int k) {
    const std::uint64_t units = std::uint64_t(n) * layout.units;
    const std::uint64_t first = std::uint64_t(blockIdx.x) * threads + threadIdx.x;
    if (first == 0) *reinterpret_cast<MessageHead*>(out[k]) = {sizeof(MessageHead) + units * 16, n};
    auto* records = reinterpret_cast<uint4*>(out[k] + sizeof(MessageHead));
    for (std::uint64_t i = first; i < units; i += std::uint64_t(gridDim.x) * threads) {
        const std::uint32_t s = slot[i / layout.units];
        const int u = static_cast<int>(i % layout.units);
        uint4 unit;
        if (u == 0) {
            const RecordHead head{layout.id[s], layout.body[s], 0, 0, 0};
            memcpy(&unit, &head, sizeof(unit));
        } else {
            unit = record_unit(layout, u, s);
        }
        records[i] = unit;
    }
}

__global__ void __launch_bounds__(threads)
    unpack_kernel(std::uint32_t n, std::uint32_t first_slot, const __grid_constant__ RecordLayout layout,
                  const std::byte* const* in, int k) {
    const auto* records = reinterpret_cast<const uint4*>(in[k] + sizeof(MessageHead));
    const std::uint64_t units = std::uint64_t(n) * layout.units;
    for (std::uint64_t i = std::uint64_t(blockIdx.x) * threads + threadIdx.x; i < units;
         i += std::uint64_t(gridDim.x) * threads)
        set_record_unit(layout, static_cast<int>(i % layout.units),
                        first_slot + static_cast<std::uint32_t>(i / layout.units), records[i]);
}

template <class Real, int Dim>
__device__ __forceinline__ int cell_of_row(const Row<Real>& row) {
    int cell = 0;
    for (int a = Dim - 1; a >= 0; --a) {
        Coordinate<Real> u;
        memcpy(&u, &row.e[a], sizeof(u));
        cell = 4 * cell + cell_of<Real>(u);
    }
    return cell;
}

/// A warp per block: a bound is where the cell of an entry differs from that of the one before.
template <class Real, int Dim>
__global__ void __launch_bounds__(threads) bound_kernel(int own, const std::uint32_t* first, const std::uint32_t* slot,
                                                        const Row<Real>* place, std::uint32_t* cell_first) {
    constexpr int cells = Block<Dim>::cells;
    const int b = static_cast<int>(blockIdx.x) * (threads / 32) + static_cast<int>(threadIdx.x) / 32;
    if (b >= own) return;
    const std::uint32_t begin = first[b], n = first[b + 1] - begin;
    std::uint32_t* bounds = cell_first + std::size_t(b) * (cells + 1);
    for (std::uint32_t k = static_cast<std::uint32_t>(lane_id()); k <= n; k += 32) {
        const int before = k > 0 ? cell_of_row<Real, Dim>(place[slot[begin + k - 1]]) : -1;
        const int here = k < n ? cell_of_row<Real, Dim>(place[slot[begin + k]]) : cells;
        for (int c = before + 1; c <= here; ++c) bounds[c] = k;
    }
}

unsigned grid_for(std::uint64_t items) {
    return static_cast<unsigned>(std::clamp<std::uint64_t>((items + threads - 1) / threads, 1, 4096));
}

std::vector<ListRange> leaving_of(const std::vector<BlockPlan::Partner>& partners) {
    std::vector<ListRange> all;
    for (const BlockPlan::Partner& p : partners) all.insert(all.end(), p.leaving.begin(), p.leaving.end());
    return all;
}

}  // namespace

void list_ranges(const std::vector<ListRange>& ranges, const std::uint32_t* lists, Array<ListCopy>& copies,
                 std::uint32_t* to, cudaStream_t stream) {
    if (ranges.empty()) return;
    std::vector<ListCopy> all;
    all.reserve(ranges.size());
    std::uint32_t at = 0;
    for (const ListRange& s : ranges) all.push_back({s.start, s.count, at, s.arrived}), at += s.count;
    copies.assign(all, stream);
    list_kernel<<<static_cast<unsigned>(all.size()), threads, 0, stream>>>(copies.data(), lists, to);
    check(cudaGetLastError(), "Listing blocks");
}

/// Both sides know what goes between them, so both keep the same capacities.
std::vector<BlockPlan::Partner> BlockMoves::open(const BlockPlan& plan, std::size_t chunk, std::size_t record) {
    for (const Partner& p : plan.partners) {
        const auto rank_below = [](const TransportPeer& peer, int rank) { return peer.rank < rank; };
        auto at = std::lower_bound(peers_.begin(), peers_.end(), p.rank, rank_below);
        if (at == peers_.end() || at->rank != p.rank) at = peers_.insert(at, {p.rank, 0, 0});
        const auto widen = [&](std::size_t& capacity, std::size_t particles) {
            const std::size_t needed = sizeof(MessageHead) + std::min(particles, chunk) * record;
            if (needed > capacity) capacity = needed + needed / 2;
        };
        widen(at->capacity_out, p.out);
        widen(at->capacity_in, p.in);
    }
    transport_->open(peers_);
    std::vector<Partner> partners;
    auto next = plan.partners.begin();
    for (const TransportPeer& peer : peers_)
        if (next != plan.partners.end() && next->rank == peer.rank)
            partners.push_back(*next++);
        else
            partners.push_back({peer.rank, {}, {}, 0, 0});
    return partners;
}

void BlockMoves::move(const BlockPlan& plan, const std::uint32_t* lists, const RecordLayout& layout,
                      std::uint32_t first_free, const Stream& stream) {
    std::size_t most = 0, leaving = 0;
    for (const Partner& p : plan.partners) most = std::max({most, p.in, p.out}), leaving += p.out;
    most = static_cast<std::size_t>(comm_.max(static_cast<std::int64_t>(most)));
    const std::size_t chunk = most_bytes / layout.bytes();
    const std::vector<Partner> partners = open(plan, chunk, layout.bytes());
    slots_.resize(leaving);
    list_ranges(leaving_of(partners), lists, copies_, slots_.data(), stream);
    const auto part = [&](std::size_t all, std::size_t round) {
        return static_cast<std::uint32_t>(std::min(chunk, all - std::min(all, round * chunk)));
    };
    for (std::size_t round = 0; round * chunk < most; ++round) {
        std::size_t out = round * chunk, in = first_free + round * chunk;
        for (std::size_t k = 0; k < partners.size(); out += partners[k++].out) {
            const std::uint32_t n = part(partners[k].out, round);
            pack_kernel<<<grid_for(std::uint64_t(n) * layout.units), threads, 0, stream>>>(
                n, slots_.data() + (n > 0 ? out : 0), layout, transport_->outgoing(), static_cast<int>(k));
        }
        transport_->start(stream);
        transport_->post();
        transport_->finish(stream);
        for (std::size_t k = 0; k < partners.size(); in += partners[k++].in) {
            const std::uint32_t n = part(partners[k].in, round);
            unpack_kernel<<<grid_for(std::uint64_t(n) * layout.units), threads, 0, stream>>>(
                n, static_cast<std::uint32_t>(in), layout, transport_->incoming(), static_cast<int>(k));
        }
        check(cudaGetLastError(), "Moving blocks");
    }
    stream.wait();
}

template <class Real, int Dim>
void bound_cells(int own, const std::uint32_t* first, const std::uint32_t* slot, const Row<Real>* place,
                 std::uint32_t* cell_first, cudaStream_t stream) {
    if (own == 0) return;
    bound_kernel<Real, Dim><<<static_cast<unsigned>((own + threads / 32 - 1) / (threads / 32)), threads, 0, stream>>>(
        own, first, slot, place, cell_first);
    check(cudaGetLastError(), "Finding the cells");
}

template void bound_cells<float, 2>(int, const std::uint32_t*, const std::uint32_t*, const Row<float>*, std::uint32_t*,
                                    cudaStream_t);
template void bound_cells<float, 3>(int, const std::uint32_t*, const std::uint32_t*, const Row<float>*, std::uint32_t*,
                                    cudaStream_t);
template void bound_cells<double, 2>(int, const std::uint32_t*, const std::uint32_t*, const Row<double>*,
                                     std::uint32_t*, cudaStream_t);
template void bound_cells<double, 3>(int, const std::uint32_t*, const std::uint32_t*, const Row<double>*,
                                     std::uint32_t*, cudaStream_t);

}  // namespace moraine::gpu
