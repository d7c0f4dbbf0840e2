"""Debris in a flume of 31 degrees, beside an experiment of the U.S. Geological Survey

10 m3 on 25 May 2017 (`inputs/debris_flume.toml`, plane strain), to 14 s; a level is the number of cells in a metre.

* Measured: thickness normal to the bed over time since the gate began to open (Iverson and Obryk 2019, doi 10.5066/P9NAFXW7), 2.5, 31.7, 65.4 and 80 m down
  the bed. Arrival: first time above 0.02 m; at 65.4 and 80 m the flow behind the first grains came 0.6 and 0.25 s later. SECOND is that of 24 May, with 8 m3.
* Computed: mass within a quarter of a metre up and down the bed over density and length, at outputs 0.1 s apart, between which the time of arrival is linear.
* Variants: friction and xi of Voellmy's law from the literature: 0.1 and 500 m/s2 (Hungr and Evans 1996, rock avalanches), and 0.2 and 200 m/s2, in the
  middle of what the manual of RAMMS gives for debris flows. Nothing is fitted.
"""
import math

import numpy

import norms
from sheet import Plot, Row

SCENE, MATERIAL = "debris_flume", "debris"
LEVELS = {"cpu": [10, 15, 20], "cuda": [10, 15, 20, 30, 40]}
RUNG = "1 m/{}"
VARIANTS = {"hungr-evans": [], "ramms": ["terrain.contact.friction=0.2", "terrain.contact.xi=200"]}
STATIONS = (2.5, 31.7, 65.4, 80.0)  # [m] down the bed from the foot of the gate
ARRIVED, PEAK = (0.987, 4.116, 7.822, 10.970), (0.360, 0.283, 0.341, 0.168)  # [s], [m]
SECOND = (0.833, 3.906, 7.573, 10.092), (0.359, 0.166, 0.136, 0.420)
DEPTH, WINDOW, DENSITY = 0.02, 0.5, 2090.0  # [m], [m], [kg/m3]


def sets(level):
    return [f"domain.cell={1 / level!r}", 'output.fields=["velocity","mass"]']


def along(x):
    """Way down the bed [m] of horizontal places from the gate on: slope, catenary to 4 degrees in 8.5 m, pad."""
    steep, end, pad = (math.tan(math.radians(angle)) for angle in (31.0, 4.0, 2.4))
    bend = 74 * math.cos(math.atan(steep))
    scale = 8.5 / (math.asinh(steep) - math.asinh(end))
    low = bend + scale * math.asinh(steep)
    flat = low - scale * math.asinh(pad)
    curved = 74 + scale * (steep - numpy.sinh((low - numpy.clip(x, bend, flat)) / scale))
    return numpy.where(x <= bend, x * math.hypot(1, steep), curved + numpy.maximum(x - flat, 0) * math.hypot(1, pad))


def measure(level_run):
    series = level_run.particles()
    thick, fronts = [], []
    for k, time in enumerate(series.times):
        s, mass = along(series.at(time)[:, 0]), series.read("PointData/mass", series.starts[k], series.ends[k])
        thick.append([mass[abs(s - station) < WINDOW / 2].sum() / DENSITY / WINDOW for station in STATIONS])
        fronts.append(numpy.sort(s)[int(0.995 * len(s))])
    thick, figures, curves = numpy.array(thick), {}, {"front": (series.times, fronts)}
    for station, h in zip(STATIONS, thick.T):
        over = numpy.flatnonzero(h > DEPTH)
        k = over[0] if len(over) else 0
        if len(over):
            figures[f"arrival at {station} m [s]"] = float(numpy.interp(DEPTH, h[k - 1:k + 1], series.times[k - 1:k + 1]))
        figures[f"thickest at {station} m [m]"] = float(h.max())
        curves[f"{station} m"] = (series.times, h)
    figures["front at the end [m]"] = float(fronts[-1])
    return figures, curves


def rows(ladders):
    found = []
    for variant, lines in ladders.items():
        last = lines[-1]
        for what, unit, share, measured in (("arrival", "s", 0.1, ARRIVED), ("thickest", "m", 0.3, PEAK)):
            for station, value in zip(STATIONS, measured):
                name = f"{what} at {station} m [{unit}]"
                bar = norms.richardson(lines, name) if all(name in line.get("figures", {}) for line in lines) else None
                if name in last["figures"]:
                    shown = last["figures"][name]
                    words = f"{shown:.3g} ({100 * (shown / value - 1):+.0f} %" + (f", GCI {bar.gci:.2g})" if bar and bar.p else ", no order)")
                    found.append(Row(f"{variant}: {name}, measured {value:g}", words, f"{100 * share:.0f} %", abs(shown / value - 1) <= share))
                else:
                    found.append(Row(f"{variant}: {name}, measured {value:g}", "never", f"{100 * share:.0f} %", False))
    return found


def plots(ladders):
    front = [("25 May 2017", ARRIVED, STATIONS, "ko"), ("24 May 2017", SECOND[0], STATIONS, "k^")]
    front += [(variant, *lines[-1]["curves"]["front"], "-") for variant, lines in ladders.items()]
    return [Plot("front", "Front in the flume", "time since the gate opens [s]", "way down the bed [m]", front, False)]
