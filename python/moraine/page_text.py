"""Pages that hold everything: no script, no font and no picture from elsewhere."""
import base64
import html
import io
import math
from typing import Any, List, Sequence, Tuple

STYLE = """
:root { color-scheme: light dark; --ink: #1c1f23; --faint: #59616b; --edge: #d5d9de; --paper: #ffffff; --bad: #b3261e; --badpaper: #fdecea; --mark: #1f77b4; --band: #1f77b433; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e8eb; --faint: #a4acb6; --edge: #3a4048; --paper: #14171a; --bad: #ffb4ab; --badpaper: #3b1a17; --mark: #7fb2dd; --band: #7fb2dd33; } }
* { box-sizing: border-box; }
body { font: 16px/1.5 system-ui, "DejaVu Sans", sans-serif; color: var(--ink); background: var(--paper); max-width: 84rem; margin: 0 auto; padding: 1rem; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0.5rem 0; } h2 { font-size: 1.3rem; margin: 2rem 0 0.8rem; border-bottom: 1px solid var(--edge); }
h3 { font-size: 1rem; margin: 0 0 0.4rem; } .scroll { overflow-x: auto; margin-bottom: 1.2rem; } table { border-collapse: collapse; font-size: 0.85rem; }
th, td { padding: 0.25rem 0.6rem; border-bottom: 1px solid var(--edge); text-align: right; white-space: nowrap; } th:first-child, td:first-child { text-align: left; }
@media (max-width: 47rem) { th, td { white-space: normal; padding: 0.25rem 0.3rem; } td:first-child { overflow-wrap: anywhere; min-width: 4rem; } }
.cards { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 19rem), 1fr)); gap: 1.2rem 1.6rem; }
.wide { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 34rem), 1fr)); gap: 1.2rem 1.6rem; }
figure { margin: 0; min-width: 0; overflow-x: auto; } figcaption { color: var(--faint); font-size: 0.85rem; } img { width: 100%; min-width: 34rem; height: auto; background: #fff; }
svg { width: 100%; height: auto; display: block; } svg text { font: 13px system-ui, sans-serif; fill: var(--ink); } svg .axis { stroke: var(--faint); fill: none; }
svg .mark { fill: var(--mark); } svg .line { stroke: var(--mark); fill: none; stroke-width: 2; } svg .band { fill: var(--band); }
.warning { border-left: 4px solid var(--bad); background: var(--badpaper); padding: 0.7rem 1rem; margin: 1rem 0; } .warning ul { margin: 0; padding-left: 1.2rem; }
"""
WIDE, TALL, LEFT, RIGHT, TOP, BOTTOM = 320.0, 200.0, 58.0, 308.0, 10.0, 160.0


def table(rows: Sequence[Sequence[str]]) -> str:
    """The first row has the names of the columns."""
    def line(tag: str, row: Sequence[str]) -> str:
        return "<tr>" + "".join(f"<{tag}>{html.escape(word)}</{tag}>" for word in row) + "</tr>"
    return f'<div class="scroll"><table><thead>{line("th", rows[0])}</thead><tbody>{"".join(line("td", row) for row in rows[1:])}</tbody></table></div>'


def warning(lines: Sequence[str]) -> str:
    return f'<div class="warning"><ul>{"".join(f"<li>{html.escape(line)}</li>" for line in lines)}</ul></div>' if lines else ""


def ticks(low: float, high: float, most: int = 5) -> List[float]:
    """Round numbers between.

    >>> ticks(0.1, 0.3)
    [0.1, 0.15, 0.2, 0.25, 0.3]
    """
    if not high > low:
        return [low]
    step = 10.0 ** math.floor(math.log10((high - low) / most))
    step *= next(m for m in (1, 2, 5, 10) if (high - low) / (m * step) <= most + 1e-9)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [float(f"{k * step:.12g}") for k in range(first, last + 1)]


class Axes:
    """A small plot: limits, and where a point is."""

    def __init__(self, xs: Sequence[float], ys: Sequence[float]) -> None:
        self.x, self.y = (self._limits(values) for values in (xs, ys))
        self.parts: List[str] = []

    @staticmethod
    def _limits(values: Sequence[float]) -> Tuple[float, float]:
        low, high = min(values), max(values)
        away = 0.04 * (high - low) or abs(low) * 0.05 or 1.0
        return low - away, high + away

    def at(self, x: float, y: float) -> Tuple[float, float]:
        return (LEFT + (x - self.x[0]) / (self.x[1] - self.x[0]) * (RIGHT - LEFT), BOTTOM - (y - self.y[0]) / (self.y[1] - self.y[0]) * (BOTTOM - TOP))

    def points(self, xs: Sequence[float], ys: Sequence[float]) -> None:
        self.parts += [f'<circle class="mark" cx="{x:.1f}" cy="{y:.1f}" r="3.5"/>' for x, y in (self.at(*p) for p in zip(xs, ys))]

    def line(self, xs: Sequence[float], ys: Sequence[float]) -> None:
        self.parts.append('<path class="line" d="M' + "L".join(f"{x:.1f} {y:.1f}" for x, y in (self.at(*p) for p in zip(xs, ys))) + '"/>')

    def level(self, y: float, error: float) -> None:
        """A level with a band of its error."""
        low, high = (min(max(self.at(self.x[0], value)[1], TOP), BOTTOM) for value in (y + error, y - error))
        self.parts.insert(0, f'<rect class="band" x="{LEFT}" y="{low:.1f}" width="{RIGHT - LEFT}" height="{max(high - low, 1):.1f}"/>')

    def svg(self, xlabel: str, ylabel: str) -> str:
        marks = []
        for value in ticks(*self.x):
            marks.append(f'<text x="{self.at(value, self.y[0])[0]:.1f}" y="{BOTTOM + 16}" text-anchor="middle">{value:g}</text>')
        for value in ticks(*self.y):
            marks.append(f'<text x="{LEFT - 5}" y="{self.at(self.x[0], value)[1] + 4:.1f}" text-anchor="end">{value:g}</text>')
        return (f'<svg viewBox="0 0 {WIDE:g} {TALL:g}" role="img" aria-label="{html.escape(ylabel)} over {html.escape(xlabel)}">'
                f'<path class="axis" d="M{LEFT} {TOP}V{BOTTOM}H{RIGHT}"/>{"".join(self.parts)}{"".join(marks)}'
                f'<text x="{(LEFT + RIGHT) / 2}" y="{TALL - 6}" text-anchor="middle">{html.escape(xlabel)}</text></svg>')


def picture(figure: Any, words: str) -> str:
    """A figure of matplotlib as an element of the page."""
    out = io.BytesIO()
    figure.savefig(out, format="png", dpi=110, metadata={"Software": None})
    return f'<img alt="{html.escape(words)}" src="data:image/png;base64,{base64.b64encode(out.getvalue()).decode()}">'


def page(title: str, parts: Sequence[str]) -> str:
    return ('<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            f"<title>{html.escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{html.escape(title)}</h1>\n" + "\n".join(parts) + "\n</body>\n</html>\n")


