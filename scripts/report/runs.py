"""Reads what runs wrote: summary.json, the tables, and, where they are there, block_loads.bin and replay.csv.

Without numpy the tables are lists, and block loads are left out.
"""
import csv
import json
import math
import os
import pathlib

try:
    import numpy
    from loads import Loads
except ImportError:
    numpy = None
from wrong import Wrong

PHASES = ("p2g", "nodes", "g2p", "halo", "agree", "migrate", "balance", "output")
NUMBERS = ("step", "time_s", "imbalance", "halo_bytes", "migrated_particles", "repartitioned", "planned_imbalance")
WORDS = ("reason", "plan", "kind", "partitioner", "trigger", "structure")
SUMMARY_NUMBERS = ("ranks", "threads", "particles", "steps", "wall_s", "particle_steps_per_s", "imbalance_mean",
                   "imbalance_max", "imbalance_time_mean", "repartitions", "migrated_particles", "halo_bytes")
SUMMARY_WORDS = ("version", "commit", "scene", "title", "device", "precision", "partitioner", "state_hash")
LEAST_S, NOISY = 1.0, 1.5  # of stepping, and times of ranks over their loads: below and beyond a speed says nothing
CAUSES = ("computing", "lost_to_imbalance", "exchange", "balancing", "output", "rest")


def number(text):
    try:
        return float(text)
    except ValueError:
        return text


def table(path):
    """Columns of a CSV by name; numbers as arrays, words as lists. A torn last line is left out."""
    with open(path, newline="") as file:
        rows = [row for row in csv.reader(file)]
    names, rows = rows[0], [row for row in rows[1:] if len(row) == len(rows[0])]
    columns = {}
    for k, name in enumerate(names):
        values = [number(row[k]) for row in rows]
        words = name in WORDS or any(isinstance(value, str) for value in values)
        columns[name] = [row[k] for row in rows] if words else numpy.array(values, dtype=float) if numpy else values
    return columns


def check_numbers(path, columns, names):
    """Columns of a run's records that must be there, of finite numbers."""
    for name in names:
        if name not in columns:
            raise Wrong(f"{path} has no column {name} (it is not of this version, or damaged). Run it again?")
        if not all(isinstance(value, float) and math.isfinite(value) for value in columns[name]):
            raise Wrong(f"{path} is damaged (not all of column {name} are numbers). Run it again?")


def check_summary(path, summary):
    """What the page needs of summary.json is there, and of the kind that a run writes."""
    if not isinstance(summary, dict) or not isinstance(summary.get("times_s"), dict):
        raise Wrong(f"{path} is no summary of a run (times_s is missing). Run it again?")
    for group, names in ((summary, SUMMARY_NUMBERS), (summary["times_s"], CAUSES)):
        for name in names:
            value = group.get(name)
            if isinstance(value, bool) or not isinstance(value, (int, float)) or not -1e300 < value < 1e300:
                raise Wrong(f"{path} is damaged ({name} is no number). Run it again?")
    if summary["ranks"] < 1 or summary["particles"] < 0 or summary["wall_s"] <= 0:
        raise Wrong(f"{path} is damaged (ranks, particles or wall_s cannot be). Run it again?")
    for name in SUMMARY_WORDS:
        if not isinstance(summary.get(name), str):
            raise Wrong(f"{path} is damaged ({name} is missing). Run it again?")


class Run:
    def __init__(self, directory):
        self.path = pathlib.Path(directory)
        if not self.path.is_dir():
            raise Wrong(f"{directory} is not a run (no such directory). Is the path right?")
        self.finished = (self.path / "summary.json").exists()
        for name in ("balance.csv",) if self.finished else ("history.csv",):
            if not (self.path / name).exists():
                raise Wrong(f"{directory} is not a run (it has no {name}). Is the path right?")
        self.loads = self.replay = None
        if self.finished:
            self.read_work()
        self.name = self.key = self.path.name
        self.read_flow()
        if not self.finished:
            self.summary = self.known_so_far()

    def read_work(self):
        """What a run says of itself when it has ended, and how its work was shared."""
        try:
            self.summary = json.loads((self.path / "summary.json").read_text())
            check_summary(self.path / "summary.json", self.summary)
            self.balance = table(self.path / "balance.csv")
            check_numbers(self.path / "balance.csv", self.balance, NUMBERS)
            self.ranks, self.partitioner = self.summary["ranks"], self.summary["partitioner"]
            self.times = self.summary["times_s"]
        except (ValueError, IndexError, KeyError, csv.Error) as error:
            raise Wrong(f"{self.path} cannot be read ({type(error).__name__}: {error}). Run it again?") from None
        loads = self.path / "block_loads.bin"
        self.loads = Loads(loads) if loads.exists() and numpy else None
        replay = self.path / "replay.csv"
        self.replay = table(replay) if replay.exists() else None

    def known_so_far(self):
        """Stands for the summary of a run that is under way, or was killed: what its records say."""
        try:
            scene = json.loads((self.path / "scene.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            scene = {}
        scene = scene if isinstance(scene, dict) else {}
        words = {name: str(scene.get(name, "")) for name in ("scene", "title", "version")}
        last = {name: (list(self.history.get(name, [])) or [None])[-1] for name in ("particles", "step", "time_s", "lost_particles", "over_filling")}
        return {**words, "particles": last["particles"], "steps": last["step"], "simulated_time_s": last["time_s"],
                "lost_particles": last["lost_particles"]}

    def read_flow(self):
        """history.csv, and structures.csv by structure. What is no number in them stays so: the page leaves it out."""
        try:
            self.history = table(self.path / "history.csv")
            rows = table(self.path / "structures.csv") if (self.path / "structures.csv").exists() else {}
        except (OSError, ValueError, IndexError, csv.Error) as error:
            raise Wrong(f"{self.path} cannot be read (history.csv or structures.csv: {error}). Run it again?") from None
        if not len(self.history.get("time_s", [])):
            raise Wrong(f"{self.path / 'history.csv'} has no row of a time (the run ended before its first output). Run it again?")
        self.dimensions = 3 if "centre_z_m" in self.history else 2
        names = rows.get("structure", [])
        self.structures = {name: {key: [value for value, at in zip(values, names) if at == name] for key, values in rows.items()}
                           for name in dict.fromkeys(names)}

    @property
    def time(self):
        return self.balance["time_s"]

    @property
    def steps_between(self):
        """Steps that each row of balance.csv is over."""
        return numpy.diff(self.balance["step"], prepend=self.first_step())

    def first_step(self):
        step = self.balance["step"]
        if self.loads and self.loads.checks:
            return self.loads.checks[0].step
        return max(0, 2 * step[0] - step[1]) if len(step) > 1 else 0

    def not_measurable(self, idle=True):
        """Why its speed says nothing; empty where it does. idle: ranks without particles count, which of two ways to share out work is no matter."""
        stepping = self.summary.get("stepping_s", self.summary["wall_s"])
        if stepping < LEAST_S:
            return f"it stepped for {stepping:.2g} s (less than {LEAST_S:g} s)"
        least = list(self.balance.get("particles_min", []))
        if idle and self.ranks > 1 and least and max(least) == 0:
            return "it had ranks without particles"
        if self.summary["imbalance_time_mean"] > NOISY * self.summary["imbalance_mean"]:
            return f"ranks with {self.summary['imbalance_mean']:.3g} times the mean load took {self.summary['imbalance_time_mean']:.3g} times its time (a machine that others used, or fewer cores than ranks)"
        return ""

    def speed(self):
        """Particle-steps per second."""
        return self.summary["particle_steps_per_s"]

    def lost(self):
        """Seconds lost to imbalance by cause: granularity, partition, timing noise; none but their sum without block loads."""
        total = self.times["lost_to_imbalance"]
        if not self.loads or len(self.loads.checks) < 2:
            return {"imbalance": total}
        weight = numpy.diff([check.step for check in self.loads.checks])
        best = numpy.average([check.best_imbalance() for check in self.loads.checks[1:]], weights=weight)
        mean = self.times["computing"]
        granularity = min(total, mean * (best - 1))
        partition = min(total - granularity, mean * max(0, self.summary["imbalance_mean"] - best))
        return {"granularity": granularity, "partition": partition, "timing noise": total - granularity - partition}


def unique_names(runs):
    """Each run by the end of its path that no other run has."""
    for depth in range(1, 6):
        names = [os.sep.join(run.path.resolve().parts[-depth:]) for run in runs]
        if len(set(names)) == len(names):
            break
    for run, name in zip(runs, names):
        run.name = name
