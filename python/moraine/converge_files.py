"""Files of a refinement study: converge.csv, error-QUANTITY.svg, and the errors of whole maps."""
import csv
import dataclasses
import pathlib
import re
from typing import Any, List, Mapping, Optional, Sequence

from .curve_plot import write_curve
from .curves import CurveName, Data, band_of, beside
from .error_plot import Curve, error_plot
from .errors import Error
from .map_errors import MapError, write_map_errors
from .number_text import two_digits
from .quantity import Quantity, maps_of
from .results import Run
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


def refuse_curves(curves: Sequence[CurveName], data: Optional[Data], scene: Mapping[str, Any]) -> None:
    """Raises Error for a curve of a structure that the scene has not, and for data beside no curve."""
    names = [item.get("name", "") for item in scene.get("structure", [])]
    for curve in curves:
        if curve.structure not in names:
            raise Error(f"--curve {curve.text} is not there (the structures are {', '.join(names) or 'none'}). Is it structure.NAME.force_y/displacement_y?")
    if data is not None and not curves:
        raise Error("--with beside no curve (it is laid over one). Add --curve structure.NAME.force_y/displacement_y?")


def write_curves(study: Study, curves: Sequence[CurveName], data: Optional[Data]) -> List[str]:
    """curve-NAME.csv and .svg of each variant's levels, and a line about each."""
    said = []
    for variant in study.variants:
        if not variant.levels:
            continue
        runs, cells = [Run(study.path / level.directory) for level in variant.levels], [level.cell for level in variant.levels]
        for curve in curves:
            band = band_of(runs, cells, curve)
            write_curve(study.path / variant.name, curve, band, data)
            head = f"{variant.name}: " if variant.name else ""
            share = 100 * band.mean_difference / (float(abs(band.y).max()) or 1.0)
            bar = "NO ORDER on these levels, so there is no band" if band.order is None else f"order {band.order:.2f}, band +- {two_digits(float(band.error.mean()))} in the mean"
            said.append(f"{head}{curve.text}: to the level before {two_digits(band.mean_difference)} in the mean ({two_digits(share)} % of its largest); {bar}"
                        + (f"; the data: {beside(band, data)}" if data is not None else ""))
    return said
