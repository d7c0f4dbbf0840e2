#pragma once
// What a run will need, said before it starts: particles, blocks, dt, steps, memory.
//
// Particles and blocks are exact at the start. dt is cfl h / (c + |v|) with the elastic wave speed
// c = sqrt(M / density) and the speeds of the start; a flow that speeds up takes more steps.

#include <cstdint>
#include <string>
#include <vector>

#include "core/data/morton.hpp"
#include "core/scene_spec.hpp"

namespace moraine {

/// sqrt(M / density) of the body's material at the start, where its stress is largest [m/s].
double wave_speed(const Scene& scene, const BodySpec& body);

double norm(const Triple& v);

struct Prediction {
    std::int64_t particles = 0;
    std::int64_t blocks = 0;        ///< occupied at the start
    std::int64_t epoch_blocks = 0;  ///< these and their neighbours
    std::int64_t node_blocks = 0;   ///< with nodes of these
    double mass = 0;                ///< [kg]
    double cells = 0;               ///< full ones that the bodies fill
    double dt = 0;                  ///< [s]
    double steps = 0;
    int substeps = 1;           ///< of a step, of the start (core/fluid/grid_pressure.hpp)
    double steps_without = 0;   ///< substeps
    double max_speed = 0;       ///< at the start [m/s]
    double max_wave_speed = 0;  ///< [m/s]
};

/// Not collective. Throws InputError if a table of particles is bad.
Prediction predict(const Scene& scene);

/// Of one of `ranks` ranks, above an empty run [B]. With R bytes per real and d dimensions:
///   particle: position, velocity d R each; stress (4 or 6) R; volume, mass, ln J R each; id 8; body 2;
///             lists 10; one column while it is written 8 d, a whole output if that is asynchronous; each scalar of the
///             laws R; APIC and TPIC d^2 R; b (4 or 6) R; stretch of GIMP d R; sleep 16, its forecast 48
///   block:    tile (4 + w - 1)^d 8 R; w: width of the stencil. Nodes 4^d 8 R, also of one more layer
///             of blocks, and tables, of two more, as if the body were a cube
///   maps:     hazard maps of what lies at the start, 240 a column
double bytes_per_rank(const Scene& scene, const Prediction& prediction, int ranks);

/// Of hazard maps that reach all of the domain, over all ranks [B].
double map_bytes_at_most(const Scene& scene);

/// Of the GPU of one of `ranks` ranks, beside the driver's own share (0.5 GB on an H200) [B]. It goes through the
/// arrays of gpu/memory/particles.hpp, gpu/kernels/binning/lists.hpp, gpu/memory/device_tables.hpp and gpu/engine.hpp,
/// and with several ranks through the boxes of the transports; a test holds it to what was measured.
double bytes_on_device(const Scene& scene, const Prediction& p, int ranks = 1);

/// Of the host, for one of `ranks` ranks that compute on GPUs [B]: 1 GB allowed for CUDA, MPI and the transports;
/// blocks, which every rank knows, and the tables of its own ones, twice while a next epoch is made; a piece of the
/// particles; where `writes_particles`, one column of them for particles.vtkhdf. Scenes that are not is_lattice() are
/// seeded on the host: there all particles are in its memory at the start. Checkpoints need a column too, and are not
/// counted.
double host_bytes_with_device(const Scene& scene, const Prediction& prediction, int ranks, bool writes_particles);

/// What particles.vtkhdf or cells.vtkhdf will hold.
struct OutputPrediction {
    double row_bytes = 0;  ///< of a particle or a cell in an output
    double rows = 0;       ///< in an output: particles, about a share of output.every, or about the cells at the start
    double outputs = 0;    ///< with those of the start and the end
    double steps = 0;      ///< between two
};

/// Not collective. Once in a file there are also the numbers of its vertices, 8 bytes a row.
OutputPrediction predict_output(const Scene& scene, const Prediction& prediction);

/// The numbers of blocks, from the keys of the occupied ones in order. Not collective.
void count_blocks(const Scene& scene, const std::vector<Key>& occupied, Prediction& p);

}  // namespace moraine
