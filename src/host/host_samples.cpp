#include "host/host_samples.hpp"

#include <algorithm>

#include "core/data/gravity_work.hpp"

namespace moraine {

template <class Real, int Dim>
void find_samples(Patch<Host, Real, Dim>& patch, LayerQuery& query) {
    if constexpr (Dim == 3) {
        const PlanColumns& columns = query.columns;
        const ListView<Dim> list = patch.list();
        const ParticleView<Real, Dim> p = patch.particles.view();
        const std::vector<Vec<std::int32_t, Dim>>& position = patch.tables().position;
        Layers* const all = query.layers.data();
#pragma omp parallel for schedule(dynamic, 64)
        for (int b = 0; b < patch.own(); ++b) {
            const Vec<std::int32_t, Dim>& at = position[static_cast<std::size_t>(b)];
            for (std::uint32_t k = list.first[b]; k < list.first[b + 1]; ++k) {
                const std::uint32_t s = list.slot[k];
                const std::size_t column =
                    columns.column(columns.along(0, columns.places.of<Real>(0, at[0], p.position[s][0])),
                                   columns.along(1, columns.places.of<Real>(1, at[1], p.position[s][1])));
                const Layers layer = columns.layer(column, columns.places.of<Real>(2, at[2], p.position[s][2]));
#pragma omp atomic
                all[column] |= layer;
            }
        }
    }
}

template <class Real, int Dim>
void find_samples(Patch<Host, Real, Dim>& patch, ColumnQuery& query) {
    if constexpr (Dim == 3) {
        const PlanColumns& columns = query.columns;
        double fastest = 0;
        const ListView<Dim> list = patch.list();
        const ParticleView<Real, Dim> p = patch.particles.view();
        const std::vector<Vec<std::int32_t, Dim>>& position = patch.tables().position;
        std::int64_t* const all = query.sums.data();
#pragma omp parallel for schedule(dynamic, 64) reduction(max : fastest)
        for (int b = 0; b < patch.own(); ++b) {
            const Vec<std::int32_t, Dim>& at = position[static_cast<std::size_t>(b)];
            for (std::uint32_t k = list.first[b]; k < list.first[b + 1]; ++k) {
                const std::uint32_t s = list.slot[k];
                const std::int64_t i = columns.along(0, columns.places.of<Real>(0, at[0], p.position[s][0]));
                const std::int64_t j = columns.along(1, columns.places.of<Real>(1, at[1], p.position[s][1]));
                fastest = std::max(fastest, PlanColumns::square_of(p.velocity[s]));
                const double z = columns.places.of<Real>(2, at[2], p.position[s][2]);
                if (!columns.is_summed(columns.column(i, j), z)) continue;
                std::int64_t* const to = all + columns.place(i, j);
                columns.add_particle<Real>(static_cast<double>(p.volume[s]), static_cast<double>(p.mass[s]),
                                           p.velocity[s], [&](int q, std::int64_t whole) {
#pragma omp atomic
                                               to[q] += whole;
                                           });
            }
        }
        query.square_speed = fastest;
    }
}

template <class Real, int Dim>
void find_samples(Patch<Host, Real, Dim>& patch, LineQuery& query) {
    const PlanLines& lines = query.lines;
    query.near.clear();
    const ListView<Dim> list = patch.list();
    const ParticleView<Real, Dim> p = patch.particles.view();
    for (int b = 0; b < patch.own(); ++b) {
        const Vec<std::int32_t, Dim>& at = patch.tables().position[static_cast<std::size_t>(b)];
        if (list.count(b) == 0 || !lines.is_near_block(at)) continue;
        for (std::uint32_t k = list.first[b]; k < list.first[b + 1]; ++k) {
            const std::uint32_t s = list.slot[k];
            const double x = lines.places.of<Real>(0, at[0], p.position[s][0]);
            const double y = lines.places.of<Real>(1, at[1], p.position[s][1]);
            if (lines.is_near(x, y, lines.reach))
                query.near.push_back(
                    {p.id[s], {x, y}, static_cast<double>(p.volume[s]), static_cast<double>(p.mass[s])});
        }
    }
}

template <class Real, int Dim>
void find_samples(Patch<Host, Real, Dim>& patch, GravityQuery<Dim>& query) {
    const ListView<Dim> list = patch.list();
    const ParticleView<Real, Dim> p = patch.particles.view();
    const std::vector<Vec<std::int32_t, Dim>>& position = patch.tables().position;
    double change[Dim];
    std::copy_n(query.change.begin(), Dim, change);
    query.work = {};
#pragma omp parallel
    {
        ExactSum mine;
#pragma omp for schedule(dynamic, 64) nowait
        for (int b = 0; b < patch.own(); ++b)
            for (std::uint32_t k = list.first[b]; k < list.first[b + 1]; ++k) {
                const std::uint32_t s = list.slot[k];
                const auto u = [&](int a) { return p.position[s][a]; };
                mine.add(query.quantum.of(gravity_work<Real>(
                    query.places, change, position[static_cast<std::size_t>(b)], u, static_cast<double>(p.mass[s]))));
            }
#pragma omp critical
        query.work.add(mine);
    }
}

/// Of one precision and dimension.
#define MORAINE_SAMPLES(Real, Dim)                                     \
    template void find_samples(Patch<Host, Real, Dim>&, LayerQuery&);  \
    template void find_samples(Patch<Host, Real, Dim>&, ColumnQuery&); \
    template void find_samples(Patch<Host, Real, Dim>&, LineQuery&);   \
    template void find_samples(Patch<Host, Real, Dim>&, GravityQuery<Dim>&);
MORAINE_SAMPLES(float, 2)
MORAINE_SAMPLES(float, 3)
MORAINE_SAMPLES(double, 2)
MORAINE_SAMPLES(double, 3)

}  // namespace moraine
