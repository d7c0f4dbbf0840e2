"""block_loads.bin: who held which block at each balance interval."""
import pathlib
import struct

import numpy
from wrong import Wrong

HEADER = struct.Struct("<8s2i3i3i8id2q3dd24s2dQ")  # io/block_loads.hpp
FRAME = struct.Struct("<8sqddqqqQ")
ROW = numpy.dtype([("key", "<u8"), ("particles", "<u4"), ("owner", "<i4")])  # the top bit of particles: it sleeps
ASLEEP = 1 << 31
SLEEPERS_PER_AWAKE = 16  # balance/weight.hpp


def mix(word):
    """One step of core/data/hash.hpp."""
    word = (word + 0x9e3779b97f4a7c15) % 2**64
    word = (word ^ word >> 30) * 0xbf58476d1ce4e5b9 % 2**64
    word = (word ^ word >> 27) * 0x94d049bb133111eb % 2**64
    return word ^ word >> 31


def hash_of(data):
    """mix_bytes of core/data/hash.hpp, of whole words."""
    value = 0
    for word, in struct.iter_unpack("<Q", data):
        value = mix(value ^ mix(word))
    return value


def gather_bits(key, start, stride, bits):
    value = numpy.zeros(key.shape, dtype=numpy.uint64)
    for k in range(bits):
        bit = (key >> numpy.uint64(start + stride * k)) & numpy.uint64(1)
        value |= bit << numpy.uint64(k)
    return value


class ImbalanceCheck:
    """Blocks at one balance interval: keys, particles, owners, who sleeps (`slept`: the run has sleepers), and their loads."""

    def __init__(self, step, time, ranks, rows, slept):
        self.step, self.time, self.ranks, self.rows = step, time, ranks, rows.copy()
        self.rows["particles"] &= ASLEEP - 1
        self.asleep = (rows["particles"] & ASLEEP != 0) & slept
        particles = self.rows["particles"].astype(numpy.int64)
        self.loads = numpy.where(self.asleep, -(-particles // SLEEPERS_PER_AWAKE), particles)

    def imbalance(self):
        """Maximum over mean of the ranks, of particles by what they cost."""
        held = numpy.bincount(self.rows["owner"], weights=self.loads, minlength=self.ranks)
        return held.max() * self.ranks / held.sum()

    def best_imbalance(self):
        """The same of the best contiguous cut of the Morton curve: bisection over the heaviest part."""
        sums = numpy.concatenate(([0], numpy.cumsum(self.loads)))
        low, high = int(max(self.loads.max(), -(-sums[-1] // self.ranks))), int(sums[-1])
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
        if len(data) < HEADER.size or data[:8] != b"MORLOAD5":
            raise Wrong(f"{path} is no record of block loads (its header is missing). Leave that run out?")
        if hash_of(data[:HEADER.size - 8]) != HEADER.unpack_from(data)[-1]:
            raise Wrong(f"{path} is damaged (its header is not what was written). Leave that run out?")
        head = HEADER.unpack_from(data)
        self.dimensions = head[1]
        self.slept = head[15] == 1  # SleepersRecord::asleep
        self.corner, self.side = head[20:23], head[23]
        self.checks, at = [], HEADER.size
        while at + FRAME.size <= len(data):
            _, step, time, _, _, ranks, blocks, _ = FRAME.unpack_from(data, at)
            at += FRAME.size + 32 * ranks
            if at + ROW.itemsize * blocks > len(data):
                break
            self.checks.append(ImbalanceCheck(step, time, ranks, numpy.frombuffer(data, ROW, blocks, at), self.slept))
            at += ROW.itemsize * blocks

    def position(self, check):
        """Lower corners of the blocks [m], one row an axis."""
        bits = 31 if self.dimensions == 2 else 21
        bias = 1 << (bits - 1)
        axes = [gather_bits(check.rows["key"], a, self.dimensions, bits) for a in range(self.dimensions)]
        return [self.corner[a] + self.side * (axes[a].astype(numpy.int64) - bias) for a in range(self.dimensions)]

    def nearest(self, time):
        return min(self.checks, key=lambda check: abs(check.time - time))
