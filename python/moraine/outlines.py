"""Outlines of rigid structures, as a view along an axis shows them.

All shapes but the polygon are convex, and so is their silhouette: it is the convex hull of points on the surface, seen along
the axis. A displacement and a turn about the centre place them at any time; of a prism that turns in 3-D the hull is drawn.
"""
from typing import Any, Dict, List, Mapping, Optional, Tuple

import numpy
from numpy.typing import NDArray

from .records import Table

_ROUND = numpy.linspace(0, 2 * numpy.pi, 64, endpoint=False)


def hull(points: NDArray[Any]) -> NDArray[Any]:
    """Corners (m, 2) of the convex hull of points (n, 2), counterclockwise.

    >>> hull(numpy.array([[0, 0], [2, 0], [1, 1], [2, 2], [0, 2]])).tolist()
    [[0, 0], [2, 0], [2, 2], [0, 2]]
    """
    def half(row: List[List[float]]) -> List[List[float]]:
        chain: List[List[float]] = []
        for p in row:
            while len(chain) > 1 and ((chain[-1][0] - chain[-2][0]) * (p[1] - chain[-2][1])
                                      <= (chain[-1][1] - chain[-2][1]) * (p[0] - chain[-2][0])):
                chain.pop()
            chain.append(p)
        return chain[:-1]

    ordered = numpy.unique(points, axis=0).tolist()
    return numpy.array(half(ordered) + half(ordered[::-1]))


def _ball(radius: float, dimensions: int) -> NDArray[Any]:
    circle = radius * numpy.column_stack([numpy.cos(_ROUND), numpy.sin(_ROUND)])
    if dimensions == 2:
        return circle
    rings = []
    for axis in range(3):  # great circles: seen along an axis, one of them is the outline
        rings.append(numpy.insert(circle, axis, 0, axis=1))
    return numpy.concatenate(rings)


def _disk(radius: float, axis: NDArray[Any]) -> NDArray[Any]:
    """Points of a circle around the axis, at the origin."""
    across = numpy.cross(axis, numpy.eye(3)[numpy.argmin(abs(axis))])
    across /= numpy.linalg.norm(across)
    up = numpy.cross(axis, across) / numpy.linalg.norm(axis)
    return radius * (numpy.outer(numpy.cos(_ROUND), across) + numpy.outer(numpy.sin(_ROUND), up))


def _surface(structure: Mapping[str, Any], dimensions: int) -> NDArray[Any]:
    shape = structure["shape"]
    if shape == "sphere":
        ball: NDArray[Any] = _ball(structure["radius"], dimensions) + numpy.array(structure["center"])
        return ball
    if shape == "box":
        both = numpy.array([structure["min"], structure["max"]], dtype=float)
        corners: NDArray[Any] = numpy.stack(numpy.meshgrid(*both.T), axis=-1).reshape(-1, dimensions)
        return corners
    if shape == "polygon":
        points = numpy.array(structure["points"], dtype=float)
        return points if dimensions == 2 else numpy.concatenate([numpy.insert(points, 2, z, axis=1) for z in structure["z"]])
    ends = [numpy.array(structure[end], dtype=float) for end in ("from", "to")]
    ring = _ball(structure["radius"], dimensions) if shape == "capsule" else _disk(structure["radius"], ends[1] - ends[0])
    return numpy.concatenate([ring + end for end in ends])


def _centre(structure: Mapping[str, Any], points: NDArray[Any]) -> NDArray[Any]:
    """About what a structure turns: the middle of its points, of a polygon that of its area.

    >>> _centre({"shape": "polygon", "points": [[0, 0], [3, 0], [0, 3]]}, numpy.array([[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]])).tolist()
    [1.0, 1.0]
    """
    middle: NDArray[Any] = (points.min(axis=0) + points.max(axis=0)) / 2
    if structure["shape"] == "polygon":
        x, y = numpy.array(structure["points"], dtype=float).T
        twice = numpy.roll(x, 1) * y - x * numpy.roll(y, 1)
        middle[:2] = [(twice * (v + numpy.roll(v, 1))).sum() / (3 * twice.sum()) for v in (x, y)]
    return middle


def outline(structure: Mapping[str, Any], axes: Tuple[int, int], dimensions: int, displacement: NDArray[Any],
            turn: Optional[NDArray[Any]] = None) -> Optional[NDArray[Any]]:
    """Outline (m, 2) [m] of a [[structure]] of the scene in the plane of the two axes; None of a plane, which has no end, and of
    ground in 3-D, whose heights are in its own file. turn: a matrix (dimensions, dimensions), of one that turns.

    >>> box = {"shape": "box", "min": [0, 0], "max": [2, 1]}
    >>> outline(box, (0, 1), 2, numpy.array([1.0, 0.0])).tolist()
    [[1.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0]]
    """
    if structure["shape"] in ("plane", "ground"):
        return None
    moved = displacement[list(axes)]
    if turn is not None:
        points = _surface(structure, dimensions)
        centre = _centre(structure, points)
        corners = ((points - centre) @ turn.T + centre)[:, list(axes)]
        corners = corners if structure["shape"] == "polygon" and dimensions == 2 else hull(corners)
    elif structure["shape"] == "polygon":
        corners = numpy.array(structure["points"], dtype=float)
        if axes != (0, 1):
            low, high = corners[:, 0].min(), corners[:, 0].max()
            corners = numpy.array([[x, z] for x, z in zip((low, high, high, low), numpy.repeat(structure["z"], 2))])
    else:
        corners = hull(_surface(structure, dimensions)[:, list(axes)])
    there: NDArray[Any] = corners + moved
    return there


def displacement_at(tables: Dict[str, Table], name: str, time: float, dimensions: int) -> NDArray[Any]:
    """How far a structure has come at a time [s], (dimensions,) [m], from the run's structures; 0 where no row tells.

    Between the rows it is linear, and before the first one it comes from 0 at the start. What is no number is passed over.
    """
    if name not in tables:
        return numpy.zeros(dimensions)
    rows = tables[name]
    moved = []
    for axis in "xyz"[:dimensions]:
        values = rows[f"displacement_{axis}_m"]
        known = numpy.isfinite(values)
        moved.append(numpy.interp(time, numpy.insert(rows["time_s"][known], 0, 0.0), numpy.insert(values[known], 0, 0.0)))
    return numpy.array(moved)


def turn_at(tables: Dict[str, Table], name: str, time: float, dimensions: int) -> Optional[NDArray[Any]]:
    """How a structure is turned at a time [s], a matrix (dimensions, dimensions); None where no row tells. Between the rows as
    displacement_at; a quaternion is brought back to its length.

    >>> rows = {"time_s": numpy.array([1.0]), "angle_rad": numpy.array([numpy.pi / 2])}
    >>> turn_at({"door": rows}, "door", 1.0, 2).round(12).tolist()
    [[0.0, -1.0], [1.0, 0.0]]
    """
    rows = tables.get(name, {})
    parts = ["angle_rad"] if dimensions == 2 else [f"quaternion_{part}" for part in "wxyz"]
    if parts[0] not in rows:
        return None
    w, *axis = [numpy.interp(time, numpy.insert(rows["time_s"], 0, 0.0), numpy.insert(rows[part], 0, float(part == "quaternion_w")))
                for part in parts]
    if dimensions == 2:
        return numpy.array([[numpy.cos(w), -numpy.sin(w)], [numpy.sin(w), numpy.cos(w)]])
    x, y, z = axis
    cross = numpy.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn: NDArray[Any] = numpy.eye(3) + 2 * (w * cross + cross @ cross) / (w * w + x * x + y * y + z * z)
    return turn
