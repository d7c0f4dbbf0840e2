#include "simulation/supply.hpp"

#include <algorithm>
#include <utility>

namespace moraine {

Supply::Supply(const Scene& scene) {
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
        if (!comes_later(scene.bodies[b])) continue;
        const int stage = scene.bodies[b].stage;
        BodySeeds seeds(scene, static_cast<int>(b));
        const std::int64_t total = stage > 0 ? seeds.count(0, seeds.rows()) : 0;
        sources_.push_back({std::move(seeds), stage, total, 0});
    }
    find_next();
}

void Supply::skip_to(double time) {
    for (Source& s : sources_)
        while (s.row < s.seeds.rows() && time_of(s) <= time) ++s.row;
    find_next();
}

void Supply::begin_stage(int stage) {
    for (Source& s : sources_)
        if (s.stage == stage) s.stage = 0;
    find_next();
}

void Supply::find_next() {
    next_ = never;
    for (const Source& s : sources_)
        if (s.row < s.seeds.rows()) next_ = std::min(next_, time_of(s));
}

}  // namespace moraine
