#pragma once
// Whether a run has come to rest, so that it may end before time.end (time.stop = "rest").
//
// At rest: in each of rest.intervals intervals in turn, rest.mass of the mass has moved less than rest.displacement
// cells. An interval ends with the first step that is rest_interval() or more after its beginning. What a particle has
// moved is how far it is from where it was then, not the way between: waves and FLIP's noise go to and fro. Who has
// left has moved.
//
// Followed are all particles up to 2^18, above that one of n, chosen by a hash of the ids. All ranks know where they
// were, in a table by id, and so come to one result; particles carry nothing, nothing travels but where an interval
// ends, and checkpoints keep the table. A column of particles would be moved in every step, and an exchange by owner
// would be a message for each particle that has gone elsewhere.

#include <cstdint>
#include <string>
#include <vector>

#include "simulation/simulation.hpp"

namespace moraine {

template <int Dim>
class RestWatch {
  public:
    /// Both must outlive it. Not collective.
    RestWatch(const Scene& scene, const Comm& comm) : scene_(scene), comm_(comm) {}

    /// Whether an interval ends now, or the first begins: none does while gravity changes. The same on all ranks.
    bool is_due(double time) const;
    /// From when on it is due [s].
    double next_look() const;
    /// Where that is so, ends the interval, if one has begun, and begins the next. Collective.
    template <class Real>
    void look(Simulation<Real, Dim>& sim);
    /// The same on all ranks.
    bool is_at_rest() const { return calm_ >= scene_.rest.intervals; }
    /// What the last interval told, for the user.
    std::string message() const;

    /// For a checkpoint; the same on all ranks. Empty: no interval has begun.
    std::vector<std::int64_t> stored() const;
    /// Returns whether `all` can be what stored() gave. Intervals by other thresholds do not count: it begins again.
    bool restore(const std::vector<std::int64_t>& all);

  private:
    /// A particle that is followed, at the beginning of the interval.
    struct Start {
        std::uint64_t id;
        double mass;                ///< [kg]
        std::array<double, Dim> x;  ///< [m]
    };

    template <class Real>
    void begin_next(const Simulation<Real, Dim>& sim);
    template <class Real>
    std::vector<Start> places(const Simulation<Real, Dim>& sim) const;
    double share_at_rest(const std::vector<Start>& now) const;
    bool has_moved(const Start& from, const Start& to) const;

    const Scene& scene_;
    const Comm& comm_;
    std::int64_t followed_ = 0;  ///< one particle of so many; 0: no interval has begun
    std::int64_t calm_ = 0;      ///< intervals in turn
    double begun_ = 0;           ///< this interval [s]
    double share_ = 0;           ///< of the mass that rested in the last one
    std::vector<Start> starts_;  ///< ids ascending
};

}  // namespace moraine
