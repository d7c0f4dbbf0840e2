"""E14, Prandtl's strip footing

Half model of 4 B x 3 B, weightless Tresca clay, E = 1000 su, nu = 0.495, footing with alpha = 1 (`inputs/strip_footing.toml`), APIC.
Nc: V / (B su), mean over a settlement of 0.05 to 0.1 B, against 2 + pi. Noise: rms of the rows of 0.02 s about a moving average over 0.01 B.
An even number of cells puts the footing's edge on a node, whose share of the soil reaches half a cell beyond it (B is h wider); an odd one puts it
half way between nodes. The heave beside a footing that has sunk by 0.1 B bears a little: of 5.14 (1 + O(u/B)) nothing is taken off.
"""
import math

import numpy

import norms
from sheet import Plot, Row

SCENE = "strip_footing"
MATERIAL = "clay"
LEVELS = {"cpu": [8, 9, 16, 17], "cuda": [8, 9, 16, 17, 32, 33, 64]}
RUNG = "B/{}"
VARIANTS = {"rough": []}
B, SU, EXACT = 1.0, 1e3, 2 + math.pi


def sets(level):
    return [f"domain.cell={B / level!r}", "domain.max=[4,1]", "output.interval=0", 'output.fields=["pressure"]']


def measure(rung):
    footing = rung.structure("footing")
    u, load = -footing["displacement_y_m"] / B, 2 * footing["force_y_N"] / (B * SU)
    mean = norms.moving_average(u, load, 0.01)
    use = u >= 0.05
    figures = {"Nc": load[use].mean(), "Nc at 0.05": numpy.interp(0.05, u, mean), "Nc at 0.1": numpy.interp(0.1, u, mean),
               "noise [%]": 100 * norms.rms((load[use] - mean[use]) / mean[use])}
    return figures, {"load": (u, load), "mean": (u, mean)}


def rows(ladders):
    found = []
    for variant, lines in ladders.items():
        for x in lines:
            off = 100 * (x["figures"]["Nc"] / EXACT - 1)
            goal = "3 %" if x["level"] == 16 else "-"
            found.append(Row(f"{variant}, B/{x['level']}: Nc", f"{x['figures']['Nc']:.3f}, {off:+.1f} %", goal, abs(off) <= 3 if x["level"] == 16 else None))
    return found


def plots(ladders):
    lines = [(f"{v} B/{z['level']}", *z["curves"]["mean"], "-") for v, zs in ladders.items() for z in zs]
    lines.append(("2 + pi", [0, 0.1], [EXACT, EXACT], "k--"))
    errors = [(v, [B / z["level"] for z in zs], [abs(z["figures"]["Nc"] / EXACT - 1) for z in zs], "o-") for v, zs in ladders.items()]
    return [Plot("load", "Load of the footing", "settlement / B", "V / (B su)", lines, False), Plot("error", "Error of Nc", "h [m]", "|Nc / 5.14 - 1|", errors, True)]
