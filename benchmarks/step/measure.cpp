#include "step/measure.hpp"

#include "simulation/simulation.hpp"

namespace moraine {

namespace {

/// Particles, cells, blocks, and how the particles move and yield, as they are now.
template <class Real, int Dim>
void look_at(Simulation<Real, Dim>& sim, Measured& m) {
    sim.conclude();
    const BinnedBlocks binned = sim.patch().binned();
    m.particles = static_cast<double>(binned.slot.size());
    m.blocks = static_cast<double>(binned.key.size());
    m.cells = 0;
    const ListView<Dim> list = sim.patch().list();
    for (int b = 0; b < sim.patch().own(); ++b) {
        if (list.count(b) == 0) continue;
        const std::uint32_t* first = list.cell_first + static_cast<std::size_t>(b) * (Block<Dim>::cells + 1);
        for (int c = 0; c < Block<Dim>::cells; ++c) m.cells += first[c + 1] > first[c] ? 1 : 0;
    }
    const ParticleView<Real, Dim> p = sim.patch().particles.view();
    double moved = 0;
    double yielded = 0;
    for (std::uint32_t s : binned.slot) {
        double square = 0;
        for (int a = 0; a < Dim; ++a) square += static_cast<double>(p.velocity[s][a] * p.velocity[s][a]);
        moved += std::sqrt(square) * sim.clock().dt / sim.scene().cell;
        if (p.history[0] && p.history[0][s] > Real(0)) yielded += 1;
    }
    m.moved = moved / m.particles;
    m.yielded = yielded / m.particles;
    m.row_bytes = static_cast<double>(sim.patch().particles.row_bytes());
}

template <class Real, int Dim>
Measured measure_as(const Scene& scene, const Runs& plan) {
    const Comm comm(MPI_COMM_WORLD);
    Simulation<Real, Dim> sim(scene, comm);
    const auto advance = [&](int steps) {
        for (int i = 0; i < steps; ++i) sim.step(), sim.balance();
    };
    sim.seed();
    Measured m;
    m.seeded_bytes = peak_memory();
    advance(plan.warm_up);
    const std::array<double, Phases::count> before = sim.phases().all();
    std::vector<double> wall, processor;
    for (int r = 0; r < plan.runs; ++r) {
        const double w = wall_seconds();
        const double u = processor_seconds();
        advance(plan.steps);
        wall.push_back(wall_seconds() - w);
        processor.push_back(processor_seconds() - u);
    }
    const double steps = plan.runs * plan.steps;
    for (double w : wall) m.step_seconds += w / steps;
    for (std::size_t k = 0; k < Phases::count; ++k) m.phases[k] = (sim.phases().all()[k] - before[k]) / steps;
    m.wall = spread_of(wall);
    m.processor = spread_of(processor);
    m.peak_bytes = peak_memory();
    look_at(sim, m);
    return m;
}

}  // namespace

Measured measure(const Case& c, const Runs& plan) {
    const bool single = c.scene.precision == Precision::single_;
    if (c.scene.dimensions == 2)
        return single ? measure_as<float, 2>(c.scene, plan) : measure_as<double, 2>(c.scene, plan);
    return single ? measure_as<float, 3>(c.scene, plan) : measure_as<double, 3>(c.scene, plan);
}

}  // namespace moraine
