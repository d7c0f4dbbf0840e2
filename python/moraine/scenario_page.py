"""study.html: what a study found, on one page."""
import html
import pathlib
from typing import Any, List

import numpy

from .grids import Grid, read_grid
from .maps import KINDS, UNITS, ground_of
from .page_text import Axes, page, picture, table, warning
from .parameters import Parameter
from .scenario_text import influence_rows, spread_rows, warnings_of
from .scenario_data import Scenarios

SHOWN = 12  # maps at most
TITLES = {"envelope": "largest of all runs", "mean": "mean of the runs", "q05": "5 % of the runs have less", "q50": "half of the runs have less",
          "q95": "95 % of the runs have less", "earliest": "earliest of all runs", "probability": "share of the runs that came there"}


def _range_text(parameter: Parameter) -> str:
    if parameter.kind == "values":
        return ", ".join(map(str, parameter.values))
    if parameter.kind == "normal":
        return f"normal, {parameter.low:g} +- {parameter.high:g}"
    return f"{parameter.low:g} to {parameter.high:g}{', even in the logarithm' if parameter.log else ''}"


def _asked(found: Scenarios) -> str:
    sampling = found.file.given.get("sampling", {})
    words = f"{len(found.members)} runs of {found.file.scene.name}, by {sampling.get('method', 'sobol')}; {len(found.finished)} have ended."
    return f"<p>{html.escape(words)}</p>{table([['parameter', 'values'], *([p.key, _range_text(p)] for p in found.file.parameters)])}"


def _scatter(found: Scenarios) -> str:
    """Every quantity over every parameter."""
    cards = []
    for quantity in found.file.quantities:
        values = found.column(quantity).tolist()
        error = found.cell_error(quantity)
        for parameter in found.file.parameters:
            inputs = found.inputs(parameter)
            if not all(isinstance(x, (int, float)) for x in inputs):
                continue
            axes = Axes(inputs, values)
            if error is not None:
                axes.level(float(numpy.mean(values)), error)
            axes.points(inputs, values)
            cards.append(f"<figure><h3>{html.escape(quantity.text)}</h3>{axes.svg(parameter.key, quantity.text)}</figure>")
    return f'<div class="cards">{"".join(cards)}</div>'


def _title_of(name: str, kind: str) -> str:
    return f"share of the runs with more than {kind[len('exceeds-'):]} {UNITS.get(name, '')}" if kind.startswith("exceeds-") else TITLES.get(kind, kind)


def _maps(found: Scenarios) -> str:
    """Maps over the ground, where matplotlib is."""
    try:
        from .map_figure import draw_map
    except ImportError:
        return "<p>The maps are not drawn: this Python has no matplotlib.</p>"
    ground = ground_of(found.path / found.finished[0].name)
    order = {"exceeds": 0, "envelope": 1, "probability": 2, "earliest": 3, "q95": 4, "q50": 5, "mean": 6, "q05": 7}
    parts: List[str] = []
    for each in sorted(found.maps, key=lambda m: order.get(m["kind"].split("-")[0], 9))[:SHOWN]:
        grid = read_grid(found.path / "maps" / each["file"])
        label, colours = KINDS.get(each["map"], (each["map"], "viridis"))
        if each["unit"] == "":
            label, colours = f"{_title_of(each['map'], each['kind'])} [-]", "viridis"
        elif label.endswith("[kPa]"):
            grid = Grid(grid.values / 1e3, grid.first, grid.cell)
        title = f"{each['map']}: {_title_of(each['map'], each['kind'])}"
        figure: Any = draw_map(label, colours, grid, numpy.isfinite(grid.values), ground, title)
        parts.append(f"<figure>{picture(figure, title)}</figure>")
    more = f"<p>maps/ has {len(found.maps)} maps, of which {len(parts)} are shown.</p>" if len(found.maps) > len(parts) else ""
    return f'<div class="wide">{"".join(parts)}</div>{more}'


def write_page(found: Scenarios) -> pathlib.Path:
    """study.html in the folder of the study; the file."""
    parts = [warning(warnings_of(found)), "<h2>What was asked</h2>", _asked(found)]
    if found.finished:
        parts += ["<h2>What came out</h2>", table(spread_rows(found))]
        if found.cells:
            parts.append("<p>Bands in the plots: the error of the cells around the mean of the runs.</p>")
        parts.append(_scatter(found))
    if found.influences:
        parts += ["<h2>What matters</h2>", table(influence_rows(found))]
    if found.maps:
        parts += ["<h2>Maps</h2>", _maps(found)]
    failed = [[m.name, str(m.code), m.problem] for m in found.failed]
    if failed:
        parts += ["<h2>Runs that failed</h2>", table([["run", "exit code", "message"], *failed])]
    path = found.path / "study.html"
    path.write_text(page(f"Study of {found.file.scene.stem}", [part for part in parts if part]), encoding="utf-8")
    return path
