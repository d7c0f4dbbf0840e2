"""The way of a flow in plan, along which its front is counted: hazard.path of the scene, or the steepest way from its source.

Where a scene has neither path nor ground in 3-D, the way is the x axis.
"""
import dataclasses
import json
import math
from typing import Any, Dict, List, Mapping, Tuple

import numpy
from numpy.typing import NDArray

from .errors import Error
from .grids import Grid
from .maps import ground_of
from .results import Run

FLAT = 1e-3   # slope below which the ground leads nowhere: on it the way goes straight on
AHEAD = 0.25  # of a new direction, the rest is that of the step before: a way down a channel does not go from wall to wall
ENDLESS = 5   # times the diagonal of the model


@dataclasses.dataclass(frozen=True)
class Way:
    """points (n, 2) [m] from the source downwards; kind: "path", "steepest" or "x"."""

    points: NDArray[Any]
    kind: str

    def along(self, position: NDArray[Any]) -> NDArray[Any]:
        """Distances (N,) [m] from the first point on of places (N, 2 or 3), each by its nearest point of the way, which goes on in a line
        behind both ends; x itself where the way is the axis.

        >>> way = Way(numpy.array([[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]]), "path")
        >>> way.along(numpy.array([[1.0, 1.0], [4.0, 2.0], [3.0, 9.0], [-2.0, 0.0]])).tolist()
        [1.0, 5.0, 12.0, -2.0]
        """
        x = position[:, 0].astype(float)
        if self.kind == "x":
            return x
        y, start, last = position[:, 1].astype(float), 0.0, len(self.points) - 2
        found, nearest = numpy.zeros(len(x)), numpy.full(len(x), numpy.inf)
        for k, (a, b) in enumerate(zip(self.points, self.points[1:])):
            long = float(numpy.hypot(*(b - a)))
            ahead = (b - a) / long
            s = (x - a[0]) * ahead[0] + (y - a[1]) * ahead[1]
            s = numpy.clip(s, -numpy.inf if k == 0 else 0.0, numpy.inf if k == last else long)
            far = (x - a[0] - s * ahead[0])**2 + (y - a[1] - s * ahead[1])**2
            closer = far < nearest
            found[closer], nearest[closer] = start + s[closer], far[closer]
            start += long
        return found


def scene_record(run: Run) -> Dict[str, Any]:
    """scene.json of a run. Raises Error where it is not there or damaged."""
    try:
        found = json.loads((run.path / "scene.json").read_text(encoding="utf-8"))
    except (OSError, ValueError) as wrong:
        raise Error(f"{run.path / 'scene.json'} cannot be read ({wrong}). Run it again?") from None
    if not isinstance(found, dict):
        raise Error(f"{run.path / 'scene.json'} is no record of a scene (it is a {type(found).__name__}). Run it again?")
    return found


def area_of(points: NDArray[Any]) -> Tuple[float, NDArray[Any]]:
    """Area and centroid of a polygon (n, 2).

    >>> area_of(numpy.array([[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [0.0, 2.0]]))
    (8.0, array([2., 1.]))
    """
    at = points - points[0]
    following = numpy.roll(at, -1, axis=0)
    cross = at[:, 0] * following[:, 1] - following[:, 0] * at[:, 1]
    area = float(cross.sum()) / 2
    if area == 0:
        return 0.0, points.mean(axis=0)
    return abs(area), points[0] + ((at + following) * cross[:, None]).sum(axis=0) / (6 * area)


def sources(keys: Mapping[str, str], kind: str) -> Dict[str, NDArray[Any]]:
    """Corners (n, 2) of the areas of all releases (`kind` release), or points of the lines of all inflows, by name."""
    found = {}
    for key, value in keys.items():
        parts = key.split(".")
        if parts[0] == kind and parts[-1] == "points" and len(parts) == 3:
            found[parts[1]] = numpy.array(json.loads(value), dtype=float)
    return found


def _source(run: Run, keys: Mapping[str, str]) -> Tuple[NDArray[Any], float]:
    """Where the flow comes from, and a length of its area [m]."""
    areas = [area_of(points) for points in sources(keys, "release").values()]
    if areas and sum(area for area, _ in areas) > 0:
        area, middle = max(areas, key=lambda found: found[0])
        return middle, math.sqrt(area)
    for points in sources(keys, "inflow").values():
        return points.mean(axis=0), float(numpy.hypot(*(points[-1] - points[0])))
    for k in range(len(run.particles)):
        place = run.particles.read(k, []).position
        if len(place):
            return place[:, :2].mean(axis=0), float(numpy.sqrt(numpy.prod(numpy.ptp(place[:, :2], axis=0))))
    raise Error(f"{run.path} has no way of the flow (nothing is there from which it begins). Name one by hazard.path?")


def _smoothed(ground: Grid, radius: float) -> Grid:
    """Means over squares of about that radius; cells of no height count nothing."""
    reach = max(1, round(radius / ground.cell))
    known = numpy.isfinite(ground.values)
    total, count = numpy.where(known, ground.values, 0.0), known.astype(float)
    for axis in (0, 1):
        sums = []
        for values in (total, count):
            padded = numpy.pad(values, [(reach + 1, reach) if a == axis else (0, 0) for a in (0, 1)])
            run_sum = numpy.cumsum(padded, axis=axis)
            ahead, behind = (numpy.take(run_sum, range(start, start + values.shape[axis]), axis=axis) for start in (2 * reach + 1, 0))
            sums.append(ahead - behind)
        total, count = sums
    with numpy.errstate(invalid="ignore", divide="ignore"):
        return Grid(numpy.where(count > 0, total / count, numpy.nan), ground.first, ground.cell)


def _slope_at(ground: Grid, x: NDArray[Any]) -> NDArray[Any]:
    """Gradient of the bilinear surface; NaN beyond it."""
    at = (x - ground.first) / ground.cell
    column, row = (int(math.floor(place)) for place in at)
    rows, columns = ground.values.shape
    if not (0 <= row < rows - 1 and 0 <= column < columns - 1):
        return numpy.full(2, numpy.nan)
    v = ground.values[row:row + 2, column:column + 2]
    fx, fy = at[0] - column, at[1] - row
    return numpy.array([(v[0, 1] - v[0, 0]) * (1 - fy) + (v[1, 1] - v[1, 0]) * fy,
                        (v[1, 0] - v[0, 0]) * (1 - fx) + (v[1, 1] - v[0, 1]) * fx]) / ground.cell


def steepest_way(ground: Grid, start: NDArray[Any], length: float) -> NDArray[Any]:
    """Points (n, 2) [m] from `start` down to the model's edge: the steepest way over heights that are smoothed over a quarter of
    `length` [m], that of the source. Over flats and out of hollows it goes on as it went.

    >>> plane = Grid(numpy.fromfunction(lambda j, i: 100.0 - i, (40, 60)), (0.0, 0.0), 1.0)
    >>> steepest_way(plane, numpy.array([5.0, 20.0]), 8.0)[-1].round(1).tolist()[1]
    20.0
    """
    smooth = _smoothed(ground, length / 4)
    rows, columns = ground.values.shape
    most = int(ENDLESS * math.hypot(rows, columns))
    x, ahead, points = start.astype(float), numpy.zeros(2), [start.astype(float)]
    for _ in range(most):
        slope = _slope_at(smooth, x)
        if not numpy.isfinite(slope).all():
            break
        steep = float(numpy.hypot(*slope))
        if steep > FLAT:
            wanted = -slope / steep
            if not ahead.any():
                ahead = wanted
            elif float(wanted @ ahead) > 0:
                ahead = (1 - AHEAD) * ahead + AHEAD * wanted
                ahead /= numpy.hypot(*ahead)
        if not ahead.any():
            raise Error("there is no steepest way (the ground is level where the flow begins). Name one by hazard.path?")
        x = x + ground.cell * ahead
        points.append(x)
    if len(points) < 3:
        raise Error("there is no steepest way (the flow begins at the edge of the model of the ground). Name one by hazard.path?")
    every = max(1, round(length / 4 / ground.cell))
    kept: List[NDArray[Any]] = [points[0], *points[every:-1:every], points[-1]]
    return numpy.array(kept)


def way_of(run: Run) -> Way:
    """The way of a run's flow. Raises Error where the ground that it needs is not found."""
    scene = scene_record(run)
    path = (scene.get("hazard") or {}).get("path") or []
    if path:
        return Way(numpy.array(path, dtype=float), "path")
    if run.dimensions == 2 or not any(s.get("shape") == "ground" for s in scene.get("structure", [])):
        return Way(numpy.zeros((0, 2)), "x")
    ground = ground_of(run.path)
    if ground is None:
        raise Error(f"{run.path} has no way of the flow (the model of its ground is not where the run found it). Name one by hazard.path?")
    return Way(steepest_way(ground, *_source(run, scene.get("keys", {}))), "steepest")
