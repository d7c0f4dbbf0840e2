"""Figures of a run: particles coloured by a field, with their surroundings, over a profile of the depth along x or a line."""
import textwrap
from typing import Any, List, Optional, Sequence, Tuple

import matplotlib
import numpy
from numpy.typing import NDArray
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from .axis_text import label_axis
from .columns import depth_along, depth_profile, spacing
from .fields import field_of, finite
from .panels import colour_bar, draw_particles
from .particles import Particles
from .results import Run
from .surroundings import Surroundings

LEFT, RIGHT, TOP, BOTTOM, GAP, PROFILE = 0.75, 1.1, 0.4, 0.6, 0.62, 1.3  # [inch]
STYLE: Any = {"font.size": 11, "axes.titlesize": 12, "axes.linewidth": 0.8, "hatch.linewidth": 0.5, "figure.dpi": 100}
Line = Tuple[Sequence[float], Sequence[float]]  # start and end [m]: x in 2-D, x and y in 3-D


class Frames:
    """Draws outputs `ks` of a run, all in one scale, so that pictures can be compared.

    3-D runs are seen from above and from the side (y towards the reader), 2-D runs from the side. The profile is along x, or along
    `line`.
    """

    def __init__(self, run: Run, ks: Sequence[int], name: str, around: Surroundings, title: str = "", line: Optional[Line] = None) -> None:
        self.run, self.field, self.around, self.title, self.line = run, field_of(name), around, title, line
        self.views: List[Tuple[int, int]] = [(0, 1)] if run.dimensions == 2 else [(0, 1), (0, 2)]
        first = self.read(0, [])
        self.between = spacing(first.position)
        self.width = 4 * self.between or 1.0
        self.first_time, self.first = first.time, self.profile(first)
        self._survey(ks)

    def read(self, k: int, needs: Optional[Sequence[str]] = None) -> Particles:
        return finite(self.run.particles.read(k, self.field.needs if needs is None else needs))

    def profile(self, particles: Particles) -> Tuple[NDArray[Any], NDArray[Any]]:
        """Places along x, or distances along the line, and depths [m]."""
        if self.line:
            return depth_along(particles.position, *self.line, self.width, self.between)
        return depth_profile(particles.position, self.width, self.between)

    def values(self, particles: Particles) -> NDArray[Any]:
        return self.field.value(particles, self.width, self.between)

    def _survey(self, ks: Sequence[int]) -> None:
        """Limits of the view, of the colours and of the depth, over all outputs that will be drawn."""
        low, high = numpy.full(self.run.dimensions, numpy.inf), numpy.full(self.run.dimensions, -numpy.inf)
        ranges, self.deepest = [], float(self.first[1].max(initial=0))
        for k in ks:
            particles = self.read(k)
            if len(particles) == 0:
                continue
            low, high = numpy.minimum(low, particles.position.min(axis=0)), numpy.maximum(high, particles.position.max(axis=0))
            for view in self.views:
                for _, shape in self.around.outlines(view, particles.time):
                    for end, axis in enumerate(view):
                        low[axis], high[axis] = min(low[axis], shape[:, end].min()), max(high[axis], shape[:, end].max())
            values = self.values(particles)
            values = values[numpy.isfinite(values)]
            if len(values):
                ranges.append(numpy.percentile(values, [self.field.below or 0, 100 - self.field.above]))
            self.deepest = max(self.deepest, float(self.profile(particles)[1].max(initial=0)))
        if not numpy.isfinite(low).all():
            low, high = numpy.zeros(self.run.dimensions), numpy.ones(self.run.dimensions)  # no particle is left
        side = high - low
        margin = numpy.maximum(numpy.minimum(0.03 * side.max(), 0.15 * side), self.between)  # less along the short side of a long flow
        self.limits = self.around.clip(numpy.column_stack([low - margin, high + margin]), margin)
        most = float(numpy.max(ranges)) if ranges else 1.0
        least = 0.0 if self.field.below is None or not ranges else float(numpy.min(ranges))
        self.range = (least, most if most > least else least + 1)  # all alike: of a flow at rest, or one pressure

    def panels(self) -> Tuple[float, List[float]]:
        """Width and heights [inch] of the views; as many inches a metre along both axes."""
        side = self.limits[:, 1] - self.limits[:, 0]
        scale = min(8 / side[0], 5 / max(side[view[1]] for view in self.views))
        # a narrow flow stands in a view that is wider than it
        return max(side[0] * scale, 3.0), [max(side[view[1]] * scale, 0.5) for view in self.views]

    def figure(self, k: int) -> Figure:
        """Output k, over its profile."""
        particles = self.read(k)
        wide, tall = self.panels()
        size = (LEFT + wide + RIGHT, TOP + sum(tall) + PROFILE + GAP * len(tall) + BOTTOM)
        with matplotlib.rc_context(STYLE):
            figure = Figure(figsize=size)
            at = size[1] - TOP
            for view, height in zip(self.views, tall):
                at -= height
                box = figure.add_axes((LEFT / size[0], at / size[1], wide / size[0], height / size[1]))
                marks = draw_particles(self, box, view, particles, wide, height)
                if view == self.views[0]:
                    box.set_title(f"t = {particles.time:.2f} s", loc="left", fontweight="bold")
                    box.set_title(textwrap.shorten(self.title, int(11 * (wide - 1)), placeholder=" ..."), loc="right")
                    colour_bar(self, figure, marks, ((LEFT + wide + 0.15) / size[0], at / size[1], 0.16 / size[0], height / size[1]))
                at -= GAP
            below = figure.add_axes((LEFT / size[0], (at - PROFILE) / size[1], wide / size[0], PROFILE / size[1]))
            self._depth(below, particles, figure.axes[0].get_xlim())
        return figure

    def sheet(self, ks: Sequence[int]) -> Figure:
        """Outputs `ks` in one figure, one above the other, without profiles; 3-D from above."""
        (wide, (tall, *_)), view = self.panels(), self.views[0]
        step = tall + 0.34
        size = (LEFT + wide + RIGHT, step * len(ks) + BOTTOM)
        with matplotlib.rc_context(STYLE):
            figure = Figure(figsize=size)
            for place, k in enumerate(ks):
                particles = self.read(k)
                at = size[1] - step * (place + 1)
                box = figure.add_axes((LEFT / size[0], at / size[1], wide / size[0], tall / size[1]))
                marks = draw_particles(self, box, view, particles, wide, tall)
                box.set_title(f"t = {particles.time:.3g} s", loc="left", pad=4)
                box.set_xticklabels([]) if k != ks[-1] else label_axis(box.xaxis, "x", *box.get_xlim())
            colour_bar(self, figure, marks, ((LEFT + wide + 0.15) / size[0], BOTTOM / size[1], 0.16 / size[0], 1 - (BOTTOM + 0.34) / size[1]))
        return figure

    def _edges(self, middles: NDArray[Any]) -> NDArray[Any]:
        half = (middles[1] - middles[0]) / 2 if len(middles) > 1 else self.width / 2
        return numpy.append(middles - half, middles[-1:] + half)

    def _depth(self, box: Any, particles: Particles, limits: Tuple[float, float]) -> None:
        x, depth = self.profile(particles)
        if self.line:
            limits = (0, float(numpy.linalg.norm(numpy.subtract(*self.line))))
        if len(x):
            box.stairs(depth, self._edges(x), fill=True, color="#9ebcda")
            box.stairs(depth, self._edges(x), color="#225ea8", linewidth=1.2, label=f"t = {particles.time:.2f} s")
        if particles.time != self.first_time:
            start, depth = self.first
            box.stairs(depth, self._edges(start), color="0.35", linewidth=1, linestyle="--", label=f"t = {self.first_time:.2f} s")
        box.set(xlim=limits, ylim=(0, 1.1 * self.deepest or 1), xlabel="distance along the line [m]", ylabel="depth [m]")
        if not self.line:
            label_axis(box.xaxis, "x", *limits)
        box.yaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
        if box.patches:
            box.legend(loc="lower right", bbox_to_anchor=(1, 0.97), frameon=False, ncol=2, borderaxespad=0)
        for edge in ("top", "right"):
            box.spines[edge].set_visible(False)
