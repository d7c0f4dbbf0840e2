"""Where a run slept: of each place the share of its particle-steps that were saved, from block_loads.bin."""
import base64
import html
import io

import numpy
from charts import scales, text_of, ticks
from plots import Plot, pyplot

COLOURS = "viridis"  # from awake, dark, to asleep, bright
FLAT = 6.0           # times as wide as high at most: flatter places are stretched


def sums_of(loads):
    """Of columns seen from above (3-D) or blocks (2-D), by the lower corner [m]: particle-steps, and those that slept.

    A check stands for half of the steps to the one before, and half of those to the next.
    """
    steps = numpy.diff([check.step for check in loads.checks])
    corners, sums = numpy.empty(0, complex), numpy.empty((2, 0))  # x + iy: sorted as one number
    for check, of in zip(loads.checks, (numpy.append(0, steps) + numpy.append(steps, 0)) / 2):
        made = of * check.rows["particles"]
        x, y = loads.position(check)[:2]
        sums = numpy.concatenate((sums, (made, made * check.asleep)), axis=1)
        corners, at = numpy.unique(numpy.concatenate((corners, x + 1j * y)), return_inverse=True)
        sums = numpy.stack([numpy.bincount(at, weights=row) for row in sums])
    return dict(zip(zip(corners.real.tolist(), corners.imag.tolist()), sums.T.tolist()))


class Map:
    """The places of a run on a lattice: corner, shares (rows upwards; no number where nothing was), and limits [m]."""

    def __init__(self, loads, place):
        corners = numpy.array(list(place))
        self.side = loads.side
        self.low = corners.min(axis=0)
        cells = numpy.rint((corners - self.low) / self.side).astype(int)
        self.size = cells.max(axis=0) + 1
        self.shares = numpy.full(self.size[::-1], numpy.nan)
        for (column, row), (made, slept) in zip(cells, place.values()):
            self.shares[row, column] = slept / made if made else numpy.nan
        self.high = self.low + self.side * self.size
        wide, tall = self.high - self.low
        self.stretch = max(1.0, wide / tall / FLAT)

    def png(self):
        """One pixel a place; transparent where nothing was."""
        from matplotlib import colormaps
        from PIL import Image
        colours = colormaps[COLOURS](numpy.nan_to_num(self.shares[::-1]))
        colours[..., 3] = numpy.isfinite(self.shares[::-1])
        out = io.BytesIO()
        Image.fromarray((255 * colours).round().astype(numpy.uint8), "RGBA").save(out, format="PNG", optimize=True)
        return "data:image/png;base64," + base64.b64encode(out.getvalue()).decode()

    def html(self, name):
        wide, tall = self.high - self.low
        rows = max(1, min(5, int(300 * tall * self.stretch / wide / 22)))
        xs = [((x - self.low[0]) / wide * 100, text_of(x)) for x in ticks(self.low[0], self.high[0], 5)]
        ys = [((self.high[1] - y) / tall * 100, text_of(y)) for y in ticks(self.low[1], self.high[1], rows)]
        down, along = scales(xs, ys)
        return (f'<figure class="still"><h4>{html.escape(name)}</h4><div class="ylabel">y [m]</div><div class="plot">{down}<div class="pane">'
                f'<img alt="share of the particle-steps that slept" style="image-rendering:pixelated;aspect-ratio:{wide / tall / self.stretch:.4f}" '
                f'src="{self.png()}"></div>{along}</div><div class="xlabel">x [m]</div></figure>')

    def draw(self, figure, axes, name):
        mesh = axes.pcolormesh(*(numpy.linspace(self.low[a], self.high[a], self.size[a] + 1) for a in (0, 1)), 100 * self.shares, cmap=COLOURS, vmin=0, vmax=100)
        axes.set(xlabel="x [m]", ylabel="y [m]", aspect=self.stretch, title=name)
        axes.grid(False)
        figure.colorbar(mesh, ax=axes, label="slept [%]")


def bar():
    from matplotlib import colormaps
    stops = ",".join("#%02x%02x%02x" % tuple(int(255 * part) for part in colormaps[COLOURS](k / 12)[:3]) for k in range(13))
    marks = "".join(f'<span class="{kind}" style="left:{at}%">{at}</span>' for at, kind in ((0, "first"), (25, ""), (50, ""), (75, ""), (100, "last")))
    return (f'<div class="bar"><div class="ylabel">particle-steps that slept [%]</div><div class="colours" style="background:linear-gradient(to right,{stops})">'
            f'</div><div class="xs">{marks}</div></div>')


def where_it_slept(runs):
    """None of runs without sleepers, or without their block loads."""
    runs = [run for run in runs if run.loads and run.loads.slept and len(run.loads.checks) > 1]
    if not runs:
        return None
    figure, panels = pyplot.subplots(len(runs), 1, figsize=(8, 2.6 * len(runs)), squeeze=False)
    rows, parts, saved, stretched = [], [], [], False
    for run, axes in zip(runs, panels[:, 0]):
        place = sums_of(run.loads)
        seen = Map(run.loads, place)
        seen.draw(figure, axes, run.name)
        parts.append(seen.html(run.name))
        stretched = stretched or seen.stretch > 1
        rows += [(run.name, x, y, made, slept) for (x, y), (made, slept) in sorted(place.items())]
        made, slept = (sum(sums[k] for sums in place.values()) for k in (0, 1))
        saved.append(f"{run.name} made {(made - slept) / 1e6:.4g} million particle-steps and saved {slept / 1e6:.4g} million ({100 * slept / made:.1f} %).")
    flat = all(run.loads.dimensions == 2 for run in runs)
    caption = ("Share of its particle-steps that a place slept, by " + ("block" if flat else "column of blocks, seen from above")
               + (", from the block loads. " if not stretched else ", from the block loads; heights are stretched. ") + " ".join(saved))
    return Plot("where_it_slept", "Where it slept", caption, figure, ("run", "x_m", "y_m", "particle_steps", "slept"), rows,
                bar() + "".join(parts))
