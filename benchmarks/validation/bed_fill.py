#!/usr/bin/env python3
"""How full the cells at the bed are in the viscous current, beside how fast it spreads: one line per level, particles and time.

    benchmarks/validation/bed_fill.py [--program build/release/moraine] [--cases 10:2 10:4 20:2 20:3] [-- --set KEY=VALUE ...]

A case is the cells over the block's height, and the particles of a cell per axis. Columns of cells count where they and
their neighbours are three cells deep or more.

  bed        particles' volume in the cells at the bed over those cells' room
  inside     the same of the cells above them, but those at the surface
  ahead      x of 99.5 % of the volume over that of theory (cases/huppert.py), less 1
  spreads    rise of x^5 since the time before over that of theory: in lubrication theory that is in proportion to the mobility of the layer
"""
import argparse
import pathlib
import subprocess
import sys
import tempfile

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "benchmarks"), str(ROOT / "scripts/report"), str(ROOT / "python")]
from cases import huppert
from particles import Particles

TIMES = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0)


def fills(x, h, volume):
    """Of the cells at the bed, and inside."""
    cell = numpy.floor(x[:, :2] / h).astype(int)
    full = numpy.zeros((cell[:, 0].max() + 2, cell[:, 1].max() + 2))
    numpy.add.at(full, (cell[:, 0], cell[:, 1]), volume / h**2)
    top = [numpy.nonzero(column)[0].max(initial=-1) for column in full]
    bed, inside = [], []
    for i in range(1, len(top) - 1):
        least = min(top[i - 1 : i + 2])
        if least >= 2:
            bed.append(full[i, 0])
            inside.extend(full[i, 1:least])
    return [numpy.mean(values) if values else float("nan") for values in (bed, inside)]


def measure(program, cells, count, options):
    h = huppert.Q**0.5 / cells  # the block is a square
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "run", str(ROOT / "inputs/viscous_current.toml"), "--output", f"{folder}/run", "--quiet", "--set", f"domain.cell={h!r}",
                   "--set", f"body.block.particles_per_cell={count}", *options]
        if subprocess.run(command, check=False).returncode != 0:
            sys.exit(f"{' '.join(command)} failed. Is the program built?")
        series = Particles(f"{folder}/run/particles.vtkhdf", program)
        before = None
        for t in TIMES:
            k = int(numpy.argmin(numpy.abs(series.times - t)))
            x = series.read("Points", series.starts[k], series.ends[k])
            far = numpy.sort(x[:, 0])[int(0.995 * len(x))]
            bed, inside = fills(x, h, huppert.Q / len(x))
            now = (far**5, (huppert.SHARE * huppert.PREFACTOR * huppert.SCALE) ** 5 * series.times[k])
            ahead = f"{100 * ((now[0] / now[1]) ** 0.2 - 1):+.2f} %"
            spreads = "" if before is None else f"{(now[0] - before[0]) / (now[1] - before[1]):.2f}"
            print(f"H0/{cells:g} {count}x{count} t {t:4g} s  bed {bed:.3f}  inside {inside:.3f}  ahead {ahead}  spreads {spreads}", flush=True)
            before = now


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(ROOT / "build/release/moraine"))
    parser.add_argument("--cases", nargs="+", default=["10:2", "10:4", "20:2", "20:3"])
    parser.add_argument("options", nargs="*")
    words = parser.parse_args()
    for case in words.cases:
        cells, count = case.split(":")
        measure(words.program, float(cells), int(count), words.options)


main()
