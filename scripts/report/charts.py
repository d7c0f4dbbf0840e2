"""Line charts as HTML that fit any width: the lines are an SVG that stretches, the labels are text of the page and do not.

Nothing but Python's own library is needed. As files (CSV, SVG, PNG) they are drawn by matplotlib, where it is there.
"""
import dataclasses
import html
import math

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a7a00", "#777777")  # on white and on black, and for the red-green blind
WIDE, TALL = 1000.0, 500.0  # of the SVG's own units


@dataclasses.dataclass
class Line:
    label: str
    x: list
    y: list
    colour: str = ""
    dashed: bool = False


@dataclasses.dataclass
class Chart:
    """name of its files; title; the sentence under it; labels with units; the lines; rows of its table."""

    name: str
    title: str
    caption: str
    xlabel: str
    ylabel: str
    lines: list
    log: bool = False
    zero: bool = False  # the axis begins at 0 at the latest
    columns: tuple = ()  # of its table

    def __post_init__(self):
        self.columns = self.columns or ("line", self.xlabel, self.ylabel)

    @property
    def rows(self):
        return [(line.label, float(x), float(y)) for line in self.lines for x, y in zip(line.x, line.y)]

    @property
    def figure(self):
        from canvas import pyplot  # not before a figure is wanted: it may not be there
        figure, axes = pyplot.subplots(figsize=(8, 3))
        for k, line in enumerate(self.lines):
            axes.plot(line.x, line.y, color=line.colour or COLOURS[k % len(COLOURS)], linestyle="--" if line.dashed else "-",
                      linewidth=1.3, label=line.label)
        axes.set(xlabel=self.xlabel, ylabel=self.ylabel, yscale="log" if self.log else "linear")
        if len(self.lines) > 1:
            axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1), borderaxespad=0, fontsize=9)
        return figure


def ticks(low, high, most):
    """At most so many round numbers between."""
    step = 10 ** math.floor(math.log10((high - low) / most))
    step *= next(m for m in (1, 2, 5, 10, 20) if (high - low) / (m * step) <= most)
    first = math.ceil(low / step - 1e-9)
    return [k * step for k in range(first, math.floor(high / step + 1e-9) + 1)]


def log_ticks(low, high):
    found = [m * 10.0**e for e in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1) for m in (1, 2, 5)]
    inside = [value for value in found if low * (1 - 1e-9) <= value <= high * (1 + 1e-9)]
    return inside[:: max(1, math.ceil(len(inside) / 6))]


def text_of(value):
    return f"{0.0 if abs(value) < 1e-12 else value:.6g}".replace("-", "\N{MINUS SIGN}")


def finite(values):
    return [float(v) for v in values if math.isfinite(v)]


def limits(chart):
    """Of both axes over what is a number; None where nothing is."""
    xs = finite(v for line in chart.lines for v in line.x)
    ys = finite(v for line in chart.lines for v in line.y if not chart.log or v > 0)
    if not xs or not ys:
        return None
    low, high = min(ys), max(ys)
    if chart.log:
        return min(xs), max(xs), low / 1.1, high * 1.1
    if chart.zero:
        low, high = min(low, 0.0), max(high, 0.0)
    if high - low <= 1e-12 * max(abs(low), abs(high)):
        low, high = (0.0, 1.0) if high == 0 else (low - 0.1 * abs(low), high + 0.1 * abs(high))
    margin = 0.04 * (high - low)
    return min(xs), max(xs), low - (margin if low < 0 or not chart.zero else 0), high + margin


def pieces(line, place):
    """The line in pieces between what is no number, as points of the SVG."""
    piece, found = [], []
    for x, y in zip(line.x, line.y):
        at = place(x, y) if math.isfinite(x) and math.isfinite(y) else None
        if at:
            piece.append(f"{at[0]:.1f},{at[1]:.1f}")
        elif piece:
            found.append(piece)
            piece = []
    return [points for points in [*found, piece] if points]


def svg(chart, box, xticks, yticks):
    left, right, low, high = box
    scale = math.log if chart.log else lambda v: v

    def place(x, y):
        if chart.log and y <= 0:
            return None
        return ((x - left) / ((right - left) or 1) * WIDE, (1 - (scale(y) - scale(low)) / (scale(high) - scale(low))) * TALL)
    parts = [f'<svg viewBox="0 0 {WIDE:g} {TALL:g}" preserveAspectRatio="none" role="img" aria-label="{html.escape(chart.title)}">']
    for x in xticks:
        at = place(x, high)[0]
        parts.append(f'<line class="grid" x1="{at:.1f}" x2="{at:.1f}" y1="0" y2="{TALL:g}"/>')
    for y in yticks:
        at = place(left, y)[1]
        parts.append(f'<line class="grid{" zero" if y == 0 else ""}" x1="0" x2="{WIDE:g}" y1="{at:.1f}" y2="{at:.1f}"/>')
    for k, line in enumerate(chart.lines):
        dash = ' stroke-dasharray="6 4"' if line.dashed else ""
        for points in pieces(line, place):
            if len(points) == 1:
                points = points * 2
            parts.append(f'<polyline class="line" stroke="{line.colour or COLOURS[k % len(COLOURS)]}"{dash} points="{" ".join(points)}"/>')
    return "\n".join([*parts, "</svg>"]), place


def scales(xs, ys):
    """Labels of both axes; xs and ys: (share of the width or height, text)."""
    edge = lambda at: ' class="first"' if at < 4 else ' class="last"' if at > 96 else ""  # noqa: E731
    down = "".join(f'<span style="top:{at:.2f}%">{text}</span>' for at, text in ys)
    along = "".join(f'<span{edge(at)} style="left:{at:.2f}%">{text}</span>' for at, text in xs)
    return f'<div class="ys">{down}</div>', f'<div class="xs">{along}</div>'


def section(chart, level="h3"):
    """A figure; nothing to draw is said in words."""
    head = f"<{level}>{html.escape(chart.title)}</{level}>"
    box = limits(chart)
    if not box:
        return f'<figure class="chart">{head}<p class="none">The records of it hold no numbers.</p></figure>'
    xticks = ticks(box[0], box[1], 5) if box[1] > box[0] else [box[0]]
    yticks = log_ticks(box[2], box[3]) if chart.log else ticks(box[2], box[3], 5)
    picture, place = svg(chart, box, xticks, yticks)
    ys, xs = scales([(place(x, box[3])[0] / WIDE * 100, text_of(x)) for x in xticks],
                    [(place(box[0], y)[1] / TALL * 100, text_of(y)) for y in yticks])
    names = "".join(f'<li><i class="{"dashed" if line.dashed else ""}" style="border-color:{line.colour or COLOURS[k % len(COLOURS)]}"></i>'
                    f"{html.escape(line.label)}</li>" for k, line in enumerate(chart.lines))
    legend = f'<ul class="legend">{names}</ul>' if len(chart.lines) > 1 else ""
    return (f'<figure class="chart" id="{chart.name}">{head}<div class="ylabel">{html.escape(chart.ylabel)}</div>\n<div class="plot">{ys}'
            f'<div class="area">{picture}</div>{xs}</div>\n<div class="xlabel">{html.escape(chart.xlabel)}</div>{legend}'
            f"<figcaption>{html.escape(chart.caption)}</figcaption></figure>")


def bars(lines):
    """Stacked bars of 100 % as HTML; lines: name, and of each part its words and colour, and its share [%]."""
    parts, seen = [], {}
    for name, shares in lines:
        pieces = []
        for (words, colour), share in shares:
            seen[words] = colour
            light = sum(int(colour[k:k + 2], 16) for k in (1, 3, 5)) > 420
            label = f"{share:.0f} %" if share >= 12 else ""
            pieces.append(f'<span title="{html.escape(words)}: {share:.1f} %" style="width:{share:.3f}%;background:{colour};'
                          f'color:{"#111" if light else "#fff"}">{label}</span>')
        parts.append(f'<div class="barname">{html.escape(name)}</div><div class="barline">{"".join(pieces)}</div>')
    names = "".join(f'<li><i class="square" style="background:{colour}"></i>{html.escape(words)}</li>' for words, colour in seen.items())
    return f'<div class="bars">{"".join(parts)}</div><div class="xlabel">share of the wall time</div><ul class="legend">{names}</ul>'
