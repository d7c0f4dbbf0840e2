"""A curve with its band as SVG, beside a user's own. Pure Python, as error_plot.py."""
import csv
import html
import pathlib
import re
from typing import Any, List, Optional

import numpy
from numpy.typing import NDArray

from .curves import Band, CurveName, Data
from .page_text import ticks

WIDE, TALL, LEFT, RIGHT, TOP, BOTTOM = 640.0, 400.0, 84.0, 616.0, 44.0, 336.0
STYLE = ("text{font:13px sans-serif;fill:#222}.grid{stroke:#ddd}.axis{stroke:#222;fill:none}.band{fill:#0072b2;opacity:.22}.line{stroke:#0072b2;fill:none;stroke-width:2}"
         ".data{fill:#d55e00}.note{font-size:12px;fill:#555}"
         "@media(prefers-color-scheme:dark){text{fill:#ddd}.grid{stroke:#444}.axis{stroke:#ddd}.note{fill:#aaa}.back{fill:#181818}.line{stroke:#56b4e9}.band{fill:#56b4e9}.data{fill:#e69f00}}")


def _path(x: NDArray[Any], y: NDArray[Any]) -> str:
    return "M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in zip(x, y))


def curve_svg(name: CurveName, band: Band, data: Optional[Data] = None) -> str:
    """The finest level's curve, its band, and the data as points."""
    error = numpy.nan_to_num(band.error)
    ys = [band.y - error, band.y + error] + ([data.y] if data else [])
    low, high = min(0.0, *(float(y.min()) for y in ys)), max(0.0, *(float(y.max()) for y in ys))
    high = high if high > low else low + 1
    factor, unit = (1e-3, "kN") if max(abs(low), abs(high)) >= 1e4 and name.y.startswith("force") else (1.0, "N" if name.y.startswith("force") else "")
    x0, x1 = float(band.x[0]), float(band.x[-1])

    def px(x: Any) -> Any:
        return LEFT + (x - x0) / (x1 - x0) * (RIGHT - LEFT)

    def py(y: Any) -> Any:
        return BOTTOM - (y - low) / (high - low) * (BOTTOM - TOP)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDE:g} {TALL:g}" width="{WIDE:g}" height="{TALL:g}" role="img">',
             f"<title>{html.escape(name.text)}</title><style>{STYLE}</style>", f'<rect class="back" width="{WIDE:g}" height="{TALL:g}" fill="#fff"/>',
             f'<text x="{LEFT}" y="26" font-weight="bold">{html.escape(f"{name.structure}: {name.y} over {name.x}")}</text>']
    for value in ticks(x0, x1):
        parts.append(f'<line class="grid" x1="{px(value):.1f}" x2="{px(value):.1f}" y1="{TOP}" y2="{BOTTOM}"/><text x="{px(value):.1f}" y="{BOTTOM + 18}" text-anchor="middle">{value:g}</text>')
    for value in ticks(factor * low, factor * high):
        y = py(value / factor)
        parts.append(f'<line class="grid" x1="{LEFT}" x2="{RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/><text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{value:g}</text>')
    if band.order is not None:
        edge = _path(numpy.concatenate([px(band.x), px(band.x)[::-1]]), numpy.concatenate([py(band.y + error), py(band.y - error)[::-1]]))
        parts.append(f'<path class="band" d="{edge}Z"/>')
    parts += [f'<path class="axis" d="M{LEFT} {TOP}V{BOTTOM}H{RIGHT}"/>', f'<path class="line" d="{_path(px(band.x), py(band.y))}"/>']
    inside = [(x, y) for x, y in zip(data.x, data.y) if x0 <= x <= x1] if data else []
    parts += [f'<circle class="data" cx="{px(x):.1f}" cy="{py(y):.1f}" r="4"/>' for x, y in inside]
    note = "Band: grid convergence index of the whole curve." if band.order is not None else "No band: the levels show no order."
    parts += [f'<text x="{(LEFT + RIGHT) / 2}" y="{BOTTOM + 38}" text-anchor="middle">{html.escape(name.x)} [m]</text>',
              f'<text x="{LEFT}" y="{TOP - 4}" class="note">{html.escape(name.y)} [{unit}]</text>' if unit else "",
              f'<text class="note" x="{LEFT}" y="{TALL - 8}">{note}{" Points: the data." if inside else ""}</text>', "</svg>"]
    return "\n".join(part for part in parts if part) + "\n"


def write_curve(folder: pathlib.Path, name: CurveName, band: Band, data: Optional[Data] = None) -> List[pathlib.Path]:
    """curve-NAME.csv and .svg in a folder; the files."""
    stem = "curve-" + re.sub(r"[^A-Za-z0-9_.-]+", "_", name.text[len("structure."):])
    files = [folder / f"{stem}.csv", folder / f"{stem}.svg"]
    folder.mkdir(parents=True, exist_ok=True)
    with open(files[0], "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow([name.x, name.y, "error"])
        rows.writerows([f"{x:.9g}", f"{y:.9g}", "" if numpy.isnan(e) else f"{e:.4g}"] for x, y, e in zip(band.x.tolist(), band.y.tolist(), band.error.tolist()))
    files[1].write_text(curve_svg(name, band, data), encoding="utf-8")
    return files
