// Particles that come in during the run (simulation/supply.hpp): between steps, in the binned state. Every rank knows
// all that is due and takes what lies in its blocks, so nothing travels; an epoch begins with them.

#include <algorithm>
#include <tuple>

#include "host/host_engine.hpp"
#include "seeding/seed_state.hpp"
#include "seeding/structure_seeds.hpp"
#include "simulation/place_seed.hpp"
#include "simulation/simulation.hpp"

namespace moraine {

namespace {

/// What the budget must know of those that came in: as if they had been there from the start.
template <int Dim>
struct SupplySums {
    ExactSum mass, energy, potential, momentum[Dim];

    void add(const SupplySums& o) {
        mass.add(o.mass), energy.add(o.energy), potential.add(o.potential);
        for (int a = 0; a < Dim; ++a) momentum[a].add(o.momentum[a]);
    }
};

struct Placed {
    Key key;
    int cell;
    std::uint64_t id;
    std::uint32_t slot;
};

/// Lists of blocks with those of `placed` behind their cells' own, by id.
template <class Real, int Dim>
BinnedBlocks merged(Patch<Host, Real, Dim>& share, const BinnedBlocks& here, std::vector<Placed>& placed) {
    std::sort(placed.begin(), placed.end(), [](const Placed& a, const Placed& b) {
        return std::tie(a.key, a.cell, a.id) < std::tie(b.key, b.cell, b.id);
    });
    BinnedBlocks all;
    auto next = placed.begin();
    auto slot = here.slot.begin();
    const auto begin_block = [&](Key key) { all.key.push_back(key), all.count.push_back(0); };
    const auto put = [&](std::uint32_t s) { all.slot.push_back(s), ++all.count.back(); };
    const auto put_new_blocks = [&](auto is_before) {
        while (next != placed.end() && is_before(next->key)) {
            const Key key = next->key;
            begin_block(key);
            for (; next != placed.end() && next->key == key; ++next) put(next->slot);
        }
    };
    for (std::size_t b = 0; b < here.key.size(); ++b) {
        put_new_blocks([&](Key key) { return key < here.key[b]; });
        begin_block(here.key[b]);
        for (std::uint32_t k = 0; k < here.count[b]; ++k, ++slot) {
            for (; next != placed.end() && next->key == here.key[b] && next->cell < share.cell_of_slot(*slot); ++next)
                put(next->slot);
            put(*slot);
        }
        for (; next != placed.end() && next->key == here.key[b]; ++next) put(next->slot);
    }
    put_new_blocks([](Key) { return true; });
    return all;
}

}  // namespace

template <class Real, int Dim>
void Simulation<Real, Dim>::admit() {
    conclude();
    synchronize();
    epochs_.forget_next();
    Share& share = patch();
    const BinnedBlocks here = share.binned();
    std::vector<Placed> placed;
    SupplySums<Dim> sums;
    double signal = 0, square_speed = 0;
    supply_.take(clock_.time, [&](std::vector<Seed>& seeds) {
        clear_structures(scene_, seeds);
        for (const Seed& seed : seeds) {
            const Key key = key_of_seed<Real, Dim>(scene_, method_, domain_, seed);
            if (epochs_.next().owner_near(key) != comm_.rank()) continue;
            const std::uint32_t slot = share.take_slots(1).front();
            const ParticleView<Real, Dim> p = share.particles.view();
            place_seed(scene_, method_, domain_, p, seed, slot);
            placed.push_back({key, share.cell_of_slot(slot), seed.id, slot});
            const double m = static_cast<double>(p.mass[slot]);
            double energy = 0, potential = 0, square = 0;
            for (int a = 0; a < Dim; ++a) {
                const auto i = static_cast<std::size_t>(a);
                const double v = static_cast<double>(p.velocity[slot][a]);
                square += v * v;
                const double weight = m * clock_.gravity[i] * (seed.x[i] - scene_.min[i]);
                energy += 0.5 * m * v * v - weight;
                potential -= weight;
                sums.momentum[a].add(quantum().of(m * (v - clock_.gravity_impulse[i])));
            }
            sums.mass.add(quantum().of(m));
            sums.energy.add(quantum().of(energy));
            sums.potential.add(quantum().of(potential));
            signal = std::max(signal, method_.law_of(seed.body).signal(p, slot));
            square_speed = std::max(square_speed, square);
        }
    });
    begin_epoch(merged(share, here, placed));
    const SupplySums<Dim> all = comm_.exact_sum(sums);
    clock_.start_mass += quantum().value(all.mass);
    if (stage()) clock_.stages.back().added_mass += quantum().value(all.mass);
    clock_.start_energy += quantum().value(all.energy);
    clock_.start_potential += quantum().value(all.potential);
    for (std::size_t a = 0; a < Dim; ++a) clock_.start_momentum[a] += quantum().value(all.momentum[a]);
    clock_.signal = agreement_.own().signal = std::max(clock_.signal, comm_.max(signal));
    if (scene_.substeps != 1)
        clock_.square_speed = agreement_.own().square_speed = std::max(clock_.square_speed, comm_.max(square_speed));
    ++counts_.epochs;
}

template class Simulation<float, 2>;
template class Simulation<float, 3>;
template class Simulation<double, 2>;
template class Simulation<double, 3>;

}  // namespace moraine
