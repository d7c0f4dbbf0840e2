// What the records, checkpoints and tests ask of a simulation in the filed state.

namespace moraine {

template <class Real, int Dim>
void Simulation<Real, Dim>::each_particle(
    const std::function<void(std::uint32_t, const std::array<double, Dim>&)>& f) const {
    Share& share = engine_->share();
    const ListView<Dim> list = share.list();
    const BlockTable<Dim> table = share.table();
    const auto* position = share.particles.view().position;
    for (int b = 0; b < table.own; ++b)
        for (std::uint32_t k = list.first[b]; k < list.first[b + 1]; ++k) {
            const std::uint32_t s = list.slot[k];
            f(s, place_in<Real, Dim>(scene_, method_.stencil, table.position[b], position[s]));
        }
}

template <class Real, int Dim>
double Simulation<Real, Dim>::sum_of(const ExactSum& mine) const {
    const std::vector<ExactSum> all = comm_.all_gather(std::vector<ExactSum>{mine});
    ExactSum sum;
    for (const ExactSum& s : all) sum.add(s);
    return quantum().value(sum);
}

template <class Real, int Dim>
std::vector<StructureSums<Dim>> Simulation<Real, Dim>::sum_of(const std::vector<StructureSums<Dim>>& mine) const {
    const std::vector<StructureSums<Dim>> all = comm_.all_gather(mine);
    std::vector<StructureSums<Dim>> sums(mine.size());
    for (std::size_t k = 0; k < all.size(); ++k) sums[k % mine.size()].add(all[k]);
    return sums;
}

template <class Real, int Dim>
Totals<Dim> Simulation<Real, Dim>::totals() const {
    Share& share = engine_->share();
    const ListView<Dim> list = share.list();
    const BlockTable<Dim> table = share.table();
    const ParticleView<Real, Dim> p = share.particles.view();
    std::array<ExactSum, Totals<Dim>::sums> sums{};
    Totals<Dim> extremes;
    for (int b = 0; b < table.own; ++b) {
        Totals<Dim> block;
        for (std::uint32_t k = list.first[b]; k < list.first[b + 1]; ++k) {
            const std::uint32_t s = list.slot[k];
            add_particle<Real, Dim>(block, p, s,
                                    place_in<Real, Dim>(scene_, method_.stencil, table.position[b], p.position[s]),
                                    method_.law_of(p.body[s]));
        }
        const auto parts = block.additive();
        for (std::size_t q = 0; q < parts.size(); ++q) sums[q].add(quantum().of(parts[q]));
        extremes.widen(block);
    }
    std::array<double, Totals<Dim>::sums> whole{};
    for (std::size_t q = 0; q < sums.size(); ++q) whole[q] = sum_of(sums[q]);
    extremes.set_additive(whole);
    extremes.max_speed = comm_.max(extremes.max_speed);
    extremes.max_J = comm_.max(extremes.max_J);
    extremes.min_J = comm_.min(extremes.min_J);
    extremes.max_x = comm_.max(extremes.max_x);
    return extremes;
}

template <class Real, int Dim>
double Simulation<Real, Dim>::potential_energy(const Totals<Dim>& totals) const {
    double energy = 0;
    for (std::size_t a = 0; a < Dim; ++a)
        energy -= scene_.gravity[a] * (totals.centre[a] - totals.mass * scene_.min[a]);
    return energy;
}

template <class Real, int Dim>
std::vector<double> Simulation<Real, Dim>::column_volumes() const {
    const double cell_volume = std::pow(scene_.cell, Dim);
    const double quanta = std::ldexp(1.0, 30);  // per cell volume: 2^33 full cells fit in a column
    std::vector<std::int64_t> columns(static_cast<std::size_t>(domain_.nodes[0]) + 1, 0);
    const ParticleView<Real, Dim> p = engine_->share().particles.view();
    each_particle([&](std::uint32_t s, const std::array<double, Dim>& x) {
        const double at = std::floor((x[0] - scene_.min[0]) / scene_.cell);
        const auto column = static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(columns.size() - 1)));
        const double volume = static_cast<double>(p.volume[s]) / cell_volume;
        if (volume < 1e6) columns[column] += std::llround(volume * quanta);
    });
    comm_.sum(columns);
    std::vector<double> volumes;
    for (std::int64_t c : columns) volumes.push_back(static_cast<double>(c) / quanta * cell_volume);
    return volumes;
}

template <class Real, int Dim>
std::uint64_t Simulation<Real, Dim>::state_hash(bool with_lists) const {
    Share& share = engine_->share();
    const ListView<Dim> list = share.list();
    const std::vector<ColumnBytes> columns = share.particles.columns();
    std::uint64_t sum = 0;
    for (int b = 0; b < share.own(); ++b)
        for (std::uint32_t k = list.first[b]; k < list.first[b + 1]; ++k) {
            std::uint64_t h = mix(share.tables().own[static_cast<std::size_t>(b)]);
            if (with_lists) h = mix(h ^ (k - list.first[b]));
            for (const ColumnBytes& c : columns) h = mix_bytes(h, c.data + list.slot[k] * c.row_bytes, c.row_bytes);
            sum += h;
        }
    std::uint64_t all = 0;
    MPI_Allreduce(&sum, &all, 1, MPI_UINT64_T, MPI_SUM, comm_.handle());
    return all;
}

template <class Real, int Dim>
void Simulation<Real, Dim>::refresh_signal() {
    const ParticleView<Real, Dim> p = engine_->share().particles.view();
    double signal = 0;
    each_particle([&](std::uint32_t s, const std::array<double, Dim>&) {
        signal = std::max(signal, method_.law_of(p.body[s]).signal(p, s));
    });
    own_.signal = clock_.signal = comm_.max(signal);
}

template <class Real, int Dim>
void Simulation<Real, Dim>::conclude() {
    file();
    book();
    reduction_.start(own_);
    const Agreement all = reduction_.finish();
    if (all.faults) report_faults();
    clock_.signal = all.signal;
}

}  // namespace moraine
