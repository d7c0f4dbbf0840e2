"""Reads what runs wrote: summary.json, balance.csv, and, where they are there, block_loads.bin and replay.csv."""
import csv
import json
import os
import pathlib
import struct

import numpy

PHASES = ("p2g", "nodes", "g2p", "halo", "agree", "migrate", "balance", "output")
NUMBERS = ("step", "time_s", "imbalance", "halo_bytes", "migrated_particles", "repartitioned", "planned_imbalance")
WORDS = ("reason", "plan", "kind", "partitioner", "trigger")
SUMMARY_NUMBERS = ("ranks", "threads", "particles", "steps", "wall_s", "particle_steps_per_s", "imbalance_mean",
                   "imbalance_max", "imbalance_time_mean", "repartitions", "migrated_particles", "halo_bytes")
SUMMARY_WORDS = ("version", "commit", "scene", "title", "device", "precision", "partitioner", "state_hash")
CAUSES = ("computing", "lost_to_imbalance", "exchange", "balancing", "output", "rest")
HEADER = struct.Struct("<8s2i3i3i6id2q3dd24s2dQ")  # io/block_loads.hpp
FRAME = struct.Struct("<8sqddqqQ")
ROW = numpy.dtype([("key", "<u8"), ("particles", "<u4"), ("owner", "<i4")])


class Wrong(Exception):
    """The input is wrong; the words are for the user."""


def mix(word):
    """One step of core/hash.hpp."""
    word = (word + 0x9e3779b97f4a7c15) % 2**64
    word = (word ^ word >> 30) * 0xbf58476d1ce4e5b9 % 2**64
    word = (word ^ word >> 27) * 0x94d049bb133111eb % 2**64
    return word ^ word >> 31


def hash_of(data):
    """mix_bytes of core/hash.hpp, of whole words."""
    value = 0
    for word, in struct.iter_unpack("<Q", data):
        value = mix(value ^ mix(word))
    return value


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
        columns[name] = [row[k] for row in rows] if words else numpy.array(values, dtype=float)
    return columns


def check_numbers(path, columns, names):
    """Columns of a run's records that must be there, of finite numbers."""
    for name in names:
        if name not in columns:
            raise Wrong(f"{path} has no column {name} (it is not of this version, or damaged). Run it again?")
        if isinstance(columns[name], list) or not numpy.isfinite(columns[name]).all():
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


def gather_bits(key, start, stride, bits):
    value = numpy.zeros(key.shape, dtype=numpy.uint64)
    for k in range(bits):
        bit = (key >> numpy.uint64(start + stride * k)) & numpy.uint64(1)
        value |= bit << numpy.uint64(k)
    return value


class ImbalanceCheck:
    """Blocks at one balance interval: keys, particles, owners."""

    def __init__(self, step, time, ranks, rows):
        self.step, self.time, self.ranks, self.rows = step, time, ranks, rows

    def imbalance(self):
        """Maximum over mean of the ranks, by particles."""
        held = numpy.bincount(self.rows["owner"], weights=self.rows["particles"], minlength=self.ranks)
        return held.max() * self.ranks / held.sum()

    def best_imbalance(self):
        """The same of the best contiguous cut of the Morton curve: bisection over the heaviest part."""
        sums = numpy.concatenate(([0], numpy.cumsum(self.rows["particles"], dtype=numpy.int64)))
        low, high = int(max(self.rows["particles"].max(), -(-sums[-1] // self.ranks))), int(sums[-1])
        while low < high:
            middle, at = (low + high) // 2, 0
            for _ in range(self.ranks):
                at = int(numpy.searchsorted(sums, sums[at] + middle, side="right")) - 1
            if at == len(sums) - 1:
                high = middle
            else:
                low = middle + 1
        return low * self.ranks / sums[-1]


class Loads:
    """block_loads.bin, by checks; the whole of it, up to a torn end."""

    def __init__(self, path):
        data = pathlib.Path(path).read_bytes()
        if len(data) < HEADER.size or data[:8] != b"MORLOAD3":
            raise Wrong(f"{path} is no record of block loads (its header is missing). Leave that run out?")
        if hash_of(data[:HEADER.size - 8]) != HEADER.unpack_from(data)[-1]:
            raise Wrong(f"{path} is damaged (its header is not what was written). Leave that run out?")
        head = HEADER.unpack_from(data)
        self.dimensions = head[1]
        self.corner, self.side = head[18:21], head[21]
        self.checks, at = [], HEADER.size
        while at + FRAME.size <= len(data):
            _, step, time, _, ranks, blocks, _ = FRAME.unpack_from(data, at)
            at += FRAME.size + 32 * ranks
            if at + ROW.itemsize * blocks > len(data):
                break
            self.checks.append(ImbalanceCheck(step, time, ranks, numpy.frombuffer(data, ROW, blocks, at)))
            at += ROW.itemsize * blocks

    def position(self, check):
        """Lower corners of the blocks [m], one row an axis."""
        bits = 31 if self.dimensions == 2 else 21
        bias = 1 << (bits - 1)
        axes = [gather_bits(check.rows["key"], a, self.dimensions, bits) for a in range(self.dimensions)]
        return [self.corner[a] + self.side * (axes[a].astype(numpy.int64) - bias) for a in range(self.dimensions)]

    def nearest(self, time):
        return min(self.checks, key=lambda check: abs(check.time - time))


class Run:
    def __init__(self, directory):
        self.path = pathlib.Path(directory)
        if not self.path.is_dir():
            raise Wrong(f"{directory} is not a run (no such directory). Is the path right?")
        for name in ("summary.json", "balance.csv"):
            if not (self.path / name).exists():
                raise Wrong(f"{directory} is not a finished run (it has no {name}). Is the path right?")
        try:
            self.summary = json.loads((self.path / "summary.json").read_text())
            check_summary(self.path / "summary.json", self.summary)
            self.balance = table(self.path / "balance.csv")
            check_numbers(self.path / "balance.csv", self.balance, NUMBERS)
            self.ranks, self.partitioner = self.summary["ranks"], self.summary["partitioner"]
            self.times = self.summary["times_s"]
        except (ValueError, IndexError, KeyError, csv.Error) as error:
            raise Wrong(f"{directory} cannot be read ({type(error).__name__}: {error}). Run it again?") from None
        loads = self.path / "block_loads.bin"
        self.loads = Loads(loads) if loads.exists() else None
        replay = self.path / "replay.csv"
        self.replay = table(replay) if replay.exists() else None
        self.name = self.path.name

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
