"""One level of a refinement study: the program run on a scene, and what is measured of what it wrote; the log of all runs.

A case is a module of cases/ with
  __doc__                the first line is its title; the rest says scene, references and norms
  SCENE                  name of a file in inputs/, or of what write_scene writes
  write_scene(level, folder)  optional: writes SCENE.toml and what it needs into the folder
  LEVELS                 {"cpu": [...], "cuda": [...]}: numbers of cells over the case's length
  RUNG                   what a level is called, "H0/{}"
  VARIANTS               name: settings; each but "... default" also runs as name+cell, with the mean volumetric rate of a cell (against locking)
  MATERIAL               name of the material that +cell is set for
  sets(level)            settings of a level
  measure(level_run)          (figures, curves): name: number, and name: (list, list)
  rows(ladders)          of {variant: [line, ...] by level}: sheet.Row
  plots(ladders)         of the same: sheet.Plot
"""
import importlib
import json
import os
import pathlib
import shutil
import subprocess
import sys

import records
from runs import table

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
ENVIRONMENT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
AT_NODES = ['numerics.bed="nodes"', 'numerics.transfer="apic"', "time.cfl=0.5"]  # of clay until it took pressures on cells
DIGITS = 4  # of what is kept of curves, which plots show and nothing else is made of
POINTS = 64  # of a curve at most: of a longer one every second, third, ... point is kept


def cases():
    names = sorted(file.stem for file in (HERE / "cases").glob("*.py"))
    return {name: importlib.import_module(f"cases.{name}") for name in names}


def variants(case):
    cell = [f'material.{case.MATERIAL}.volumetric="cell"']
    return {**case.VARIANTS, **{f"{name}+cell": settings + cell for name, settings in case.VARIANTS.items() if not name.endswith(" default")}}


def plain(variant):
    """Its name without +cell and --label."""
    return variant.split()[0].partition("+")[0]


def name_of(case):
    return case.__name__.rpartition(".")[2]


def key(line):
    return line["case"], line["variant"], line["level"]


class Log:
    """results.jsonl: what is measured again replaces its line."""

    def __init__(self, path):
        self.path = path
        self.read()

    def read(self):
        self.lines = records.read(self.path)

    def put(self, line):
        self.read()  # another case may be running into the same file
        self.lines = [x for x in self.lines if key(x) != key(line)] + [line]
        self.lines.sort(key=key)
        records.write(self.path, self.lines)

    def add(self, file):
        for line in records.read(file):
            self.put(line)


class LevelRun:
    """A finished run, as a case measures it."""

    def __init__(self, directory, variant, level, program):
        self.directory, self.variant, self.level, self.program = directory, variant, level, program
        self.summary = json.loads((directory / "summary.json").read_text())
        self.history = table(directory / "history.csv")

    def structure(self, name):
        """Columns of structures.csv of one structure."""
        columns = table(self.directory / "structures.csv")
        mine = [k for k, other in enumerate(columns["structure"]) if other == name]
        return {c: v[mine] for c, v in columns.items() if c != "structure"}

    def particles(self):
        from particles import Particles
        return Particles(self.directory / "particles.vtkhdf", self.program)


def scene_file(case, level, runs):
    if not hasattr(case, "write_scene"):
        return ROOT / "inputs" / f"{case.SCENE}.toml"
    folder = runs / f"scene-{case.SCENE}-{level}"
    folder.mkdir(parents=True, exist_ok=True)
    case.write_scene(level, folder)
    return folder / f"{case.SCENE}.toml"


def run(case, variant, level, args, directory):
    """(command, what went wrong or "")"""
    command = [args.program, "run", str(scene_file(case, level, args.runs)), "--output", str(directory), "--device", args.device, "--quiet", "--set", "time.stop=end"]
    for setting in [*case.sets(level), *variants(case)[variant], *args.sets]:
        command += ["--set", setting]
    print(" ".join(command), file=sys.stderr)
    shutil.rmtree(directory, ignore_errors=True)
    directory.parent.mkdir(parents=True, exist_ok=True)
    try:
        done = subprocess.run(command, env=dict(os.environ, **ENVIRONMENT), check=False, timeout=args.limit, stderr=subprocess.PIPE, text=True)
    except subprocess.TimeoutExpired:
        return command, f"ended after {args.limit:g} s"
    sys.stderr.write(done.stderr)
    last = (done.stderr.strip().splitlines() or [""])[-1]
    return command, f"exit code {done.returncode}: {last}" if done.returncode else ""


def thinned(values):
    kept = values[::-(-len(values) // POINTS)]
    return records.shorter([float(v) for v in kept], DIGITS)


def climb(case, variant, level, args):
    """Runs one level and returns its line."""
    name = variant + (f" {args.label}" if args.label else "")
    directory = args.runs / f"{name_of(case)}-{name}-{level}".replace(" ", "-").replace(",", "")
    command, failed = run(case, variant, level, args, directory)
    place = "" if hasattr(case, "write_scene") else "inputs/"
    words = ["moraine", "run", f"{place}{case.SCENE}.toml", *command[command.index("--device"):]]
    line = {"case": name_of(case), "variant": name, "level": level, "command": " ".join(words)}
    if failed:
        print(f"validation: {line['case']} {name} {level}: {failed}", file=sys.stderr)
        return dict(line, failed=failed)
    level_run = LevelRun(directory, name, level, args.program)
    for what in ("commit", "machine", "device", "precision", "particles", "steps", "wall_s", "state_hash"):
        line[what] = level_run.summary[what]
    line["wall_s"] = round(line["wall_s"], 2)
    try:
        figures, curves = case.measure(level_run)
    except (OSError, KeyError, IndexError, ValueError) as error:  # the other levels go on
        print(f"validation: {directory} cannot be measured ({type(error).__name__}: {error}). It is kept", file=sys.stderr)
        return dict(line, failed=f"not measured: {error}")
    line["figures"] = {k: float(v) for k, v in figures.items()}
    line["curves"] = {k: [thinned(x), thinned(y)] for k, (x, y) in curves.items()}
    print(f"{line['case']} {name} {level}: {line['figures']}", file=sys.stderr)
    if not args.keep:
        shutil.rmtree(directory)
    return line
