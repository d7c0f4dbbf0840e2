#include "seeding/seed.hpp"

#include <cmath>
#include <numbers>

#include "core/data/hash.hpp"
#include "seeding/property_profile.hpp"

namespace moraine {
namespace {

/// Uniform in [-1, 1).
double uniform(std::uint64_t seed, std::uint64_t id, std::uint64_t axis) {
    const std::uint64_t bits = mix(mix(mix(seed) ^ id) + axis);
    return std::ldexp(static_cast<double>(bits >> 11), -52) - 1;
}

}  // namespace

Triple start_velocity(const BodySpec& body, const Triple& x) {
    Triple v = body.velocity;
    const WaveSpec& wave = body.wave;
    if (!(wave.wavelength > 0)) return v;
    const double phase = (x[static_cast<std::size_t>(wave.axis)] - wave.origin) / wave.wavelength;
    for (std::size_t a = 0; a < 3; ++a) v[a] += wave.velocity[a] * std::sin(2 * std::numbers::pi * phase);
    return v;
}

BodySeeds::BodySeeds(const Scene& scene, int body)
    : scene_(scene), body_(scene.bodies[static_cast<std::size_t>(body)]), index_(body) {
    if (body_.shape == BodyShape::table)
        table_ = read_particle_table(scene, body_);
    else if (body_.shape == BodyShape::layer)
        layer_.emplace(scene, body_);
    else if (body_.shape == BodyShape::inflow)
        inflow_.emplace(scene, body_);
    else
        lattice_ = lattice_of(scene, body_);
}

std::int64_t BodySeeds::rows() const {
    if (body_.shape == BodyShape::table) return static_cast<std::int64_t>(table_.x.size());
    if (layer_) return layer_->rows();
    if (inflow_) return inflow_->layers();
    return lattice_.count[static_cast<std::size_t>(scene_.dimensions - 1)];
}

/// Calls f(lattice index, place) for the lattice points of rows [first, last) that are in the body.
template <class F>
void BodySeeds::each_point(std::int64_t first, std::int64_t last, const F& f) const {
    const bool flat = scene_.dimensions == 2;
    const auto& n = lattice_.count;
    for (std::int64_t k = flat ? 0 : first; k < (flat ? 1 : last); ++k)
        for (std::int64_t j = flat ? first : 0; j < (flat ? last : n[1]); ++j)
            for (std::int64_t i = 0; i < n[0]; ++i) {
                const Triple x{lattice_.place(0, i), lattice_.place(1, j), flat ? 0 : lattice_.place(2, k)};
                if (body_.shape != BodyShape::box && !is_inside(body_, scene_.dimensions, x)) continue;
                f(i + n[0] * (j + n[1] * k), x);
            }
}

std::int64_t BodySeeds::count(std::int64_t first, std::int64_t last) const {
    if (body_.shape == BodyShape::table) return last - first;
    if (layer_) return layer_->count(first, last);
    if (inflow_) return inflow_->count(first, last);
    if (body_.shape == BodyShape::box)
        return (last - first) * lattice_.count[0] * (scene_.dimensions == 2 ? 1 : lattice_.count[1]);
    std::int64_t sum = 0;
    each_point(first, last, [&](std::int64_t, const Triple&) { ++sum; });
    return sum;
}

void BodySeeds::fill(std::int64_t first, std::int64_t last, std::int64_t total, std::vector<Seed>& out) const {
    if (body_.shape == BodyShape::table) {
        for (std::int64_t r = first; r < last; ++r) out.push_back(table_seed(r));
        return;
    }
    if (inflow_) {
        for (std::int64_t row = first; row < last; ++row) fill_at(row, inflow_->time(row), 0, out);
        return;
    }
    const std::uint64_t base = static_cast<std::uint64_t>(index_) << 48;
    if (layer_) {
        layer_->each(first, last, [&](std::int64_t point, const Triple& x, double volume) {
            const std::uint64_t id = base | static_cast<std::uint64_t>(point);
            out.push_back({id, index_, x, mass_of(volume, x), volume, start_velocity(body_, x)});
        });
        return;
    }
    const double volume = measure_of(body_, scene_.dimensions) / static_cast<double>(total);
    each_point(first, last, [&](std::int64_t point, const Triple& lattice_x) {
        const std::uint64_t id = base | static_cast<std::uint64_t>(point);
        const Triple x = body_.seeding == Seeding::jittered ? jittered(id, lattice_x) : lattice_x;
        out.push_back({id, index_, x, mass_of(volume, x), volume, start_velocity(body_, x)});
    });
}

void BodySeeds::fill_at(std::int64_t row, double time, std::int64_t total, std::vector<Seed>& out) const {
    if (!inflow_) return fill(row, row + 1, total, out);
    const std::uint64_t base = static_cast<std::uint64_t>(index_) << 48;
    inflow_->each(row, time, [&](std::int64_t number, const Triple& x, double volume, const Triple& velocity) {
        out.push_back({base | static_cast<std::uint64_t>(number), index_, x, mass_of(volume, x), volume, velocity});
    });
}

double BodySeeds::mass_of(double volume, const Triple& x) const {
    return density_at(scene_, body_, x) * volume;
}

Seed BodySeeds::table_seed(std::int64_t row) const {
    const auto r = static_cast<std::size_t>(row);
    double volume = 1;
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene_.dimensions); ++a)
        volume *= scene_.cell / body_.particles_per_cell[a];
    if (!table_.mass.empty()) volume = table_.mass[r] / density_at(scene_, body_, table_.x[r]);
    Triple velocity = start_velocity(body_, table_.x[r]);
    for (std::size_t a = 0; a < 3; ++a) velocity[a] += table_.velocity[r][a];
    const std::uint64_t id = static_cast<std::uint64_t>(index_) << 48 | static_cast<std::uint64_t>(row);
    return {id, index_, table_.x[r], mass_of(volume, table_.x[r]), volume, velocity};
}

Triple BodySeeds::jittered(std::uint64_t id, const Triple& x) const {
    Triple moved = x;
    for (std::size_t a = 0; a < static_cast<std::size_t>(scene_.dimensions); ++a)
        moved[a] += body_.jitter * lattice_.spacing[a] * uniform(scene_.seed, id, a);
    return is_inside(body_, scene_.dimensions, moved) ? moved : x;
}

}  // namespace moraine
