"""Error against run time as SVG, on two logarithmic axes. Pure Python, so that a study needs no plotting library."""
import dataclasses
import html
import math
from typing import Iterable, List, Sequence, Tuple

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")  # they differ for the red-green blind, too
WIDE, TALL = 640, 400                                   # of the picture
LEFT, RIGHT, TOP, BOTTOM = 76, 616, 44, 336             # of what the axes enclose
STYLE = ("text{font:13px sans-serif;fill:#222}.grid{stroke:#ddd}.axis{stroke:#222;fill:none}.note{font-size:12px;fill:#555}"
         "@media(prefers-color-scheme:dark){text{fill:#ddd}.grid{stroke:#444}.axis{stroke:#ddd}.note{fill:#aaa}.back{fill:#181818}}")


@dataclasses.dataclass
class Curve:
    """A line of the plot: (run time [s], error) of its levels, and (run time [s], GCI) of those that have one; as shares."""

    label: str
    errors: List[Tuple[float, float]]
    bars: List[Tuple[float, float]]


def decades(values: Iterable[float]) -> Tuple[float, float]:
    """Exponents of ten around positive values, with some room.

    >>> decades([0.5, 20.0])
    (-0.5, 1.5)
    """
    found = [math.log10(value) for value in values]
    return math.floor(2 * min(found) - 0.1) / 2, math.ceil(2 * max(found) + 0.1) / 2


def ticks(low: float, high: float) -> List[float]:
    """1, 2, 5 of each decade, or the decades alone where there are many, between 10^low and 10^high.

    >>> ticks(-0.5, 1.0)
    [0.5, 1.0, 2.0, 5.0, 10.0]
    """
    steps = (1, 2, 5) if high - low < 2.6 else (1,)
    found = [float(f"{m}e{e}") for e in range(math.floor(low), math.ceil(high) + 1) for m in steps]
    return [value for value in found if low - 1e-9 <= math.log10(value) <= high + 1e-9]


class Frame:
    """Both axes, and where a point is on the picture."""

    def __init__(self, points: Sequence[Tuple[float, float]]) -> None:
        self.x, self.y = decades(x for x, _ in points), decades(y for _, y in points)

    def at(self, x: float, y: float) -> Tuple[float, float]:
        across = (math.log10(x) - self.x[0]) / (self.x[1] - self.x[0])
        up = (math.log10(y) - self.y[0]) / (self.y[1] - self.y[0])
        return LEFT + across * (RIGHT - LEFT), BOTTOM - up * (BOTTOM - TOP)

    def lines(self) -> List[str]:
        parts = []
        for value in ticks(*self.x):
            x = self.at(value, 1.0)[0]
            parts.append(f'<line class="grid" x1="{x:.1f}" x2="{x:.1f}" y1="{TOP}" y2="{BOTTOM}"/>'
                         f'<text x="{x:.1f}" y="{BOTTOM + 18}" text-anchor="middle">{value:g}</text>')
        for value in ticks(*self.y):
            y = self.at(1.0, value)[1]
            parts.append(f'<line class="grid" x1="{LEFT}" x2="{RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/>'
                         f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{100 * value:g} %</text>')
        return [*parts, f'<path class="axis" d="M{LEFT} {TOP}V{BOTTOM}H{RIGHT}"/>']


def _curve(frame: Frame, curve: Curve, colour: str) -> List[str]:
    places = [frame.at(*point) for point in curve.errors if point[1] > 0]
    path = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
    parts = [f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="1.5"/>' if places else ""]
    parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"/>' for x, y in places]
    for x, y in (frame.at(*point) for point in curve.bars):
        parts.append(f'<path d="M{x - 7:.1f} {y:.1f}H{x + 7:.1f}" stroke="{colour}" stroke-width="3"/>')
    return parts


def error_plot(title: str, curves: Sequence[Curve]) -> str:
    """The SVG. Points: distance of each level to the Richardson value; short bars: the GCI.

    >>> error_plot("front", [Curve("apic", [(1.0, 0.1), (8.0, 0.05)], [(8.0, 0.06)])]).count("<circle")
    2
    """
    points = [point for curve in curves for point in [*curve.errors, *curve.bars] if point[0] > 0 and point[1] > 0]
    frame = Frame(points)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDE} {TALL}" width="{WIDE}" height="{TALL}" role="img">',
             f"<title>{html.escape(title)}</title><style>{STYLE}</style>", f'<rect class="back" width="{WIDE}" height="{TALL}" fill="#fff"/>',
             f'<text x="{LEFT}" y="26" font-weight="bold">{html.escape(title)}</text>', *frame.lines()]
    for k, curve in enumerate(curves):
        colour = COLOURS[k % len(COLOURS)]
        parts += _curve(frame, curve, colour)
        parts.append(f'<text x="{RIGHT - 4}" y="{TOP + 16 + 17 * k}" text-anchor="end" style="fill:{colour}">{html.escape(curve.label)}</text>')
    parts += [f'<text x="{(LEFT + RIGHT) / 2}" y="{BOTTOM + 38}" text-anchor="middle">run time [s]</text>',
              f'<text class="note" x="{LEFT}" y="{TALL - 8}">Points: distance to the Richardson value. Short bars: grid convergence index.</text>',
              "</svg>"]
    return "\n".join(part for part in parts if part) + "\n"
