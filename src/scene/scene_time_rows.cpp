// Keys of [time], [rest] and [sleep]: how far a step goes, when a run ends, and what rests meanwhile.
#include "scene/scene_keys.hpp"

namespace moraine {
namespace {

using enum KeyType;
using S = Scene;
using V = KeyValue;

const std::vector<KeyRow<Scene>> rows = in_tables<Scene>({
    {{.table = "time", .name = "end", .unit = "s", .range = from_zero, .meaning = "Simulated time."},
     [](S& s, const V& v) { s.end = v.real; }},
    {{.name = "cfl",
      .standard = "",
      .range = {0, 1.5, true, false},
      .meaning =
          "dt = cfl h / (c + |v|), the least over all particles; left out: 0.8 of what is stable with the method "
          "(docs/stability.md). Not together with dt."},
     [](S& s, const V& v) { s.cfl = v.real; }},
    {{.name = "dt", .unit = "s", .standard = "", .range = above_zero, .meaning = "Fixed time step, instead of cfl."},
     [](S& s, const V& v) { s.dt = v.real; }},

    {{.name = "stop",
      .type = choice,
      .standard = "\"end\"",
      .choices = {"end", "rest"},
      .meaning = "Rest: the run ends where nearly all has come to rest, by [rest], or at time.end if that is sooner."},
     [](S& s, const V& v) { s.rest.stops = v.choice == 1; }},

    {{.table = "rest",
      .name = "displacement",
      .unit = "cells",
      .standard = "0.05",
      .range = above_zero,
      .meaning = "What has moved less in an interval has rested."},
     [](S& s, const V& v) { s.rest.displacement = v.real; }},
    {{.name = "interval",
      .unit = "s",
      .standard = "",
      .range = above_zero,
      .meaning = "Simulated time, ended by a step; left out: twice (domain.cell / |gravity|)^(1/2)."},
     [](S& s, const V& v) { s.rest.interval = v.real; }},
    {{.name = "intervals",
      .type = integer,
      .standard = "3",
      .range = {1, 1e9},
      .meaning = "In turn, in each of which so much has rested."},
     [](S& s, const V& v) { s.rest.intervals = static_cast<int>(v.integer); }},
    {{.name = "mass",
      .standard = "0.999",
      .range = {0, 1, true, false},
      .meaning = "Share of the mass that must rest."},
     [](S& s, const V& v) { s.rest.mass = v.real; }},

    {{.table = "sleep",
      .name = "displacement",
      .unit = "cells",
      .standard = "0.005",
      .range = {1e-4, 0.5},
      .meaning = "A block falls asleep where it and its neighbours have moved less from one sleep check to the next. "
                 "Less is taken where a structure moves slowly: sleepers wake at a twentieth of its speed."},
     [](S& s, const V& v) { s.sleep.displacement = v.real; }},
    {{.name = "stress",
      .standard = "0.1",
      .range = above_zero,
      .meaning = "And where their mean and Mises stresses have changed by less than this share of a block's weight on "
                 "its face, density |gravity| 4 domain.cell."},
     [](S& s, const V& v) { s.sleep.stress = v.real; }},
    {{.name = "interval",
      .unit = "s",
      .standard = "",
      .range = above_zero,
      .meaning = "Simulated time between sleep checks, ended by a step, of 16 steps at least; left out: "
                 "(domain.cell / |gravity|)^(1/2)."},
     [](S& s, const V& v) { s.sleep.interval = v.real; }},
    {{.name = "wake",
      .standard = "2.0",
      .range = {1, 1e6},
      .meaning = "A sleeper wakes where neighbours exceed these thresholds so many times, or one of its nodes is as "
                 "many times faster than displacement over interval."},
     [](S& s, const V& v) { s.sleep.wake = v.real; }},
});

}  // namespace

const std::vector<KeyRow<Scene>>& time_rows() {
    return rows;
}

}  // namespace moraine
