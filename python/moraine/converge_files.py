"""Files of a refinement study: converge.csv, error-QUANTITY.svg, and the errors of whole maps."""
import csv
import dataclasses
import pathlib
import re
from typing import Any, List

from .error_plot import Curve, error_plot
from .map_errors import MapError, write_map_errors
from .quantity import Quantity, maps_of
from .study import Study, Variant

HEAD = ["variant", "level", "cell_m", "particles", "steps", "wall_s", "quantity", "value", "verdict", "order", "richardson", "safety", "gci", "origin"]


def rows_of(study: Study) -> List[List[Any]]:
    """A row of HEAD for each level and quantity; what is not known is empty."""
    rows = []
    for variant in study.variants:
        for k, level in enumerate(variant.levels):
            for quantity in study.quantities:
                e = variant.estimate(quantity, k + 1)
                more = ["" if x is None else x for x in (e.order, e.value, e.safety, e.error)]
                rows.append([variant.name, k + 1, level.cell, level.particles, level.steps, level.wall_s, quantity.text, e.finest, e.verdict, *more, e.origin])
    return rows


def map_errors(study: Study, variant: Variant) -> List[MapError]:
    """Of the maps that are asked for, whose files it writes; none of one level alone."""
    names = maps_of(study.quantities)
    if len(variant.levels) < 2 or not names:
        return []
    found, _ = write_map_errors([study.path / level.directory for level in variant.levels], [level.cell for level in variant.levels], names,
                                study.path / "maps" / variant.name)
    variant.maps = [dataclasses.asdict(error) for error in found]
    return found


def _curves(study: Study, quantity: Quantity) -> List[Curve]:
    """Run time and error of each level that has a Richardson value, against that of the finest three."""
    found = []
    for variant in study.variants:
        last = variant.estimate(quantity) if variant.levels else None
        if last is None or last.verdict != "converges" or last.value is None or last.value == last.origin:
            continue
        limit = last.value
        errors = [(level.wall_s, abs((level.values[quantity.text] - limit) / (limit - last.origin))) for level in variant.levels]
        bars = []
        for k in range(2, len(variant.levels)):
            bar = variant.estimate(quantity, k + 1).relative
            if bar:
                bars.append((variant.levels[k].wall_s, bar))
        found.append(Curve(variant.name or quantity.text, errors, bars))
    return found


def write_files(study: Study) -> List[pathlib.Path]:
    """converge.csv, and error-QUANTITY.svg of each quantity that converges; the files."""
    files = [study.path / "converge.csv"]
    with open(files[0], "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(HEAD)
        writer.writerows(rows_of(study))
    for quantity in study.quantities:
        path = study.path / f"error-{re.sub(r'[^A-Za-z0-9_.-]+', '_', quantity.text)}.svg"
        curves = _curves(study, quantity)
        path.unlink(missing_ok=True)
        if curves:
            path.write_text(error_plot(f"{quantity.text}: error against run time", curves), encoding="utf-8")
            files.append(path)
    return files
