#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "core/structures/particle_depth.hpp"
#include "gpu/device_sample.cuh"
#include "gpu/kernels/gaps/gaps.hpp"
#include "gpu/kernels/nodes/device_structures.hpp"
#include "gpu/kernels/nodes/near_blocks.hpp"
#include "gpu/kernels/nodes/nodes.hpp"
#include "gpu/kernels/programs.hpp"

namespace moraine::test {

/// The sample with its tiles summed by the host, and a copy on the device; both solve the same nodes.
template <class Real, int Dim>
class NodePair {
  public:
    Sample<Real, Dim> sample;
    DeviceSample<Real, Dim> device;
    const Quantum quantum = Quantum::for_largest(1e4);
    int own;  ///< blocks from here on pass for another rank's
    bool marking = false;
    Real light_mass = 0;  ///< below which nodes are marked [kg]
    gpu::Array<std::uint8_t> marks;
    gpu::Array<std::uint32_t> counts_of_marked;

    NodePair(const Scene& scene, int particles)
        : sample(scene, particles, 31), device(sample), own(sample.patch.own()) {
        sample.method.kernels.p2g(sample.call(), sample.method.cell);
        const std::size_t reals = static_cast<std::size_t>(sample.patch.tiles_in_use()) *
                                  power<Dim>(tile_side(sample.method.stencil.width)) * node_reals;
        gpu::check(
            cudaMemcpy(device.view.grid.tiles, sample.patch.grid().tiles, reals * sizeof(Real), cudaMemcpyHostToDevice),
            "Copying tiles");
    }

    std::vector<StructureSums<Dim>> felt_on_host, felt_on_device;

    /// The gaps by the loop of the host, and by the device's kernel.
    ContactPairs<Dim> pairs;
    std::vector<NodeGap> gaps;
    gpu::DeviceGaps<Dim> device_gaps;

    void find_gaps(const StructureSet<Dim>& structures) {
        const ContactField<Dim> field = structures.field();
        pairs.make(sample.patch.tables(), field, false);
        const int width = sample.method.stencil.width;
        gaps.assign(pairs.tiles() * static_cast<std::size_t>(power<Dim>(tile_side(width))), NodeGap{});
        sample.method.kernels.gaps(sample.call(), {field, gaps.data(), pairs.interior().data(),
                                                   static_cast<std::int64_t>(pairs.interior().size())});
        gpu::DeviceStructures<Dim> there;
        device_gaps.forget();
        device_gaps.make(sample.patch.tables(), field, false, width, nullptr);
        gpu::check(cudaMemset(device_gaps.tiles(), 0, gaps.size() * sizeof(NodeGap)), "Emptying gaps");
        gpu::find_gaps(device.view, sample.scene.shape, there.place(structures, nullptr), device_gaps,
                       device_gaps.interior(), nullptr);
        gpu::check(cudaDeviceSynchronize(), "Finding gaps");
    }

    /// Largest difference of what the tiles of occupied blocks say: of gaps [cells] and areas [faces].
    double difference_of_gaps() {
        std::vector<NodeGap> found(gaps.size());
        gpu::check(cudaMemcpy(found.data(), device_gaps.tiles(), gaps.size() * sizeof(NodeGap), cudaMemcpyDeviceToHost),
                   "Copying gaps");
        const auto nodes = static_cast<std::size_t>(power<Dim>(tile_side(sample.method.stencil.width)));
        double worst = 0;
        for (const ContactPair& pair : pairs.interior()) {
            if (sample.patch.tile_of()[pair.block] < 0) continue;
            for (std::size_t n = static_cast<std::size_t>(pair.tile) * nodes, end = n + nodes; n < end; ++n) {
                widen(worst, std::fabs(found[n].cells() - gaps[n].cells()));
                widen(worst, std::fabs(found[n].faces() - gaps[n].faces()));
            }
        }
        return worst;
    }

    /// Brings back who is too deep, on both: largest difference of the places [cells], and how many moved.
    std::pair<double, int> limit_depths(const StructureSet<Dim>& structures) {
        const ParticleView<Real, Dim> p = sample.patch.particles.view();
        const std::vector<Vec<Coordinate<Real>, Dim>> before(p.position, p.position + sample.patch.particles.size());
        const auto count = static_cast<int>(pairs.interior().size());
        const LimitDepth<Real, Dim> limit{p.position,
                                          sample.method.ends,
                                          sample.patch.table(),
                                          sample.patch.list(),
                                          structures.field(),
                                          pairs.interior().data(),
                                          count};
        for (int k = 0; k < count; ++k) limit(k);
        gpu::DeviceStructures<Dim> there;
        gpu::limit_depths(device.view, sample.method.ends, there.place(structures, nullptr), device_gaps,
                          device_gaps.interior(), nullptr);
        gpu::check(cudaDeviceSynchronize(), "Limiting depths");
        double worst = 0;
        int moved = 0;
        for (std::uint32_t s = 0; s < before.size(); ++s) {
            const gpu::CoreRows<Real, Dim> found = device.particle(s);
            bool here = false;
            for (int a = 0; a < Dim; ++a) {
                here = here || p.position[s][a] != before[s][a];
                widen(worst, std::fabs(local_of<Real>(0, found.coordinate(a)) - local_of<Real>(0, p.position[s][a])));
            }
            moved += here;
        }
        return {worst, moved};
    }

    template <bool Contact = false>
    std::array<ExactSum, Dim> on_host(const NodeRound<Real, Dim>& round, ContactField<Dim> contact = {}) {
        felt_on_host.assign(static_cast<std::size_t>(contact.count), {});
        contact.sums = felt_on_host.data();
        const auto chosen = sample.patch.node_blocks();
        std::vector<ExactSum> impulse(chosen.size() * Dim);
        BlockTable<Dim> table = sample.patch.table();
        table.own = own;
        const SolveNodes<Real, Dim, Contact> kernel{sample.method.context.walls,
                                                    table,
                                                    sample.patch.grid(),
                                                    chosen.data(),
                                                    sample.method.stencil.width,
                                                    sample.method.stencil.origin,
                                                    round,
                                                    quantum,
                                                    impulse.data(),
                                                    contact,
                                                    {pairs.structures(), pairs.tile_of().data(), gaps.data()}};
        Host::launch_teams(static_cast<std::int64_t>(chosen.size()), kernel);
        std::array<ExactSum, Dim> all{};
        for (std::size_t k = 0; k < impulse.size(); ++k) all[k % Dim].add(impulse[k]);
        return all;
    }

    std::array<ExactSum, Dim> on_device(const NodeRound<Real, Dim>& round,
                                        const StructureSet<Dim>* structures = nullptr) {
        device.clear_accounts();
        device.view.table.own = own;
        gpu::DeviceStructures<Dim> there;
        gpu::DeviceNearBlocks<Dim> near;
        gpu::NodeContact<Dim> contact{};
        if (structures) {
            contact = {there.place(*structures, nullptr), device_gaps.view(), {}};
            contact.near = near.find(device.view.table, contact.field, sample.method.stencil.origin, false, nullptr);
        }
        gpu::LightMarks<Real> light{};
        if (marking) {
            marks.resize(static_cast<std::size_t>(sample.patch.table().node_blocks * gpu::light_marks<Dim>));
            counts_of_marked.assign(std::vector<std::uint32_t>(gpu::light_counts, 7));
            light = {marks.data(), light_mass, counts_of_marked.data()};
        }
        KernelKey key = gpu::device_kernel_key<Real, Dim>(sample.scene);
        key.structures = structures != nullptr;
        gpu::Nodes<Real, Dim>(key).solve(device.view, sample.method.stencil, round, quantum, light, nullptr,
                                         structures ? &contact : nullptr);
        if (structures) there.fetch(nullptr);
        gpu::check(cudaDeviceSynchronize(), "Solving nodes");
        std::vector<TurningSums<Dim>> none_turns;
        there.take(felt_on_device, none_turns);
        std::array<ExactSum, Dim> all{};
        for (const gpu::Account<Dim>& a : device.accounts())
            for (std::size_t i = 0; i < Dim; ++i) all[i].add(a.impulse[i]);
        return all;
    }

    bool needed(int c) {
        const BlockTable<Dim> table = sample.patch.table();
        for (int delta = 0; delta < Block<Dim>::corners; ++delta) {
            const std::int32_t source = table.source[c * Block<Dim>::corners + delta];
            if (source >= 0 && source < own && sample.patch.tile_of()[source] >= 0) return true;
        }
        return false;
    }

    /// Largest difference of a node's values; node blocks that nobody needs must not have been touched.
    double difference() {
        const std::vector<Quad<Real>> found = device.nodes();
        const TileView<Real> grid = sample.patch.grid();
        constexpr std::size_t reals = Block<Dim>::cells * node_reals;
        double worst = 0;
        for (int c = 0; c < sample.patch.table().node_blocks; ++c) {
            const auto* got = reinterpret_cast<const Real*>(found.data()) + static_cast<std::size_t>(c) * reals;
            if (!needed(c)) {
                const auto* bytes = reinterpret_cast<const unsigned char*>(got);
                REQUIRE(std::all_of(bytes, bytes + reals * sizeof(Real), [](unsigned char x) { return x == 0xff; }));
                continue;
            }
            const Real* expected = grid.nodes + static_cast<std::size_t>(grid.node_of[c]) * reals;
            for (std::size_t k = 0; k < reals; ++k) {
                const bool mass = k % node_reals == quad - 1;  // left for the gather where light nodes are marked
                widen(worst, std::fabs(double(got[k]) - (mass && !marking ? 0.0 : double(expected[k]))));
            }
        }
        return worst;
    }

    /// Whether the marks are those of the host's masses.
    bool marks_are_right() {
        const std::vector<std::uint8_t> found = marks.host();
        const TileView<Real> grid = sample.patch.grid();
        constexpr int nodes = Block<Dim>::cells / gpu::light_marks<Dim>;
        bool right = counts_of_marked.host() == std::vector<std::uint32_t>(gpu::light_counts, 0);
        for (int m = 0; m < sample.patch.table().node_blocks * gpu::light_marks<Dim>; ++m) {
            const int c = m / gpu::light_marks<Dim>;
            if (!needed(c)) continue;
            const Real* from = grid.nodes + (static_cast<std::size_t>(grid.node_of[c]) * Block<Dim>::cells +
                                             static_cast<std::size_t>(m % gpu::light_marks<Dim> * nodes)) *
                                                node_reals;
            bool light = false;
            for (int n = 0; n < nodes; ++n) light = light || from[n * node_reals + quad - 1] < light_mass;
            right = right && (found[static_cast<std::size_t>(m)] != 0) == light;
        }
        return right;
    }
};

}  // namespace moraine::test
