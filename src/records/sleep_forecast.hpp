#pragma once
// Which blocks of a run in which all are awake would sleep by the rule of core/sleep/sleep.hpp, for `moraine replay
// --sleep`.
//
// The rule wants places and stresses of the last sleep check. Scenes that sleep carry them with the particles; here
// they are kept by id beside the run, so that its state, hash and checkpoints are those without a record. Of particles
// that changed ranks they follow by messages; so the answer is the same on any ranks.
//
// It is a forecast: checks are at the first balance interval at which one is due, sleepers wake at balance intervals
// and not in the step, and those that would sleep go on to move a little. A restart knows nobody at first.

#include <vector>

#include "core/sleep/scene_sleep.hpp"
#include "core/sleep/sleep_contact.hpp"
#include "scene/scene_check.hpp"
#include "simulation/simulation.hpp"

namespace moraine {

template <class Real, int Dim>
class SleepForecast {
  public:
    /// Both must outlive it. Not collective.
    SleepForecast(const Scene& scene, const Comm& comm) : comm_(comm), rule_(sleep_rule(scene)), domain_(scene) {}

    /// Keys of the blocks that would sleep now, ascending; the same on all ranks. Binned state, host. Collective.
    const std::vector<Key>& look(const Simulation<Real, Dim>& sim);

  private:
    /// A particle at the last check.
    struct Rest {
        std::uint64_t id, place, stress;
        bool operator<(const Rest& other) const { return id < other.id; }
    };
    struct Activity {
        Key key;
        double u;      ///< of core/sleep/sleep.hpp
        double speed;  ///< the part of u that is of speeds alone
        bool stays;    ///< asleep, and neither its speeds nor a structure wake it: its u is 0
    };
    using Activities = std::vector<Activity>;

    bool is_due(const RunClock<Dim>& clock) const;
    std::vector<Rest> rests_of(const Simulation<Real, Dim>& sim) const;
    void learn(const std::vector<Rest>& now);
    Activities activities(const Simulation<Real, Dim>& sim, bool due) const;
    double activity_around(const Activities& all, Key key) const;

    const Comm& comm_;
    const SleepRule rule_;
    const DomainBlocks<Dim> domain_;
    std::vector<Rest> rests_;  ///< of this rank's particles, by id
    std::vector<Key> asleep_;
    double time_ = 0;         ///< of the last check [s]
    std::int64_t step_ = -1;  ///< likewise; -1: none yet
};

}  // namespace moraine
