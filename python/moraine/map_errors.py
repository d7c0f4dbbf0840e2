"""What a refinement study knows of whole maps: differences to the next level, their order, the error bar of each cell, and how the
areas that were reached overlap.

The order is that of the mean difference over the cells that any of two levels reached; a cell's error is the safety factor times its
difference to the level before over r^p - 1 (Roache 1994, of grid functions), where that is no less than the root mean square of the
differences of the cells around it: two levels that happen to cross there are not exact.
"""
import dataclasses
import math
import pathlib
from typing import Any, Dict, List, Optional, Tuple

import numpy
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from .grids import Grid
from .map_values import laid_on, named_map, one_grid, reached
from .maps import UNITS, map_files
from .number_text import two_digits
from .results import Run
from .richardson import observed_order, safety_factor
from .tiff import write_like


@dataclasses.dataclass(frozen=True)
class MapError:
    """Of a map on the finest level: mean and largest difference to the level before [of the map], area reached [m2] and its
    overlap with that of the level before (common over united area), observed order and safety factor, and mean and largest
    error; None where there is no order. Means are over the cells that one of the two levels reached.
    """

    name: str
    mean: float
    largest: float
    area: float
    overlap: float
    order: Optional[float] = None
    safety: Optional[float] = None
    mean_error: Optional[float] = None
    largest_error: Optional[float] = None


def overlap_of(one: NDArray[Any], other: NDArray[Any]) -> float:
    """Common over united cells; 1 where both are empty.

    >>> overlap_of(numpy.array([True, True, False]), numpy.array([True, False, False]))
    0.5
    """
    united = int((one | other).sum())
    return float((one & other).sum()) / united if united else 1.0


def _difference(one: NDArray[Any], other: NDArray[Any]) -> Tuple[NDArray[Any], float]:
    """Of every cell, and the mean over those that are not 0 in both."""
    away = abs(one - other)
    there = numpy.isfinite(away) & ((one != 0) | (other != 0))
    return away, float(away[there].mean()) if there.any() else 0.0


def around(away: NDArray[Any]) -> NDArray[Any]:
    """The larger of a cell's own difference and the root mean square of those of the 3 x 3 cells around it that have one.

    >>> around(numpy.array([[3.0, 0.0, numpy.nan]])).round(3).tolist()
    [[3.0, 2.121, nan]]
    """
    known = numpy.isfinite(away)
    squares, counts = (sliding_window_view(numpy.pad(values, 1), (3, 3)).sum(axis=(2, 3)) for values in (numpy.where(known, away, 0.0)**2, known.astype(float)))
    wide: NDArray[Any] = numpy.maximum(away, numpy.sqrt(squares / numpy.maximum(counts, 1.0)))
    return wide


def map_error(runs: List[Run], cells: List[float], name: str) -> Tuple[MapError, Grid]:
    """Of two runs or three from coarse to fine; and the error of each cell, or its difference where there is no order."""
    grids = tuple(named_map(run, name) for run in runs)
    laid = one_grid(grids)
    came = [numpy.nan_to_num(values).astype(bool) for values in one_grid(tuple(dataclasses.replace(g, values=g.values.astype(float)) for g in map(reached, runs)))]
    away, mean = _difference(laid[-1], laid[-2])
    found = MapError(name, mean, float(numpy.nanmax(away, initial=0.0)), float(came[-1].sum()) * grids[0].cell**2, overlap_of(came[-1], came[-2]))
    field = Grid(numpy.where(came[-1] | came[-2], away, numpy.nan), laid_on(grids), grids[0].cell)
    before = _difference(laid[-2], laid[-3])[1] if len(laid) > 2 else 0.0
    order = observed_order(cells[-3:], [before + mean, mean, 0.0]) if len(laid) > 2 and mean > 0 and before > 0 else None
    if order is None:
        return found, field
    safety = safety_factor(order)
    factor = safety / math.expm1(order * math.log(cells[-2] / cells[-1]))
    field.values = factor * around(field.values)
    return dataclasses.replace(found, order=order, safety=safety, mean_error=factor * mean, largest_error=factor * found.largest), field


def write_map_errors(directories: List[pathlib.Path], cells: List[float], names: List[str], folder: pathlib.Path) -> Tuple[List[MapError], List[pathlib.Path]]:
    """Of the finest levels, with folder/NAME-error.tif of each map, or NAME-difference.tif where no order is seen."""
    runs, found, files = [Run(directory) for directory in directories[-3:]], [], []
    for name in names:
        error, field = map_error(runs, cells[-3:], name)
        for old in folder.glob(f"{name}-*.*") if folder.is_dir() else []:
            if old.name.startswith((f"{name}-error.", f"{name}-difference.")):
                old.unlink()
        kind = "difference" if error.order is None else "error"
        tags: Dict[str, str] = {"cells_m": ", ".join(f"{cell:.6g}" for cell in cells[-3:]), "what": WHAT[kind]}
        files.append(write_like(folder, f"{name}-{kind}", field, UNITS.get(name, ""), map_files(runs[-1].path)[name], tags))
        found.append(error)
    return found, files


WHAT = {"error": "error bar of the finest cells by the grid convergence index of the whole map",
        "difference": "difference of the finest two cells; the differences do not shrink, so there is no error bar"}


def map_line(error: MapError) -> str:
    """
    >>> map_line(MapError("deposit", 0.1, 1.2, 400.0, 0.9))
    'maps.deposit: to the level before 0.10 in the mean and 1.2 at most; NO ORDER on these levels, so there is no error bar; outlines overlap by 90 %'
    """
    text = f"maps.{error.name}: to the level before {two_digits(error.mean)} in the mean and {two_digits(error.largest)} at most; "
    if error.order is None:
        text += "NO ORDER on these levels, so there is no error bar"
    else:
        assert error.mean_error is not None and error.largest_error is not None and error.safety is not None
        text += (f"order {error.order:.2f}, error bar {two_digits(error.mean_error)} in the mean and {two_digits(error.largest_error)} at most "
                 f"(safety factor {error.safety:.2f})")
    return f"{text}; outlines overlap by {100 * error.overlap:.3g} %"
