#include "balance/time_model.hpp"

#include <algorithm>
#include <cmath>

namespace moraine {

double TimeModel::slowest(std::span<const std::int64_t> particles, std::span<const std::int64_t> blocks) const {
    double most = 0;
    for (std::size_t r = 0; r < particles.size(); ++r) {
        const auto n = static_cast<double>(particles[r]);
        most = std::max(most, computing(n, static_cast<double>(blocks[r])) + exchange * n);
    }
    return most;
}

double TimeModel::sending(const HaloForecast& halo, int ranks) const {
    if (ranks == 1) return 0;
    return rounds * (wire.latency * halo.neighbours_max + static_cast<double>(halo.busiest_bytes) / wire.bandwidth) +
           wire.latency * std::log2(ranks);
}

void ModelFit::add(std::span<const Sample> ranks, double steps, double sending, double look) {
    const Sample* heaviest = nullptr;
    for (const Sample& s : ranks) {
        nn_ += steps * s.particles * s.particles;
        nb_ += steps * s.particles * s.blocks;
        bb_ += steps * s.blocks * s.blocks;
        nt_ += steps * s.particles * s.computing;
        bt_ += steps * s.blocks * s.computing;
        if (!heaviest || s.particles > heaviest->particles) heaviest = &s;
    }
    if (!heaviest) return;
    heaviest_particles_ += steps * heaviest->particles;
    heaviest_blocks_ += steps * heaviest->blocks;
    stepping_ += steps * (heaviest->step - sending);
    looks_.push_back(look);
}

TimeModel ModelFit::model(const CostModel& prior) const {
    TimeModel m;
    // The prior's ratio, scaled to fit; then the fit with a pull towards it.
    const auto a = static_cast<double>(prior.a), d = static_cast<double>(prior.d);
    const double modelled = a * a * nn_ + 2 * a * d * nb_ + d * d * bb_;
    const double scale = modelled > 0 ? (a * nt_ + d * bt_) / modelled : 0;
    constexpr double pull = 0.01;
    const double nn = nn_ * (1 + pull), bb = bb_ * (1 + pull);
    const double nt = nt_ + pull * nn_ * scale * a, bt = bt_ + pull * bb_ * scale * d;
    const double determinant = nn * bb - nb_ * nb_;
    if (determinant > 0) {
        m.particle = (nt * bb - bt * nb_) / determinant;
        m.block = (nn * bt - nb_ * nt) / determinant;
    }
    if (m.particle <= 0 || m.block < 0) m.particle = scale * a, m.block = scale * d;
    if (heaviest_particles_ > 0)
        m.exchange =
            std::max(0.0, stepping_ - m.computing(heaviest_particles_, heaviest_blocks_)) / heaviest_particles_;
    std::vector<double> looks = looks_;
    if (looks.empty()) return m;
    std::nth_element(looks.begin(), looks.begin() + static_cast<std::ptrdiff_t>(looks.size() / 2), looks.end());
    m.look = looks[looks.size() / 2];  // the median: those with a migration are few
    return m;
}

}  // namespace moraine
