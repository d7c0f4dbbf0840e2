#pragma once
// What predict/prediction.hpp predicts of a scene of lattices (seeding/lattice_seeds.hpp), without going through its
// particles.

#include <cstdint>
#include <optional>
#include <vector>

#include "core/data/morton.hpp"
#include "core/scene_spec.hpp"

namespace moraine {

struct LatticePrediction {
    std::int64_t particles = 0;
    double mass = 0;            ///< [kg]
    std::vector<double> speed;  ///< largest at the start, by body [m/s]
    std::vector<Key> occupied;  ///< blocks, in key order
};

/// For a scene that is_lattice(). Not collective.
LatticePrediction predict_lattice(const Scene& scene);

/// The first particle of a body on a lattice that is inside of a box; none: it has none there. Not collective.
std::optional<Triple> first_inside(const Scene& scene, const BodySpec& body, const BodySpec& box);

}  // namespace moraine
