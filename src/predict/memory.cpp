// The memory that a scene will need (predict/prediction.hpp).

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "core/data/block.hpp"
#include "core/data/plan_samples.hpp"
#include "core/grid/shape.hpp"
#include "core/sleep/scene_sleep.hpp"
#include "core/transfer/kernel_key.hpp"
#include "core/transfer/method.hpp"
#include "engine/lead_rule.hpp"
#include "predict/prediction.hpp"
#include "seeding/lattice_seeds.hpp"

namespace moraine {

namespace {

/// What of the table of a particle's state (core/particles/particle_state.hpp) a scene keeps.
struct ParticleSize {
    int reals = 0;    ///< of a particle on the host, besides its id and body
    int widest = 0;   ///< variable [reals]
    int rows = 0;     ///< of four reals on a device
    int scalars = 0;  ///< there besides
};

template <int Dim>
ParticleSize size_of(const ColumnNeeds& needs) {
    ParticleSize size;
    bool row[row_groups][most_group_rows] = {};
    each_variable<double, Dim>([&](const auto& v) {
        if (std::is_integral_v<typename std::decay_t<decltype(v)>::Type>) return;  // id, body
        if (!v.present(needs) || v.lives == Lifetime::step) return;
        size.reals += v.components();
        size.widest = std::max(size.widest, v.components());
        size.scalars += v.places[0].lanes == 0;
        for (const RowPlace& p : v.places)
            if (p.lanes > 0 && !std::exchange(row[static_cast<int>(p.group)][p.row], true)) ++size.rows;
    });
    return size;
}

ParticleSize size_of(const Scene& scene) {
    return scene.dimensions == 2 ? size_of<2>(needs_of(scene)) : size_of<3>(needs_of(scene));
}

double real_bytes(const Scene& scene) {
    return scene.precision == Precision::single_ ? 4 : 8;
}

/// Blocks of a compact body of `blocks` with `layers` more along each axis.
double grown(const Scene& scene, double blocks, int layers) {
    return std::pow(std::pow(blocks, 1.0 / scene.dimensions) + layers, scene.dimensions);
}

double tile_bytes(const Scene& scene) {
    return std::pow(tile_side(stencil_of(scene.shape).width), scene.dimensions) * node_reals * real_bytes(scene);
}

/// Node values, and over terrain the ground at the nodes (GroundNode in core/structures/structure.hpp).
double node_block_bytes(const Scene& scene) {
    const bool ground = !scene.structures.empty() && scene.structures[0].shape == StructureShape::ground;
    return std::pow(4, scene.dimensions) *
           (node_reals * real_bytes(scene) + (ground ? 8.0 * (scene.dimensions + 3) : 0.0));
}

/// What the grid's pressure keeps of a block's cells and nodes (core/fluid/grid_pressure.hpp): geometry as factors of
/// its nodes, on the host only that of cells that are not whole is ever touched; on a device also what cells push with
/// and velocities of nodes (gpu/kernels/pressure/pressure_work.hpp).
double pressure_bytes(const Scene& scene, bool on_device) {
    if (!uses_grid_pressure(scene)) return 0;
    const int d = scene.dimensions;
    const double cells = std::pow(4, d), nodes = std::pow(3, d), state = 8, held = d + 1;
    const double water = scene.water.on ? 2 + 1.3 * (5 + 3 * d) : 0;  // of cells and nodes
    if (!on_device) return cells * (state + nodes * (d + 1) + 1.3 * held + water) * real_bytes(scene);
    const double of_tile = d * std::pow(tile_side(3), d), lists = 4 * 4 * (2 + std::pow(2, d) + cells / 32);
    return (cells * (state + 1 + nodes * d + 1.3 * (held + 5)) + of_tile) * real_bytes(scene) + lists;
}

/// Of an output that a rank holds until it is written: one that is asynchronous, or compressed (then less).
double held_output(const Scene& scene, const Prediction& p, int ranks) {
    if (!scene.output.asynchronous && !scene.output.deflate) return 0;
    const OutputPrediction o = predict_output(scene, p);
    return o.row_bytes * o.rows / ranks;
}

/// Tiles of hazard maps (records/hazard_maps.hpp) over what lies at the start, as if it were a square: kept, and in
/// what a sample is made of.
double map_bytes(const Scene& scene, const Prediction& p, int ranks) {
    if (!(scene.hazard.cell > 0)) return 0;
    constexpr double of_sample = 3 * 40 + 4 * 8 + 3 * 8, tile = 16;
    const double side = std::sqrt(static_cast<double>(p.blocks)) * 4 * scene.cell / scene.hazard.cell;
    return std::pow(side + 2 * tile, 2) * (static_cast<double>(PlanColumns::kept_bytes) + of_sample) / ranks;
}

}  // namespace

double map_bytes_at_most(const Scene& scene) {
    double columns = 1;
    for (std::size_t a = 0; a < 2; ++a) columns *= (scene.max[a] - scene.min[a]) / scene.hazard.cell;
    return static_cast<double>(PlanColumns::kept_bytes) * columns;
}

double bytes_per_rank(const Scene& scene, const Prediction& p, int ranks) {
    const int d = scene.dimensions;
    const double lists = 10;
    const double frame = 4 + 8 * d + (d == 2 ? 24 : 0);       // list and places of an output; 2-D ones get a third axis
    const double sleep = scene.sleep.on ? 16 : 0;             // two words
    const double forecast = forecasts_sleep(scene) ? 48 : 0;  // id and two words, of two sleep checks
    const double particle = size_of(scene).reals * real_bytes(scene) + 8 + 2 + sleep + forecast + lists + frame;
    const double mine = static_cast<double>(p.blocks) / ranks;
    const double tables = 4 * (std::pow(3, d) + std::pow(4, d) + 3 * std::pow(2, d)) + 100;
    return static_cast<double>(p.particles) / ranks * particle +
           mine * (tile_bytes(scene) + pressure_bytes(scene, false)) + grown(scene, mine, 1) * node_block_bytes(scene) +
           grown(scene, mine, 2) * tables + held_output(scene, p, ranks) + map_bytes(scene, p, ranks);
}

namespace {

/// Reals of a particle on the device: its rows and a spare one, and further scalars.
int device_reals(const Scene& scene) {
    const ParticleSize size = size_of(scene);
    const int d = scene.dimensions;
    return 4 * (size.rows + 1) + size.scalars + (gather_way(scene) == GatherWay::fused ? 0 : d * d);
}

/// What may be larger in a later epoch, whose arrays then have a sixteenth to spare.
double device_tables(const Scene& scene, const Prediction& p) {
    const int d = scene.dimensions;
    const double cells = std::pow(4, d), offsets = std::pow(3, d), corners = std::pow(2, d);
    const double sleepers = scene.sleep.on ? 8 + 8 + 8 + 4 * 4 + 3 : 0;
    const double sorted =
        gather_way(scene) == GatherWay::by_material ? 4.0 * static_cast<double>(scene.materials.size() + 1) + 2 : 0;
    const double own = 4 * (d + offsets + corners + 2 * (cells + 1) + (offsets + 2) + 8) + 2 + sleepers + sorted;
    const double node = 4 * (d + corners + 1) + 1 + node_block_bytes(scene);
    return 17.0 / 16 * (static_cast<double>(p.epoch_blocks) * own + static_cast<double>(p.node_blocks) * node);
}

/// What is sized by an epoch's blocks comes from a pool (gpu/memory/pool_array.hpp), which takes pieces of 32 MiB: a
/// few whole ones, or half of one to spare. What it holds idle, because an array outgrew it, is given back where memory
/// is short, and not counted.
double pool_bytes(double blocks) {
    constexpr double piece = 32.0 * (1 << 20);
    return blocks < 4 * piece ? piece * std::ceil(blocks / piece) : blocks + piece / 2;
}

double bytes_of_one_device(const Scene& scene, const Prediction& p) {
    const auto particles = static_cast<double>(p.particles), blocks = static_cast<double>(p.blocks);
    const double ids = 8 + 2, lists = 2 * 4 + 2 + 4 + 1 + 0.125;
    const double words = scene.sleep.on ? 16 : 0;
    const int loads = scene.course.tractions.empty() ? 0 : scene.dimensions * (scene.dimensions + 1);
    const double particle = (device_reals(scene) + loads) * real_bytes(scene) + ids + words + lists;
    const double tiles = std::min(static_cast<double>(p.epoch_blocks), 13.0 / 12 * blocks + 32);  // open_epoch()
    // One column of a million particles on its way from or to the host.
    const double staging = std::min(particles, 1048576.0) * size_of(scene).widest * real_bytes(scene);
    const double of_blocks = tiles * (tile_bytes(scene) + pressure_bytes(scene, true)) + device_tables(scene, p);
    const double rounding = 8 * 524288.0;  // some 8 columns, each rounded up to 2 MB or a share of it
    return particles * particle + pool_bytes(of_blocks) + staging + rounding;
}

/// Graphs of steps that a device alone makes by itself (docs/adr/0013-device-leads.md).
double lead_bytes(const Scene& scene, const Prediction& p) {
    const bool leads = scene.structures.empty() && !scene.sleep.on && scene.course.tractions.empty() &&
                       p.particles <= most_led_particles;
    return leads ? 23e6 : 0;
}

/// Boxes of a transport for messages of so many bytes in all, two for each (the inboxes of gpu/transport).
double boxes(double bytes) {
    const double capacity = 2 * 9.0 / 8 * bytes;
    return capacity + std::max(capacity / 8, std::min(capacity, 64.0 * (1 << 20)));
}

/// Blocks of one of `ranks` shares that touch others: as many as if all were cubes in a larger one, and half as many
/// again, for parts of a curve are more ragged.
double boundary_blocks(const Scene& scene, double blocks, int ranks) {
    const double d = scene.dimensions;
    return std::min(blocks, 1.5 * 2 * d * std::pow(blocks, (d - 1) / d) * (1 - std::pow(ranks, -1 / d)));
}

/// What one of several devices needs besides its share: spare slots, the tiles of others, messages.
double bytes_for_others(const Scene& scene, const Prediction& mine, int ranks) {
    const auto particles = static_cast<double>(mine.particles), blocks = static_cast<double>(mine.blocks);
    const double record = 16 + (device_reals(scene) - 4) * real_bytes(scene);
    const double boundary = boundary_blocks(scene, blocks, ranks);
    const double outgoing = 5.0 / 4 * 0.35 * boundary * particles / std::max(blocks, 1.0);  // of 64 cells 16 and more
    const double halo = boundary * tile_bytes(scene) * 0.4;  // of a face and some edges, without the unused sums
    const double moves = std::min(particles / 16 * record, 64.0 * (1 << 20));  // a round of gpu/exchange/block_moves.cu
    return particles / 64 * (record + 40) + boundary * 9 / 8 * tile_bytes(scene) + device_tables(scene, mine) / 4 +
           boxes(outgoing * record) + boxes(halo) + boxes(moves);
}

}  // namespace

double bytes_on_device(const Scene& scene, const Prediction& p, int ranks) {
    if (ranks == 1) return bytes_of_one_device(scene, p) + lead_bytes(scene, p);
    Prediction mine = p;
    for (std::int64_t Prediction::*count :
         {&Prediction::particles, &Prediction::blocks, &Prediction::epoch_blocks, &Prediction::node_blocks})
        mine.*count = (p.*count + ranks - 1) / ranks;
    return bytes_of_one_device(scene, mine) + bytes_for_others(scene, mine, ranks);
}

namespace {

/// Of a scene whose particles are made on the host and uploaded: they, what of them travels at most both ways, and
/// their order.
double rows_on_host(const Scene& scene, const Prediction& p, int ranks) {
    const double row = size_of(scene).reals * real_bytes(scene) + 8 + 2;
    const double travels = 1 - 1.0 / ranks;
    return static_cast<double>(p.particles) / ranks * (row * (1 + 2 * travels) + 28) +
           static_cast<double>(p.blocks) / ranks * (tile_bytes(scene) + node_block_bytes(scene));
}

}  // namespace

double host_bytes_with_device(const Scene& scene, const Prediction& p, int ranks, bool writes_particles) {
    const int d = scene.dimensions;
    const auto particles = static_cast<double>(p.particles), blocks = static_cast<double>(p.blocks);
    const double replicated = 32 + 3 * 16 + 2 * 20 + 3 * 8;  // loads, occupied blocks, topologies and gathers of keys
    const double own = 2 * (4 * std::pow(3, d) + 8 * std::pow(2, d) + 8 * d + 42) + 60;  // tables, twice; counts
    const double column = (ranks > 1 ? 3 : 1) * 24;  // of places: as made, as sent, as written
    const double lattice = 200 * std::min(particles / ranks, 1048576.0);
    const double seeding = is_lattice(scene) ? lattice : std::max(lattice, rows_on_host(scene, p, ranks));
    const double output = writes_particles ? column * particles / ranks + held_output(scene, p, ranks) : 0;
    return 1e9 + blocks * replicated + grown(scene, blocks / ranks, 2) * own + std::max(seeding, output) +
           map_bytes(scene, p, ranks);
}

}  // namespace moraine
