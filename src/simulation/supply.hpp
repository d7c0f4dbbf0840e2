#pragma once
// Who comes in during a run: releases with a start, the layers of inflows (seeding/inflow.hpp), and bodies of stages.
//
// A row of a body comes in at the end of the first step that ends at its time or later; of a stage's, as it begins.
// What has come in follows from the time and the stages of the run alone, so a restart needs no record of it, and from
// steps, which are the same on any ranks.

#include <cstdint>
#include <limits>
#include <vector>

#include "seeding/seed.hpp"

namespace moraine {

class Supply {
  public:
    static constexpr double never = std::numeric_limits<double>::infinity();

    /// The scene must outlive it.
    explicit Supply(const Scene& scene);

    static bool comes_later(const BodySpec& body) { return body.release_time > 0 || body.hydrograph || body.stage > 0; }
    /// Time of the next row [s]; infinite: all are in.
    double next() const { return next_; }
    /// What is due at this time has come in already, but for bodies of stages that have not begun.
    void skip_to(double time);
    /// The bodies of this stage are due.
    void begin_stage(int stage);
    /// Calls f(seeds) with the rows that are due, a part at a time, and counts them as in.
    template <class F>
    void take(double time, const F& f) {
        std::vector<Seed> seeds;
        for (Source& s : sources_) {
            for (; s.row < s.seeds.rows() && time_of(s) <= time; ++s.row) {
                s.seeds.fill_at(s.row, time, s.total, seeds);
                if (seeds.size() > 65536) f(seeds), seeds.clear();
            }
        }
        if (!seeds.empty()) f(seeds);
        find_next();
    }

  private:
    struct Source {
        BodySeeds seeds;
        int stage = 0;         ///< that it waits for; 0: none
        std::int64_t total;    ///< particles of a body of a stage
        std::int64_t row = 0;  ///< the next one
    };
    static double time_of(const Source& s) { return s.stage > 0 ? never : s.seeds.time_of(s.row); }
    void find_next();

    std::vector<Source> sources_;
    double next_ = never;
};

}  // namespace moraine
