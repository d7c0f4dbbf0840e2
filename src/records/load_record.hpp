#pragma once
// block_loads.bin in terms of the simulation: where the run stands at each balance interval, for `moraine replay`
// and `moraine report`. Exists only where the scene says output.block_loads = "on".

#include "io/block_loads.hpp"
#include "simulation/simulation.hpp"

namespace moraine {

/// What a replay must know of the run besides its loads. Not collective.
template <class Real, int Dim>
LoadHeader load_header(const Simulation<Real, Dim>& sim) {
    const Scene& scene = sim.scene();
    const Layout layout = layout_of(DomainBlocks<Dim>(scene), sim.method().stencil.width);
    LoadHeader h;
    h.dimensions = Dim;
    h.width = layout.width;
    h.blocks = layout.blocks;
    std::copy(layout.periodic.begin(), layout.periodic.end(), h.periodic.begin());
    const bool has_mean = sim.method().fluid() || sim.method().grid_bulk();
    h.node_bytes = static_cast<std::int32_t>((node_sums<Dim> + (has_mean ? 1 : 0)) * sizeof(Real));
    h.rounds = static_cast<std::int32_t>(sim.method().rounds.size());
    h.interval = scene.balance.interval;
    h.axis = scene.balance.axis;
    h.trigger = static_cast<std::int32_t>(scene.balance.trigger);
    h.weighs_cost = scene.balance.weight == "cost" ? 1 : 0;
    h.threshold = scene.balance.threshold;
    const bool on_host = sim.engine().device() == "cpu";
    const CostModel& costs = on_host ? host_costs : device_costs;
    const MoveModel& moves = on_host ? host_moves : device_moves;
    h.model = {costs.a, costs.d};
    h.moves = {moves.start, moves.particle};
    for (std::size_t a = 0; a < Dim; ++a) h.corner[a] = scene.min[a] - scene.cell * sim.method().stencil.offset();
    h.block_side = 4 * scene.cell;
    scene.balance.partitioner.copy(h.partitioner.data(), h.partitioner.size() - 1);
    return h;
}

template <class Real, int Dim>
class LoadRecord {
  public:
    /// With `resume_step` it goes on behind the frame of that step. Collective.
    LoadRecord(Simulation<Real, Dim>& sim, const Comm& comm, const std::string& path,
               std::optional<std::int64_t> resume_step)
        : sim_(sim), comm_(comm), writer_(comm, path, load_header(sim), resume_step) {}

    /// Files the particles, and writes who holds which block. Collective.
    void write() {
        LoadFrame frame;
        frame.step = sim_.clock().step;
        frame.time = sim_.clock().time;
        for (const BlockLoad& load : sim_.block_loads())
            frame.rows.push_back({load.key, static_cast<std::uint32_t>(load.particles), load.owner});
        RankSeconds mine{};
        for (std::size_t k = 0; k < Phases::count; ++k)
            mine[k] = static_cast<float>(sim_.phases().all()[k] - reported_[k]);
        reported_ = sim_.phases().all();
        frame.lost = sim_.counts().seconds_lost - lost_;
        lost_ = sim_.counts().seconds_lost;
        frame.exchanges = sim_.counts().exchanges - exchanges_;
        exchanges_ = sim_.counts().exchanges;
        frame.seconds = comm_.all_gather(std::vector<RankSeconds>{mine});
        writer_.write(frame);
    }

  private:
    Simulation<Real, Dim>& sim_;
    const Comm& comm_;
    BlockLoadWriter writer_;
    std::array<double, Phases::count> reported_{};  ///< seconds, as of the last frame
    double lost_ = 0;                               ///< the same
    std::int64_t exchanges_ = 0;                    ///< the same
};

}  // namespace moraine
