"""Prandtl's strip footing

Half model of 4 B x 3 B, weightless Tresca clay, E = 1000 su, nu = 0.495, footing with alpha = 1 (`inputs/strip_footing.toml`), contact at nodes and APIC; `default`:
pressures on cells, AFLIP and contact on surfaces, whose figures are with those of other [beds](../placement/results.md#clay).

* Nc: V / (B su), mean over a settlement u of 0.05 to 0.1 B, against 2 + pi. Noise: rms of the rows of 0.02 s about a moving average over 0.01 B.
* `stiff`: E = 10 000 su, where the plateau is there before the footing has sunk by 0.01 B; mean over u of 0.0075 B to the end, 0.014 B. 2 + pi is
  exact for small displacements, so that the goal is put to this variant too.
* An even number of cells puts the footing's edge on a node, whose share of the soil reaches half a cell beyond it (B is h wider); an odd one puts it
  half way between nodes, where the node half a cell beyond it is held too (B is h wider as well).

Why goals are missed:

* `stiff` with means of cells meets the goal at B/16, where it is set, but B/16 is the luckiest level: B/32, 33 and 64 are at +8.8, +6.6 and +5.4 %.
* Its load at u = 0.006 B, where the plateau begins, is 5.25, 5.31 and 5.34 at B/16, 32 and 64 (5.46 and 5.35 at B/17 and 33). After that it stays
  where it is at B/16 (5.23 at the end) and 64 (5.42) and rises at B/32 and 33 (to 5.65 and 5.50).
* A footing that is h wider makes 1.6 % of the 5.4 % at B/64; the rest is not known. Without means of cells all levels are 12 to 27 % high.
* `rough` is above 5.14 at all levels because it has sunk. With means of cells its load at B/33 is 5.41 at u = 0.02 B, 5.58 at 0.05 B and 5.53 at 0.1 B
  (5.57 over 0.05 to 0.1 B); the depth factor 1 + 0.27 (u/B)^(1/2) of Salgado et al. 2004 (from memory) makes 5.34, 5.45 and 5.58 of 5.14.
"""
import math

import numpy

import ladder
import norms
from sheet import Plot, Row

SCENE = "strip_footing"
MATERIAL = "clay"
LEVELS = {"cpu": [8, 9, 16, 17], "cuda": [8, 9, 16, 17, 32, 33, 64]}
RUNG = "B/{}"
STIFF = ["material.clay.young=1e7", "time.end=0.9"]
VARIANTS = {"rough": ladder.AT_NODES, "stiff": STIFF + ladder.AT_NODES, "stiff default": STIFF,
            "smooth default": [*STIFF, 'structure.footing.contact={law="smooth"}']}
B, SU, EXACT = 1.0, 1e3, 2 + math.pi


def sets(level):
    return [f"domain.cell={B / level!r}", "domain.max=[4,1]", "output.interval=0", 'output.fields=["pressure"]']


def measure(level_run):
    footing = level_run.structure("footing")
    u, load = -footing["displacement_y_m"] / B, 2 * footing["force_y_N"] / (B * SU)
    mean = norms.moving_average(u, load, 0.01)
    stiff = u[-1] < 0.05
    use = u >= (0.0075 if stiff else 0.05)
    places = () if stiff else (0.02, 0.05, 0.1)
    figures = {"Nc": load[use].mean()} | {f"Nc at {at}": numpy.interp(at, u, mean) for at in places}
    figures["noise [%]"] = 100 * norms.rms((load[use] - mean[use]) / mean[use])
    return figures, {"mean": (u, mean)}


def rows(ladders):
    found = []
    for variant, lines in ladders.items():
        for x in lines:
            off = 100 * (x["figures"]["Nc"] / EXACT - 1)
            asked = x["level"] == 16 and variant != "stiff"  # of stiff: with a cure against locking
            found.append(Row(f"{variant}, B/{x['level']}: Nc", f"{x['figures']['Nc']:.3f}, {off:+.1f} %", "3 %" if asked else "-", abs(off) <= 3 if asked else None))
    return found


def plots(ladders):
    lines = [(f"{v} B/{z['level']}", *z["curves"]["mean"], "-") for v, zs in ladders.items() for z in zs]
    lines.append(("2 + pi", [0, 0.1], [EXACT, EXACT], "k--"))
    errors = [(v, [B / z["level"] for z in zs], [abs(z["figures"]["Nc"] / EXACT - 1) for z in zs], "o-") for v, zs in ladders.items()]
    return [Plot("load", "Load of the footing", "settlement / B", "V / (B su)", lines, False), Plot("error", "Error of Nc", "h [m]", "|Nc / 5.14 - 1|", errors, True)]
