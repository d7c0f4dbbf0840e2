"""Huppert's viscous gravity current

0.1 m x 0.1 m of fluid with nu = 0.005 m2/s over a rough bed (`inputs/viscous_current.toml`), to 30 s. Theory (Huppert 1982, plane, fixed area q):
x_N = 1.41124 (g q^3 / (3 nu))^(1/5) (t + t0)^(1/5), once thin and slow.

* Front: x with 0.5 % of the volume ahead of it, divided by that share of the similarity profile (0.983 x_N).
* Over 3 to 30 s, a decade, t0 is fitted once with prefactor and exponent: log x is a least-squares line in log(t + t0), t0 the one of the least
  residual with the exponent free; the prefactor is fitted with the exponent 1/5 held.
* E_h: L1 of the depth at 30 s against the similarity profile of that front.

Shifted: `pressure_smoothing = 0.22` and `particle_shifting = 0.2` ([ADR 8](../../docs/adr/0008-filling.md)). APIC at H0/20, 40: exponent 0.186, 0.194, prefactor -0.4, +0.5 % (979f2bf, host); at H0/80 0.199, +0.2 % (89cc4d5, before beds were filled).

Grid: pressures on cells besides, with `numerics.substeps = "auto"` ([ADR 9](../../docs/adr/0009-grid-pressure.md)): what the shipped scene has. APIC at H0/20, 40, 80: exponent 0.190, 0.199, 0.199,
front at 30 s +0.6, +1.1, +1.0 % (979f2bf, which fills beds); with 3 x 3 particles it is further ([what is left](../../docs/runouts.md#the-viscous-current)).

Why goals are missed with neither: two errors of opposite sign tilt the line, so that the exponent is too low while the prefactor is within 5 %.

* Early the front is ahead of theory: by 13 and 9 % (H0/20), by 10 and 7 % (H0/40) at 1 and 3 s, where the fluid is 5 to 11 cells deep on average. The
  block slumps elastically first: E = 3 kPa is three times rho g H0. On the host at H0/10 it is ahead by 8 and 4 %, with E = 12 kPa by 4 and 0 %
  (`--variants APIC --levels 10 --set material.syrup.young=12000 --label stiffer`).
* Late it falls behind, where the fluid is 3 to 6 cells deep: the local exponent at H0/40 is 0.18 over 2 to 6 s and 0.16 over 10 to 30 s.
* At H0/10, to 30 s, front over theory (exponent): 0.95 (0.145); half the time step 0.98 (0.165); E = 12 kPa 0.93 (0.162); cubic shape 1.01 (0.184);
  FLIP 0.92 (0.135); means of cells 0.94 (0.133); 4 particles per cell and direction 0.81 (0.081). At H0/20, host: means of cells 0.90 (0.115),
  nu = 0.45 0.95 (0.130).
* Finer particles make it worse and a wider shape better, so it is the sum over particles in disorder, not the number of cells alone; the depth then is
  uneven by a cell from bin to bin. What holds such a film is not known further. R9's films, 20 cells deep, are within 0.2 %.
"""
import math

import numpy

import norms
from sheet import Plot, Row

SCENE = "viscous_current"
MATERIAL = "syrup"
LEVELS = {"cpu": [10, 20], "cuda": [20, 40, 80]}
RUNG = "H0/{}"
TRANSFERS = {name: [f"numerics.transfer={name.lower()}"] for name in ("APIC", "FLIP", "AFLIP")}
PARTICLES = ["material.syrup.volumetric=particle", "numerics.substeps=1", "material.syrup.pressure_smoothing=0", "material.syrup.particle_shifting=0", "time.cfl=0.5"]
CURE = ["material.syrup.pressure_smoothing=0.22", "material.syrup.particle_shifting=0.2"]  # docs/adr/0008-filling.md
VARIANTS = ({name: sets + PARTICLES for name, sets in TRANSFERS.items()}
            | {f"{name} shifted": sets + PARTICLES + CURE for name, sets in TRANSFERS.items()}
            | {f"{name} shifted grid 10": sets for name, sets in TRANSFERS.items()})  # the shipped scene: docs/adr/0009-grid-pressure.md
G, Q, NU, PREFACTOR = 9.81, 0.01, 0.005, 1.41124
SCALE = (G * Q**3 / (3 * NU))**0.2
AHEAD = 0.005


def sets(level):
    return [f"domain.cell={0.1 / level!r}", 'output.fields=["pressure"]']


def quantile_of_profile():
    """xi / xi_N with a share AHEAD of the area of (1 - s^2)^(1/3) beyond it."""
    s = numpy.linspace(0, 1, 200001)
    area = numpy.cumsum((1 - s * s)**(1 / 3))
    return float(numpy.interp(1 - AHEAD, area / area[-1], s))


SHARE = quantile_of_profile()


def similar(x, front):
    """Depth of the similarity profile of area q that ends at `front`."""
    s = numpy.linspace(0, 1, 20001)
    shape = ((1 - s * s)**(1 / 3)).mean()
    return Q / (front * shape) * numpy.maximum(0, 1 - (x / front)**2)**(1 / 3)


def fit(t, x):
    """(t0, exponent with that t0, prefactor with 1/5, rms of ln x about it) over 3..30 s."""
    use = (t >= 3) & (t <= 30)
    best = None
    for t0 in numpy.linspace(-2, 2, 401):
        p, c = numpy.polyfit(numpy.log(t[use] + t0), numpy.log(x[use]), 1)
        off = norms.rms(numpy.log(x[use]) - p * numpy.log(t[use] + t0) - c)
        if best is None or off < best[1]:
            best = t0, off, p
    t0, off, p = best
    return t0, p, math.exp(numpy.mean(numpy.log(x[use]) - 0.2 * numpy.log(t[use] + t0))) / SCALE, off


def measure(level_run):
    series = level_run.particles()
    fronts = numpy.array([numpy.quantile(series.at(t)[:, 0], 1 - AHEAD) for t in series.times]) / SHARE
    end = series.at(None)
    x, h = norms.depth(end[:, 0], Q / len(end), 0.0, 0.8, 0.01)
    t0, exponent, prefactor, off = fit(series.times, fronts)
    history = level_run.history
    figures = {"front at 30 s [m]": fronts[-1], "over-filling [%]": 100 * max(history["over_filling"]), "exponent": exponent, "t0 [s]": t0, "prefactor": prefactor, "rms of ln x": off,
               "E_h [%]": 100 * norms.l1(h, similar(x, fronts[-1])), "cells at x = 0": h[0] / (0.1 / level_run.level)}
    return figures, {"front": (series.times, fronts), "depth": (x, h)}


def rows(ladders):
    found = []
    for variant, lines in ladders.items():
        for x in lines:
            f, name = x["figures"], f"{variant}, H0/{x['level']}"
            found.append(Row(f"{name}: exponent (t0 = {f['t0 [s]']:.2f} s)", f"{f['exponent']:.4f}", "0.2 +- 0.005", abs(f["exponent"] - 0.2) <= 0.005))
            off = 100 * (f["prefactor"] / PREFACTOR - 1)
            found.append(Row(f"{name}: prefactor", f"{f['prefactor']:.4f}, {off:+.1f} %", "2 %", abs(off) <= 2))
            found.append(Row(f"{name}: depth at 30 s", f"{f['E_h [%]']:.1f} %, {f['cells at x = 0']:.1f} cells deep", "3 %", f["E_h [%]"] <= 3))
    return found


def plots(ladders):
    t, x = numpy.geomspace(0.3, 30, 50), numpy.linspace(0, 0.8, 161)
    fronts = [(f"{v} H0/{z['level']}", *[numpy.array(c)[1:] for c in z["curves"]["front"]], "-") for v, zs in ladders.items() for z in zs]
    fronts.append(("1.411 (g q^3 / 3 nu)^(1/5) t^(1/5)", t, PREFACTOR * SCALE * t**0.2, "k--"))
    depth = [(f"{v} H0/{z['level']}", *z["curves"]["depth"], "-") for v, zs in ladders.items() for z in zs]
    depth.append(("similarity profile at 30 s", x, similar(x, PREFACTOR * SCALE * 30**0.2), "k--"))
    return [Plot("front", "Front of the current", "time [s]", "x_N [m]", fronts, True), Plot("depth", "Depth at 30 s", "x [m]", "depth [m]", depth, False)]
