#include "predict/prediction.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "blocks/growth.hpp"
#include "blocks/topology.hpp"
#include "core/data/block.hpp"
#include "core/data/morton.hpp"
#include "core/grid/shape.hpp"
#include "core/material/laws.hpp"
#include "core/particles/place_step.hpp"
#include "core/transfer/method.hpp"
#include "predict/lattice_prediction.hpp"
#include "seeding/lattice_seeds.hpp"
#include "seeding/seed.hpp"
#include "seeding/seed_region.hpp"
#include "seeding/seed_state.hpp"
#include "seeding/structure_seeds.hpp"

namespace moraine {
namespace {

/// Block of a particle, wrapped along periodic axes as in the run.
template <class Real, int Dim>
Key block_of(const Scene& scene, double offset, const Triple& x) {
    BlockPosition<Dim> position;
    for (std::size_t a = 0; a < Dim; ++a) {
        Place<Real> at = place<Real>((x[a] - scene.min[a]) / scene.cell + offset);
        const auto cells = static_cast<std::int32_t>(std::lround((scene.max[a] - scene.min[a]) / scene.cell));
        if (scene.periodic[a])
            position[a] = (at.block % (cells / 4) + cells / 4) % (cells / 4);
        else
            position[a] = at.block + bin_below<Real>(cells, static_cast<Real>(offset), at.block, at.u);
    }
    return Morton<Dim>::encode(position);
}

using BlockOf = Key (*)(const Scene&, double offset, const Triple& x);

BlockOf choose_block_of(const Scene& scene) {
    const bool single = scene.precision == Precision::single_;
    if (scene.dimensions == 2) return single ? block_of<float, 2> : block_of<double, 2>;
    return single ? block_of<float, 3> : block_of<double, 3>;
}

void sort_unique(std::vector<Key>& keys) {
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

/// Whether the rows of a body that lie in the same layer of blocks are alike: then one of them tells of all.
bool rows_are_alike(const Scene& scene, const BodySpec& body) {
    const bool cleared = std::any_of(scene.structures.begin(), scene.structures.end(),
                                     [](const StructureSpec& structure) { return structure.clear; });
    return body.shape == BodyShape::box && !(body.wave.wavelength > 0) && !cleared;
}

/// Layers of blocks, numbered, by row; jitter across a layer's face is left out.
std::vector<std::int64_t> layers_of(const Scene& scene, const BodySpec& body, std::int64_t rows) {
    const auto axis = static_cast<std::size_t>(scene.dimensions - 1);
    const Lattice lattice = lattice_of(scene, body);
    std::vector<std::int64_t> layer;
    for (std::int64_t row = 0; row < rows; ++row) {
        const double cells = (lattice.place(axis, row) - scene.min[axis]) / scene.cell;
        layer.push_back(std::llround(std::floor((cells + stencil_of(scene.shape).offset()) / 4)));
    }
    return layer;
}

/// Adds one body, a few rows at a time so that the memory stays small. Returns its top speed [m/s] and volume [m3].
std::pair<double, double> add_body(const Scene& scene, int body, Prediction& p, std::vector<Key>& keys) {
    const BodySeeds seeds(scene, body);
    const std::int64_t rows = seeds.rows();
    const std::int64_t total = seeds.count(0, rows);
    const double offset = stencil_of(scene.shape).offset();
    const BlockOf block = choose_block_of(scene);
    const std::int64_t stretch = scene.bodies[static_cast<std::size_t>(body)].shape == BodyShape::table ? 65536 : 1;
    std::vector<Key> mine;
    std::vector<Seed> some;
    double speed = 0, volume = 0, row_mass = 0, row_volume = 0;
    std::int64_t particles = 0;
    const BodySpec& spec = scene.bodies[static_cast<std::size_t>(body)];
    const bool one_density = !scene.materials[static_cast<std::size_t>(spec.material)].density_profile();
    const bool alike = rows_are_alike(scene, spec) && one_density;
    const std::vector<std::int64_t> layer = alike ? layers_of(scene, spec, rows) : std::vector<std::int64_t>{};
    for (std::int64_t row = 0; row < rows; row += stretch) {
        const auto at = static_cast<std::size_t>(row);
        if (alike && row > 0 && layer[at] == layer[at - 1]) {
            p.mass += row_mass, volume += row_volume;
            particles += seeds.count(row, row + 1);
            continue;
        }
        some.clear();
        seeds.fill(row, std::min(rows, row + stretch), total, some);
        clear_structures(scene, some);
        particles += static_cast<std::int64_t>(some.size());
        row_mass = row_volume = 0;
        for (const Seed& s : some) {
            row_mass += s.mass, row_volume += s.volume;
            speed = std::max(speed, norm(s.velocity));
            const Key key = block(scene, offset, s.x);
            if (mine.empty() || mine.back() != key) mine.push_back(key);
        }
        p.mass += row_mass, volume += row_volume;
        if (mine.size() > 1000000) sort_unique(mine);
    }
    p.particles += particles;
    keys.insert(keys.end(), mine.begin(), mine.end());
    return {speed, volume};
}

template <int Dim>
void count_blocks_in(const Scene& scene, const std::vector<Key>& occupied, Prediction& p) {
    const DomainBlocks<Dim> domain(scene);
    std::vector<OccupiedBlock> blocks;
    for (Key key : occupied) blocks.push_back({key, 0});
    const Topology<Dim> topology = make_topology<Dim>(domain, blocks, [](const BlockPosition<Dim>&) { return 0; });
    p.blocks = static_cast<std::int64_t>(occupied.size());
    p.epoch_blocks = static_cast<std::int64_t>(topology.keys.size());
    p.node_blocks = static_cast<std::int64_t>(grown(topology.index, domain, Reach::upwards).keys().size());
}

}  // namespace

void count_blocks(const Scene& scene, const std::vector<Key>& occupied, Prediction& p) {
    scene.dimensions == 2 ? count_blocks_in<2>(scene, occupied, p) : count_blocks_in<3>(scene, occupied, p);
}

double norm(const Triple& v) {
    return std::hypot(v[0], v[1], v[2]);
}

double wave_speed(const Scene& scene, const BodySpec& body) {
    const MaterialSpec& material = scene.materials[static_cast<std::size_t>(body.material)];
    const LawInfo& law = *find_law(material.law);
    if (const auto pore = pore_water<double>(scene, material); pore.is_wet())
        return pore.wave_speed(pore.porosity, material.density);
    return std::sqrt(law.wave_modulus(material.parameters.data(), body.start, deepest_stress(scene, body)) /
                     material.density);
}

Prediction predict(const Scene& scene) {
    Prediction p;
    std::vector<Key> keys;
    double signal = 0;
    LatticePrediction lattice;
    if (is_lattice(scene)) {
        lattice = predict_lattice(scene);
        p.particles = lattice.particles;
        p.mass = lattice.mass;
        keys = std::move(lattice.occupied);
    }
    for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
        const BodySpec& body = scene.bodies[b];
        const auto [speed, volume] = b < lattice.speed.size()
                                         ? std::pair{lattice.speed[b], measure_of(body, scene.dimensions)}
                                         : add_body(scene, static_cast<int>(b), p, keys);
        p.cells += volume / std::pow(scene.cell, scene.dimensions);
        const double wave = wave_speed(scene, body);
        signal = std::max(signal, wave + speed);
        p.max_speed = std::max(p.max_speed, speed);
        p.max_wave_speed = std::max(p.max_wave_speed, wave);
    }
    if (lattice.speed.empty()) sort_unique(keys);
    count_blocks(scene, keys, p);
    const StepChoice step = choose_step(scene, signal, p.max_speed, shear_wave_share(scene));
    p.dt = scene.dt > 0 ? scene.dt : step.dt;
    p.substeps = step.substeps;
    p.steps = std::ceil(scene.end / p.dt);
    p.steps_without = std::ceil(scene.end * signal / (courant_number(scene) * scene.cell));
    return p;
}

}  // namespace moraine
