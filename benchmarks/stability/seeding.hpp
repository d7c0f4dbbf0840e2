#pragma once
// Ways to fill a box with particles (S9): places in a table of their own, which the scene's body then reads.

#include <string>
#include <vector>

#include "core/scene_spec.hpp"

namespace moraine {

/// How a box is filled; each gives all particles the same volume, the box's over their number.
struct Filling {
    enum Kind { lattice, jittered, poisson_disk, rotated } kind;
    double amount;  ///< jittered: share of the spacing; rotated: angle [deg]
    std::string name() const;
    bool is_random() const { return kind == jittered || kind == poisson_disk; }
};

/// Points of [min, max] no two of which are nearer than `distance`, none can be added (Bridson 2007).
std::vector<std::array<double, 2>> poisson_disk(const Triple& min, const Triple& max, double distance,
                                                std::uint64_t seed);

/// Points of a square lattice of this spacing, turned about the box's middle, that are in the box.
std::vector<std::array<double, 2>> turned_lattice(const Triple& min, const Triple& max, double spacing, double degrees);

/// The scene's first body (a box, in 2-D) filled so; a table is written into `folder`.
void fill_body(Scene& scene, const Filling& filling, std::uint64_t seed, const std::string& folder);

}  // namespace moraine
