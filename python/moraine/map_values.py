"""Numbers of a run's hazard maps, and what lies between the maps of two runs on one grid."""
import dataclasses
import difflib
from typing import Any, Tuple

import numpy
from numpy.typing import NDArray

from .errors import Error
from .grids import Grid
from .maps import map_files
from .results import Run

MAP_VALUES = ("max", "mean")
NEAR = 1e-6  # of a cell: grids that lie closer are one


def named_map(run: Run, name: str) -> Grid:
    """A map of a run, 0 where nothing came but in arrival. Raises Error where the run has it not."""
    found = list(map_files(run.path))
    if name not in found:
        near = difflib.get_close_matches(name, found, 1, 0.3) or found[:1]
        raise Error(f"--quantity maps.{name} is not there ({'the maps are ' + ', '.join(found) if found else 'the scene has no [hazard]'}). "
                    f"Did you mean {f'maps.{near[0]}' if near else 'front'}?")
    grid = run.maps[name]
    return grid if name == "arrival" else dataclasses.replace(grid, values=numpy.nan_to_num(grid.values, nan=0.0))


def reached(run: Run) -> Grid:
    """Whether the flow came to a cell: its time of arrival is known."""
    if "arrival" not in map_files(run.path):
        raise Error("--quantity maps.area is not there (it needs the map arrival). Add it to hazard.maps of the scene?")
    grid = run.maps["arrival"]
    return dataclasses.replace(grid, values=numpy.isfinite(grid.values))


def map_value(run: Run, name: str) -> float:
    """maps.area [m2], or maps.NAME.max or .mean: over the cells that the flow came to."""
    parts = name.split(".")
    if parts[1:] == ["area"]:
        came = reached(run)
        return float(came.values.sum()) * came.cell**2
    if len(parts) != 3 or parts[2] not in MAP_VALUES:
        raise Error(f"--quantity {name} (a map has {' and '.join(MAP_VALUES)}). Did you mean {'.'.join(parts[:2])}?")
    grid = named_map(run, parts[1])
    values = grid.values[numpy.isfinite(grid.values) & ((grid.values != 0) | (parts[1] == "arrival"))]
    if not values.size:
        return 0.0
    return float(values.max() if parts[2] == "max" else values.mean())


def one_grid(grids: Tuple[Grid, ...]) -> Tuple[NDArray[Any], ...]:
    """Values of several maps on the smallest grid that holds all, NaN where one has none. Raises Error where their cells do not fit."""
    first = grids[0]
    for grid in grids[1:]:
        away = [(b - a) / first.cell for a, b in zip(first.first, grid.first)]
        if abs(grid.cell - first.cell) > NEAR * first.cell or any(abs(x - round(x)) > 1e3 * NEAR for x in away):
            raise Error("maps of two runs do not lie on one grid (their cells or corners differ). Have both one hazard.cell?")
    low = tuple(min(grid.first[a] for grid in grids) for a in (0, 1))
    high = tuple(max(grid.last[a] for grid in grids) for a in (0, 1))
    columns, rows = (round((high[a] - low[a]) / first.cell) + 1 for a in (0, 1))
    laid = []
    for grid in grids:
        i, j = (round((grid.first[a] - low[a]) / first.cell) for a in (0, 1))
        values = numpy.full((rows, columns), numpy.nan)
        values[j:j + grid.values.shape[0], i:i + grid.values.shape[1]] = grid.values
        laid.append(values)
    return tuple(laid)


def laid_on(grids: Tuple[Grid, ...]) -> Tuple[float, float]:
    """Centre of the south-western cell of one_grid() [m]."""
    return min(grid.first[0] for grid in grids), min(grid.first[1] for grid in grids)
