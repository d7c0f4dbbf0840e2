// What the records, checkpoints and tests ask of a simulation in the binned state.

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

/// Of one block, in list order.
template <class Real, int Dim>
Totals<Dim> Simulation<Real, Dim>::totals_of(const SharePiece<Real, Dim>& piece, int block) const {
    Totals<Dim> sums;
    for (std::uint32_t s : piece.slots(block))
        add_particle<Real, Dim>(sums, piece.p, s, place_of(piece, block, s), method_.law_of(piece.p.body[s]));
    return sums;
}

template <class Real, int Dim>
Totals<Dim> Simulation<Real, Dim>::totals() const {
    std::array<ExactSum, Totals<Dim>::sums> sums{};
    Totals<Dim> extremes;
    each_piece({}, [&](const SharePiece<Real, Dim>& piece) {
#pragma omp parallel
        {
            std::array<ExactSum, Totals<Dim>::sums> mine{};
            Totals<Dim> widest;
#pragma omp for schedule(dynamic, 64) nowait
            for (int b = piece.begin; b < piece.end; ++b) {
                const Totals<Dim> block = totals_of(piece, b);
                const auto parts = block.additive();
                for (std::size_t q = 0; q < parts.size(); ++q) mine[q].add(quantum().of(parts[q]));
                widest.widen(block);
            }
#pragma omp critical
            {
                for (std::size_t q = 0; q < sums.size(); ++q) sums[q].add(mine[q]);
                extremes.widen(widest);
            }
        }
    });
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
    const auto add = [&](std::vector<std::int64_t>& to, double x, double volume) {
        const double at = std::floor((x - scene_.min[0]) / scene_.cell);
        const auto column = static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(to.size() - 1)));
        if (volume / cell_volume < 1e6) to[column] += std::llround(volume / cell_volume * quanta);
    };
    each_piece({"position", "volume"}, [&](const SharePiece<Real, Dim>& piece) {
#pragma omp parallel
        {
            std::vector<std::int64_t> mine(columns.size(), 0);
#pragma omp for schedule(dynamic, 64) nowait
            for (int b = piece.begin; b < piece.end; ++b)
                for (std::uint32_t s : piece.slots(b))
                    add(mine, place_of(piece, b, s)[0], static_cast<double>(piece.p.volume[s]));
#pragma omp critical
            for (std::size_t c = 0; c < columns.size(); ++c) columns[c] += mine[c];
        }
    });
    comm_.sum(columns);
    std::vector<double> volumes;
    for (std::int64_t c : columns) volumes.push_back(static_cast<double>(c) / quanta * cell_volume);
    return volumes;
}

template <class Real, int Dim>
std::uint64_t Simulation<Real, Dim>::state_hash(bool with_lists) const {
    std::uint64_t sum = 0;
    each_piece({}, [&](const SharePiece<Real, Dim>& piece) {
#pragma omp parallel for schedule(dynamic, 64) reduction(+ : sum)
        for (int b = piece.begin; b < piece.end; ++b) {
            std::uint64_t place = 0;
            for (std::uint32_t s : piece.slots(b)) {
                std::uint64_t h = mix(piece.tables.own[static_cast<std::size_t>(b)]);
                if (with_lists) h = mix(h ^ place++);
                for (const ColumnBytes& c : piece.columns) h = mix_bytes(h, c.data + s * c.row_bytes, c.row_bytes);
                sum += h;
            }
        }
    });
    std::uint64_t all = 0;
    MPI_Allreduce(&sum, &all, 1, MPI_UINT64_T, MPI_SUM, comm_.handle());
    return all;
}

template <class Real, int Dim>
void Simulation<Real, Dim>::refresh_signal() {
    double signal = 0;
    each_piece({}, [&](const SharePiece<Real, Dim>& piece) {
        const std::span<const std::uint32_t> slots = piece.slots();
#pragma omp parallel for schedule(static) reduction(max : signal)
        for (std::size_t k = 0; k < slots.size(); ++k)
            signal = std::max(signal, method_.law_of(piece.p.body[slots[k]]).signal(piece.p, slots[k]));
    });
    own_.signal = clock_.signal = comm_.max(signal);
}

template <class Real, int Dim>
void Simulation<Real, Dim>::conclude() {
    bin();
    record_step();
    reduction_.start(own_);
    const Agreement all = reduction_.finish();
    if (all.faults) report_faults();
    clock_.signal = all.signal;
}

}  // namespace moraine
