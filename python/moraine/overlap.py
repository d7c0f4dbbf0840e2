"""How the area that a run reached lies to one that was seen: on the cells of its maps, wherever the polygons end, and only in one system of coordinates."""
import dataclasses
import json
import pathlib
import re
import sqlite3
from typing import Any, List, Optional

import numpy

from .errors import Error
from .grids import Grid
from .map_errors import overlap_of
from .map_values import reached
from .maps import map_files
from .polygons import Ring, cells_inside, read_polygons
from .results import Run

GEO_KEYS, PROJECTED, USER_DEFINED = 34735, 3072, 32767  # of GeoTIFF
WGS84 = 4326


@dataclasses.dataclass(frozen=True)
class Seen:
    """Polygons, of rings each, and the EPSG code of their system, None where they are in that of the scene."""

    polygons: List[List[Ring]]
    system: Optional[int]


def _geojson_system(path: pathlib.Path) -> Optional[int]:
    """Without a name a GeoJSON is in degrees, unless its numbers cannot be such."""
    text = path.read_text(encoding="utf-8")
    named = json.loads(text).get("crs")
    if named is None:
        corners = numpy.concatenate([ring for polygon in read_polygons(path) for ring in polygon])
        return WGS84 if bool((abs(corners) <= (180, 90)).all()) else None
    code = re.search(r"EPSG:+(\d+)", json.dumps(named))
    return int(code[1]) if code else WGS84 if "CRS84" in json.dumps(named) else None


def _geopackage_system(path: pathlib.Path) -> Optional[int]:
    base = sqlite3.connect(f"file:{path}?mode=ro&immutable=1", uri=True)
    try:
        found = base.execute("select organization, organization_coordsys_id from gpkg_spatial_ref_sys natural join gpkg_geometry_columns").fetchone()
        return int(found[1]) if found and str(found[0]).upper() == "EPSG" else None
    finally:
        base.close()


def read_seen(path: pathlib.Path) -> Seen:
    """Of a .geojson, a .gpkg or a .csv of corners. Raises Error."""
    polygons = read_polygons(path)
    ending = path.suffix.lower()
    return Seen(polygons, None if ending == ".csv" else _geopackage_system(path) if ending == ".gpkg" else _geojson_system(path))


def system_of(run: Run) -> Optional[int]:
    """EPSG code of a run's maps; None where they name none."""
    file = next((path for path in map_files(run.path).values() if path.suffix == ".tif"), None)
    if file is None:
        return None
    from PIL import Image
    with Image.open(file) as picture:
        tags: Any = getattr(picture, "tag_v2")
        keys = tags.get(GEO_KEYS, ())
    codes = [int(keys[k + 3]) for k in range(4, len(keys) - 3, 4) if keys[k] == PROJECTED]
    return codes[0] if codes and codes[0] != USER_DEFINED else None


def _around(grid: Grid, polygons: List[List[Ring]]) -> Grid:
    """The grid's cells, and False in as many more as the polygons need. Raises Error where they do not meet."""
    corners = numpy.concatenate([ring for polygon in polygons for ring in polygon])
    low, high = corners.min(axis=0), corners.max(axis=0)
    west, east, south, north = grid.extent
    if low[0] > east or high[0] < west or low[1] > north or high[1] < south:
        raise Error(f"the outline lies nowhere in the maps (x {low[0]:.10g} to {high[0]:.10g} and y {low[1]:.10g} to {high[1]:.10g}, the maps x {west:.10g} to {east:.10g} "
                    f"and y {south:.10g} to {north:.10g}). Is it in the coordinates of the model?")
    before = [max(0, int(numpy.ceil((first - corner) / grid.cell))) for first, corner in zip(grid.first, low)]
    behind = [max(0, int(numpy.ceil((corner - last) / grid.cell))) for last, corner in zip(grid.last, high)]
    values = numpy.pad(grid.values, ((before[1], behind[1]), (before[0], behind[0])))
    return Grid(values, (grid.first[0] - before[0] * grid.cell, grid.first[1] - before[1] * grid.cell), grid.cell)


class Overlap:
    """Areas [m2]: `seen`, `computed` and `common`; share: common over united area. Raises Error where both are not in one system."""

    def __init__(self, run: Run, seen: Seen) -> None:
        system = system_of(run) if seen.system is not None else None
        if system is not None and system != seen.system:
            raise Error(f"the outline is in EPSG:{seen.system} and the maps are in EPSG:{system} (it is not reprojected). ogr2ogr -t_srs EPSG:{system} NEW.gpkg OLD?")
        came = _around(reached(run), seen.polygons)
        inside = cells_inside(seen.polygons, came)
        cell = came.cell**2
        self.seen, self.computed = float(inside.sum()) * cell, float(came.values.sum()) * cell
        self.common = float((inside & came.values).sum()) * cell
        self.share = overlap_of(inside, came.values)
