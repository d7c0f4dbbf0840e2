"""Particles and the bar of their colours, drawn into a figure."""
import math
from typing import Any, Tuple

import matplotlib
import numpy
from numpy.typing import NDArray
from matplotlib.colors import ListedColormap
from matplotlib.ticker import MaxNLocator

from .axis_text import label_axis
from .particles import Particles

#: of ranks: ten that differ for the red-green blind, too (P. Tol's "muted", and black)
RANKS = ("#332288", "#88ccee", "#ddcc77", "#117733", "#cc6677", "#44aa99", "#aa4499", "#999933", "#882255", "#000000")
DRAWN = 300_000  # particles at most: more do not show in a picture


def _order(particles: Particles, view: Tuple[int, int], thin: int) -> NDArray[Any]:
    """Which particles are drawn, in which order: in 3-D the nearest to the reader last, highest from above, least y from the side."""
    order = numpy.arange(0, len(particles), thin)
    if particles.dimensions == 2:
        return order
    near = particles.position[order, 2] if view == (0, 1) else -particles.position[order, 1]
    return order[numpy.argsort(near, kind="stable")]


def draw_particles(frames: Any, box: Any, view: Tuple[int, int], particles: Particles, wide: float, tall: float) -> Any:
    """Particles and what stands around them, into a panel of so many inches; what is no number is grey. Returns the marks."""
    middle, side = frames.limits.mean(axis=1), frames.limits[:, 1] - frames.limits[:, 0]
    inch = min(wide / side[view[0]], tall / side[view[1]])  # of a metre
    box.set_xlim(middle[view[0]] - wide / inch / 2, middle[view[0]] + wide / inch / 2)
    box.set_ylim(middle[view[1]] - tall / inch / 2, middle[view[1]] + tall / inch / 2)
    thin = math.ceil(len(particles) / DRAWN) or 1
    order = _order(particles, view, thin)
    size = max(72 * inch * frames.between * 1.3 * thin ** (1 / particles.dimensions), 0.8)
    values = frames.values(particles)[order]
    if frames.field.label == "rank":  # of ten colours, again and again
        values, limits = values % 10, (-0.5, 9.5)
    else:
        limits = frames.range
    named = frames.field.colours
    colours = (ListedColormap(RANKS) if named == "ranks" else matplotlib.colormaps[named]).with_extremes(bad="0.6")
    marks = box.scatter(particles.position[order, view[0]], particles.position[order, view[1]], s=size**2, linewidths=0, c=values,
                        cmap=colours, vmin=limits[0], vmax=limits[1], zorder=1, plotnonfinite=True)
    frames.around.draw(box, view, particles.time)
    if frames.line and view == (0, 1) and particles.dimensions == 3:
        box.plot(*numpy.transpose(frames.line), color="#b2182b", linewidth=1.5, zorder=5)
    label_axis(box.yaxis, "xyz"[view[1]], *box.get_ylim())  # x stands under the profile, and is that of all
    label_axis(box.xaxis, "xyz"[view[0]], *box.get_xlim())
    box.set_xlabel("")
    box.yaxis.set_major_locator(MaxNLocator(max(2, int(2.2 * tall)), steps=[1, 2, 5, 10]))
    return marks


def colour_bar(frames: Any, figure: Any, marks: Any, place: Tuple[float, float, float, float]) -> None:
    """At left, bottom, width, height of the figure."""
    box = figure.add_axes(place)
    bar = figure.colorbar(marks, cax=box, extend="neither" if frames.range[0] == 0 else "both", extendfrac=0.03)
    bar.set_label(frames.field.label)
    if frames.field.label == "rank":
        most = min(9, int(frames.range[1]))
        box.set_ylim(-0.5, most + 0.5)
        bar.set_ticks(range(most + 1))
        return
    tall = place[3] * figure.get_size_inches()[1]
    bar.locator = MaxNLocator(max(2, int(2 * tall)), steps=[1, 2, 5, 10])
    bar.update_ticks()
