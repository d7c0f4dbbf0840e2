"""Polygons in the coordinates of the scene, from GeoJSON, a .csv of corners or a GeoPackage, and the cells of a grid that they hold."""
import json
import math
import pathlib
import sqlite3
import struct
from typing import Any, List, Tuple

import numpy
from numpy.typing import NDArray

from .errors import Error
from .grids import Grid

Ring = NDArray[Any]  # (n, 2) [m]
ENVELOPES = (0, 32, 48, 48, 64)  # bytes of a GeoPackage's envelope by its kind


def _geojson(path: pathlib.Path) -> List[List[Ring]]:
    def polygons(shape: Any) -> List[Any]:
        kind = shape.get("type")
        if kind == "FeatureCollection":
            return [polygon for feature in shape["features"] for polygon in polygons(feature)]
        if kind == "Feature":
            return polygons(shape["geometry"])
        if kind == "GeometryCollection":
            return [polygon for part in shape["geometries"] for polygon in polygons(part)]
        return [shape["coordinates"]] if kind == "Polygon" else list(shape["coordinates"]) if kind == "MultiPolygon" else []
    return [[numpy.array([point[:2] for point in ring], dtype=float) for ring in polygon] for polygon in polygons(json.loads(path.read_text(encoding="utf-8")))]


def _wkb(data: bytes, at: int) -> Tuple[List[List[Ring]], int]:
    """A polygon or several, and where what follows begins."""
    order = "<" if data[at] == 1 else ">"
    kind = struct.unpack_from(order + "I", data, at + 1)[0]
    count = struct.unpack_from(order + "I", data, at + 5)[0]
    width = 2 + (kind // 1000 in (1, 2, 3)) + (kind // 1000 == 3)
    at, rings, found = at + 9, [], []
    for _ in range(count):
        if kind % 1000 == 3:
            points = struct.unpack_from(order + "I", data, at)[0]
            rings.append(numpy.frombuffer(data, order + "f8", points * width, at + 4).reshape(points, width)[:, :2].astype(float))
            at += 4 + 8 * points * width
        elif kind % 1000 == 6:
            more, at = _wkb(data, at)
            found += more
        else:
            raise ValueError(f"a geometry of kind {kind}")
    return found + ([rings] if rings else []), at


def _geopackage(path: pathlib.Path) -> List[List[Ring]]:
    base = sqlite3.connect(f"file:{path}?mode=ro&immutable=1", uri=True)
    try:
        layers = base.execute("select table_name, column_name from gpkg_geometry_columns").fetchall()
        found: List[List[Ring]] = []
        for layer, column in layers:
            for (blob,) in base.execute('select "{}" from "{}"'.format(column.replace('"', '""'), layer.replace('"', '""'))):
                if blob is not None:
                    found += _wkb(blob, 8 + ENVELOPES[(blob[3] >> 1) & 7])[0]
        return found
    finally:
        base.close()


def read_polygons(path: pathlib.Path) -> List[List[Ring]]:
    """All polygons of a file, each with its outer ring and its holes. Raises Error.

    >>> import tempfile
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "area.csv"
    >>> _ = file.write_text("x,y\\n0,0\\n4,0\\n4,2\\n")
    >>> read_polygons(file)[0][0].tolist()
    [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0]]
    """
    try:
        if path.suffix.lower() == ".csv":
            found = [[numpy.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)[:, :2]]]
        else:
            found = _geopackage(path) if path.suffix.lower() == ".gpkg" else _geojson(path)
    except OSError as wrong:
        raise Error(f"{path} cannot be read ({wrong.strerror or wrong}). Is the path right?") from None
    except (ValueError, LookupError, TypeError, AttributeError, sqlite3.Error, struct.error) as wrong:
        raise Error(f"{path} has no polygons that can be read ({wrong or type(wrong).__name__}). Give it as .geojson, .gpkg or .csv with x,y?") from None
    if not found or any(len(ring) < 3 for polygon in found for ring in polygon):
        raise Error(f"{path} has no polygons (rings of 3 corners or more are needed). Is it the right file?")
    return found


def cells_inside(polygons: List[List[Ring]], grid: Grid) -> NDArray[Any]:
    """Cells (rows, columns) whose centres lie within one of the polygons, and not in a hole of it.

    >>> cells_inside([[numpy.array([[0.0, 0.0], [2.0, 0.0], [2.0, 3.0], [0.0, 3.0]])]], Grid(numpy.zeros((2, 3)), (0.5, 0.5), 1.0)).tolist()
    [[True, True, False], [True, True, False]]
    """
    rows, columns = grid.values.shape
    x = grid.first[0] + grid.cell * numpy.arange(columns)
    inside = numpy.zeros((rows, columns), dtype=bool)
    for polygon in polygons:
        within = numpy.zeros((rows, columns), dtype=bool)
        for ring in polygon:
            for (ax, ay), (bx, by) in zip(ring, numpy.roll(ring, -1, axis=0)):
                low, high = ((min(ay, by) - grid.first[1]) / grid.cell, (max(ay, by) - grid.first[1]) / grid.cell)
                for row in range(max(0, math.floor(low)), min(rows, math.ceil(high) + 1)):
                    y = grid.first[1] + grid.cell * row
                    if (ay > y) != (by > y):
                        within[row] ^= x < ax + (y - ay) / (by - ay) * (bx - ax)
        inside |= within
    return inside
