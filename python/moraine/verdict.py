"""Whether a slope with reduced strengths stands, by the ways of its particles since it had settled.

    stands      it comes to rest by [rest] of the scene, for 2.5 sqrt(H/g) at least
    fails       the way exceeds 0.05 H (or another share), and grows faster than what [rest] calls rest
    undecided   neither within 20 sqrt(H/g), nor in two more times as much

H is the height of the soil. The way is that which all particles but a share 1 - rest.mass have not exceeded: a grain that rolls
is no landslide. Rest is no faster than a twentieth of that way in an interval, whatever [rest] says.
"""
import dataclasses
import math
from typing import Any, Dict, List, Mapping, Optional, Sequence

import numpy
from numpy.typing import NDArray

from .particles import ParticleSeries

STANDS, FAILS, UNDECIDED = "stands", "fails", "undecided"
WAY = 0.05  # of H: more is a failure where it grows
PART = 20   # of the way: more in an interval is no rest
LIMIT, LIMITS = 20.0, 3  # in sqrt(H/g), and how often a trial may last so long
CALM = 2.5  # in sqrt(H/g): rest is as long as this
LOOKS = 4   # outputs in CALM: a trial goes on by CALM at a time


@dataclasses.dataclass(frozen=True)
class Rule:
    """Times and ways of one cell: height H [m], g [m/s2], the way of a failure [m], the time between looks [s], the rest interval [s],
    how many of them are rest, the way [m] in one that is rest, the same in cells, and the share of the mass."""

    height: float
    gravity: float
    way: float
    look: float
    interval: float
    intervals: int
    still: float
    displacement: float
    mass: float

    @property
    def unit(self) -> float:
        """sqrt(H/g) [s]."""
        return math.sqrt(self.height / self.gravity)

    @property
    def parts(self) -> int:
        """How many times CALM a trial may last."""
        return LIMITS * round(LIMIT / CALM)

    def rest_sets(self) -> Dict[str, Any]:
        """Keys of the scene by which a run ends at rest."""
        return {"time.stop": "rest", "rest.interval": self.interval, "rest.intervals": self.intervals, "rest.displacement": self.displacement}


def rule_of(scene: Mapping[str, Any], cell: float, height: float, share: float = WAY) -> Rule:
    """The rule for a scene (its keys) on a cell [m], for soil of a height [m]; share: of the height, the way of a failure.

    >>> rule = rule_of({"gravity": [0.0, -10.0]}, 0.5, 10.0)
    >>> rule.unit, rule.intervals, round(rule.look, 4)
    (1.0, 6, 0.625)
    """
    rest, g = scene.get("rest", {}), math.hypot(*scene["gravity"])
    interval = rest.get("interval", 2 * math.sqrt(cell / g))
    unit = math.sqrt(height / g)
    intervals = max(int(rest.get("intervals", 3)), math.ceil(CALM * unit / interval))
    still = min(rest.get("displacement", 0.05) * cell, share * height / PART)
    return Rule(height, g, share * height, CALM * unit / LOOKS, interval, intervals, still, still / cell, rest.get("mass", 0.999))


def judge(rule: Rule, times: Sequence[float], ways: Sequence[float], is_at_rest: bool) -> Optional[str]:
    """The verdict of the looks so far [s], [m], the first of them when strengths were reduced; None: it goes on.

    >>> rule = rule_of({"gravity": [0.0, -10.0]}, 0.5, 10.0)
    >>> judge(rule, [0.0, 0.6, 1.2], [0.0, 0.2, 0.9], False), judge(rule, [0.0, 0.6], [0.0, 0.3], True), judge(rule, [0.0, 0.6], [0.0, 0.2], False)
    ('fails', 'stands', None)
    """
    for before, now, way_before, way in zip(times, times[1:], ways, ways[1:]):
        if way > rule.way and (way - way_before) * rule.interval > rule.still * (now - before):
            return FAILS
    return STANDS if is_at_rest else None


class Ways:
    """How far particles have gone from where they were in one output of the settled run, look by look; on periodic axes by
    the nearest way between two looks. Who has left the domain has gone infinitely far.
    """

    def __init__(self, settled: ParticleSeries, k: int, periodic: Sequence[float], share: float) -> None:
        start = settled.read(k, ["id"])
        order = numpy.argsort(start["id"], kind="stable")
        self.ids, self.last = start["id"][order], start.position[order]
        self.way: NDArray[Any] = numpy.zeros_like(self.last)
        self.periodic, self.share = periodic, share
        self.times: List[float] = [start.time]
        self.ways: List[float] = [0.0]

    def look(self, series: ParticleSeries, last: Optional[int] = None) -> None:
        """Takes the outputs, up to `last` where it is given, that are later than those so far."""
        for k in range(len(series) if last is None else last + 1):
            if series.times[k] > self.times[-1]:
                self._take(series.read(k, ["id"]))

    def _take(self, now: Any) -> None:
        place = numpy.searchsorted(self.ids, now["id"])
        step = now.position - self.last[place]
        for axis, length in enumerate(self.periodic):
            if length > 0:
                step[:, axis] -= length * numpy.round(step[:, axis] / length)
        gone = numpy.full(len(self.ids), numpy.inf)
        self.way[place] += step
        self.last[place] = now.position
        gone[place] = numpy.linalg.norm(self.way[place], axis=1)
        self.times.append(now.time)
        self.ways.append(float(numpy.quantile(gone, self.share, method="lower")))
