#include "simulation/supply.hpp"

#include <algorithm>

namespace moraine {

Supply::Supply(const Scene& scene) {
    for (std::size_t b = 0; b < scene.bodies.size(); ++b)
        if (comes_later(scene.bodies[b])) sources_.push_back({BodySeeds(scene, static_cast<int>(b)), 0});
    find_next();
}

void Supply::skip_to(double time) {
    for (Source& s : sources_)
        while (s.row < s.seeds.rows() && s.seeds.time_of(s.row) <= time) ++s.row;
    find_next();
}

void Supply::find_next() {
    next_ = never;
    for (const Source& s : sources_)
        if (s.row < s.seeds.rows()) next_ = std::min(next_, s.seeds.time_of(s.row));
}

}  // namespace moraine
