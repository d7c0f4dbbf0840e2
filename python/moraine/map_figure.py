"""A figure of a map over the shaded ground, with outline, lines of equal height, scale bar and legend."""
import math
from typing import Any, List, Optional, Tuple

import matplotlib
import matplotlib.patheffects
import numpy
from numpy.typing import NDArray
from matplotlib.collections import LineCollection
from matplotlib.colors import BoundaryNorm, LightSource
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from .axis_text import label_axis
from .grids import Grid

OUTLINE, HALO = "#b2182b", [matplotlib.patheffects.withStroke(linewidth=3, foreground="white")]
STYLE: Any = {"font.size": 11, "axes.titlesize": 12, "axes.linewidth": 0.8, "figure.dpi": 100}


def _round(length: float) -> float:
    """The largest of 1, 2, 5, 10, ... that is not longer.

    >>> [_round(x) for x in (0.7, 49, 50, 260)]
    [0.5, 20.0, 50.0, 200.0]
    """
    ten = 10.0 ** math.floor(math.log10(length))
    return ten * max(step for step in (1, 2, 5) if step * ten <= length * (1 + 1e-9))


def _outline(reached: NDArray[Any], grid: Grid) -> List[Any]:
    """Edges [m] between cells that were reached and cells that were not."""
    padded = numpy.pad(reached, 1)
    west, _, south, _ = grid.extent
    lines = []
    for row, column in zip(*numpy.nonzero(padded[:, 1:] != padded[:, :-1])):
        x, y = west + column * grid.cell, south + (row - 1) * grid.cell
        lines.append([(x, y), (x, y + grid.cell)])
    for row, column in zip(*numpy.nonzero(padded[1:] != padded[:-1])):
        x, y = west + (column - 1) * grid.cell, south + row * grid.cell
        lines.append([(x, y), (x + grid.cell, y)])
    return lines


def _shade(box: Any, ground: Grid) -> float:
    """Hillshade with lines of equal height; returns the height between two of these [m]."""
    known = numpy.where(numpy.isfinite(ground.values), ground.values, numpy.nanmin(ground.values))
    light = LightSource(azdeg=315, altdeg=45).hillshade(known[::-1], dx=ground.cell, dy=ground.cell)[::-1]
    shown = numpy.where(numpy.isfinite(ground.values), 0.3 + 0.62 * light, numpy.nan)
    box.imshow(shown, cmap="gray", vmin=0, vmax=1, extent=ground.extent, origin="lower", interpolation="bilinear", zorder=0)
    between = _round(max(numpy.ptp(known) / 8, 1e-9))
    x, y = (numpy.linspace(ground.first[a], ground.last[a], ground.values.shape[1 - a]) for a in (0, 1))
    heights = numpy.arange(math.ceil(known.min() / between), math.floor(known.max() / between) + 1) * between
    if min(known.shape) > 1 and len(heights):
        lines = box.contour(x, y, ground.values, levels=heights, colors="0.25", linewidths=0.5, alpha=0.7, zorder=1)
        box.clabel(lines, fontsize=8.5, fmt="%g")
    return between


def _scale_bar(box: Any) -> None:
    (west, east), (south, north) = box.get_xlim(), box.get_ylim()
    long = _round((east - west) / 4)
    x, y, tall = east - 0.03 * (east - west) - long, south + 0.05 * (north - south), 0.012 * (east - west)
    for part, colour in ((0, "black"), (0.5, "white")):
        box.add_patch(matplotlib.patches.Rectangle((x + part * long, y), long / 2, tall, facecolor=colour, edgecolor="black", linewidth=0.8, zorder=6))
    box.text(x + long / 2, y + 1.6 * tall, f"{long:g} m", ha="center", va="bottom", zorder=6, path_effects=HALO)


def _colours(values: NDArray[Any], name: str) -> Any:
    most = float(values.max()) if values.size else 1.0
    levels = MaxNLocator(10, steps=[1, 2, 2.5, 5, 10]).tick_values(0, most if most > 0 else 1.0)
    colours = matplotlib.colormaps[name].resampled(256)
    return colours, BoundaryNorm(levels, 256)


def draw_map(label: str, colours: str, grid: Grid, reached: NDArray[Any], ground: Optional[Grid], title: str = "") -> Figure:
    """A figure of a map: its cells where the flow came, over the ground, with outline, heights, scale bar and colour bar.

    colours: a colour map of matplotlib; reached (rows, columns): the cells that the outline is around.
    """
    west, east, south, north = grid.extent
    wide = min(8.0, 5.5 * (east - west) / (north - south))
    tall, legend = wide * (north - south) / (east - west), 0.35
    size = (0.85 + wide + 1.15, 0.4 + tall + 0.62 + legend)
    values = numpy.where(reached, grid.values, numpy.nan)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=size)
        box = figure.add_axes((0.85 / size[0], (0.62 + legend) / size[1], wide / size[0], tall / size[1]))
        between = _shade(box, ground.within(*grid.extent)) if ground else None
        palette, norm = _colours(values[numpy.isfinite(values)], colours)
        marks = box.imshow(values, cmap=palette, norm=norm, extent=grid.extent, origin="lower", interpolation="nearest", alpha=0.8, zorder=2)
        box.add_collection(LineCollection(_outline(reached, grid), colors=OUTLINE, linewidths=1.4, capstyle="round", zorder=3))
        box.set(xlim=(west, east), ylim=(south, north), facecolor="0.93")
        for axis, inches in ((box.xaxis, wide), (box.yaxis, tall)):
            axis.set_major_locator(MaxNLocator(max(2, int(1.1 * inches)), steps=[1, 2, 5, 10]))
        label_axis(box.xaxis, "x", west, east)
        label_axis(box.yaxis, "y", south, north)
        _scale_bar(box)
        box.set_title(title, loc="left")
        bar = figure.colorbar(marks, cax=figure.add_axes(((0.85 + wide + 0.15) / size[0], (0.62 + legend) / size[1], 0.16 / size[0], tall / size[1])))
        bar.set_label(label)
        _legend(figure, between, size)
    return figure


def _legend(figure: Figure, between: Optional[float], size: Tuple[float, float]) -> None:
    lines = [matplotlib.lines.Line2D([], [], color=OUTLINE, linewidth=1.4, label="reached by the flow")]
    if between:
        lines.append(matplotlib.lines.Line2D([], [], color="0.25", linewidth=0.8, label=f"height of the ground, every {between:g} m"))
    figure.legend(handles=lines, loc="lower left", bbox_to_anchor=(0.85 / size[0], 0.06 / size[1]), ncol=2, frameon=False, borderaxespad=0)
