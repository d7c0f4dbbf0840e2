"""Pictures of the flow for a page: particles by speed as small palette PNGs without labels, which the page adds around them."""
import base64
import html
import io
import json

import numpy
from charts import scales, text_of, ticks
from matplotlib import colormaps
from moraine.axis_text import axis_title, offset_of
from PIL import Image, ImageDraw

WIDE, TALL = 900, 420   # pixels at most
SMALL = 560             # of the width, where pictures stand side by side
LARGEST = 500_000       # of the slider's frames [bytes]: there are fewer where they are large
LEVELS = 48            # of colour
WALL, EDGE, SOLID, LINE, GREY = range(LEVELS + 1, LEVELS + 6)  # 0 is transparent, 1 ... LEVELS the particles
STILLS, FRAMES = 6, 24
FIELDS = ("speed", "pressure", "depth")


def open_frames(directory):
    """moraine.frames.Frames of the outputs that the page shows, their numbers, and those of the stills; the Python package's."""
    from moraine.errors import Error
    from moraine.fields import FIELDS as fields
    from moraine.frames import Frames
    from moraine.results import Run
    from moraine.surroundings import Surroundings, surroundings_of
    run = Run(directory)
    count = len(run.particles)
    if count == 0:
        raise Error(f"{directory} has no output (its particles.vtkhdf is empty). Was it stopped at once?")
    ks = sorted({int(k) for k in numpy.linspace(0, count - 1, min(count, FRAMES)).round()})
    stills = sorted({ks[int(k)] for k in numpy.linspace(0, len(ks) - 1, min(len(ks), STILLS)).round()})
    name = next(name for name in FIELDS if set(fields[name].needs) <= set(run.particles.fields))
    return Frames(run, ks, name, Surroundings(run, surroundings_of(run))), ks, stills


def is_flat(frames):
    """Long and low: pictures stand one above the other."""
    side = frames.limits[:, 1] - frames.limits[:, 0]
    return side[0] > 2.4 * side[1]


class Plane:
    """One view of a flow: axes seen, limits [m], pixels."""

    def __init__(self, frames, view):
        self.frames, self.view = frames, view
        self.low, self.high = (frames.limits[list(view), end] for end in (0, 1))
        side = self.high - self.low
        self.scale = min((WIDE if is_flat(frames) else SMALL) / side[0], TALL / side[1])  # pixels of a metre
        self.size = tuple(max(2, int(round(s * self.scale))) for s in side)
        self.colours = (colormaps[frames.field.colours](numpy.linspace(0, 1, LEVELS))[:, :3] * 255).round().astype(int)
        # white between the particles of a dense body would be noise: marks are a little larger than their distance
        self.mark = max(2, int(numpy.ceil(1.15 * frames.between * self.scale)))

    def palette(self):
        rest = [(222, 222, 222), (90, 90, 90), (200, 203, 208), (80, 80, 80), (150, 150, 150)]
        return [255, 255, 255, *self.colours.reshape(-1).tolist(), *(part for colour in rest for part in colour)]

    def pixel(self, places):
        """Columns and rows of places (n, 2) [m]."""
        at = (places - self.low) * self.scale
        return at[:, 0], self.size[1] - at[:, 1]

    def png(self, particles):
        image = numpy.zeros((self.size[1], self.size[0]), dtype=numpy.uint8)
        self._particles(image, particles)
        picture = Image.fromarray(image, mode="P")
        picture.putpalette(self.palette())
        self._around(picture, particles.time)
        out = io.BytesIO()
        picture.save(out, format="PNG", optimize=True, transparency=0)
        return "data:image/png;base64," + base64.b64encode(out.getvalue()).decode()

    def _particles(self, image, particles):
        values, (low, high) = self.frames.values(particles), self.frames.range
        share = numpy.clip((values - low) / (high - low), 0, 1)
        colour = numpy.where(numpy.isfinite(values), 1 + numpy.nan_to_num(share) * (LEVELS - 1) + 0.5, GREY).astype(numpy.uint8)
        order = numpy.arange(len(particles))
        if particles.dimensions == 3:  # the nearest to the reader last
            order = numpy.argsort(particles.position[:, 2] if self.view == (0, 1) else -particles.position[:, 1], kind="stable")
        x, y = self.pixel(particles.position[order][:, list(self.view)])
        left, top = (numpy.floor(v - self.mark / 2).astype(int) for v in (x, y))
        colour = colour[order]
        for dx in range(self.mark):
            for dy in range(self.mark):
                column, row = left + dx, top + dy
                seen = (column >= 0) & (column < self.size[0]) & (row >= 0) & (row < self.size[1])
                image[row[seen], column[seen]] = colour[seen]

    def _around(self, picture, time):
        """Walls, planes and structures."""
        draw = ImageDraw.Draw(picture)
        around = self.frames.around
        for shape, kind in around.solids(self.view, time, numpy.column_stack([self.low, self.high])):
            corners = list(zip(*(axis.tolist() for axis in self.pixel(numpy.asarray(shape, dtype=float)))))
            draw.polygon(corners, fill=WALL if kind == "wall" else SOLID)
            draw.line([*corners, corners[0]], fill=EDGE if kind == "wall" else LINE, width=2)

    def names(self, time):
        """Names of structures as marks over the picture, in the middle of what is in view."""
        found = []
        for name, shape in self.frames.around.outlines(self.view, time):
            low, high = numpy.maximum(shape.min(axis=0), self.low), numpy.minimum(shape.max(axis=0), self.high)
            if (low < high).all():
                x, y = ((low + high) / 2 - self.low) / (self.high - self.low) * 100
                found.append(f'<b style="left:{x:.2f}%;top:{100 - y:.2f}%">{html.escape(name)}</b>')
        return "".join(found)

    def box(self, source, time, last=True):
        """The picture with its axes."""
        side = self.high - self.low
        rows = max(2, min(6, int(300 * self.size[1] / self.size[0] / 22)))  # on a narrow screen
        zero = [offset_of(float(low), float(high)) for low, high in zip(self.low, self.high)]
        xs = [((x - self.low[0]) / side[0] * 100, text_of(x - zero[0])) for x in ticks(self.low[0], self.high[0], 5)]
        ys = [((self.high[1] - y) / side[1] * 100, text_of(y - zero[1])) for y in ticks(self.low[1], self.high[1], rows)]
        down, along = scales(xs, ys)
        return (f'<div class="ylabel">{axis_title("xyz"[self.view[1]], zero[1])}</div><div class="plot">{down}<div class="pane"><img width="{self.size[0]}" '
                f'height="{self.size[1]}" alt="particles at t = {time:.3g} s" src="{source}">{self.names(time)}</div>{along}</div>'
                + (f'<div class="xlabel">{axis_title("x", zero[0])}</div>' if last else ""))


def colour_bar(frames):
    plane = Plane(frames, frames.views[0])
    stops = ",".join("#%02x%02x%02x" % tuple(colour) for colour in plane.colours[:: LEVELS // 12].tolist())
    low, high = frames.range
    marks = "".join(f'<span class="{"last" if v > low + 0.96 * (high - low) else "first" if v < low + 0.04 * (high - low) else ""}" '
                    f'style="left:{(v - low) / (high - low) * 100:.2f}%">{text_of(v)}</span>' for v in ticks(low, high, 5))
    return (f'<div class="bar"><div class="ylabel">{html.escape(frames.field.label)}</div><div class="colours" '
            f'style="background:linear-gradient(to right,{stops})"></div><div class="xs">{marks}</div></div>')


def pictures(frames, ks, stills, name):
    """Stills and the slider, as HTML."""
    planes = [Plane(frames, view) for view in frames.views]
    shots = {k: (particles.time, [plane.png(particles) for plane in planes]) for k in ks for particles in [frames.read(k)]}
    flat = is_flat(frames)
    while len(ks) > 4 and sum(len(source) for k in ks for source in shots[k][1]) > LARGEST:
        ks = [*ks[:-1][::2], ks[-1]]

    def figure(k):
        time, sources = shots[k]
        views = "".join(plane.box(source, time, plane is planes[-1]) for plane, source in zip(planes, sources))
        return f'<figure class="still"><h4>t = {time:.3g} s</h4>{views}</figure>'
    still = f'<div class="stills{" flat" if flat else ""}">' + "".join(map(figure, stills)) + "</div>"
    if len(ks) < 2:
        return colour_bar(frames) + still
    first = ks[0]
    data = json.dumps({"times": [f"{shots[k][0]:.3g}" for k in ks], "frames": [shots[k][1] for k in ks],
                       "names": [[plane.names(shots[k][0]) for plane in planes] for k in ks]}).replace("<", "\\u003c")
    views = "".join(plane.box(source, shots[first][0], plane is planes[-1]) for plane, source in zip(planes, shots[first][1]))
    slider = (f'<figure class="still movie{"" if flat else " high"}" id="{name}"><h3>Move through the run</h3><div class="control"><button type="button">Play</button>'
              f'<input type="range" min="0" max="{len(ks) - 1}" value="0" aria-label="time"><output>t = {shots[first][0]:.3g} s</output></div>'
              f'{views}<script type="application/json">{data}</script></figure>')
    return colour_bar(frames) + still + slider


SCRIPT = """
for (const movie of document.querySelectorAll(".movie")) {
  const data = JSON.parse(movie.querySelector("script").textContent), range = movie.querySelector("input");
  const panes = movie.querySelectorAll(".pane"), button = movie.querySelector("button");
  let timer = 0;
  const show = k => {
    range.value = k;
    movie.querySelector("output").textContent = "t = " + data.times[k] + " s";
    panes.forEach((pane, p) => {
      pane.querySelector("img").src = data.frames[k][p];
      pane.querySelector("img").alt = "particles at t = " + data.times[k] + " s";
      pane.querySelectorAll("b").forEach(name => name.remove());
      pane.insertAdjacentHTML("beforeend", data.names[k][p]);
    });
  };
  const stop = () => { clearInterval(timer); timer = 0; button.textContent = "Play"; };
  range.addEventListener("input", () => { stop(); show(+range.value); });
  button.addEventListener("click", () => {
    if (timer) return stop();
    button.textContent = "Stop";
    if (+range.value === data.times.length - 1) show(0);
    timer = setInterval(() => +range.value < data.times.length - 1 ? show(+range.value + 1) : stop(), 200);
  });
}
"""
