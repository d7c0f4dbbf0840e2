#pragma once
// One scene on the device and the step in kernels; which P2G and G2P is chosen by name.

#include <cstring>
#include <string>

#include "filing.cuh"
#include "g2p.cuh"
#include "nodes.cuh"
#include "p2g_losers.cuh"
#include "p2g_resident.cuh"
#include "p2g_slices.cuh"
#include "refresh.cuh"
#include "scene.cuh"

namespace lab {

template <class Real>
struct P2gVariant {
    const char* name;
    void (*run)(const View<Real>&, const Extra<Real>&);
    bool sums;  ///< writes node sums, not tiles
};
template <class Real>
struct G2pVariant {
    const char* name;
    void (*run)(const View<Real>&);
};

template <class Kernel>
void allow_shared(Kernel kernel, int bytes) {
    check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, bytes),
          "shared memory of a kernel");
}

template <class Real, int Stages, int Roles, int MinBlocks>
void run_staged(const View<Real>& v, const Extra<Real>&) {
    constexpr int bytes = staged_bytes<Real, Stages>();
    static const bool once = (allow_shared(p2g_staged<Real, Stages, Roles, MinBlocks>, bytes), true);
    (void)once;
    p2g_staged<Real, Stages, Roles, MinBlocks><<<v.blocks, 192 * Roles, bytes>>>(v);
}
template <class Real, int MinBlocks>
void run_direct(const View<Real>& v, const Extra<Real>&) {
    constexpr int bytes = all_planes_bytes<Real> + 7 * tile_nodes * int(sizeof(Real));
    static const bool once = (allow_shared(p2g_direct<Real, MinBlocks>, bytes), true);
    (void)once;
    p2g_direct<Real, MinBlocks><<<v.blocks, 192, bytes>>>(v);
}
template <class Real, int Threads, int MinBlocks, bool Narrow>
void run_g2p(const View<Real>& v) {
    g2p<Real, Threads, MinBlocks, Narrow><<<v.blocks, Threads>>>(v);
}
template <class Real, int Threads, int MinBlocks, bool Narrow>
void run_ahead(const View<Real>& v) {
    constexpr int bytes = 2 * Threads * 16 * int(sizeof(Real));
    static const bool once = (allow_shared(g2p_ahead<Real, Threads, MinBlocks, Narrow>, bytes), true);
    (void)once;
    g2p_ahead<Real, Threads, MinBlocks, Narrow><<<v.blocks, Threads, bytes>>>(v);
}
template <class Real, int Stages, int MinBlocks>
void run_passes(const View<Real>& v, const Extra<Real>&) {
    constexpr int bytes = passes_bytes<Real, Stages>();
    static const bool once = (allow_shared(p2g_passes<Real, Stages, MinBlocks>, bytes), true);
    (void)once;
    p2g_passes<Real, Stages, MinBlocks><<<v.blocks, 192, bytes>>>(v);
}
template <class Real, int Stages, int Passes, int MinBlocks>
void run_resident(const View<Real>& v, const Extra<Real>&) {
    constexpr int bytes = resident_bytes<Real, Stages>();
    const auto kernel = p2g_resident<Real, Stages, Passes, MinBlocks>;
    static const int grid = [&] {
        allow_shared(kernel, bytes);
        int per = 0, processors = 0;
        check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&per, kernel, 192, bytes), "occupancy");
        check(cudaDeviceGetAttribute(&processors, cudaDevAttrMultiProcessorCount, 0), "device");
        return per * processors;
    }();
    kernel<<<std::min(grid, v.blocks), 192, bytes>>>(v);
}
template <class Real>
void run_gather_nodes(const View<Real>& v, const Extra<Real>& e) {
    gather_nodes<Real><<<(v.node_blocks + 3) / 4, 256>>>(v, e);
}
template <class Real>
void run_global_atomics(const View<Real>& v, const Extra<Real>& e) {
    check(cudaMemsetAsync(e.sums, 0, std::size_t(v.node_blocks) * cells * 8 * sizeof(Real)), "clearing sums");
    global_atomics<Real><<<v.blocks, 128>>>(v, e);
}
template <class Real, int Way>
void run_shared_tile(const View<Real>& v, const Extra<Real>& e) {
    shared_tile<Real, Way><<<v.blocks, 128>>>(v, e);
}

/// Device memory that knows its size.
template <class T>
class Device {
  public:
    Device() = default;
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;
    ~Device() { cudaFree(data_); }
    void resize(std::size_t n) {
        if (n == size_) return;
        check(cudaFree(data_), "free");
        check(cudaMalloc(&data_, n * sizeof(T)), "malloc");
        size_ = n;
    }
    void assign(const std::vector<T>& from) {
        resize(from.size());
        check(cudaMemcpy(data_, from.data(), from.size() * sizeof(T), cudaMemcpyHostToDevice), "copy in");
    }
    std::vector<T> host() const {
        std::vector<T> to(size_);
        check(cudaMemcpy(to.data(), data_, size_ * sizeof(T), cudaMemcpyDeviceToHost), "copy out");
        return to;
    }
    void poison() { check(cudaMemset(data_, 0xff, size_ * sizeof(T)), "poison"); }
    void swap(Device& o) { std::swap(data_, o.data_), std::swap(size_, o.size_); }
    T* data() const { return data_; }
    std::size_t size() const { return size_; }

  private:
    T* data_ = nullptr;
    std::size_t size_ = 0;
};

/// Sum over particles of a strong hash of (id, row, word): equal for equal states in whatever order.
template <class Real>
__global__ void hash_state(View<Real> v, std::uint32_t n, unsigned long long* sum) {
    const std::uint32_t s = blockIdx.x * 256 + threadIdx.x;
    if (s >= n) return;
    const auto mix = [](std::uint64_t x) {
        x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
        x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
        return x ^ (x >> 31);
    };
    std::uint64_t h = mix(v.p.id[s] + 1);
    const void* rows[4] = {v.p.place + s, v.p.motion + s, v.p.normal + s, v.p.shear + s};
    for (int r = 0; r < 4; ++r)
        for (int i = 0; i < int(sizeof(Real)); ++i)
            h = mix(h + 0x9e3779b97f4a7c15ull + reinterpret_cast<const std::uint32_t*>(rows[r])[i]);
    atomicAdd(sum, (unsigned long long)h);
}

template <class Real>
class Stepper {
  public:
    void init(const SceneSpec& spec);

    /// New lists from the moves of the last step.
    void file() {
        const int grid = (v.blocks + filing_warps - 1) / filing_warps, threads = 32 * filing_warps;
        collect_leavers<<<grid, threads>>>(v, f);
        count_next<<<grid, threads>>>(v, f);
        scan_counts<<<1, 1024>>>(v.blocks, f.next_count, f.next_first);
        fill_next<<<grid, threads>>>(v, f);
        first_.swap(next_first_), cell_first_.swap(next_cell_first_), slot_.swap(next_slot_);
        point();
    }
    void p2g(const P2gVariant<Real>& variant) { variant.run(v, extra); }
    void nodes() { solve_nodes<<<(v.node_blocks + 3) / 4, 256>>>(v); }
    void g2p(const G2pVariant<Real>& variant) { variant.run(v); }
    void refresh() {
        permute_column(place_, spare_place_), permute_column(motion_, spare_row_);
        permute_column(normal_, spare_row_), permute_column(shear_, spare_row_);
        permute_column(id_, spare_id_), permute_column(body_, spare_body_);
        count_up<<<(count + 255) / 256, 256>>>(count, slot_.data());
        point();
    }
    void step(const P2gVariant<Real>& a, const G2pVariant<Real>& b) {
        if (steps > 0) file();
        if (refresh_every > 0 && steps > 0 && steps % refresh_every == 0) refresh();
        p2g(a), nodes(), g2p(b);
        ++steps;
    }
    std::uint64_t hash();
    std::size_t bytes() const;

    View<Real> v{.law = law_of<Real>()};
    Filing f{};
    Extra<Real> extra{};
    Topology topology;
    SceneSpec scene{};
    std::uint32_t count = 0;
    int steps = 0, refresh_every = 0;
    int ahead = 0;  ///< of the view
    Device<Place<Real>> place_, spare_place_;
    Device<Row<Real>> motion_, normal_, shear_, spare_row_;
    Device<std::uint64_t> id_, spare_id_;
    Device<Quad<Real>> tiles_, nodes_, sums_;
    Device<Outcome> outcome_;

  private:
    template <class T>
    void permute_column(Device<T>& column, Device<T>& spare) {
        permute<<<(count + 255) / 256, 256>>>(count, slot_.data(), column.data(), spare.data());
        column.swap(spare);
    }
    void point() {
        v.first = first_.data(), v.cell_first = cell_first_.data(), v.slot = slot_.data();
        f.next_first = next_first_.data(), f.next_cell_first = next_cell_first_.data(), f.next_slot = next_slot_.data();
        v.p = {place_.data(), motion_.data(), normal_.data(), shear_.data(), id_.data(), body_.data()};
    }

    Device<std::uint16_t> body_, spare_body_, moves_;
    Device<std::int32_t> neighbour_, node_block_, source_;
    Device<Vec<std::int32_t, 3>> position_;
    Device<std::uint8_t> border_, leaver_cell_;
    Device<std::uint32_t> first_, next_first_, cell_first_, next_cell_first_, slot_, next_slot_;
    Device<std::uint32_t> leaver_slot_, leaver_first_, next_count_, changed_;
    Device<double> dt_;
};

template <class Real>
void Stepper<Real>::init(const SceneSpec& spec) {
    scene = spec;
    topology = make_topology(spec);
    count = topology.first.back(), steps = 0;
    const auto n = std::size_t(topology.blocks), m = topology.position.size(), k = std::size_t(count);
    neighbour_.assign(topology.neighbour), node_block_.assign(topology.node_block), source_.assign(topology.source);
    position_.assign(topology.position), border_.assign(topology.border), first_.assign(topology.first);
    next_first_.resize(n + 1), cell_first_.resize(n * bounds), next_cell_first_.resize(n * bounds);
    slot_.resize(k), next_slot_.resize(k), moves_.resize(k), changed_.resize(k / 32 + n + 1), leaver_slot_.resize(k),
        leaver_cell_.resize(k);
    leaver_first_.resize(n * exits), next_count_.resize(n);
    place_.resize(k), spare_place_.resize(k), motion_.resize(k), normal_.resize(k), shear_.resize(k),
        spare_row_.resize(k);
    id_.resize(k), spare_id_.resize(k), body_.resize(k), spare_body_.resize(k);
    tiles_.resize(n * tile_nodes * 2), nodes_.resize(m * cells * 2), sums_.resize(m * cells * 2), outcome_.resize(n);
    dt_.assign({SceneSpec::dt});
    tiles_.poison(), nodes_.poison(), sums_.poison(), moves_.poison(), outcome_.poison(), next_slot_.poison();
    v = View<Real>{topology.blocks,
                   int(m),
                   neighbour_.data(),
                   node_block_.data(),
                   source_.data(),
                   position_.data(),
                   border_.data(),
                   {},
                   nullptr,
                   nullptr,
                   nullptr,
                   moves_.data(),
                   changed_.data(),
                   tiles_.data(),
                   nodes_.data(),
                   outcome_.data(),
                   walls_of<Real>(spec),
                   Real(1 / SceneSpec::h),
                   Real(1 / SceneSpec::density),
                   Real(0),
                   Real(1),
                   dt_.data(),
                   {{Real(0), Real(0), Real(-9.81)}},
                   law_of<Real>(),
                   ahead,
                   false};
    f = Filing{leaver_slot_.data(), leaver_cell_.data(), leaver_first_.data(), next_count_.data()};
    const double m0 = 1000 * 1e-3;
    extra = {reinterpret_cast<Real*>(sums_.data()), {0x1p28 / m0, 0x1p28 / (m0 * 4), 0x1p28 / 16}};
    if (sizeof(Real) == 8)
        for (double& s : extra.scale) s *= 0x1p30;
    point();
    seed<<<topology.blocks, 64>>>(v, spec, cell_first_.data(), slot_.data());
    check(cudaDeviceSynchronize(), "seeding");
}

template <class Real>
std::uint64_t Stepper<Real>::hash() {
    Device<unsigned long long> sum;
    sum.assign({0});
    hash_state<<<(count + 255) / 256, 256>>>(v, count, sum.data());
    return sum.host()[0];
}

}  // namespace lab
