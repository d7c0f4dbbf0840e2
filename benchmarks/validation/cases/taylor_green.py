"""Taylor-Green vortex: what transfers take from a flow

One vortex in a box of 1 m with smooth walls, u = U sin(pi x) cos(pi y), v = -U cos(pi x) sin(pi y), U = 1 m/s, Re = U L / nu = 200, U / c = 0.05, 2 x 2
particles per cell, no pressure at the start. Exact and incompressible: the kinetic energy falls as exp(-4 nu pi^2 t), to 0.306 at 6 L / U.

Shifted: `pressure_smoothing = 0.22`, `particle_shifting = 0.2` ([ADR 8](../../docs/adr/0008-filling.md)). It stalls at 64 cells and gets worse at 128; half the step is better there. With pressures on cells (grid 10: `volumetric = "grid"`, ten substeps) it does not stall to 64 cells, so there it is the sums over particles; 128 was not run with them.
"""
import math

import numpy

import fluid_scene
from sheet import Plot, Row

SCENE = "taylor_green"
MATERIAL = "fluid"
LEVELS = {"cpu": [16, 32, 64], "cuda": [16, 32, 64, 128]}
RUNG = "L/{}"
HALF = {"APIC": "time.cfl=0.344", "AFLIP": "time.cfl=0.304"}  # of the default step
VARIANTS = fluid_scene.VARIANTS | {f"{name} shifted half": fluid_scene.VARIANTS[f"{name} shifted"] + [step] for name, step in HALF.items()}
SPEED, NU, END = 1.0, 1 / 200, 6.0
GOALS = {"AFLIP shifted": {16: 12, 32: 6, 64: 5}, "APIC shifted": {32: 15}}


def sets(level):
    return []


def write_scene(level, folder):
    n = 2 * level
    places = (numpy.arange(n) + 0.5) / n
    mass = fluid_scene.DENSITY / n**2
    rows = [(x, y, SPEED * math.sin(math.pi * x) * math.cos(math.pi * y), -SPEED * math.cos(math.pi * x) * math.sin(math.pi * y), mass)
            for x in places for y in places]
    table, body = fluid_scene.table("vortex", rows)
    (folder / "vortex.csv").write_text(table)
    (folder / f"{SCENE}.toml").write_text(
        fluid_scene.head("Taylor-Green vortex", (0.0, 0.0), (1.0, 1.0), 1 / level, END, 0.25, 0.0, 20 * SPEED, fluid_scene.DENSITY * NU)
        + body + fluid_scene.walls("x-min", "x-max", "y-min", "y-max"))


def left(t):
    return numpy.exp(-4 * NU * math.pi**2 * t)


def measure(level_run):
    history = level_run.history
    t, energy = history["time_s"], history["kinetic_J"] / history["kinetic_J"][0]
    figures = {"energy at 6 L/U, off by [%]": 100 * (energy[-1] / left(END) - 1), "over-filling [%]": 100 * max(history["over_filling"]),
               "rms of pressure / rho U2": float(numpy.std(level_run.particles().at(None, "pressure"))) / (fluid_scene.DENSITY * SPEED**2)}
    return figures, {"energy": (t, energy)}


def rows(ladders):
    found = []
    name = "energy at 6 L/U, off by [%]"
    at = {(v, z["level"]): z["figures"][name] for v, zs in ladders.items() for z in zs}
    for (variant, level), off in sorted(at.items()):
        goal = GOALS.get(variant, {}).get(level)
        found.append(Row(f"{variant}, L/{level}: kinetic energy", f"{off:+.1f} %", f"{goal} %" if goal else "-", abs(off) <= goal if goal else None))
        whole = at.get((variant.removesuffix(" half"), level))
        if variant.endswith(" half") and whole is not None:
            found.append(Row(f"{variant}, L/{level}: less than at the whole step", f"{off - whole:+.1f} %", "2 %", abs(off - whole) <= 2))
    return found


def plots(ladders):
    t = numpy.linspace(0, END, 50)
    lines = [(f"{v} L/{z['level']}", *z["curves"]["energy"], "-") for v, zs in ladders.items() for z in zs]
    return [Plot("energy", "Kinetic energy of the vortex", "t U / L", "E / E0", lines + [("exact", t, left(t), "k--")], False)]
