"""How far a flow went, by its particles: front along its way, runout, drop and travel angle, and its depth."""
import functools
import math
from typing import Any, Callable, Dict, List, Tuple

import numpy
from numpy.typing import NDArray

from .columns import depth_profile
from .errors import Error
from .particles import Particles
from .results import Run
from .way import Way, way_of

BEHIND = 0.995          # of the mass is behind the front
TAIL = 0.01             # of the mass, foremost or hindmost, whose mean height is that of the front or of the tail
COLUMNS_PER_CELL = 2.0  # width of a column of the depth, in cells


def _quantile(place: NDArray[Any], mass: NDArray[Any], share: float) -> float:
    order = numpy.argsort(place, kind="stable")
    behind = numpy.cumsum(mass[order])
    return float(numpy.interp(share * behind[-1], behind, place[order]))


def _height(place: NDArray[Any], height: NDArray[Any], mass: NDArray[Any]) -> float:
    """Mean height of the hindmost hundredth of the mass by `place`."""
    order = numpy.argsort(place, kind="stable")
    behind = numpy.cumsum(mass[order])
    last = order[: max(1, int(numpy.searchsorted(behind, TAIL * behind[-1], side="right")))]
    return float(numpy.average(height[last], weights=mass[last]))


class Runout:
    """The particles of a run along its way. Nothing is read before it is asked for. alike: particles count alike, where their masses were not written."""

    def __init__(self, run: Run, cell: float, alike: bool = False) -> None:
        self.run, self.cell, self.alike = run, cell, alike

    def _mass(self, particles: Particles) -> NDArray[Any]:
        found: NDArray[Any] = numpy.ones(len(particles)) if self.alike else particles["mass"].astype(float)
        return found

    @functools.cached_property
    def way(self) -> Way:
        return way_of(self.run)

    @functools.cached_property
    def start(self) -> Tuple[float, float]:
        """Place along the way and height [m] of the tail at the first output that has particles."""
        for k in range(len(self.run.particles)):
            first = self.run.particles.read(k, [] if self.alike else ["mass"])
            if len(first):
                place, mass = self.way.along(first.position), self._mass(first)
                return _quantile(place, mass, 1 - BEHIND), _height(place, first.position[:, -1], mass)
        raise Error(f"{self.run.path} has no front (it has no particles). Is time.end behind the first inflow?")

    def front(self, particles: Particles) -> float:
        """Place along the way [m] behind which 99.5 % of the mass are."""
        return _quantile(self.way.along(particles.position), self._mass(particles), BEHIND)

    def runout(self, particles: Particles) -> float:
        """L [m]: along the way from the tail at the start to the front."""
        return self.front(particles) - self.start[0]

    def drop(self, particles: Particles) -> float:
        """H [m]: from the height of the tail at the start down to that of the front."""
        place = self.way.along(particles.position)
        return self.start[1] - _height(-place, particles.position[:, -1], self._mass(particles))

    def travel_ratio(self, particles: Particles) -> float:
        """H / L [-]."""
        long = self.runout(particles)
        return self.drop(particles) / long if long > 0 else 0.0

    def travel_angle(self, particles: Particles) -> float:
        """arctan(H / L) [degrees]."""
        return math.degrees(math.atan(self.travel_ratio(particles)))

    def depth(self, particles: Particles) -> float:
        """Depth [m] of the deepest column two cells wide."""
        return float(max(depth_profile(particles.position, width=COLUMNS_PER_CELL * self.cell)[1], default=0.0))


#: Values of an output's particles, and the fields that they need.
OF_PARTICLES: Dict[str, Tuple[Callable[[Runout, Particles], float], List[str]]] = {
    "front": (Runout.front, ["mass"]), "runout": (Runout.runout, ["mass"]), "drop": (Runout.drop, ["mass"]),
    "travel_ratio": (Runout.travel_ratio, ["mass"]), "travel_angle": (Runout.travel_angle, ["mass"]), "depth": (Runout.depth, []),
}


def value_of(runout: Runout, name: str, particles: Particles) -> float:
    """One of OF_PARTICLES; 0 where there are no particles."""
    return OF_PARTICLES[name][0](runout, particles) if len(particles) else 0.0
