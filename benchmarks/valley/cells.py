#!/usr/bin/env python3
"""How maxima of the shipped valley depend on the cells over the depth of its release: a row of results.jsonl per run.

    benchmarks/valley/cells.py [--program build/release/moraine] [--cells 1.2,4,6,8,12] [--runs DIRECTORY] [-- OPTIONS]

OPTIONS go to `moraine run`, `--device cuda` for instance. Map cells are 4 m in all of them, so that maxima are of the
same columns. The release is 4 m thick.
"""
import argparse
import json
import pathlib
import subprocess
import sys
import time

from maps import largest, overlap, read_map

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
THICKNESS, MAP_CELL = 4.0, 4.0


def reached(run):
    return {(j, i) for j, row in enumerate(read_map(run, "arrival")) for i, t in enumerate(row) if t >= 0}


def measure(run):
    """What of the maps is compared."""
    arrival = read_map(run, "arrival")
    columns = [i for row in arrival for i, t in enumerate(row) if t >= 0]
    summary = json.loads((run / "summary.json").read_text())
    return {"max_depth_m": round(largest(read_map(run, "max_depth")), 4),
            "max_speed_m_s": round(largest(read_map(run, "max_speed")), 4),
            "max_pressure_kPa": round(largest(read_map(run, "max_pressure")) / 1000, 3),
            "deposit_m": round(largest(read_map(run, "deposit")), 4),
            "front_m": MAP_CELL * (max(columns) + 1), "reached_m2": MAP_CELL ** 2 * len(columns),
            "particles": summary["particles"], "steps": summary["steps"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/release/moraine"))
    parser.add_argument("--cells", default="1.2,4,6,8,12")
    parser.add_argument("--runs", default=str(ROOT / "runs/valley-cells"))
    parser.add_argument("--results", default=str(HERE / "results.jsonl"))
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
    finest = reached(runs / words.cells.split(",")[-1])
    for row, text in zip(rows, words.cells.split(",")):
        row["overlap_with_finest"] = round(overlap(reached(runs / text), finest), 4)
    results = pathlib.Path(words.results)
    kept = [json.loads(line) for line in results.read_text().splitlines()] if results.exists() else []
    kept = [row for row in kept if row["case"] != "cells"] + rows
    results.write_text("".join(json.dumps(row) + "\n" for row in kept))


if __name__ == "__main__":
    main()
