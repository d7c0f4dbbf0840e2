"""The steepest way over a model of the ground, and areas of polygons."""
import math
from typing import Any, List, Tuple

import numpy
from numpy.typing import NDArray

from .errors import Error
from .grids import Grid

FLAT = 1e-3   # slope below which the ground leads nowhere: on it the way goes straight on
AHEAD = 0.25  # of a new direction, the rest is that of the step before: a way down a channel does not go from wall to wall
ENDLESS = 5   # times the diagonal of the model


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
