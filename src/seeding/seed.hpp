#pragma once
// Bodies to particles. A particle's id, place, mass and velocity depend on the scene alone, so any rank
// can make any part of a body: ranks take rows of it, count them, add up, and fill.
//
//   id = body << 48 | position in the body's lattice (or table)
//   volume = exact volume of the body / its particles,  mass = density volume
//   jitter: x += spacing * jitter * u, u in [-1, 1) from a hash of (seed, id, axis); a particle that
//   would leave its body stays on the lattice
//
// A row is a plane of the lattice across its last axis (2-D: a line), a line along x of a layer's columns
// (seeding/seed_layer.hpp, which says what volumes they have), a particle of a table, or a layer of an inflow
// (seeding/inflow.hpp) when it comes in.
// In 2-D all is per metre of thickness.

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/scene_spec.hpp"
#include "seeding/inflow.hpp"
#include "seeding/seed_layer.hpp"
#include "seeding/seed_region.hpp"
#include "seeding/seed_table.hpp"

namespace moraine {

struct Seed {
    std::uint64_t id;
    int body;
    Triple x;         ///< [m]
    double mass;      ///< [kg]
    double volume;    ///< [m3]
    Triple velocity;  ///< at the start: of the body, its wave and its table [m/s]
};

/// Velocity of a body's particle at x at the start, that of its table left out [m/s].
Triple start_velocity(const BodySpec& body, const Triple& x);

/// Makes the particles of one body; a table is read once, by the constructor. Nothing is collective.
class BodySeeds {
  public:
    /// The scene must outlive it. Throws InputError if the table is bad.
    BodySeeds(const Scene& scene, int body);

    std::int64_t rows() const;
    /// Particles in rows [first, last).
    std::int64_t count(std::int64_t first, std::int64_t last) const;
    /// Appends the particles of rows [first, last); `total` is the count of all rows.
    void fill(std::int64_t first, std::int64_t last, std::int64_t total, std::vector<Seed>& out) const;

    /// When a row comes in [s]; 0: it is there from the start. Rows do so in order.
    double time_of(std::int64_t row) const { return inflow_ ? inflow_->time(row) : body_.release_time; }
    /// Appends the particles of a row at the end of the step in which it comes in [s]; `total` as in fill().
    void fill_at(std::int64_t row, double time, std::int64_t total, std::vector<Seed>& out) const;

  private:
    template <class F>
    void each_point(std::int64_t first, std::int64_t last, const F& f) const;
    double mass_of(double volume, const Triple& x) const;
    Seed table_seed(std::int64_t row) const;
    Triple jittered(std::uint64_t id, const Triple& x) const;

    const Scene& scene_;
    const BodySpec& body_;
    int index_;
    Lattice lattice_;
    ParticleTable table_;
    std::optional<Layer> layer_;
    std::optional<Inflow> inflow_;
};

inline std::int64_t seed_rows(const Scene& scene, int body) {
    return BodySeeds(scene, body).rows();
}

inline std::int64_t seed_count(const Scene& scene, int body, std::int64_t first_row, std::int64_t last_row) {
    return BodySeeds(scene, body).count(first_row, last_row);
}

inline void seed_body(const Scene& scene, int body, std::int64_t first_row, std::int64_t last_row, std::int64_t total,
                      std::vector<Seed>& out) {
    BodySeeds(scene, body).fill(first_row, last_row, total, out);
}

}  // namespace moraine
