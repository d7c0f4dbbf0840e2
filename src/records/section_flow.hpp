#pragma once
// sections.csv: what flows over lines in plan, by the ways of the particles between two samples.
//
//   V = sum over crossings of +-V_p,   + to the left of the line;   discharge = change of V over time from row to row
//
// A particle crosses where its way from one sample to the next, a segment, crosses one of the line's. On which side a
// point lies is decided by one formula, with what is on a line counted to its left, so a way through a corner or to a
// line and back is counted once, or twice with opposite signs. Samples are those of the maps, in which nothing goes
// much more than half a map cell: places are remembered of particles nearer to a line than two. One that changes its
// rank meanwhile is asked for by its id, and the sums are of whole numbers: one answer on any ranks. A checkpoint keeps
// sums and places.

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "simulation/simulation.hpp"

namespace moraine {

/// The number of times that the way from p to q goes over the line to its left, less those to its right.
int crossings(const std::vector<std::array<double, 2>>& line, const std::array<double, 2>& p,
              const std::array<double, 2>& q);

class SectionFlow {
  public:
    /// comm and scene must outlive it.
    SectionFlow(const Scene& scene, const Comm& comm);

    /// Takes a sample. Binned state only. Collective.
    template <class Real>
    void sample(const Simulation<Real, 3>& sim);

    /// sections.csv: step, time, and of each section discharge, and volume and mass since the start.
    std::vector<std::string> columns() const;
    const std::vector<double>& values() const { return values_; }  ///< at the last sample, behind step and time

    /// For a checkpoint; the same on all ranks. Collective.
    std::vector<std::int64_t> stored() const;
    /// Returns whether `all` can be what stored() gave in such a scene.
    bool restore(const std::vector<std::int64_t>& all);

  private:
    using InPlan = std::array<double, 2>;
    struct Seen {
        std::uint64_t id;
        InPlan x;
    };
    struct Moved {
        Seen now;
        double volume, mass;
    };

    /// The image of `from` from which the way to `to` is the shorter one.
    InPlan start_of_way(InPlan from, const InPlan& to) const;
    template <class Real>
    std::vector<Moved> near_particles(const Simulation<Real, 3>& sim) const;
    /// Where those that were seen before, here or by another rank, were; sorted by id. Collective.
    std::vector<Seen> seen_before(const std::vector<Moved>& now) const;

    const Scene& scene_;
    const Comm& comm_;
    double volume_unit_ = 1, mass_unit_ = 1;
    std::vector<std::array<std::int64_t, 2>> sums_;  ///< volume and mass, of each section
    double time_ = -1;                               ///< of the last sample [s]; negative: none
    std::vector<PlanSegment> segments_;              ///< of all sections
    std::vector<Seen> seen_;                         ///< near a section at the last sample, on this rank; by id
    std::vector<double> values_;
};

}  // namespace moraine
