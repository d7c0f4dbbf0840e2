"""Grids of numbers in plan: the model of the ground, and the maps of a run. ESRI ASCII grids, and TIFF of 32-bit numbers."""
import dataclasses
import pathlib
from typing import Any, Dict, Tuple, Union

import numpy
from numpy.typing import NDArray

from .errors import Error

SCALE, TIE, NO_DATA = 33550, 33922, 42113  # tags of GeoTIFF and GDAL


@dataclasses.dataclass
class Grid:
    """values (rows, columns), from the south and west on; NaN: no value. The outer cells' centres are `first` and `last` [m]."""

    values: NDArray[Any]
    first: Tuple[float, float]
    cell: float

    @property
    def last(self) -> Tuple[float, float]:
        rows, columns = self.values.shape
        return self.first[0] + (columns - 1) * self.cell, self.first[1] + (rows - 1) * self.cell

    @property
    def extent(self) -> Tuple[float, float, float, float]:
        """West, east, south, north of the outer cells' edges [m]."""
        half = self.cell / 2
        return self.first[0] - half, self.last[0] + half, self.first[1] - half, self.last[1] + half

    def within(self, west: float, east: float, south: float, north: float) -> "Grid":
        """The cells whose centres lie within, and one more all around where there is one."""
        low = [max(0, int(numpy.floor((edge - first) / self.cell))) for edge, first in zip((west, south), self.first)]
        high = [int(numpy.ceil((edge - first) / self.cell)) + 1 for edge, first in zip((east, north), self.first)]
        first = self.first[0] + low[0] * self.cell, self.first[1] + low[1] * self.cell
        return Grid(self.values[low[1]:max(high[1], 0), low[0]:max(high[0], 0)], first, self.cell)


def read_grid(path: Union[str, pathlib.Path]) -> Grid:
    """An ESRI ASCII grid (.asc), or a TIFF of 32-bit numbers with the tags of GeoTIFF (.tif), which needs Pillow.

    >>> import tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "depth.asc"
    >>> _ = file.write_text("ncols 2\\nnrows 2\\nxllcorner 10\\nyllcorner 0\\ncellsize 4\\nNODATA_value -9\\n1 2\\n3 -9\\n")
    >>> grid = read_grid(file)
    >>> grid.values.tolist(), grid.first, grid.extent
    ([[3.0, nan], [1.0, 2.0]], (12.0, 2.0), (10.0, 18.0, 0.0, 8.0))
    """
    path = pathlib.Path(path)
    if not path.is_file():
        raise Error(f"{path} cannot be read (no such file). Is the path right?")
    try:
        grid = _tiff(path) if path.suffix.lower() in (".tif", ".tiff") else _ascii(path)
    except (ValueError, KeyError, IndexError, OverflowError) as wrong:
        raise Error(f"{path} is no grid that can be read ({type(wrong).__name__}: {wrong}). Is it an ESRI ASCII grid, or a TIFF of 32-bit numbers?") from None
    if grid.values.size == 0 or not grid.cell > 0:
        raise Error(f"{path} is no grid that can be read (it has no cells). Is it whole?")
    return grid


def _ascii(path: pathlib.Path) -> Grid:
    head: Dict[str, float] = {}
    words = path.read_text(encoding="utf-8").split()
    k = 0
    while k + 1 < len(words) and words[k][0].isalpha() and words[k].lower() not in ("nan", "inf"):
        head[words[k].lower()] = float(words[k + 1])
        k += 2
    rows, columns, cell = int(head["nrows"]), int(head["ncols"]), head["cellsize"]
    values = numpy.array(words[k:], dtype=float).reshape(rows, columns)[::-1]
    values[values == head.get("nodata_value", -9999.0)] = numpy.nan
    west, south = (head[f"{axis}llcenter"] if f"{axis}llcenter" in head else head[f"{axis}llcorner"] + cell / 2 for axis in "xy")
    return Grid(values, (west, south), cell)


def _tiff(path: pathlib.Path) -> Grid:
    try:
        from PIL import Image
    except ImportError as missing:
        raise Error(f"{path} cannot be read ({missing}). pip install pillow, or give it as .asc by gdal_translate -of AAIGrid?") from None
    try:
        with Image.open(path) as picture:
            tags: Any = getattr(picture, "tag_v2")
            if picture.mode != "F":
                raise ValueError(f"its numbers are of mode {picture.mode}")
            values = numpy.array(picture, dtype=float)[::-1]
    except OSError as wrong:
        raise ValueError(str(wrong)) from None
    cell, tie = float(tags[SCALE][0]), tags[TIE]
    if NO_DATA in tags:
        values[values == float(str(tags[NO_DATA]).strip("\0 "))] = numpy.nan
    west, north = tie[3] - tie[0] * cell, tie[4] + tie[1] * cell
    return Grid(values, (west + cell / 2, north - (len(values) - 0.5) * cell), cell)
