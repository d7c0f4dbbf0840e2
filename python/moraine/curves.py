"""Curves of a structure, as load over displacement: over a range, with a band from three levels of cells, beside a user's own."""
import csv
import dataclasses
import math
import pathlib
from typing import Any, List, Optional, Sequence, Tuple

import numpy
from numpy.typing import NDArray

from .errors import Error
from .record_columns import column_of
from .results import Run
from .richardson import observed_order, safety_factor

POINTS = 80  # of a curve over its range


@dataclasses.dataclass(frozen=True)
class CurveName:
    """structure.NAME.Y/X: column Y of a structure over its column X."""

    structure: str
    y: str
    x: str

    @property
    def text(self) -> str:
        return f"structure.{self.structure}.{self.y}/{self.x}"

    def read(self, run: Run) -> Tuple[NDArray[Any], NDArray[Any]]:
        """x rising from its start on, and y there: rows in which x goes back are left out; what goes down counts as rising.

        Raises Error where the run has it not.
        """
        if self.structure not in run.structures:
            names = ", ".join(run.structures) or "none"
            raise Error(f"--curve {self.text} is not there (the structures are {names}). Is it structure.NAME.force_y/displacement_y?")
        table = run.structures[self.structure]
        x, y = (column_of(table, name, "structures.csv") for name in (self.x, self.y))
        away = x - x[0]
        turned = -1.0 if abs(away.min(initial=0)) > abs(away.max(initial=0)) else 1.0
        known = numpy.isfinite(away) & numpy.isfinite(y)
        away, y = turned * away[known], y[known]
        ahead = away > numpy.maximum.accumulate(numpy.concatenate([[-numpy.inf], away[:-1]]))
        return away[ahead], y[ahead]


def parse_curve(text: str) -> CurveName:
    """
    >>> parse_curve("structure.pipe.force_y/displacement_y").x
    'displacement_y'
    """
    path, slash, x = text.strip().partition("/")
    parts = path.split(".")
    if not slash or not x or len(parts) != 3 or parts[0] != "structure":
        raise Error(f"--curve {text} (it is a column of a structure over another). Is it structure.NAME.force_y/displacement_y?")
    return CurveName(parts[1], parts[2], x)


@dataclasses.dataclass(frozen=True)
class Band:
    """A curve of the finest level: x, y and error (points,), NaN where there is none; the order of the mean difference, None without one."""

    x: NDArray[Any]
    y: NDArray[Any]
    error: NDArray[Any]
    order: Optional[float]
    mean_difference: float


def around(away: NDArray[Any]) -> NDArray[Any]:
    """Root mean square over a fifth of the range around each point: where two levels happen to cross they are not exact.

    >>> around(numpy.array([3.0, 4.0])).round(3).tolist()
    [3.536, 3.536]
    """
    reach = max(1, len(away) // 10)
    total = numpy.concatenate([[0.0], numpy.cumsum(away**2)])
    ends = [(max(0, k - reach), min(len(away), k + reach + 1)) for k in range(len(away))]
    smooth: NDArray[Any] = numpy.sqrt(numpy.array([(total[b] - total[a]) / (b - a) for a, b in ends]))
    return smooth


def band_of(runs: Sequence[Run], cells: Sequence[float], name: CurveName) -> Band:
    """Of the finest three levels, over the range that all have."""
    curves = [name.read(run) for run in runs[-3:]]
    low, high = max(float(x[0]) for x, _ in curves), min(float(x[-1]) for x, _ in curves)
    if not high > low:
        raise Error(f"--curve {name.text} has no range (the structure's {name.x} does not move). Is it the column that moves?")
    at = numpy.linspace(low, high, POINTS)
    laid = [numpy.interp(at, x, y) for x, y in curves]
    away = abs(laid[-1] - laid[-2]) if len(laid) > 1 else numpy.full(POINTS, numpy.nan)
    mean = float(away.mean())
    before = float(abs(laid[-2] - laid[-3]).mean()) if len(laid) > 2 else 0.0
    order = observed_order(list(cells[-3:]), [before + mean, mean, 0.0]) if len(laid) > 2 and mean > 0 and before > 0 else None
    if order is None:
        return Band(at, laid[-1], numpy.full(POINTS, numpy.nan), None, mean)
    error = safety_factor(order) / math.expm1(order * math.log(cells[-2] / cells[-1])) * around(away)
    return Band(at, laid[-1], error, order, mean)


@dataclasses.dataclass(frozen=True)
class Data:
    """A user's own curve: names of its two columns, x and y (points,)."""

    xname: str
    yname: str
    x: NDArray[Any]
    y: NDArray[Any]


def read_data(path: pathlib.Path) -> Data:
    """A .csv with a header of two names, x first, and rows of numbers. Raises Error.

    >>> import tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "test.csv"
    >>> _ = file.write_text("displacement_y_m,force_y_N\\n0,0\\n0.1,2000\\n")
    >>> read_data(file).y.tolist()
    [0.0, 2000.0]
    """
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            rows: List[List[str]] = [row for row in csv.reader(file) if row]
        values = numpy.array([[float(word) for word in row[:2]] for row in rows[1:]])
        if values.ndim != 2 or values.shape[1] != 2 or len(values) < 2 or not numpy.isfinite(values).all():
            raise ValueError("two rows of two numbers at least are needed")
        return Data(rows[0][0].strip(), rows[0][1].strip(), values[:, 0], values[:, 1])
    except OSError as wrong:
        raise Error(f"--with {path} cannot be read ({wrong.strerror}). Is the path right?") from None
    except (ValueError, IndexError) as wrong:
        raise Error(f"--with {path} is no curve ({wrong}). Give it a header as displacement_y_m,force_y_N and rows of numbers?") from None


def beside(band: Band, data: Data) -> str:
    """How a user's curve lies to the computed one, in words."""
    there = (data.x >= band.x[0]) & (data.x <= band.x[-1])
    if not there.any():
        return f"none of the {len(data.x)} points of the data is in the range of the curve"
    off = numpy.interp(data.x[there], band.x, band.y) - data.y[there]
    scale = float(abs(data.y[there]).max()) or 1.0
    text = f"off by {100 * float(numpy.sqrt((off**2).mean())) / scale:.2g} % of the data's largest value in the mean (root mean square of {int(there.sum())} points)"
    if band.order is None:
        return text
    inside = abs(off) <= numpy.interp(data.x[there], band.x, band.error)
    return f"{text}; {int(inside.sum())} of them are within the band of the cells"
