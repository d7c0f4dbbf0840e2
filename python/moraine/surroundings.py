"""Walls and structures of a scene, drawn into a view."""
from typing import Any, List, Mapping, Optional, Sequence, Tuple

import numpy

from .outlines import displacement_at, outline
from .results import Run

SOLID = {"facecolor": "0.82", "edgecolor": "0.35", "linewidth": 1.2}


class Surroundings:
    """What stands around the particles of a run. Files of a run do not tell it, so it is from the scene; None: nothing."""

    def __init__(self, run: Run, scene: Optional[Mapping[str, Any]]) -> None:
        self.dimensions, self._scene = run.dimensions, scene or {}
        self._alpha = 1.0 if run.dimensions == 2 else 0.65  # in 3-D there may be soil before a structure
        self._tables = run.structures if scene else {}

    def outlines(self, axes: Tuple[int, int], time: float) -> List[Tuple[str, numpy.ndarray]]:
        """Name and outline [m] of each structure that has an end, at a time [s]."""
        found = []
        for structure in self._scene.get("structure", []):
            moved = displacement_at(self._tables, structure["name"], time, self.dimensions)
            shape = outline(structure, axes, self.dimensions, moved)
            if shape is not None:
                found.append((structure["name"], shape))
        return found

    def clip(self, limits: numpy.ndarray, margin: float) -> numpy.ndarray:
        """Limits of a view (dimensions, 2) [m], no further than a margin [m] outside the domain; what is near a wall shows it."""
        domain = self._scene.get("domain")
        if not domain:
            return limits
        low, high = (numpy.array(domain[end], dtype=float) for end in ("min", "max"))
        return numpy.column_stack([numpy.maximum(limits[:, 0], low - margin), numpy.minimum(limits[:, 1], high + margin)])

    def draw(self, panel: Any, axes: Tuple[int, int], time: float) -> None:
        """Walls, planes and structures at a time [s] into a panel (matplotlib Axes) whose limits are set."""
        view = numpy.array([panel.get_xlim(), panel.get_ylim()])
        for wall in self._scene.get("wall", []):
            axis = "xyz".index(wall["face"][0])
            if axis in axes and wall.get("kind") not in ("open", "none"):
                self._wall(panel, view, axes.index(axis), wall["face"].endswith("min"), axis)
        for structure in self._scene.get("structure", []):
            if structure["shape"] == "plane":
                moved = displacement_at(self._tables, structure["name"], time, self.dimensions)
                self._plane(panel, view, axes, numpy.array(structure["point"]) + moved, numpy.array(structure["normal"]))
        for name, shape in self.outlines(axes, time):
            panel.fill(shape[:, 0], shape[:, 1], zorder=3, alpha=self._alpha, **SOLID)
            low, high = numpy.maximum(shape.min(axis=0), view[:, 0]), numpy.minimum(shape.max(axis=0), view[:, 1])
            if (low < high).all():  # the name stands in the middle of what is in view
                middle = (low + high) / 2
                panel.annotate(name, middle, ha="center", va="center", zorder=4, clip_on=True)

    def _wall(self, panel: Any, view: numpy.ndarray, across: int, lower: bool, axis: int) -> None:
        domain = self._scene["domain"]
        face = domain["min" if lower else "max"][axis]
        outside = [view[across, 0], face] if lower else [face, view[across, 1]]
        if outside[0] >= outside[1]:
            return  # not in view
        span = panel.axvspan if across == 0 else panel.axhspan
        span(*outside, facecolor="0.9", edgecolor="0.6", hatch="////", linewidth=0, zorder=2)
        (panel.axvline if across == 0 else panel.axhline)(face, color="0.25", linewidth=1.5, zorder=2.5)

    def _plane(self, panel: Any, view: numpy.ndarray, axes: Sequence[int], point: numpy.ndarray, normal: numpy.ndarray) -> None:
        """The half of the view behind a plane; nothing where the view is not along the plane."""
        seen = normal[list(axes)].astype(float)
        if abs(normal).sum() > abs(seen).sum() * (1 + 1e-9):
            return
        corners = numpy.array([[view[0, i], view[1, j]] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))])
        height = (corners - point[list(axes)]) @ seen
        behind = []
        for k in range(4):  # the view's rectangle, cut by the line
            if height[k] <= 0:
                behind.append(corners[k])
            if (height[k] <= 0) != (height[k - 3] <= 0):
                share = height[k] / (height[k] - height[k - 3])
                behind.append(corners[k] + share * (corners[k - 3] - corners[k]))
        if behind:
            shape = numpy.array(behind)
            panel.fill(shape[:, 0], shape[:, 1], zorder=3, **SOLID)
