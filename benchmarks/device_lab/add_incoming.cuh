#pragma once
// Who came from other blocks: into the region's tail and into the tile, in the order (source block, slot); and what
// blocks tell, into accounts. A warp per block that somebody came to: a lane per node of a particle's stencil, one
// particle after the other, into a tile in shared memory, which is then added to the block's.

#include "device_lab/fused_layout.cuh"

namespace moraine::gpu::lab {

template <class Real>
inline constexpr int incoming_warps = sizeof(Real) == 4 ? 4 : 2;
template <class Real>
inline constexpr int incoming_resident = sizeof(Real) == 4 ? 7 : 6;

/// Weight of the node k above the lowest of the stencil, and its slope [1/cell].
template <class Real>
__device__ __forceinline__ void spline_of(unsigned k, Real f, Real& w, Real& d) {
    const Real t = f - (Real(1) - Real(0.5) * Real(k)), a = k == 1 ? Real(-1) : Real(0.5);
    w = a * t * t + (k == 1 ? Real(0.75) : Real(0));
    d = (a + a) * t;
}

/// One warp's work on one block.
template <class Real>
class Incoming {
  public:
    static constexpr int side = tile_side(3), nodes = power<3>(side);
    static constexpr unsigned batch = 32 / core_rows<3>;
    struct Scratch {
        Row<Real> tile[nodes][2];
        Row<Real> row[batch][core_rows<3>];
        std::size_t from[32];    ///< where those of a code stand, less those of the codes below
        std::uint32_t upto[32];  ///< those who come, by neighbour code, added up
    };

    __device__ Incoming(const FusedStep<Real>& step, Scratch& scratch, int block) : s(step), m(scratch), b(block) {}

    __device__ void run() {
        __syncwarp();
        prefetch_tile();
        find();
        const std::uint32_t all = m.upto[31], tail = s.region[b].tail;
        if (tail + all > s.capacity) {
            *s.error = 1;
            return;
        }
        Row<Real>* tile = &m.tile[0][0];
        for (int k = lane_id(); k < 2 * nodes; k += 32) store_row(tile + k, Row<Real>{});
        for (std::uint32_t first = 0; first < all; first += batch) {
            __syncwarp();
            const unsigned here = min(all - first, batch);
            fetch(first, here, tail);
            __syncwarp();
            for (unsigned k = 0; k < here; ++k) {
                if (lane_id() < 27) add(m.row[k]);
                __syncwarp();
            }
        }
        add_tile();
        if (lane_id() != 0) return;
        s.region[b].incoming = all;
        if (s.tile_of[b] < 0) s.tile_of[b] = b, s.occupied[atomicAdd(s.occupieds, 1u)] = b;
    }

  private:
    __device__ const char* tile_begin() const {
        return reinterpret_cast<const char*>(s.v.grid.tiles) + std::size_t(b) * nodes * 2 * sizeof(Row<Real>);
    }
    /// Into the L2 cache.
    __device__ void prefetch_tile() const {
        for (unsigned k = 128 * unsigned(lane_id()); k < nodes * 2 * sizeof(Row<Real>); k += 128 * 32)
            asm volatile("prefetch.global.L2 [%0];" ::"l"(tile_begin() + k));
    }

    __device__ void find() {
        const int code = lane_id();
        std::uint32_t n = 0;
        std::size_t at = 0;
        const int source = code < Block<3>::offsets && code != Block<3>::centre
                               ? s.v.table.neighbour[std::size_t(b) * Block<3>::offsets + std::size_t(code)]
                               : -1;
        if (source >= 0) {
            const std::uint16_t* exit =
                s.exit_at + std::size_t(source) * (exits + 1) + std::size_t(Block<3>::opposite(code));
            const std::uint32_t begin = exit[0], end = exit[1];
            if (s.region[source].leaving > 0) n = end - begin, at = std::size_t(source) * s.capacity + begin;
        }
        const std::uint32_t upto = scan_inclusive(n);
        m.upto[code] = upto, m.from[code] = at - (upto - n);
        __syncwarp();
    }

    /// Rows of some who come, to the region's tail and into shared memory: a lane per row.
    __device__ void fetch(std::uint32_t first, unsigned here, std::uint32_t tail) {
        const unsigned k = unsigned(lane_id()) / core_rows<3>, r = unsigned(lane_id()) % core_rows<3>;
        if (k >= here) return;
        int code = 0;
#pragma unroll
        for (int step = 16; step > 0; step /= 2)
            if (m.upto[code + step - 1] <= first + k) code += step;
        const std::size_t from = m.from[code] + first + k, to = std::size_t(b) * s.capacity + tail + first + k;
        const Row<Real> row = load_row(s.v.p.core[r] + from);
        if (r == 0) s.home[to] = s.home[from];
        store_row(&m.row[k][r], row);
        store_row(s.v.p.core[r] + to, row);
    }

    /// One particle, at the lane's node of its stencil.
    __device__ void add(const Row<Real>* row) {
        CoreRows<Real, 3> p;
#pragma unroll
        for (int r = 0; r < core_rows<3>; ++r) p.row[r] = load_row(row + r);
        const unsigned k[3] = {unsigned(lane_id()) % 3, unsigned(lane_id()) / 3 % 3, unsigned(lane_id()) / 9};
        Real w[3], d[3];
        unsigned node = 0;
#pragma unroll
        for (int a = 2; a >= 0; --a) {
            spline_of(k[a], fraction_of<Real>(p.coordinate(a)), w[a], d[a]);
            node = node * side + unsigned(moraine::cell_of<Real>(p.coordinate(a))) + k[a];
        }
        const Real mass = w[0] * w[1] * w[2] * p.mass(), scale = -p.volume() * s.v.context.inverse_cell;
        const Real g[3] = {d[0] * w[1] * w[2] * scale, w[0] * d[1] * w[2] * scale, w[0] * w[1] * d[2] * scale};
        Row<Real> first = load_row(&m.tile[node][0]), second = load_row(&m.tile[node][1]);
        first.e[0] += mass;
#pragma unroll
        for (int c = 0; c < 3; ++c) {
            first.e[1 + c] += mass * p.velocity(c);
#pragma unroll
            for (int a = 0; a < 3; ++a) second.e[c] += p.stress(Sym<Real, 3>::index(c, a)) * g[a];
        }
        store_row(&m.tile[node][0], first), store_row(&m.tile[node][1], second);
    }

    /// Nodes that somebody touches, several loads at a time.
    __device__ void add_tile() {
        constexpr int at_once = 4;
        auto* to = reinterpret_cast<Row<Real>*>(s.v.grid.tiles) + std::size_t(b) * nodes * 2;
#pragma unroll 1
        for (int base = lane_id(); base < nodes; base += 32 * at_once) {
            Row<Real> first[at_once], second[at_once];
            bool touched[at_once];
#pragma unroll
            for (int k = 0; k < at_once; ++k) {
                const int n = base + 32 * k;
                touched[k] = n < nodes && m.tile[n][0].e[0] > Real(0);
                if (touched[k]) first[k] = load_row(to + 2 * n), second[k] = load_row(to + 2 * n + 1);
            }
#pragma unroll
            for (int k = 0; k < at_once; ++k) {
                if (!touched[k]) continue;
                const int n = base + 32 * k;
                const Row<Real> mine = load_row(&m.tile[n][0]), other = load_row(&m.tile[n][1]);
#pragma unroll
                for (int i = 0; i < quad; ++i) first[k].e[i] += mine.e[i], second[k].e[i] += other.e[i];
                store_row(to + 2 * n, first[k]), store_row(to + 2 * n + 1, second[k]);
            }
        }
    }

    const FusedStep<Real>& s;
    Scratch& m;
    int b;
};

/// The last thread block to end makes ready for the next step.
template <class Real>
__device__ __forceinline__ void conclude(const FusedStep<Real>& s) {
    if (atomicAdd(s.ticket, 1u) + 1 < gridDim.x) return;
    *s.ticket = 0;
    *s.overfulls_all += *s.overfulls;
    *s.overfulls = 0;
    ++*s.number;
}

/// A warp looks at every so-many-th block: those that somebody comes to are often neighbours.
template <class Real>
__global__ void __launch_bounds__(32 * incoming_warps<Real>) add_incoming(const __grid_constant__ FusedStep<Real> s) {
    __shared__ typename Incoming<Real>::Scratch scratch[incoming_warps<Real>];
    let_next_launch_begin();
    wait_for_launch_before();
    const int warp = int(threadIdx.x) / 32, warps = int(gridDim.x) * incoming_warps<Real>;
    const std::uint32_t number = *s.number;
    Account<3>& account = account_of(s.v);
    for (int base = int(blockIdx.x) * incoming_warps<Real> + warp; base < s.v.table.own; base += 32 * warps) {
        const int mine = base + lane_id() * warps;
        const bool in = mine < s.v.table.own;
        const BlockReport report = in ? s.report[mine] : BlockReport{0, 0, 0};
        unsigned left = __ballot_sync(all_lanes, in && s.claimed[mine] == number);
        const ExactSum work[1] = {s.g.quantum.of(report.work)};
        fold_sums(work, &account.work);
        const double signal = warp_max(report.signal), moved = warp_max(report.moved);
        if (lane_id() == 0 && signal > 0) raise(account.signal, signal), raise(account.moved, moved);
        for (; left != 0; left &= left - 1)
            Incoming<Real>(s, scratch[warp], base + (__ffs(int(left)) - 1) * warps).run();
    }
    __syncthreads();
    if (threadIdx.x == 0) conclude(s);
}

}  // namespace moraine::gpu::lab
