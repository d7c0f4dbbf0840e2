#pragma once
// Who comes in during a run: releases with a start, and the layers of inflows (seeding/inflow.hpp).
//
// A row of a body comes in at the end of the first step that ends at its time or later. What has come in follows from
// the time of the run alone, so a restart needs no record of it, and from steps, which are the same on any ranks.

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

    static bool comes_later(const BodySpec& body) { return body.release_time > 0 || body.hydrograph; }
    /// Time of the next row [s]; infinite: all are in.
    double next() const { return next_; }
    /// What is due at this time has come in already.
    void skip_to(double time);
    /// Calls f(seeds) with the rows that are due, a part at a time, and counts them as in.
    template <class F>
    void take(double time, const F& f) {
        std::vector<Seed> seeds;
        for (Source& s : sources_) {
            for (; s.row < s.seeds.rows() && s.seeds.time_of(s.row) <= time; ++s.row) {
                s.seeds.fill_at(s.row, time, seeds);
                if (seeds.size() > 65536) f(seeds), seeds.clear();
            }
        }
        if (!seeds.empty()) f(seeds);
        find_next();
    }

  private:
    struct Source {
        BodySeeds seeds;
        std::int64_t row = 0;  ///< the next one
    };
    void find_next();

    std::vector<Source> sources_;
    double next_ = never;
};

}  // namespace moraine
