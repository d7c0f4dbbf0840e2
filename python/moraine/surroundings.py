"""Walls and structures of a scene, drawn into a view."""
import json
from typing import Any, List, Mapping, Optional, Tuple

import numpy
from numpy.typing import NDArray

from .outlines import displacement_at, outline, turn_at
from .results import Run

SOLID = {"facecolor": "0.82", "edgecolor": "0.35", "linewidth": 1.2}


def surroundings_of(run: Run) -> Optional[Mapping[str, Any]]:
    """scene.json of a run: domain, walls and structures by the keys of a scene. None of a run that has none, or a damaged one."""
    try:
        found = json.loads((run.path / "scene.json").read_text(encoding="utf-8"))
        Surroundings(run, found).solids((0, 1), 0.0, numpy.array([[0.0, 1.0], [0.0, 1.0]]))
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        return None
    return found if isinstance(found, dict) else None


class Surroundings:
    """What stands around the particles of a run, by its scene or its scene.json; None: nothing."""

    def __init__(self, run: Run, scene: Optional[Mapping[str, Any]]) -> None:
        self.dimensions, self._scene = run.dimensions, scene or {}
        self._alpha = 1.0 if run.dimensions == 2 else 0.65  # in 3-D there may be soil before a structure
        self._tables = run.structures if scene else {}

    def outlines(self, axes: Tuple[int, int], time: float) -> List[Tuple[str, NDArray[Any]]]:
        """Name and outline [m] of each structure that has an end, at a time [s]."""
        found = []
        for structure in self._scene.get("structure", []):
            moved = displacement_at(self._tables, structure["name"], time, self.dimensions)
            shape = outline(structure, axes, self.dimensions, moved, turn_at(self._tables, structure["name"], time, self.dimensions))
            if shape is not None:
                found.append((structure["name"], shape))
        return found

    def clip(self, limits: NDArray[Any], margin: NDArray[Any]) -> NDArray[Any]:
        """Limits of a view (dimensions, 2) [m], no further than a margin (dimensions,) [m] outside the domain; what is near a wall shows it."""
        domain = self._scene.get("domain")
        if not domain:
            return limits
        low, high = (numpy.array(domain[end], dtype=float) for end in ("min", "max"))
        return numpy.column_stack([numpy.maximum(limits[:, 0], low - margin), numpy.minimum(limits[:, 1], high + margin)])

    def walls(self, axes: Tuple[int, int], view: NDArray[Any]) -> List[Tuple[int, float, List[float]]]:
        """Closed faces in a view (2, 2) [m]: which of its axes they are across, where, and from where to where they fill it."""
        found = []
        for wall in self._scene.get("wall", []):
            axis = "xyz".index(wall["face"][0])
            if axis not in axes or wall.get("kind") in ("open", "none", "periodic"):
                continue
            across, lower = axes.index(axis), wall["face"].endswith("min")
            face = self._scene["domain"]["min" if lower else "max"][axis]
            outside = [view[across, 0], face] if lower else [face, view[across, 1]]
            if outside[0] < outside[1]:
                found.append((across, face, outside))
        return found

    def planes(self, axes: Tuple[int, int], time: float, view: NDArray[Any]) -> List[NDArray[Any]]:
        """The part (m, 2) [m] of a view that is behind a plane, of each; of none that the view is not along."""
        found = []
        for structure in self._scene.get("structure", []):
            if structure["shape"] != "plane":
                continue
            normal = numpy.array(structure["normal"], dtype=float)
            seen = normal[list(axes)]
            if abs(normal).sum() > abs(seen).sum() * (1 + 1e-9):
                continue
            moved = displacement_at(self._tables, structure["name"], time, self.dimensions)
            shape = _behind(view, (numpy.array(structure["point"]) + moved)[list(axes)], seen)
            if len(shape):
                found.append(shape)
        return found

    def solids(self, axes: Tuple[int, int], time: float, view: NDArray[Any]) -> List[Tuple[NDArray[Any], str]]:
        """All of these as polygons (m, 2) [m], each a "wall" or a "structure"."""
        found = []
        for across, _, outside in self.walls(axes, view):
            x, y = (outside, view[1]) if across == 0 else (view[0], outside)
            found.append((numpy.array([[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]]), "wall"))
        shapes = self.planes(axes, time, view) + [shape for _, shape in self.outlines(axes, time)]
        return found + [(shape, "structure") for shape in shapes]

    def draw(self, panel: Any, axes: Tuple[int, int], time: float) -> None:
        """Walls, planes and structures at a time [s] into a panel (matplotlib Axes) whose limits are set."""
        view = numpy.array([panel.get_xlim(), panel.get_ylim()])
        for across, face, outside in self.walls(axes, view):
            span, line = (panel.axvspan, panel.axvline) if across == 0 else (panel.axhspan, panel.axhline)
            span(*outside, facecolor="0.9", edgecolor="0.6", hatch="////", linewidth=0, zorder=2)
            line(face, color="0.25", linewidth=1.5, zorder=2.5)
        for shape in self.planes(axes, time, view):
            panel.fill(shape[:, 0], shape[:, 1], zorder=3, **SOLID)
        for name, shape in self.outlines(axes, time):
            panel.fill(shape[:, 0], shape[:, 1], zorder=3, alpha=self._alpha, **SOLID)
            low, high = numpy.maximum(shape.min(axis=0), view[:, 0]), numpy.minimum(shape.max(axis=0), view[:, 1])
            if (low < high).all():  # the name stands in the middle of what is in view
                middle = (low + high) / 2
                panel.annotate(name, middle, ha="center", va="center", zorder=4, clip_on=True)


def _behind(view: NDArray[Any], point: NDArray[Any], normal: NDArray[Any]) -> NDArray[Any]:
    """The view's rectangle, cut by the line through a point across a normal: what is behind it, (m, 2)."""
    corners = numpy.array([[view[0, i], view[1, j]] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))])
    height = (corners - point) @ normal
    behind = []
    for k in range(4):
        if (height[k] <= 0) != (height[k - 1] <= 0):
            share = height[k] / (height[k] - height[k - 1])
            behind.append(corners[k] + share * (corners[k - 1] - corners[k]))
        if height[k] <= 0:
            behind.append(corners[k])
    return numpy.array(behind)
