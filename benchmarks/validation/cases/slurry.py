"""Runout of a Bingham slurry after a dam break

10 m x 5 m behind a gate that is gone at t = 0, tau_y / (rho g H0) = 0.0068, plane strain, to 30 s (`inputs/slurry_runout.toml`).

* Runout: front less 10 m; `front` is front_m of history.csv (last column of cells with a quarter of a cell's volume, so whole cells), `front 99.5 %`
  has 0.5 % of the volume ahead, which is smooth in h: order, Richardson value and GCI are of it.
* Noise: rms of p - rho g (h(x) - y) over rho g H0 at rest, raw of all particles, and of the means of cells. Creep: what the front does from 20 to 30 s.
* E_h: L1 of the final depth against the arrest of Liu and Mei 1989, h^2 = 2 b (X - x) with b = tau_y / (rho g), and with the extensional stress of
  the next order, h = pi b/2 + ((pi b/2)^2 + 2 b (X - x))^(1/2); both leave inertia out, which carries this flow much further, so no goal is put
  to them.

Grid: pressures on cells, `volumetric = "grid"` with `numerics.substeps = 1` or `10`, and both cures ([ADR 9](../../docs/adr/0009-grid-pressure.md)): what the shipped scene has,
with 10. x of 99.5 % of the volume at rest, H0/25, 50, 100, 200, 10 substeps: APIC 57.55, 60.11, 60.52, 60.43 m; AFLIP 62.34, 61.49, 60.80, 60.55; FLIP 61.17, 61.13, 60.72, 60.58 (979f2bf).

* The runout converges: at H0/200 three transfers, each with one and ten substeps, end within 0.6 % of each other, in an eighth of the steps with ten.
* From H0/25 to 50, 100 and 200 it changes by 5.4, 0.8 and -0.2 % (APIC), -1.6, -1.3 and -0.5 % (AFLIP), -0.1, -0.8 and -0.3 % (FLIP), ten substeps; at 8 s by 3.2, 0.0, -0.7 %, -1.2, -2.3, -0.9 % and 1.6, -0.8, -0.5 %.
* AFLIP at H0/100, ten substeps: half the step 0.2 %, a quarter 0.5 %, jittered particles 0.0 %, 3 x 3 in a cell 1.1 % (APIC 1.5, at H0/200 0.6 %).
* At 8 s all six are 52.65 to 52.87 m at H0/200. Noise at rest is 3.1 to 3.9 % at H0/25, 1.9 to 2.1, 1.0 to 1.2 and 0.6 to 0.8 % on finer levels, ten substeps: smoothing stays inside a cell. Creep is at most 0.2 % of H0 at H0/200.
* Over-filling falls from H0/50 on and is 0.7 to 0.8 % at most at H0/200. Noise lies in the half cells at the bed, over-filling in 2 x 2 particles ([what is left](../../docs/runouts.md)). The energy that is unaccounted for is 12, 4.8, 1.7 and 0.7 % of the potential (AFLIP, ten).

Shifted: `pressure_smoothing = 0.22` and `particle_shifting = 0.2` with the particles' own pressures ([ADR 8](../../docs/adr/0008-filling.md)). Runout at rest, H0/25, 50, 100, 200: APIC 46.9, 48.4, 49.7, 49.1 m; AFLIP 51.7, 52.3, 50.5, 48.8; FLIP 50.8, 51.4, 49.9, 48.5 (979f2bf).

* The three transfers are 10, 8.1, 1.6 and 1.3 % apart: they meet as cells shrink. From H0/100 to 200 the runout changes by -1.2 % (APIC), -3.2 % (AFLIP) and -2.9 % (FLIP).
* At 8 s they are 1.3 % apart at H0/200 (42.1, 41.8, 41.5 m) and 1.4 % at H0/100.
* Noise at rest 1.5, 0.62, 0.29, 0.27 % (APIC), creep at most 0.8 %. Over-filling is at most 0.03 % at rest, but its largest value in the run grows with the level: 0.8, 1.4, 2.0, 3.5 % (APIC).

Why goals are missed without it:

* Noise: each particle's own volume drifts, and nu = 0.495 makes 1 % of volume 113 % of rho g H0. With nu = 0.45, a tenth of the bulk modulus, it is 21 %
  instead of 100 % at H0/25 (APIC, host: `--variants APIC --levels 25 --set material.slurry.poisson=0.45 --label nu-0.45`), and the creep 0.2 instead of
  1.1 % of H0.
* It falls by 0.5 to 0.75 from level to level, too slowly for 2 %. Means of cells leave 7 to 11 %, which does not fall: the means of neighbouring cells
  still differ.
* The runout has two errors that both fall with h and pull in opposite directions. What the transfer takes (17, 18, 13, 9 % of the potential energy with
  APIC) makes it shorter; noise makes it longer: nu = 0.45 at H0/25 shortens it by 1.6 m, and means of cells shorten it by 3 to 8 m at every level, with
  FLIP by 5 to 12 m.
* So it is not monotone, there is no Richardson value, and the finest level, which stands in for it, still has 25 % of noise.
"""
import math

import numpy

import norms
from sheet import Plot, Row

SCENE = "slurry_runout"
MATERIAL = "slurry"
LEVELS = {"cpu": [25, 50], "cuda": [25, 50, 100, 200]}
RUNG = "H0/{}"
TRANSFERS = {name: [f"numerics.transfer={name.lower()}"] for name in ("FLIP", "APIC", "AFLIP")}
CURE = ["material.slurry.pressure_smoothing=0.22", "material.slurry.particle_shifting=0.2"]  # docs/adr/0008-filling.md
PARTICLES = ["material.slurry.volumetric=particle", "numerics.substeps=1", "material.slurry.pressure_smoothing=0", "material.slurry.particle_shifting=0"]
VARIANTS = ({name: sets + PARTICLES for name, sets in TRANSFERS.items()}
            | {f"{name} shifted": sets + PARTICLES + CURE for name, sets in TRANSFERS.items()}
            | {f"{name} shifted grid {s}": sets + CURE + ["material.slurry.volumetric=grid", f"numerics.substeps={s}"]
               for name, sets in TRANSFERS.items() for s in (1, 10)})  # docs/adr/0009-grid-pressure.md
DENSITY, GRAVITY, YIELD, HEIGHT, LENGTH = 1500.0, 9.81, 500.0, 5.0, 10.0
AREA, B = HEIGHT * LENGTH, YIELD / (DENSITY * GRAVITY)
PER_CENT = 100 / (DENSITY * GRAVITY * HEIGHT)
BIN = 0.4  # of depth profiles [m]: two cells of the coarsest level


def sets(level):
    return [f"domain.cell={HEIGHT / level!r}", "domain.max=[100,8]", "time.cfl=0.5", "time.end=30", "output.interval=0.5", 'output.fields=["pressure"]']


def arrested(x, next_order=False):
    """(front X, depth at x) of the arrest without inertia."""
    k = math.pi * B / 2 if next_order else 0.0
    low, high = 0.0, 100.0
    for _ in range(100):  # area = k X + ((k^2 + 2 b X)^1.5 - k^3) / (3 b) rises with X
        front = 0.5 * (low + high)
        area = k * front + ((k * k + 2 * B * front)**1.5 - k**3) / (3 * B)
        low, high = (front, high) if area < AREA else (low, front)
    return front, numpy.where(x < front, k + numpy.sqrt(numpy.maximum(0, k * k + 2 * B * (front - x))), 0.0)


def measure(level_run):
    series = level_run.particles()
    end = series.at(None)
    volume = AREA / len(series.at(0.0))
    fronts = [numpy.quantile(series.at(t)[:, 0], 0.995) for t in series.times]
    x, h = norms.depth(end[:, 0], volume, 0.0, 80.0, BIN)
    surface = numpy.interp(end[:, 0], x, h)
    noise = series.at(None, "pressure") - DENSITY * GRAVITY * (surface - end[:, 1])
    noise[end[:, 0] > fronts[-1]] = 0
    means = norms.cell_means(end, noise, HEIGHT / level_run.level)
    history = level_run.history
    late, early = (numpy.abs(series.times - t).argmin() for t in (20, 8))
    figures = {"front [m]": history["front_m"][-1], "front 99.5 % [m]": fronts[-1], "at 8 s [m]": fronts[early],
               "over-filling [%]": 100 * max(history["over_filling"]), "at 30 s [%]": 100 * history["over_filling"][-1],
               "creep [% of H0]": 100 * (fronts[-1] - fronts[late]) / HEIGHT,
               "noise [%]": PER_CENT * norms.rms(noise), "noise of cells [%]": PER_CENT * norms.rms(means),
               "E_h to R6a [%]": 100 * norms.l1(h, arrested(x)[1]), "E_h to R6c [%]": 100 * norms.l1(h, arrested(x, True)[1]),
               "unaccounted / potential [%]": 100 * history["unaccounted_J"][-1] / history["potential_J"][0]}
    wet = int(numpy.flatnonzero(h)[-1]) + 2  # bins to the first without slurry
    return figures, {"front": (history["time_s"], history["front_m"]), "depth": (x[:wet], h[:wet])}


def rows(ladders):
    found = []
    for variant, lines in ladders.items():
        r = norms.richardson(lines, "front 99.5 % [m]")
        at = {x["level"]: x["figures"] for x in lines}
        fifty = at.get(50)
        if r and r.p:
            runout = r.value - LENGTH
            found.append(Row(f"{variant}: order of the runout, H0/{r.levels[0]} to H0/{r.levels[2]}", f"{r.p:.2f}", ">= 0.8", r.p >= 0.8))
            found.append(Row(f"{variant}: GCI at H0/{r.levels[2]}", f"{100 * r.gci / runout:.2f} % of {runout:.2f} m", "<= 2 %", r.gci <= 0.02 * runout))
        elif r:
            found.append(Row(f"{variant}: order of the runout", f"not monotone over H0/{r.levels}; reference: the finest", ">= 0.8", False))
        if r and fifty:
            error = (fifty["front 99.5 % [m]"] - r.reference) / (r.reference - LENGTH)
            found.append(Row(f"{variant}: runout at H0/50 against the Richardson value", f"{100 * error:+.2f} %", "1 %", abs(error) <= 0.01))
        best = max(at)
        noise, creep = at[best]["noise [%]"], at[best]["creep [% of H0]"]
        found.append(Row(f"{variant}: pressure noise at rest, H0/{best}", f"{noise:.2f} %", "<= 2 %", noise <= 2))
        found.append(Row(f"{variant}: creep in 10 s, H0/{best}", f"{creep:.3f} % of H0", "< 1 %", creep < 1))
    return found


def plots(ladders):
    x = numpy.linspace(0, 80, 201)
    front = [(f"{v} H0/{z['level']}", *z["curves"]["front"], "-") for v, zs in ladders.items() for z in zs]
    depth = [(f"{v} H0/{z['level']}", *z["curves"]["depth"], "-") for v, zs in ladders.items() for z in zs]
    depth += [("arrest without inertia", x, arrested(x)[1], "k--"), ("arrest, next order", x, arrested(x, True)[1], "k:")]
    shown = [Plot("front", "Front of the slurry", "time [s]", "front [m]", front, False),
             Plot("depth", "Depth at rest (30 s)", "x [m]", "depth [m]", depth, False)]
    errors = []
    for variant, lines in ladders.items():
        r = norms.richardson(lines, "front 99.5 % [m]")
        if r:
            points = [(HEIGHT / z["level"], abs(z["figures"]["front 99.5 % [m]"] / r.reference - 1)) for z in lines]
            points = [p for p in points if p[1] > 0]
            errors.append((f"{variant}, against {r.reference:.2f} m", *zip(*points), "o-"))
    return shown + ([Plot("error", "Error of the front", "h [m]", "relative error of the front", errors, True)] if errors else [])
