"""A small valley with a release, for tests of terrain and of hazard maps."""
import json
import math
import os
import sqlite3
import struct

import geotiff
import moraine
from moraine import call

SCENE = """\
dimensions = 3
gravity = [0.0, 0.0, -9.81]
[domain]
min = [0.0, 0.0, 0.0]
max = [24.0, 12.0, 16.0]
cell = 0.5
[time]
end = 1.2
[terrain]
dem = "valley.asc"
contact = { law = "voellmy", friction = 0.2, xi = 500.0 }
[hazard]
cell = 1.0
threshold = 0.2
[[material]]
name = "debris"
law = "drucker-prager"
density = 1800.0
young = 1.0e6
poisson = 0.3
friction_angle = 25.0
[[release]]
name = "scar"
material = "debris"
area = "area.csv"
thickness = 1.0
"""
AREA = "x,y\n2,3\n6,3.5\n6.5,8\n4,9\n2,8.5\n"


def heights(x, y):
    """A chute that bends and runs out on a plain."""
    return 10 * max(0, 1 - x / 20) ** 2 + 1 + 0.05 * (y - 6 - math.sin(x / 4)) ** 2


def grid(columns=13, rows=7, side=2.0, at=heights):
    lines = [f"ncols {columns}", f"nrows {rows}", "xllcenter 0", "yllcenter 0", f"cellsize {side}", "NODATA_value -9999"]
    lines += [" ".join(f"{at(side * i, side * j):.6g}" for i in range(columns)) for j in reversed(range(rows))]
    return "\n".join(lines) + "\n"


GDAL = os.environ.get("MORAINE_GDAL") == "1"
ZONE = """PROJCS["zone",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],
UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],
PARAMETER["central_meridian",9],PARAMETER["scale_factor",1],PARAMETER["false_easting",0],PARAMETER["false_northing",0],
UNIT["metre",1]]"""  # near its origin a degree is 111.3 km east and 110.6 km north


def features(*polygons):
    """A GeoJSON of (corners in x and y, properties)."""
    return json.dumps({"type": "FeatureCollection", "features": [
        {"type": "Feature", "properties": properties,
         "geometry": {"type": "Polygon", "coordinates": [corners + corners[:1]]}} for corners, properties in polygons]})


def read_map(directory, name):
    """Rows from the north; where the flow was not 0, but in arrival, where it is -9999."""
    if GDAL:
        rows = geotiff.read(directory / "maps" / f"{name}.tif")[0]
    else:
        lines = (directory / "maps" / f"{name}.asc").read_text().splitlines()
        rows = [[float(word) for word in line.split()] for line in lines[6:]]
    return [[0.0 if value == -9999 and name != "arrival" else value for value in row] for row in rows]


def map_grid(directory, name):
    """Lower left corner and side of the cells of a map [m]."""
    if GDAL:
        rows, tags = geotiff.read(directory / "maps" / f"{name}.tif")
        side, tie = tags[33550][0], tags[33922]
        return {"x": tie[3], "y": tie[4] - len(rows) * side, "side": side}
    words = (directory / "maps" / f"{name}.asc").read_text().split()[:10]
    head = dict(zip(words[::2], map(float, words[1::2])))
    return {"x": head["xllcorner"], "y": head["yllcorner"], "side": head["cellsize"]}


def total(rows):
    return sum(sum(row) for row in rows)


class ValleyTest(moraine.ProgramTest):
    def setUp(self):
        super().setUp()
        self.write(grid(), "valley.asc")
        self.write(AREA, "area.csv")
        self.scene = self.write(SCENE)

    def run_scene(self, scene, output, *words, **more):
        return super().run_scene(scene, output, *words, "--device", "cpu", **more)

    def maps(self, directory):
        return {path.name: path.read_bytes() for path in sorted((directory / "maps").iterdir())
                if path.stem != "outline"} | {"outline": self.outline(directory)}

    def outline(self, directory):
        """The geometry: a GeoPackage also says when it was made."""
        if not GDAL:
            return (directory / "maps" / "outline.geojson").read_text()
        with sqlite3.connect(directory / "maps" / "outline.gpkg") as file:
            return file.execute("select geom, threshold from outline").fetchall()

    def rows_of_outline(self, directory):
        """Area inside the outline, by its rings."""
        if GDAL:
            blob = self.outline(directory)[0][0]
            at = 8 + 32  # header and envelope
            rings = []
            count = struct.unpack_from("<I", blob, at + 5)[0]
            at += 9
            for _ in range(count):
                inner = struct.unpack_from("<I", blob, at + 5)[0]
                at += 9
                for _ in range(inner):
                    n = struct.unpack_from("<I", blob, at)[0]
                    rings.append([struct.unpack_from("<dd", blob, at + 4 + 16 * k) for k in range(n)])
                    at += 4 + 16 * n
        else:
            rings = [r for p in json.loads(self.outline(directory))["geometry"]["coordinates"] for r in p]
        return sum(0.5 * (a[0] * b[1] - b[0] * a[1]) for ring in rings for a, b in zip(ring, ring[1:]))

    def refused(self, text, name="scene.toml"):
        self.write(text, name)
        return self.assert_one_problem(call("check", self.scene, "--device", "cpu"))

    def changed(self, old, new):
        self.assertIn(old, SCENE)
        return self.refused(SCENE.replace(old, new))
