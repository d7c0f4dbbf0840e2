// Stages: what changes between two steps of one run. A stage ends with the first step at or past its time, or once all
// has come to rest; then the next one begins before the next step, in the binned state, on all ranks.
//
// Its strengths, walls and damping are a method made anew: stresses that are outside a lowered yield surface are
// returned to it by the law in the next step. Bodies that it takes away leave the budget as if they had never been
// there; those that it brings are seeded as at the start (simulation_supply.cpp). So a restart needs but the number of
// the stage and when it began.

#include "simulation/absorbing_walls.hpp"
#include "simulation/diagnostics.hpp"
#include "simulation/simulation.hpp"
#include "simulation/stage_scene.hpp"

namespace moraine {

namespace {

/// What the budget must forget of those that are taken away.
template <int Dim>
struct RemovedSums {
    ExactSum mass, kinetic, strain, potential, momentum[Dim];

    void add(const RemovedSums& o) {
        mass.add(o.mass), kinetic.add(o.kinetic), strain.add(o.strain), potential.add(o.potential);
        for (int a = 0; a < Dim; ++a) momentum[a].add(o.momentum[a]);
    }
};

/// By body: whether it is one of these.
std::vector<std::uint8_t> is_one_of(const std::vector<int>& these, std::size_t bodies) {
    std::vector<std::uint8_t> removed(bodies, 0);
    for (const int body : these) removed[static_cast<std::size_t>(body)] = 1;
    return removed;
}

/// Lists without the bodies that go, whose slots are given back.
template <class Real, int Dim>
BinnedBlocks without(Patch<Host, Real, Dim>& share, const std::vector<std::uint8_t>& removed) {
    const BinnedBlocks here = share.binned();
    const ParticleView<Real, Dim> p = share.particles.view();
    BinnedBlocks left;
    std::vector<std::uint32_t> gone;
    auto slot = here.slot.begin();
    for (std::size_t b = 0; b < here.key.size(); ++b) {
        std::uint32_t count = 0;
        for (std::uint32_t k = 0; k < here.count[b]; ++k, ++slot) {
            const bool goes = removed[p.body[*slot]] != 0;
            (goes ? gone : left.slot).push_back(*slot);
            count += goes ? 0 : 1;
        }
        if (count == 0) continue;
        left.key.push_back(here.key[b]);
        left.count.push_back(count);
    }
    share.give_slots(gone);
    return left;
}

}  // namespace

template <class Real, int Dim>
void Simulation<Real, Dim>::begin_stage() {
    conclude();
    if (rebalance_.is_under_way()) continue_check(true);
    clock_.stages.push_back({clock_.time, clock_.step});
    make_method();
    if (!stage()->removes.empty()) remove_bodies(stage()->removes);
    supply_.begin_stage(static_cast<int>(clock_.stages.size()) - 1);
    if (supply_.next() <= clock_.time) admit();
    if (!stage()->set.empty()) refresh_signal();
    begin_ends<Real, Dim>(
        scene_, comm_, [this](EndQuery<Dim>& query) { measure(query); }, *engine_, clock_);
}

template <class Real, int Dim>
void Simulation<Real, Dim>::make_method() {
    method_ = method_in_stage<Real, Dim>(scene_, clock_.stages.size() - 1, method_.needs);
    engine_->begin_stage(stage()->materials);
}

template <class Real, int Dim>
void Simulation<Real, Dim>::remove_bodies(const std::vector<int>& bodies) {
    synchronize();
    epochs_.forget_next();
    const std::vector<std::uint8_t> removed = is_one_of(bodies, scene_.bodies.size());
    RemovedSums<Dim> sums;
    const ParticleView<Real, Dim> p = patch().particles.view();
    each_particle(*this, [&](std::uint32_t s, const std::array<double, Dim>& x) {
        if (removed[p.body[s]] == 0) return;
        const double m = static_cast<double>(p.mass[s]);
        double square = 0, potential = 0;
        for (std::size_t a = 0; a < Dim; ++a) {
            const double v = static_cast<double>(p.velocity[s][static_cast<int>(a)]);
            square += v * v;
            potential -= m * clock_.gravity[a] * (x[a] - scene_.min[a]);
            sums.momentum[a].add(quantum().of(m * (v - clock_.gravity_impulse[a])));
        }
        sums.mass.add(quantum().of(m));
        sums.kinetic.add(quantum().of(0.5 * m * square));
        sums.strain.add(quantum().of(method_.law_of(p.body[s]).strain_energy(p, s)));
        sums.potential.add(quantum().of(potential));
    });
    begin_epoch(without(patch(), removed));
    const RemovedSums<Dim> all = comm_.exact_sum(sums);
    const auto value = [&](const ExactSum& sum) { return quantum().value(sum); };
    const double energy = value(all.kinetic) + value(all.strain) + value(all.potential);
    clock_.start_mass -= value(all.mass);
    clock_.start_energy -= energy;
    clock_.start_strain -= value(all.strain);
    clock_.start_potential -= value(all.potential);
    for (std::size_t a = 0; a < Dim; ++a) clock_.start_momentum[a] -= value(all.momentum[a]);
    if (stage()) clock_.stages.back().removed_mass += value(all.mass), clock_.stages.back().removed_energy += energy;
    ++counts_.epochs;
}

template class Simulation<float, 2>;
template class Simulation<float, 3>;
template class Simulation<double, 2>;
template class Simulation<double, 3>;

}  // namespace moraine
