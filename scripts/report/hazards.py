"""Hazard maps of a run for the page: PNGs over the shaded ground without labels, which the page adds around them."""
import base64
import html
import io
import warnings

import numpy
from charts import scales, text_of, ticks
from matplotlib import colormaps
from matplotlib.colors import LightSource
from matplotlib.ticker import MaxNLocator
from moraine.axis_text import axis_title, offset_of
from PIL import Image, ImageDraw

WIDE, TALL = 1240, 760                     # pixels at most
FLOW, HEIGHT, SOLID = (178, 24, 43), (70, 70, 70), 0.8  # outline, lines of equal height, share of a map's colour
LINE = 3                                   # of the outline, in pixels
MAPS = 8                                   # at most
NARROW = 300                               # pixels of a map on a screen of 390
DIFFERENT = ("max_depth", "deposit")       # of which differences of runs are shown
MARKS = {"release": ((20, 20, 20), "release or inflow"), "section": ((0, 90, 181), "section"), "gauge": ((0, 90, 181), "gauge"), "way": ((120, 60, 160), "way of the flow")}


def round_length(length):
    """The largest of 1, 2, 5, 10, ... that is not longer."""
    ten = 10.0 ** numpy.floor(numpy.log10(length))
    return float(ten * max(step for step in (1, 2, 5) if step * ten <= length * (1 + 1e-9)))


def levels_of(values):
    most = float(values.max()) if values.size else 1.0
    return [float(v) for v in MaxNLocator(8, steps=[1, 2, 2.5, 5, 10]).tick_values(0, most if most > 0 else 1.0)]


class Sheet:
    """The paper of all maps of a run: limits [m], pixels, and the shaded ground."""

    def __init__(self, grid, ground):
        self.west, self.east, self.south, self.north = grid.extent
        self.scale = min(WIDE / (self.east - self.west), TALL / (self.north - self.south))  # pixels of a metre
        self.size = (max(2, round((self.east - self.west) * self.scale)), max(2, round((self.north - self.south) * self.scale)))
        x = self.west + (numpy.arange(self.size[0]) + 0.5) / self.scale
        y = self.north - (numpy.arange(self.size[1]) + 0.5) / self.scale
        self.at = numpy.meshgrid(x, y)
        self.between, self.paper = 0.0, numpy.full((self.size[1], self.size[0], 3), 237, dtype=numpy.uint8)
        if ground is not None and min(ground.within(*grid.extent).values.shape) > 1:
            self._shade(ground.within(*grid.extent))

    def cells(self, grid):
        """Row and column of a grid's cell under each pixel, and whether there is one."""
        columns, rows = (numpy.floor((place - edge) / grid.cell).astype(int) for place, edge in zip(self.at, (grid.extent[0], grid.extent[2])))
        inside = (rows >= 0) & (rows < grid.values.shape[0]) & (columns >= 0) & (columns < grid.values.shape[1])
        return numpy.where(inside, rows, 0), numpy.where(inside, columns, 0), inside

    def _shade(self, ground):
        known = numpy.where(numpy.isfinite(ground.values), ground.values, numpy.nanmin(ground.values))
        light = LightSource(azdeg=315, altdeg=45).hillshade(known[::-1], dx=ground.cell, dy=ground.cell)
        whole = Image.fromarray(((0.3 + 0.62 * light) * 255).astype(numpy.uint8))
        west, east, south, north = ground.extent
        box = [(self.west - west) / ground.cell, (north - self.north) / ground.cell, (self.east - west) / ground.cell, (north - self.south) / ground.cell]
        limit = (whole.size[0], whole.size[1], whole.size[0], whole.size[1])
        box = [min(max(edge, 0), most) for edge, most in zip(box, limit)]
        shade = whole.resize(self.size, Image.BILINEAR, box=box)
        self.paper = numpy.repeat(numpy.asarray(shade)[:, :, None], 3, axis=2)
        self._contours(ground, known)

    def _contours(self, ground, known):
        """Lines of equal height, as far as the contouring of matplotlib is there."""
        try:
            from contourpy import contour_generator
        except ImportError:
            return
        self.between = round_length(max(float(numpy.ptp(known)) / 8, 1e-9))
        picture = Image.fromarray(self.paper)
        draw = ImageDraw.Draw(picture)
        x, y = (ground.first[a] + ground.cell * numpy.arange(known.shape[1 - a]) for a in (0, 1))
        generator = contour_generator(x, y, known)
        for k in range(int(numpy.ceil(known.min() / self.between)), int(numpy.floor(known.max() / self.between)) + 1):
            for line in generator.lines(k * self.between):
                draw.line([((px - self.west) * self.scale, (self.north - py) * self.scale) for px, py in line], fill=HEIGHT, width=1)
        self.paper = numpy.asarray(picture)

    def pixels(self, points):
        """Of places [m], as Pillow has them."""
        return [((x - self.west) * self.scale, (self.north - y) * self.scale) for x, y in points]

    def png(self, grid, reached, levels, colours, marks=()):
        """A map: its cells where the flow came, the outline of these, and `marks`: kind and points of what is drawn over it."""
        rows, columns, inside = self.cells(grid)
        values, came = grid.values[rows, columns], reached[rows, columns] & inside
        shown = came & numpy.isfinite(values)
        step = numpy.clip(numpy.searchsorted(levels, numpy.where(shown, values, levels[0]), side="right") - 1, 0, len(colours) - 1)
        image = self.paper.astype(float)
        image[shown] = SOLID * colours[step[shown]] + (1 - SOLID) * image[shown]
        edge = numpy.zeros_like(came)
        for axis in (0, 1):
            for step_aside in range(1, LINE + 1):  # seen on a narrow screen, too
                edge |= ~numpy.roll(came, step_aside, axis) | ~numpy.roll(came, -step_aside, axis)
        image[edge & came] = FLOW
        picture = Image.fromarray(image.round().astype(numpy.uint8))
        self._draw(ImageDraw.Draw(picture), marks)
        picture = picture.quantize(128)
        out = io.BytesIO()
        picture.save(out, format="PNG", optimize=True)
        return "data:image/png;base64," + base64.b64encode(out.getvalue()).decode()

    def _draw(self, draw, marks):
        for kind, points in marks:
            at = self.pixels(points)
            colour = MARKS[kind][0]
            if kind == "gauge":
                (x, y), = at
                draw.ellipse((x - 7, y - 7, x + 7, y + 7), fill=colour, outline=(255, 255, 255), width=2)
            else:
                draw.line(at + at[:1] if kind == "release" else at, fill=(255, 255, 255), width=6)
                draw.line(at + at[:1] if kind == "release" else at, fill=colour, width=3)

    def labels(self, names):
        """Names as marks over the picture, below their place where another one is above it on a narrow screen."""
        found, taken = [], []
        for name, (x, y) in names:
            across, down = (x - self.west) / (self.east - self.west), (self.north - y) / (self.north - self.south)
            if not (0 <= across <= 1 and 0 <= down <= 1):
                continue
            boxes = [(across * NARROW, down * NARROW * self.size[1] / self.size[0] + 16 * side, 4 + 6.5 * len(name)) for side in (-1, 1)]
            free = [all(abs(a - b) > (wide + other) / 2 or abs(c - d) > 15 for b, d, other in taken) for a, c, wide in boxes]
            below = free == [False, True]
            taken.append(boxes[below])
            found.append(f'<b style="left:{100 * across:.2f}%;top:calc({100 * down:.2f}% {"+" if below else "-"} 1.1rem)">{html.escape(name)}</b>')
        return "".join(found)

    def scale_bar(self):
        long = round_length((self.east - self.west) / 4)
        return f'<i class="scale" style="width:{100 * long / (self.east - self.west):.2f}%"></i><b class="scaled">{long:g} m</b>'

    def box(self, source, words, names=()):
        """The map with its axes, its scale bar, and names at places."""
        wide, tall = self.east - self.west, self.north - self.south
        zero = offset_of(self.west, self.east), offset_of(self.south, self.north)
        xs = [((x - self.west) / wide * 100, text_of(x - zero[0])) for x in ticks(self.west, self.east, 5)]
        ys = [((self.north - y) / tall * 100, text_of(y - zero[1])) for y in ticks(self.south, self.north, max(2, min(6, int(260 * tall / wide / 22))))]
        down, along = scales(xs, ys)
        return (f'<div class="ylabel">{axis_title("y", zero[1])}</div><div class="plot">{down}<div class="pane"><img width="{self.size[0]}" height="{self.size[1]}" '
                f'alt="{html.escape(words)}" src="{source}">{self.labels(names)}{self.scale_bar()}</div>{along}</div><div class="xlabel">{axis_title("x", zero[0])}</div>')


def colour_bar(label, levels, colours):
    """Steps of colour from level to level."""
    share = [100 * (level - levels[0]) / (levels[-1] - levels[0]) for level in levels]
    stops = ",".join(f"#{''.join(f'{part:02x}' for part in colour)} {low:.2f}% {high:.2f}%"
                     for colour, low, high in zip(colours.round().astype(int).tolist(), share, share[1:]))
    every = -(-(len(levels) - 1) // 4)
    marks = "".join(f'<span class="{"first" if at < 4 else "last" if at > 96 else ""}" style="left:{at:.2f}%">{text_of(level)}</span>'
                    for at, level in list(zip(share, levels))[::every])
    return (f'<div class="bar"><div class="ylabel">{html.escape(label)}</div><div class="colours" style="background:linear-gradient(to right,{stops})">'
            f'</div><div class="xs">{marks}</div></div>')


def marks_of(directory):
    """Kinds and points of what the scene has in plan, and names of gauges and sections with their places."""
    import json
    try:
        scene = json.loads((directory / "scene.json").read_text(encoding="utf-8"))
        hazard, keys = scene.get("hazard") or {}, scene.get("keys") or {}
        marks = [("release", json.loads(value)) for key, value in keys.items() if key.split(".")[0] in ("release", "inflow") and key.endswith(".points")]
    except (OSError, ValueError, AttributeError):
        return [], []
    marks += [("way", hazard["path"])] if hazard.get("path") else []
    marks += [("section", section["points"]) for section in hazard.get("sections", [])] + [("gauge", [gauge["place"]]) for gauge in hazard.get("gauges", [])]
    names = [(gauge["name"], gauge["place"]) for gauge in hazard.get("gauges", [])] + [(section["name"], section["points"][0]) for section in hazard.get("sections", [])]
    return marks, names


def maps(directory):
    """HTML of all hazard maps of a run; empty where it has none."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a damaged TIFF there is an error, too
        return _maps(directory)


def _maps(directory):
    """As maps()."""
    from moraine.grids import read_grid
    from moraine.maps import KINDS, drawn, ground_of, map_files, reached_by
    files = map_files(directory)
    if not files:
        return ""
    ground, sheet, parts = ground_of(directory), None, []
    marks, names = marks_of(directory)
    for name, path in list(files.items())[:MAPS]:
        grid = drawn(name, read_grid(path))
        reached = reached_by(files, {name: grid}, name)
        sheet = sheet or Sheet(grid, ground)
        label, palette = KINDS.get(name, (name, "viridis"))
        levels = levels_of(grid.values[reached & numpy.isfinite(grid.values)])
        colours = colormaps[palette](numpy.linspace(0.06, 1, len(levels) - 1))[:, :3] * 255
        words = label.split(" [")[0]
        parts.append(f'<figure class="still map" id="map-{html.escape(name)}-{html.escape(directory.name)}"><h4>{html.escape(words[0].upper() + words[1:])}</h4>'
                     f"{sheet.box(sheet.png(grid, reached, levels, colours, marks), words, names)}{colour_bar(label, levels, colours)}</figure>")
    legend = '<ul class="legend"><li><i style="border-color:#b2182b"></i>reached by the flow</li>'
    if sheet.between:
        legend += f'<li><i style="border-color:#666"></i>height of the ground, every {sheet.between:g} m</li>'
    for kind in dict.fromkeys(kind for kind, _ in marks):
        legend += f'<li><i style="border-color:rgb{MARKS[kind][0]}"></i>{MARKS[kind][1]}</li>'
    more = "" if ground is not None else "<p>The ground is not shown: its model is not where the run found it.</p>"
    return f'<h3>Hazard maps</h3>{legend}</ul>{more}<div class="maps">{"".join(parts)}</div>'


def differences(directories, names):
    """Largest depth and deposit of each run less those of the last, as HTML; empty where the maps are not there."""
    from moraine.grids import Grid, read_grid
    from moraine.map_values import laid_on, one_grid
    from moraine.maps import KINDS, drawn, ground_of, map_files
    files = [map_files(directory) for directory in directories]
    parts = []
    for name in [name for name in DIFFERENT if all(name in found for found in files)]:
        grids = tuple(drawn(name, read_grid(found[name])) for found in files)
        laid = [numpy.nan_to_num(values) for values in one_grid(grids)]
        sheet = Sheet(Grid(laid[0], laid_on(grids), grids[0].cell), ground_of(directories[-1]))
        most = max(float(abs(values - laid[-1]).max()) for values in laid[:-1])
        if most == 0:
            continue
        levels = [float(v) for v in MaxNLocator(8, steps=[1, 2, 2.5, 5, 10], symmetric=True).tick_values(-most, most)]
        colours = colormaps["PuOr"](numpy.linspace(0.02, 0.98, len(levels) - 1))[:, :3] * 255
        label = KINDS[name][0]
        for values, run in zip(laid[:-1], names):
            grid = Grid(values - laid[-1], laid_on(grids), grids[0].cell)
            words = f"{label.split(' [')[0]}: {run} less {names[-1]}"
            parts.append(f'<figure class="still map"><h4>{html.escape(words[0].upper() + words[1:])}</h4>'
                         f"{sheet.box(sheet.png(grid, (values != 0) | (laid[-1] != 0), levels, colours), words)}{colour_bar(label, levels, colours)}</figure>")
    return f'<h3>Differences of maps</h3><div class="maps">{"".join(parts)}</div>' if parts else ""
