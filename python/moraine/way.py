"""The way of a flow in plan, along which its front is counted: hazard.path of the scene, or the steepest way from its source.

Where a scene has neither path nor ground in 3-D, the way is the x axis.
"""
import dataclasses
import json
import math
from typing import Any, Dict, Mapping, Tuple

import numpy
from numpy.typing import NDArray

from .errors import Error
from .maps import ground_of
from .results import Run
from .steepest import area_of, steepest_way


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
        raise Error(f"{run.path} has no way of the flow (the model of its ground is not where the run found it). Start it where the run was started, or name a way by hazard.path?")
    return Way(steepest_way(ground, *_source(run, scene.get("keys", {}))), "steepest")
