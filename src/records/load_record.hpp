#pragma once
// block_loads.bin in terms of the simulation: where the run stands at each balance interval, for `moraine replay`
// and `moraine report`. Exists only where the scene has output.block_loads.

#include <algorithm>

#include "comm/halo.hpp"
#include "core/sleep/scene_sleep.hpp"
#include "io/block_loads.hpp"
#include "records/sleep_forecast.hpp"
#include "simulation/simulation.hpp"

namespace moraine {

inline SleepersRecord sleepers_recorded(const Scene& scene) {
    if (scene.sleep.on) return SleepersRecord::asleep;
    return forecasts_sleep(scene) ? SleepersRecord::would : SleepersRecord::none;
}

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
    h.node_bytes = (node_sums<Dim> + lanes_besides<Dim>(sim.method())) * static_cast<int>(sizeof(Real));
    h.rounds = static_cast<std::int32_t>(sim.method().rounds.size());
    h.interval = scene.balance.interval;
    h.axis = scene.balance.axis;
    h.trigger = static_cast<std::int32_t>(scene.balance.trigger);
    h.weighs_cost = scene.balance.weight == "cost" ? 1 : 0;
    h.threshold = scene.balance.threshold;
    const bool on_host = sim.engine().device().name == "cpu";
    if (on_host) h.sleepers = static_cast<std::int32_t>(sleepers_recorded(scene));
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
        : sim_(sim), comm_(comm), header_(load_header(sim)), writer_(comm, path, header_, resume_step) {
        if (header_.sleepers == static_cast<std::int32_t>(SleepersRecord::would))
            forecast_ = std::make_unique<SleepForecast<Real, Dim>>(sim.scene(), comm);
    }

    /// Files the particles, and writes who holds which block. Collective.
    void write() {
        LoadFrame frame;
        frame.step = sim_.clock().step;
        frame.time = sim_.clock().time;
        const std::vector<BlockLoad> loads = sim_.block_loads();
        const std::vector<Key> asleep = sleepers();
        for (const BlockLoad& load : loads)
            frame.rows.push_back({load.key, static_cast<std::uint32_t>(load.particles) & 0x7fffffffu,
                                  std::binary_search(asleep.begin(), asleep.end(), load.key) ? 1u : 0u, load.owner});
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
    /// Keys of the blocks that sleep or would, ascending; the same on all ranks. Binned state. Collective.
    std::vector<Key> sleepers() {
        if (forecast_) return forecast_->look(sim_);
        if (header_.sleepers == 0) return {};
        const BlockCounts mine = sim_.block_counts();
        std::vector<Key> asleep;
        for (std::size_t b = 0; b < mine.asleep.size(); ++b)
            if (mine.asleep[b] != 0) asleep.push_back(mine.key[b]);
        asleep = comm_.all_gather(asleep);
        std::sort(asleep.begin(), asleep.end());
        return asleep;
    }

    Simulation<Real, Dim>& sim_;
    const Comm& comm_;
    LoadHeader header_;
    std::unique_ptr<SleepForecast<Real, Dim>> forecast_;  ///< of a run in which all are awake
    BlockLoadWriter writer_;
    std::array<double, Phases::count> reported_{};  ///< seconds, as of the last frame
    double lost_ = 0;                               ///< the same
    std::int64_t exchanges_ = 0;                    ///< the same
};

}  // namespace moraine
