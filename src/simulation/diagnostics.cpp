#include "simulation/diagnostics.hpp"

#include <algorithm>
#include <cmath>

#include "core/data/hash.hpp"
#include "core/material/laws.hpp"

namespace moraine {

namespace {

/// By body: whether its material is nearly incompressible.
std::vector<std::uint8_t> bodies_that_keep_volume(const Scene& scene) {
    std::vector<std::uint8_t> keeps;
    for (const BodySpec& b : scene.bodies) {
        const MaterialSpec& m = scene.materials[static_cast<std::size_t>(b.material)];
        keeps.push_back(find_law(m.law)->is_nearly_incompressible(m.parameters.data()));
    }
    return keeps;
}

/// Of one block, in list order.
template <class Real, int Dim>
Totals<Dim> block_totals(const Simulation<Real, Dim>& sim, const SharePiece<Real, Dim>& piece, int block,
                         const std::vector<std::uint8_t>& keeps_volume) {
    Totals<Dim> sums;
    for (std::uint32_t s : piece.slots(block)) {
        const std::uint16_t body = piece.p.body[s];
        add_particle<Real, Dim>(sums, piece.p, s, place_of(sim, piece, block, s), sim.method().law_of(body),
                                keeps_volume[body] != 0);
        if (const PoreWater<Real>* pores = sim.method().pores()) add_water<Real, Dim>(sums, piece.p, s, pores[body]);
    }
    return sums;
}

}  // namespace

template <class Real, int Dim>
TotalSums<Dim> share_totals(const Simulation<Real, Dim>& sim) {
    const Quantum quantum = sim.quantum();
    const std::vector<std::uint8_t> keeps_volume = bodies_that_keep_volume(sim.scene());
    TotalSums<Dim> sums;
    sim.each_piece({}, [&](const SharePiece<Real, Dim>& piece) {
#pragma omp parallel
        {
            TotalSums<Dim> mine;
#pragma omp for schedule(dynamic, 64) nowait
            for (int b = piece.begin; b < piece.end; ++b) {
                const Totals<Dim> block = block_totals(sim, piece, b, keeps_volume);
                const auto parts = block.additive();
                for (std::size_t q = 0; q < parts.size(); ++q) mine.sum[q].add(quantum.of(parts[q]));
                mine.extremes.widen(block);
            }
#pragma omp critical
            sums.add(mine);
        }
    });
    return sums;
}

template <int Dim>
double potential_energy(const Scene& scene, const std::type_identity_t<std::array<double, Dim>>& gravity,
                        const Totals<Dim>& totals) {
    double energy = 0;
    for (std::size_t a = 0; a < Dim; ++a) energy -= gravity[a] * (totals.centre[a] - totals.mass * scene.min[a]);
    return energy;
}

template <class Real, int Dim>
std::vector<double> column_volumes(const Simulation<Real, Dim>& sim) {
    const Scene& scene = sim.scene();
    const double cell_volume = std::pow(scene.cell, Dim);
    const double quanta = std::ldexp(1.0, 30);  // per cell volume: 2^33 full cells fit in a column
    std::vector<std::int64_t> columns(static_cast<std::size_t>(DomainBlocks<Dim>(scene).nodes[0]) + 1, 0);
    const auto add = [&](std::vector<std::int64_t>& to, double x, double volume) {
        const double at = std::floor((x - scene.min[0]) / scene.cell);
        const auto column = static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(to.size() - 1)));
        if (volume / cell_volume < 1e6) to[column] += std::llround(volume / cell_volume * quanta);
    };
    sim.each_piece({"position", "volume"}, [&](const SharePiece<Real, Dim>& piece) {
#pragma omp parallel
        {
            std::vector<std::int64_t> mine(columns.size(), 0);
#pragma omp for schedule(dynamic, 64) nowait
            for (int b = piece.begin; b < piece.end; ++b)
                for (std::uint32_t s : piece.slots(b))
                    add(mine, place_of(sim, piece, b, s)[0], static_cast<double>(piece.p.volume[s]));
#pragma omp critical
            for (std::size_t c = 0; c < columns.size(); ++c) columns[c] += mine[c];
        }
    });
    sim.comm().sum(columns);
    std::vector<double> volumes;
    for (std::int64_t c : columns) volumes.push_back(static_cast<double>(c) / quanta * cell_volume);
    return volumes;
}

std::uint64_t row_hash(Key key, const std::vector<ColumnBytes>& columns, std::uint32_t slot,
                       std::optional<std::uint64_t> place) {
    std::uint64_t h = mix(key);
    if (place) h = mix(h ^ *place);
    for (const ColumnBytes& c : columns) h = mix_bytes(h, c.data + slot * c.row_bytes, c.row_bytes);
    return h;
}

template <class Real, int Dim>
std::uint64_t state_hash(const Simulation<Real, Dim>& sim, bool with_lists) {
    std::uint64_t sum = 0;
    sim.each_piece({}, [&](const SharePiece<Real, Dim>& piece) {
#pragma omp parallel for schedule(dynamic, 64) reduction(+ : sum)
        for (int b = piece.begin; b < piece.end; ++b) {
            std::uint64_t place = 0;
            for (std::uint32_t s : piece.slots(b)) {
                const Key key = piece.tables.own[static_cast<std::size_t>(b)];
                sum += row_hash(key, piece.columns, s, with_lists ? std::optional(place++) : std::nullopt);
            }
        }
    });
    return sim.comm().sum(sum);
}

template double potential_energy<2>(const Scene&, const std::array<double, 2>&, const Totals<2>&);
template double potential_energy<3>(const Scene&, const std::array<double, 3>&, const Totals<3>&);

/// Of one precision and dimension.
#define MORAINE_DIAGNOSTICS(Real, Dim)                                         \
    template TotalSums<Dim> share_totals(const Simulation<Real, Dim>&);        \
    template std::vector<double> column_volumes(const Simulation<Real, Dim>&); \
    template std::uint64_t state_hash(const Simulation<Real, Dim>&, bool);
MORAINE_DIAGNOSTICS(float, 2)
MORAINE_DIAGNOSTICS(float, 3)
MORAINE_DIAGNOSTICS(double, 2)
MORAINE_DIAGNOSTICS(double, 3)

}  // namespace moraine
