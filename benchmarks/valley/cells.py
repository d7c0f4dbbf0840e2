#!/usr/bin/env python3
"""How maxima of the shipped valley depend on the cells over the depth of its release: a row of results.jsonl per run,
and one of orders. `depth_off`, `speed_off`: by how much a map differs from that of the finest run.

    benchmarks/valley/cells.py [--program build/release/moraine] [--cells 1.2,4,6,8,12] [--runs DIRECTORY] [-- OPTIONS]

OPTIONS go to `moraine run`, `--device cuda` for instance. Map cells are 4 m in all of them, so that maxima are of the
same columns. The release is 4 m thick.
"""
import argparse
import csv
import json
import pathlib
import subprocess
import sys
import time

from maps import largest, overlap, read_map

ROOT = pathlib.Path(__file__).resolve().parents[2]
THICKNESS, MAP_CELL = 4.0, 4.0
BELOW = 60.0  # from there on nothing is released [m]


def reached(run):
    return {(j, i) for j, row in enumerate(read_map(run, "arrival")) for i, t in enumerate(row) if t >= 0}


def measure(run):
    """What of the maps is compared."""
    arrival = read_map(run, "arrival")
    columns = [i for row in arrival for i, t in enumerate(row) if t >= 0]
    summary = json.loads((run / "summary.json").read_text())
    with open(run / "history.csv", newline="") as file:
        history = list(csv.DictReader(file))
    below = [row[int(BELOW / MAP_CELL):] for row in read_map(run, "max_depth")]
    return {"max_depth_m": round(largest(read_map(run, "max_depth")), 4), "max_depth_below_m": round(largest(below), 4),
            "max_speed_m_s": round(largest(read_map(run, "max_speed")), 4),
            "max_pressure_kPa": round(largest(read_map(run, "max_pressure")) / 1000, 3),
            "deposit_m": round(largest(read_map(run, "deposit")), 4),
            "centre_m": round(float(history[-1]["centre_x_m"]), 3),  # at the end
            "kinetic_MJ": round(max(float(row["kinetic_J"]) for row in history) / 1e6, 3),  # of all outputs
            "front_m": MAP_CELL * (max(columns) + 1), "reached_m2": MAP_CELL ** 2 * len(columns),
            "particles": summary["particles"], "steps": summary["steps"]}


def off(run, finest, name):
    """Sum of what a map differs from the finest run's, over the sum of that one."""
    pairs = [(a, b) for one, other in zip(read_map(run, name), read_map(finest, name)) for a, b in zip(one, other)]
    return round(sum(abs(a - b) for a, b in pairs) / sum(b for _, b in pairs), 5)


def order(cells, values):
    """Order p and limit of values = limit + C cells^-p through three levels; none where they are not monotone."""
    (a, b, c), (u, v, w) = cells, values
    if (v - u) * (w - v) <= 0:
        return None
    excess = lambda p: (a ** -p - b ** -p) / (b ** -p - c ** -p) - (v - u) / (w - v)
    low, high = 0.01, 20.0  # excess rises with p
    if excess(low) > 0 or excess(high) < 0:
        return None
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) < 0 else (low, middle)
    return {"order": round(low, 2), "limit": round(w + (w - v) * c ** -low / (b ** -low - c ** -low), 4)}


def orders(rows):
    """Of the three finest levels, and how far the finest is from the one before."""
    found = {"case": "cells-order", "cells": [row["cells"] for row in rows[-3:]]}
    for key in ("max_depth_m", "max_depth_below_m", "max_speed_m_s", "deposit_m", "centre_m", "kinetic_MJ"):
        values = [row[key] for row in rows[-3:]]
        found[key] = {"last_change": round(values[2] / values[1] - 1, 5), **(order(found["cells"], values) or {})}
    return found


def compare_with_finest(rows, runs):
    finest = reached(runs[-1])
    for row, run in zip(rows, runs):
        row["overlap_with_finest"] = round(overlap(reached(run), finest), 4)
        row["depth_off"], row["speed_off"] = off(run, runs[-1], "max_depth"), off(run, runs[-1], "max_speed")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/release/moraine"))
    parser.add_argument("--cells", default="1.2,4,6,8,12")
    parser.add_argument("--runs", default=str(ROOT / "runs/valley-cells"))
    parser.add_argument("--results", default=str(ROOT / "runs/benchmarks/valley/results.jsonl"))
    parser.add_argument("options", nargs="*")
    words = parser.parse_args()
    runs, rows = pathlib.Path(words.runs), []
    runs.mkdir(parents=True, exist_ok=True)
    for text in words.cells.split(","):
        run, cells = runs / text, float(text)
        start = time.monotonic()
        command = [words.program, "run", str(ROOT / "inputs/valley.toml"), "--output", str(run), "--overwrite", "--quiet",
                   "--no-particles", "--set", f"domain.cell={THICKNESS / cells!r}", "--set", f"hazard.cell={MAP_CELL}",
                   *words.options]
        if subprocess.run(command).returncode != 0:
            sys.exit(f"{' '.join(command)} failed. Is the program built?")
        rows.append({"case": "cells", "cells": cells, "seconds": round(time.monotonic() - start, 1), **measure(run)})
        print(json.dumps(rows[-1]), flush=True)
    compare_with_finest(rows, [runs / text for text in words.cells.split(",")])
    results = pathlib.Path(words.results)
    kept = [json.loads(line) for line in results.read_text().splitlines()] if results.exists() else []
    rows += [orders(rows)] if len(rows) > 2 else []
    kept = [row for row in kept if not row["case"].startswith("cells")] + rows
    results.parent.mkdir(parents=True, exist_ok=True)
    results.write_text("".join(json.dumps(row) + "\n" for row in kept))


if __name__ == "__main__":
    main()
