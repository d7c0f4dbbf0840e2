"""Depth of the flow, from its particles: the ground is cut into columns, a depth is a column's extent upwards."""
from typing import Any, Optional, Sequence, Tuple

import numpy
from numpy.typing import NDArray


def spacing(position: NDArray[Any]) -> float:
    """Distance of neighbouring particles [m]: the median over at most 200 of them. (N, d) [m]; 0 of fewer than two.

    >>> spacing(numpy.array([[0.0, 0.0], [0.25, 0.0], [0.5, 0.0]]))
    0.25
    """
    if len(position) < 2:
        return 0.0
    chosen = numpy.linspace(0, len(position) - 1, min(len(position), 200)).astype(int)
    nearest = []
    for k in chosen:
        square = ((position - position[k]) ** 2).sum(axis=1)
        square[k] = numpy.inf
        nearest.append(square.min())
    return float(numpy.sqrt(numpy.median(nearest)))


def _extents(height: NDArray[Any], column: NDArray[Any], count: int) -> Tuple[NDArray[Any], NDArray[Any]]:
    """Least and greatest height (N,) of each of `count` columns, of which particle p is in column[p]; (count,) each."""
    low, high = numpy.full(count, numpy.inf), numpy.full(count, -numpy.inf)
    numpy.minimum.at(low, column, height)
    numpy.maximum.at(high, column, height)
    return low, high


def depth_at(position: NDArray[Any], width: float, between: float) -> NDArray[Any]:
    """Depth of the flow at each particle, (N,) [m]: the extent of the column that it is in, plus one spacing `between`
    [m], for the outermost centres are half a spacing inside.

    >>> depth_at(numpy.array([[0.1, 0.5], [0.2, 1.5], [1.5, 0.5]]), 1.0, between=1.0)
    array([2., 2., 1.])
    """
    cells, inverse = numpy.unique(numpy.floor(position[:, :-1] / width).astype(int), axis=0, return_inverse=True)
    inverse = inverse.reshape(-1)
    low, high = _extents(position[:, -1], inverse, len(cells))
    depths: NDArray[Any] = (high - low + between)[inverse]
    return depths


def depth_profile(position: NDArray[Any], width: Optional[float] = None,
                  between: Optional[float] = None) -> Tuple[NDArray[Any], NDArray[Any]]:
    """Depth of the flow along x: middles of the columns (n,) [m] and depths (n,) [m], 0 where there is none.

    In 3-D the depth at an x is the largest over y. `width` [m] of a column (default: four spacings) and `between`,
    the spacing [m] of the particles (default: `spacing(position)`), which is added, as the outermost centres are half a
    spacing inside. A drop in the air counts as depth of the column under it.

    >>> x, depth = depth_profile(numpy.array([[0.5, 0.5], [0.5, 1.5], [2.5, 0.5]]), width=1.0, between=1.0)
    >>> x, depth
    (array([0.5, 1.5, 2.5]), array([2., 0., 1.]))
    """
    if len(position) == 0:
        return numpy.zeros(0), numpy.zeros(0)
    between = spacing(position) if between is None else between
    width = width or 4 * between or 1.0
    column = numpy.floor(position[:, 0] / width).astype(int)
    first = column.min()
    depth = numpy.zeros(column.max() - first + 1)
    numpy.maximum.at(depth, column - first, depth_at(position, width, between))
    return (first + numpy.arange(len(depth)) + 0.5) * width, depth


def depth_along(position: NDArray[Any], start: Sequence[float], end: Sequence[float], width: float,
                between: float) -> Tuple[NDArray[Any], NDArray[Any]]:
    """Depth of the flow along a line on the ground: distances from `start` (n,) [m] and depths (n,) [m], 0 where there is none.

    start, end: x [m] in 2-D, x and y [m] in 3-D; the line is a strip as wide as a column, `width` [m].

    >>> places = numpy.array([[0.5, 0.2, 0.5], [0.5, 0.2, 1.5], [2.5, 0.2, 0.5], [0.5, 9.0, 7.0]])
    >>> depth_along(places, [0, 0], [3, 0], 1.0, between=1.0)
    (array([0.5, 1.5, 2.5]), array([2., 0., 1.]))
    """
    origin = numpy.array(start, dtype=float)
    way = numpy.array(end, dtype=float) - origin
    length = float(numpy.linalg.norm(way))
    way /= length
    relative = position[:, : len(origin)] - origin
    along = relative @ way
    aside = numpy.linalg.norm(relative - along[:, None] * way, axis=1)
    count = max(1, round(length / width))
    inside = (along >= 0) & (along < length) & (aside <= width / 2)
    column = numpy.minimum((along[inside] / length * count).astype(int), count - 1)
    low, high = _extents(position[inside, -1], column, count)
    depth = numpy.where(high >= low, high - low + between, 0.0)
    return (numpy.arange(count) + 0.5) * length / count, depth
