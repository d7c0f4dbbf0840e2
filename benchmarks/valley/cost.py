#!/usr/bin/env python3
"""What hazard maps and ground from heights cost: ms per step of runs that differ in them alone, rows of results.jsonl.

    benchmarks/valley/cost.py [--program build/release/moraine] [--cells 23] [--steps 300] [--repeats 3] [--groups slab] [-- OPTIONS]

OPTIONS go to `moraine run`, `--device cuda` for instance. With 23 cells over the 4 m of the release there are some
3 million particles. It needs no GDAL: heights are an ESRI ASCII grid, places are CSV.

  valley      the shipped one, its release at 8 m/s so that samples come as often as in a flow: bare; with all maps; with
              gauges besides; with sections besides
  slab        as much soil under tilted gravity: on a plane structure; on a wall of the same law; on level heights; on
              heights that roll by 0.2 m

The cases take turns, and each figure is the median of the repeats: `step_ms` the steps alone, `output_ms` what is done
between them (samples of maps, and the output at the end), `all_ms` the wall time beyond that of a run of no steps, per
step. `of` is the sum of the first two over that of the group's first case, `all_of` the same of the third.
"""
import argparse
import json
import math
import pathlib
import shutil
import statistics
import subprocess
import sys

from maps import write_grid

ROOT = pathlib.Path(__file__).resolve().parents[2]
THICKNESS, LENGTH, WIDTH = 4.0, 40.0, 15.0  # of the release and the slab [m]
MAPS = '\n[hazard]\ncell = 2.0\nthreshold = 0.2\n'
SLAB = """\
dimensions = 3
gravity = [3.99, 0.0, -8.96]
[domain]
min = [0.0, 0.0, -2.0]
max = [160.0, 32.0, 14.0]
cell = 1.0
[time]
end = 1.0
[[material]]
name = "debris"
law = "drucker-prager"
density = 1900.0
young = 2.0e6
poisson = 0.3
friction_angle = 32.0
[[body]]
name = "slab"
material = "debris"
shape = "box"
min = [10.0, 8.5, 0.0]
max = [50.0, 23.5, 4.0]
velocity = [8.0, 0.0, 0.0]
"""
BED = 'contact = { law = "voellmy", friction = 0.2, xi = 500.0 }\n'
PLANE = '[[structure]]\nname = "bed"\nshape = "plane"\npoint = [0.0, 0.0, 0.0]\nnormal = [0.0, 0.0, 1.0]\n' + BED
OPEN = "".join(f'[[wall]]\nface = "{axis}-{side}"\nkind = "open"\n' for axis in "xyz" for side in ("min", "max"))


def heights(path, roll):
    """Of the slab's ground, 2 m apart and up to `roll` [m] below 0."""
    wave = lambda x, y: -0.25 * roll * (2 + math.sin(2 * math.pi * x / 20) + math.sin(2 * math.pi * y / 20))
    write_grid(path, [[wave(2 * i, 2 * j) for i in range(81)] for j in reversed(range(17))], 2, (-1, -1))


def write_scenes(folder):
    """By group the names of its cases, the first of which the others are compared with."""
    for name in ("valley.asc", "valley_release.csv", "valley_gauges.csv", "valley_sections.csv"):
        shutil.copy(ROOT / "inputs" / name, folder)
    valley = (ROOT / "inputs/valley.toml").read_text()
    start, end = valley.index("[hazard]"), valley.index("[output]")
    bare = valley[:start] + valley[end:] + "velocity = [8.0, 0.0, -5.0]\n"
    gauges, sections = 'gauges = "valley_gauges.csv"\n', 'sections = "valley_sections.csv"\n'
    heights(folder / "level.asc", 0)
    heights(folder / "rolling.asc", 0.2)
    wall = SLAB.replace("min = [0.0, 0.0, -2.0]", "min = [0.0, 0.0, 0.0]").replace("32.0, 14.0]", "32.0, 12.0]")
    bed = OPEN.replace('face = "z-min"\nkind = "open"', 'face = "z-min"\nkind = "voellmy"\nfriction = 0.2\nxi = 500.0')
    groups = {"valley": {"bare": bare, "maps": bare + MAPS, "gauges": bare + MAPS + gauges,
                         "sections": bare + MAPS + gauges + sections},
              "slab": {"plane": SLAB + PLANE + OPEN, "wall": wall + bed, "level": SLAB + '[terrain]\ndem = "level.asc"\n' + BED,
                       "rolling": SLAB + '[terrain]\ndem = "rolling.asc"\n' + BED}}
    for group, cases in groups.items():
        for case, text in cases.items():
            (folder / f"{group}-{case}.toml").write_text(text)
    return {group: list(cases) for group, cases in groups.items()}


def run(words, folder, group, case, end):
    scene, directory = folder / f"{group}-{case}.toml", folder / f"{group}-{case}"
    command = [words.program, "run", str(scene), "--output", str(directory), "--overwrite", "--quiet", "--no-particles"]
    for key, value in (("domain.cell", THICKNESS / words.cells), ("time.end", end), ("output.interval", 1e6)):
        command += ["--set", f"{key}={value!r}"]
    if subprocess.run(command + words.options).returncode != 0:
        sys.exit(f"{' '.join(command + words.options)} failed. Is the program built?")
    said = json.loads((directory / "summary.json").read_text())
    samples = directory / "gauges.csv"
    per_step = 1000 / max(1, said["steps"])
    return {"step_ms": per_step * said["stepping_s"], "output_ms": per_step * said["times_s"]["output"],
            "samples": len(samples.read_text().splitlines()) - 1 if samples.exists() else None,
            **{key: said[key] for key in ("wall_s", "steps", "particles", "machine", "device", "commit")}}


def measure(words, folder, group, case, end):
    start = run(words, folder, group, case, 0.0)
    found = run(words, folder, group, case, end)
    return {**found, "all_ms": 1000 * (found["wall_s"] - start["wall_s"]) / found["steps"],
            "particles": start["particles"]}


def row_of(group, case, runs, words):
    row = {"case": "cost", "group": group, "name": case, "cells": words.cells, "repeats": len(runs)}
    row |= {key: runs[0][key] for key in ("particles", "steps", "samples", "device", "machine", "commit")}
    for key in ("step_ms", "output_ms", "all_ms"):
        values = [r[key] for r in runs]
        row |= {key: round(statistics.median(values), 4), f"{key}_least": round(min(values), 4),
                f"{key}_most": round(max(values), 4)}
    return row


def save(results, rows):
    kept = [json.loads(line) for line in results.read_text().splitlines()] if results.exists() else []
    kept = [old for old in kept if old["case"] != "cost" or old["device"] != rows[0]["device"]] + rows
    results.parent.mkdir(parents=True, exist_ok=True)
    results.write_text("".join(json.dumps(old) + "\n" for old in kept))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/release/moraine"))
    parser.add_argument("--cells", type=float, default=23)
    parser.add_argument("--steps", type=int, default=300)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--groups", nargs="+", default=["valley", "slab"])
    parser.add_argument("--runs", default=str(ROOT / "runs/valley-cost"))
    parser.add_argument("--results", default=str(ROOT / "runs/benchmarks/valley/results.jsonl"))
    parser.add_argument("options", nargs="*")
    words = parser.parse_args()
    folder, rows = pathlib.Path(words.runs), []
    folder.mkdir(parents=True, exist_ok=True)
    for group, cases in write_scenes(folder).items():
        if group not in words.groups:
            continue
        probe = 0.12 / words.cells  # [s]; a step is so long by order of magnitude
        first = run(words, folder, group, cases[0], 20 * probe)  # warms the device, and says how long a step is
        end = words.steps * 20 * probe / first["steps"]  # [s]
        runs = {case: [] for case in cases}
        for _ in range(words.repeats):
            for case in cases:
                runs[case].append(measure(words, folder, group, case, end))
        for case in cases:
            rows.append(row_of(group, case, runs[case], words))
            row, base = rows[-1], rows[-1 - cases.index(case)]
            row["of"] = round((row["step_ms"] + row["output_ms"]) / (base["step_ms"] + base["output_ms"]), 4)
            row["all_of"] = round(row["all_ms"] / base["all_ms"], 4)
            print(json.dumps(row), flush=True)
    save(pathlib.Path(words.results), rows)


if __name__ == "__main__":
    main()
