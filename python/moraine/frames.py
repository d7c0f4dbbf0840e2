"""Figures of a run: particles coloured by a field, with their surroundings, over a profile of the depth along x."""
import math
import textwrap
from typing import Any, List, Sequence, Tuple

import matplotlib
import numpy
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from .columns import depth_at, depth_profile, spacing
from .particles import Particles
from .results import Run
from .surroundings import Surroundings

#: Fields that a picture shows: label with unit, colour map, and the share of particles [%] that may lie below and above the
#: scale, or None where that begins at 0. A few extreme pressures would leave one colour for all others.
FIELDS = {"speed": ("speed [m/s]", "viridis", (None, 0.2)), "pressure": ("pressure [kPa]", "plasma", (2, 2)),
          "depth": ("depth of the flow [m]", "cividis", (None, 0))}
NEEDS = {"speed": ["velocity"], "pressure": ["pressure"], "depth": []}

DRAWN = 300_000  # particles at most: more do not show in a picture
LEFT, RIGHT, TOP, BOTTOM, GAP, PROFILE = 0.75, 1.1, 0.4, 0.6, 0.62, 1.3  # [inch]
STYLE: Any = {"font.size": 11, "axes.titlesize": 12, "axes.linewidth": 0.8, "hatch.linewidth": 0.5, "figure.dpi": 100}


class Frames:
    """Draws outputs `ks` of a run, all in one scale, so that pictures can be compared.

    3-D runs are seen from above and from the side (y towards the reader), 2-D runs from the side.
    """

    def __init__(self, run: Run, ks: Sequence[int], field: str, around: Surroundings, title: str = "") -> None:
        self.run, self.field, self.around, self.title = run, field, around, title
        self.views: List[Tuple[int, int]] = [(0, 1)] if run.dimensions == 2 else [(0, 1), (0, 2)]
        first = run.particles.read(0, [])
        self.between = spacing(first.position)
        self.width = 4 * self.between or 1.0
        self.first_time, self.first = first.time, self.profile(first)
        self._survey(ks)

    def profile(self, particles: Particles) -> Tuple[numpy.ndarray, numpy.ndarray]:
        return depth_profile(particles.position, self.width, self.between)

    def values(self, particles: Particles) -> numpy.ndarray:
        if self.field == "speed":
            return particles.speed()
        if self.field == "pressure":
            return particles["pressure"] / 1e3
        return depth_at(particles.position, self.width, self.between)

    def _survey(self, ks: Sequence[int]) -> None:
        """Limits of the view, of the colours and of the depth, over all outputs that will be drawn."""
        low, high = numpy.full(self.run.dimensions, numpy.inf), numpy.full(self.run.dimensions, -numpy.inf)
        below, above = FIELDS[self.field][2]
        ranges, self.deepest = [], float(self.first[1].max(initial=0))
        for k in ks:
            particles = self.run.particles.read(k, NEEDS[self.field])
            if len(particles) == 0:
                continue
            low, high = numpy.minimum(low, particles.position.min(axis=0)), numpy.maximum(high, particles.position.max(axis=0))
            for view in self.views:
                for _, shape in self.around.outlines(view, particles.time):
                    for end, axis in enumerate(view):
                        low[axis], high[axis] = min(low[axis], shape[:, end].min()), max(high[axis], shape[:, end].max())
            ranges.append(numpy.percentile(self.values(particles), [below or 0, 100 - above]))
            self.deepest = max(self.deepest, float(self.profile(particles)[1].max()))
        margin = max(0.03 * float((high - low).max()), self.between)
        self.limits = self.around.clip(numpy.column_stack([low - margin, high + margin]), margin)
        least = 0.0 if below is None else float(numpy.min(ranges))
        most = float(numpy.max(ranges))
        self.range = (least, most if most > least else least + 1)  # all alike: of a flow at rest, or one pressure

    def figure(self, k: int) -> Figure:
        """Output k. Each panel has as many inches a metre along both axes."""
        particles = self.run.particles.read(k, NEEDS[self.field])
        side = self.limits[:, 1] - self.limits[:, 0]
        scale = min(8 / side[0], 5 / max(side[view[1]] for view in self.views))
        wide, tall = side[0] * scale, [max(side[view[1]] * scale, 0.5) for view in self.views]
        wide = max(wide, 3.0)  # a narrow flow stands in a view that is wider than it
        size = (LEFT + wide + RIGHT, TOP + sum(tall) + PROFILE + GAP * len(tall) + BOTTOM)
        with matplotlib.rc_context(STYLE):
            figure = Figure(figsize=size)
            at = size[1] - TOP
            for view, height in zip(self.views, tall):
                at -= height
                box = figure.add_axes((LEFT / size[0], at / size[1], wide / size[0], height / size[1]))
                marks = self._particles(box, view, particles, wide, height)
                if view == self.views[0]:
                    box.set_title(f"t = {particles.time:.2f} s", loc="left", fontweight="bold")
                    box.set_title(textwrap.shorten(self.title, int(11 * (wide - 1)), placeholder=" ..."), loc="right")
                    self._colour_bar(figure, marks, at, height, size, wide)
                at -= GAP
            below = figure.add_axes((LEFT / size[0], (at - PROFILE) / size[1], wide / size[0], PROFILE / size[1]))
            self._depth(below, particles, figure.axes[0].get_xlim())
        return figure

    def _particles(self, box: Any, view: Tuple[int, int], particles: Particles, wide: float, tall: float) -> Any:
        middle, side = self.limits.mean(axis=1), self.limits[:, 1] - self.limits[:, 0]
        inch = min(wide / side[view[0]], tall / side[view[1]])  # of a metre
        box.set_xlim(middle[view[0]] - wide / inch / 2, middle[view[0]] + wide / inch / 2)
        box.set_ylim(middle[view[1]] - tall / inch / 2, middle[view[1]] + tall / inch / 2)
        thin = math.ceil(len(particles) / DRAWN)
        order = numpy.arange(0, len(particles), thin)
        if particles.dimensions == 3:  # the nearest to the reader last: highest from above, least y from the side
            depth = particles.position[order, 2] if view == (0, 1) else -particles.position[order, 1]
            order = order[numpy.argsort(depth, kind="stable")]
        size = max(72 * inch * self.between * 1.3 * thin ** (1 / particles.dimensions), 0.8)
        _, colours, _ = FIELDS[self.field]
        marks = box.scatter(particles.position[order, view[0]], particles.position[order, view[1]], s=size**2, linewidths=0,
                            c=self.values(particles)[order], cmap=colours, vmin=self.range[0], vmax=self.range[1], zorder=1)
        self.around.draw(box, view, particles.time)
        box.set_ylabel(f"{'xyz'[view[1]]} [m]")  # x stands under the profile, and is that of all
        box.yaxis.set_major_locator(MaxNLocator(max(2, int(2.2 * tall)), steps=[1, 2, 5, 10]))
        return marks

    def _colour_bar(self, figure: Figure, marks: Any, at: float, height: float, size: Tuple[float, float], wide: float) -> None:
        box = figure.add_axes(((LEFT + wide + 0.15) / size[0], at / size[1], 0.16 / size[0], height / size[1]))
        bar = figure.colorbar(marks, cax=box, extend="neither" if self.range[0] == 0 else "both", extendfrac=0.03)
        bar.set_label(FIELDS[self.field][0])
        bar.locator = MaxNLocator(max(2, int(2 * height)), steps=[1, 2, 5, 10])
        bar.update_ticks()

    def _edges(self, middles: numpy.ndarray) -> numpy.ndarray:
        return numpy.append(middles - self.width / 2, middles[-1:] + self.width / 2)

    def _depth(self, box: Any, particles: Particles, limits: Tuple[float, float]) -> None:
        x, depth = self.profile(particles)
        edges = self._edges(x)
        box.stairs(depth, edges, fill=True, color="#9ebcda")
        box.stairs(depth, edges, color="#225ea8", linewidth=1.2, label=f"t = {particles.time:.2f} s")
        if particles.time != self.first_time:
            start, depth = self.first
            box.stairs(depth, self._edges(start), color="0.35", linewidth=1, linestyle="--", label=f"t = {self.first_time:.2f} s")
        box.set(xlim=limits, ylim=(0, 1.1 * self.deepest or 1), xlabel="x [m]", ylabel="depth [m]")
        box.yaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
        box.legend(loc="lower right", bbox_to_anchor=(1, 0.97), frameon=False, ncol=2, borderaxespad=0)
        for edge in ("top", "right"):
            box.spines[edge].set_visible(False)
