#pragma once
// Whether a scene fits before anything is allocated: a run that ends for want of memory after an hour in a queue, or
// drives a machine into the ground, could have been refused at once.
//
// Particles are estimated from volumes (boxes and tables: exactly), in no time whatever their number. A rank numbers
// its particles with 31 bits, and an id has 48 bits for the place in its body.

#include <string>

#include "predict/prediction.hpp"

namespace moraine {

/// Where a scene is to run.
struct Machine {
    int ranks = 1;                 ///< of the run
    int ranks_here = 1;            ///< of them on this host
    double memory = 0;             ///< of this host [B]; 0: not known, and not checked
    bool devices = false;          ///< its ranks compute on GPUs: what counts is the memory of the host beside them
    bool writes_particles = true;  ///< particles.vtkhdf
};

/// The least memory that the control group of this process, or one above it, allows [B]; 0: not limited. A job's limit
/// stands in a nested group (Slurm, systemd). `membership`: /proc/self/cgroup; `mount`: /sys/fs/cgroup. Not collective.
double control_group_memory(const std::string& membership, const std::string& mount);

/// Memory of this host, or what its control group allows [B]; 0: not known. For tests the environment variable
/// MORAINE_PRETEND_MEMORY says it. Not collective.
double host_memory();

/// As predict(), without going through the particles: their number, blocks and nothing else. Not collective.
Prediction estimate(const Scene& scene);

/// Particles that a rank of the host has memory for, if its host's ranks share that evenly and blocks are as full as at
/// the start (inflows: as if all had come); as many as it can number where the memory is not known or nothing ever
/// comes. Not collective.
std::int64_t particles_in_memory(const Scene& scene, const Machine& machine);

/// Throws InputError, with what would do, if the scene is too large. Not collective.
void check_capacity(const Scene& scene, const Machine& machine);

}  // namespace moraine
