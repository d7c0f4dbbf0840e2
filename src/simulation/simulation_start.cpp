// How a simulation begins: from the scene's bodies, or from a checkpoint.

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include "host/host_engine.hpp"
#include "seeding/lattice_seeds.hpp"
#include "seeding/seed_state.hpp"
#include "seeding/structure_seeds.hpp"
#include "simulation/absorbing_walls.hpp"
#include "simulation/diagnostics.hpp"
#include "simulation/gravity_step.hpp"
#include "simulation/place_seed.hpp"
#include "simulation/stage_scene.hpp"

namespace moraine {

namespace {

/// c + |v| of the wave of water in the soil; 0 of a dry particle [m/s].
template <class Real, int Dim>
double signal_of_water(const PoreWater<Real>* pores, const ParticleView<Real, Dim>& p, std::uint32_t s) {
    if (!pores || !pores[p.body[s]].is_wet()) return 0;
    const PoreWater<Real>& pore = pores[p.body[s]];
    double square = 0;
    for (int a = 0; a < Dim; ++a)
        square += static_cast<double>(p.velocity[s][a]) * static_cast<double>(p.velocity[s][a]);
    return static_cast<double>(pore.wave_speed(pore.porosity_at(p.ln_J[s]), p.mass[s] / p.volume[s])) +
           std::sqrt(square);
}

/// This rank's part of every body: rows are divided evenly, whoever will own them. Some rows at a time,
/// so that a seed needs memory only until it is a particle.
template <class Real, int Dim>
BinnedBlocks seed_share(const Scene& scene, const Comm& comm, const Method<Host, Real, Dim>& method,
                        const DomainBlocks<Dim>& domain, Patch<Host, Real, Dim>& share) {
    std::vector<std::pair<Key, std::uint32_t>> placed;
    std::vector<Seed> seeds;
    for (int body = 0; body < static_cast<int>(scene.bodies.size()); ++body) {
        if (Supply::comes_later(scene.bodies[static_cast<std::size_t>(body)])) continue;
        const BodySeeds part(scene, body);
        const std::int64_t first = part.rows() * comm.rank() / comm.size();
        const std::int64_t last = part.rows() * (comm.rank() + 1) / comm.size();
        const std::int64_t mine = part.count(first, last);
        const std::int64_t total = comm.sum(mine);
        share.particles.reserve(placed.size() + static_cast<std::size_t>(mine));
        placed.reserve(placed.size() + static_cast<std::size_t>(mine));
        const std::int64_t step = std::max<std::int64_t>(1, (last - first) / 32);
        for (std::int64_t row = first; row < last; row += step) {
            seeds.clear();
            part.fill(row, std::min(row + step, last), total, seeds);
            clear_structures(scene, seeds);
            const std::vector<std::uint32_t> slots = share.take_slots(seeds.size());
            for (std::size_t k = 0; k < seeds.size(); ++k)
                placed.emplace_back(place_seed(scene, method, domain, share.particles.view(), seeds[k], slots[k]),
                                    slots[k]);
        }
    }
    std::sort(placed.begin(), placed.end());
    BinnedBlocks binned;
    binned.slot.reserve(placed.size());
    for (const auto& [key, slot] : placed) {
        if (binned.key.empty() || binned.key.back() != key) {
            binned.key.push_back(key);
            binned.count.push_back(0);
        }
        ++binned.count.back();
        binned.slot.push_back(slot);
    }
    return binned;
}

/// The initial order: (block, cell, id).
template <class Real, int Dim>
void sort_blocks(Patch<Host, Real, Dim>& share, BinnedBlocks& binned) {
    const ParticleView<Real, Dim> p = share.particles.view();
    const auto rank_of = [&](std::uint32_t s) { return std::pair(share.cell_of_slot(s), p.id[s]); };
    auto first = binned.slot.begin();
    for (std::uint32_t count : binned.count) {
        std::sort(first, first + count, [&](std::uint32_t a, std::uint32_t b) { return rank_of(a) < rank_of(b); });
        first += count;
    }
}

/// Of this rank's blocks, from the owners of all.
std::vector<std::int32_t> owners_of(const BinnedBlocks& mine, const std::vector<BlockLoad>& loads,
                                    const std::vector<std::int32_t>& owners) {
    std::vector<std::int32_t> result;
    for (Key key : mine.key) {
        const auto at = std::lower_bound(loads.begin(), loads.end(), key,
                                         [](const BlockLoad& load, Key k) { return load.key < k; });
        result.push_back(owners[static_cast<std::size_t>(at - loads.begin())]);
    }
    return result;
}

}  // namespace

template <class Real, int Dim>
Simulation<Real, Dim>::Simulation(const Scene& scene, const Comm& comm, const EngineMaker& make_engine)
    : scene_(scene),
      comm_(comm),
      method_(scene_in_stage(scene, 0)),
      domain_(scene),
      hosts_(find_hosts(comm)),
      partitioner_(make_partitioner(scene.balance, layout_of(domain_, method_.stencil.width), comm, hosts_)),
      trigger_(scene.balance, *partitioner_, make_engine ? device_moves : host_moves),
      loads_(scene.balance, comm, make_engine ? device_costs : host_costs, Block<Dim>::cells),
      agreement_(comm),
      structures_(scene),
      supply_(scene),
      epochs_(
          domain_, method_.stencil, comm, hosts_, counts_,
          [this](const BlockPosition<Dim>& at) {
              Position position{};
              std::copy(at.begin(), at.end(), position.begin());
              return partitioner_->owner_at(position);
          },
          [this](const EpochTables<Dim>& tables) { engine_->prepare(tables); }),
      rebalance_(scene.balance, comm, *partitioner_, trigger_, epochs_.next()) {
    if (make_engine)
        engine_ = make_engine(method_);
    else
        engine_ = std::make_unique<HostEngine<Real, Dim>>(scene_, comm_, method_);
    clock_.gravity = components<Dim>(gravity_at(scene, 0));
    if (!scene.course.stages.empty()) clock_.stages.push_back({}), engine_->begin_stage(stage()->materials);
    in_place_ = engine_->device().leaves_host_free;
    make_epochs_async(in_place_);
}

template <class Real, int Dim>
Simulation<Real, Dim>::~Simulation() = default;

template <class Real, int Dim>
void Simulation<Real, Dim>::make_epochs_async(bool async) {
    epochs_.set_async(async);
    rebalance_.set_async(async);
}

template <class Real, int Dim>
void Simulation<Real, Dim>::set_body_force(Acceleration acceleration) {
    body_force_ = std::move(acceleration);
    method_.needs.body_force = true;
    engine_ = std::make_unique<HostEngine<Real, Dim>>(scene_, comm_, method_);
}

/// Every rank makes rows of the bodies, whoever will own them, and blocks travel to their owners.
template <class Real, int Dim>
void Simulation<Real, Dim>::seed_rows() {
    const BinnedBlocks share = seed_share(scene_, comm_, method_, domain_, patch());
    std::vector<BlockLoad> loads = loads_.gather(counts_of(patch(), share, loads_.weighs_cells()));
    for (BlockLoad& load : loads) load.owner = -1;
    partitioner_->start(loads);
    const std::vector<std::int32_t> owners = partitioner_->owners(loads, clock_.round++);
    BlockMoveCount not_counted;
    BinnedBlocks binned = move_blocks(comm_, patch(), share, owners_of(share, loads, owners), not_counted);
    sort_blocks(patch(), binned);
    begin_epoch(binned);
    engine_->refresh_memory(true);
}

/// Every rank knows all blocks and what they hold, and makes its own ones where they stay: nothing travels, and no
/// memory of the host grows with the particles.
template <class Real, int Dim>
void Simulation<Real, Dim>::seed_lattice() {
    const LatticeTables<Real, Dim> lattice = lattice_tables(scene_, method_, domain_);
    std::vector<BlockLoad> loads;
    for (const LatticeBlock& b : lattice_blocks(lattice, loads_.weighs_cells()))
        loads.push_back({b.key, b.particles, loads_.weight(b.particles, b.cells), -1});
    partitioner_->start(loads);
    const std::vector<std::int32_t> owners = partitioner_->owners(loads, clock_.round++);
    for (std::size_t b = 0; b < loads.size(); ++b) loads[b].owner = owners[b];
    engine_->begin_epoch(epochs_.make(loads), LatticeShare<Real, Dim>{lattice});
}

template <class Real, int Dim>
void Simulation<Real, Dim>::seed() {
    if (in_place_ && is_lattice(scene_))
        seed_lattice();
    else
        seed_rows();
    set_scales();
    refresh_signal();
    begin_ends<Real, Dim>(
        scene_, comm_, [this](EndQuery<Dim>& query) { measure(query); }, *engine_, clock_);
    const Totals<Dim> start = totals_of(*this);
    clock_.start_mass = start.mass;
    clock_.start_momentum = start.momentum;
    clock_.start_strain = start.strain;
    clock_.start_potential = potential_energy(scene_, clock_.gravity, start);
    clock_.start_energy = start.kinetic + start.strain + clock_.start_potential;
}

/// Units of the exact sums and the mass below which a node is empty, from what the particles weigh.
template <class Real, int Dim>
void Simulation<Real, Dim>::set_scales() {
    double lightest = std::numeric_limits<double>::infinity();
    double heaviest = 0;
    each_piece({"mass"}, [&](const SharePiece<Real, Dim>& piece) {
        for (std::uint32_t s : piece.slots()) {
            lightest = std::min(lightest, static_cast<double>(piece.p.mass[s]));
            heaviest = std::max(heaviest, static_cast<double>(piece.p.mass[s]));
        }
    });
    std::int64_t to_come = 0;
    Supply(scene_).take(Supply::never, [&](const std::vector<Seed>& seeds) {
        for (const Seed& seed : seeds) {
            lightest = std::min(lightest, seed.mass);
            heaviest = std::max(heaviest, seed.mass);
        }
        to_come += static_cast<std::int64_t>(seeds.size());
    });
    lightest = comm_.min(lightest);
    heaviest = comm_.max(heaviest);
    clock_.mass_cutoff = lightest * (sizeof(Real) == 8 ? 1e-18 : 1e-12);
    const auto particles = static_cast<double>(comm_.sum(engine_->census().particles) + to_come);
    clock_.quantum_scale = Quantum::for_largest(heaviest * particles).scale;
}

/// Once in a while, so a device leaves it to an engine of the host, which has a copy of the share meanwhile.
template <class Real, int Dim>
void Simulation<Real, Dim>::measure(EndQuery<Dim>& query) {
    if (!engine_->device().leaves_host_free) return engine_->answer(&query);
    HostEngine<Real, Dim> host(scene_, comm_, method_);
    Share& share = patch();
    BinnedBlocks binned = share.binned();
    const std::vector<std::uint32_t> from = std::exchange(binned.slot, host.share().take_slots(binned.slot.size()));
    const std::vector<ColumnBytes> to = host.share().particles.columns();
    std::size_t column = 0;
    for (const ColumnBytes& c : share.particles.columns()) {
        const ColumnBytes& copy = to[column++];
        for (std::size_t k = 0; k < from.size(); ++k)
            std::memcpy(copy.data + binned.slot[k] * c.row_bytes, c.data + from[k] * c.row_bytes, c.row_bytes);
    }
    host.begin_epoch(share.tables(), HostShare{binned});
    host.answer(&query);
}

template <class Real, int Dim>
void Simulation<Real, Dim>::refresh_signal() {
    double signal = 0;
    each_piece({}, [&](const SharePiece<Real, Dim>& piece) {
        const std::span<const std::uint32_t> slots = piece.slots();
#pragma omp parallel for schedule(static) reduction(max : signal)
        for (std::size_t k = 0; k < slots.size(); ++k)
            signal = std::max({signal, method_.law_of(piece.p.body[slots[k]]).signal(piece.p, slots[k]),
                               signal_of_water(method_.pores(), piece.p, slots[k])});
    });
    agreement_.own().signal = clock_.signal = comm_.max(signal);
    refresh_speed();
}

/// The largest |v|^2, as a step would tell it; only where steps depend on it.
template <class Real, int Dim>
void Simulation<Real, Dim>::refresh_speed() {
    if (scene_.substeps == 1) return;
    double most = 0;
    each_piece({"velocity"}, [&](const SharePiece<Real, Dim>& piece) {
        for (const std::uint32_t slot : piece.slots()) {
            Real square = Real(0);
            for (int a = 0; a < Dim; ++a) square += piece.p.velocity[slot][a] * piece.p.velocity[slot][a];
            most = std::max(most, double(square));
        }
    });
    agreement_.own().square_speed = clock_.square_speed = comm_.max(most);
}

template <class Real, int Dim>
void Simulation<Real, Dim>::restore(const std::vector<Key>& keys, const std::vector<std::int64_t>& counts,
                                    const RunClock<Dim>& clock, const Budget<Dim>& budget,
                                    const std::vector<std::int64_t>& partitioner_state, const ReadRows& read) {
    std::vector<BlockLoad> loads;
    for (std::size_t b = 0; b < keys.size(); ++b) {
        const std::int64_t weight = loads_.weight(counts[b], std::min<std::int64_t>(counts[b], Block<Dim>::cells));
        loads.push_back({keys[b], counts[b], weight, -1});
    }
    clock_ = clock;
    if (stage()) make_method();
    if (!partitioner_->restore(partitioner_state)) partitioner_->start(loads);
    const std::vector<std::int32_t> owners = partitioner_->owners(loads, clock_.round++);
    BinnedBlocks binned;
    std::vector<std::pair<std::int64_t, std::int64_t>> ranges;
    std::int64_t at = 0;
    for (std::size_t b = 0; b < keys.size(); at += counts[b], ++b) {
        if (owners[b] != comm_.rank()) continue;
        binned.key.push_back(keys[b]);
        binned.count.push_back(static_cast<std::uint32_t>(counts[b]));
        ranges.emplace_back(at, counts[b]);
    }
    std::size_t rows = 0;
    for (std::uint32_t count : binned.count) rows += count;
    binned.slot = patch().take_slots(rows);
    read(ranges, binned.slot);
    begin_epoch(binned);
    if (comm_.is_root()) budget_ = budget;
    agreement_.own().signal = clock_.signal;
    agreement_.own().square_speed = clock_.square_speed;
    for (std::size_t k = 1; k < clock_.stages.size(); ++k) supply_.begin_stage(static_cast<int>(k));
    supply_.skip_to(clock_.time);
    loads_.resume(clock_.step);
    begin_ends<Real, Dim>(scene_, comm_, nullptr, *engine_, clock_);
}

template class Simulation<float, 2>;
template class Simulation<float, 3>;
template class Simulation<double, 2>;
template class Simulation<double, 3>;

}  // namespace moraine
