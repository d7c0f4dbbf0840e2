#pragma once
// A table of particles: .csv with a header line, or .h5 with one dataset for each column.
//
// Columns x, y, z [m] (as many as the scene has dimensions), optional vx, vy, vz [m/s] and mass [kg].

#include <cstdint>
#include <string>
#include <vector>

#include "core/scene_spec.hpp"

namespace moraine {

struct ParticleTable {
    std::vector<Triple> x;
    std::vector<Triple> velocity;  ///< zero where the table has none
    std::vector<double> mass;      ///< empty: from density and particles_per_cell
};

/// Throws InputError with file and line (csv) or dataset (h5); also for a particle outside the domain. Throws
/// RankFailure where the file is no more the one that the scene was read with. Not collective: every rank that calls it
/// reads the whole file.
ParticleTable read_particle_table(const Scene& scene, const BodySpec& body);

/// Of the bytes of a file; 0 where there is none that can be read.
std::uint64_t hash_of_file(const std::string& path);

/// Path of a file that a scene names: relative to the scene's folder.
std::string path_of_file(const Scene& scene, const std::string& file);

}  // namespace moraine
