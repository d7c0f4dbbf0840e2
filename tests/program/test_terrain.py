"""Terrain as a user meets it: one answer on any number of ranks and after a restart, maps that hold what flowed, and
words for models, areas and maps that are wrong."""
import json
import math
import os
import sqlite3
import struct
import unittest

import geotiff
import moraine
from moraine import call, checkpoints, sets, summary

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
    if GDAL:
        return geotiff.read(directory / "maps" / f"{name}.tif")[0]
    lines = (directory / "maps" / f"{name}.asc").read_text().splitlines()
    return [[float(word) for word in line.split()] for line in lines[6:]]


def total(rows):
    return sum(sum(row) for row in rows)


class Terrain(moraine.ProgramTest):
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

    def test_state_and_maps_are_the_same_on_1_to_4_ranks_and_after_a_restart(self):
        one = self.run_scene(self.scene, "one", *sets(output__checkpoint_interval=0.5))
        self.assertEqual(len(self.maps(one)), 7)
        for ranks in (2, 3, 4):
            many = self.run_scene(self.scene, f"r{ranks}", "--partitioner", "shuffle",
                                  *sets(balance__trigger="every", balance__interval=20), ranks=ranks)
            self.assertEqual(summary(many)["state_hash"], summary(one)["state_hash"])
            self.assertEqual(self.maps(many), self.maps(one))
            self.assertEqual(summary(many)["structures"], summary(one)["structures"])
        again = self.run_scene(self.scene, "again", "--restart", checkpoints(one)[0], ranks=2)
        self.assertEqual(summary(again)["state_hash"], summary(one)["state_hash"])
        self.assertEqual(self.maps(again), self.maps(one))

    def test_the_maps_hold_what_flowed(self):
        directory = self.run_scene(self.scene, "run")
        found = summary(directory)
        start = self.run_scene(self.scene, "start", *sets(time__end=0))
        volume = total(read_map(start, "deposit"))
        self.assertAlmostEqual(volume, found["mass_kg"] / 1800, delta=1e-6 * volume)
        deepest, fastest = read_map(directory, "max_depth"), read_map(directory, "max_speed")
        self.assertEqual((len(deepest), len(deepest[0])), (12, 24))
        arrival, deposit = read_map(directory, "arrival"), read_map(directory, "deposit")
        self.assertGreater(total(deposit), 0.9 * volume)
        reached = [(row, column) for row in range(12) for column in range(24) if arrival[row][column] >= 0]
        self.assertTrue(any(arrival[row][column] > 0.3 for row, column in reached))
        for row in range(12):
            for column in range(24):
                self.assertGreaterEqual(deepest[row][column], deposit[row][column])
                self.assertEqual((row, column) in reached, deepest[row][column] >= 0.2)
        top = max(max(row) for row in fastest)
        self.assertGreater(top, 1.0)
        self.assertLess(top, math.sqrt(2 * 9.81 * 11))

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

    def test_the_outline_has_the_area_of_the_cells_that_were_reached(self):
        directory = self.run_scene(self.scene, "run", *sets(time__end=0.5))
        reached = sum(d >= 0.2 for row in read_map(directory, "max_depth") for d in row)
        self.assertGreater(reached, 20)
        self.assertAlmostEqual(self.rows_of_outline(directory), reached, places=9)

    @unittest.skipUnless(GDAL, "a build without GDAL")
    def test_a_map_says_its_unit_place_and_what_is_unknown(self):
        self.write(ZONE, "valley.prj")
        directory = self.run_scene(self.scene, "run", *sets(time__end=0))
        rows, tags = geotiff.read(directory / "maps" / "arrival.tif")
        self.assertEqual(tags[42113], b"-9999\0")
        self.assertIn(b">s</Item>", tags[42112])
        self.assertEqual(tags[33550], (1.0, 1.0, 0.0))
        self.assertEqual(tags[33922], (0, 0, 0, 0.0, 12.0, 0.0))
        self.assertIn(34735, tags)  # the system's keys
        self.assertEqual(tags[259], (8,))
        self.assertIn(-9999, rows[0])

    @unittest.skipUnless(GDAL, "a build without GDAL")
    def test_a_release_is_taken_to_the_system_of_the_model(self):
        plain = self.run_scene(self.scene, "plain", *sets(time__end=0))
        self.write(ZONE, "valley.prj")
        corners = [[float(x) for x in line.split(",")] for line in AREA.split()[1:]]
        degrees = [[9 + x / 111319.490793, y / 110574.2758] for x, y in corners]
        self.write(features((degrees, {"thickness": 1.0})), "area.geojson")
        self.write(SCENE.replace("area.csv", "area.geojson").replace("thickness = 1.0\n", ""))
        ended = call("run", self.scene, "--output", self.folder / "warped", "--device", "cpu", *sets(time__end=0))
        self.assertEqual(ended.code, 0, ended)
        self.assertIn("area.geojson: reprojected from WGS 84 (EPSG:4326) to zone, the model's.", ended.err)
        self.assertAlmostEqual(summary(self.folder / "warped")["mass_kg"] / summary(plain)["mass_kg"], 1, delta=1e-4)

    @unittest.skipUnless(GDAL, "a build without GDAL")
    def test_a_run_goes_on_from_the_maps_of_another(self):
        first = self.run_scene(self.scene, "first", *sets(time__end=0.5))
        self.write(SCENE.replace("area.csv", "first/maps/outline.gpkg").replace(
            "thickness = 1.0", 'thickness = "first/maps/max_depth.tif"'))
        second = self.run_scene(self.scene, "second", *sets(time__end=0))
        deepest = total(read_map(first, "max_depth"))
        volume = summary(second)["mass_kg"] / 1800
        self.assertGreater(volume, 0.9 * deepest)
        self.assertLess(volume, 1.4 * deepest)

    def test_rasters_of_the_bed_hold_where_they_know_a_value(self):
        plain = self.run_scene(self.scene, "plain")
        with_bed = SCENE.replace("[hazard]", 'friction = "mu.asc"\nxi = "xi.asc"\n[hazard]').replace(
            'dem = "valley.asc"\ncontact = { law = "voellmy", friction = 0.2, xi = 500.0 }',
            'dem = "valley.asc"\ncontact = { law = "voellmy", friction = 0.9, xi = 500.0 }')
        self.write(grid(at=lambda x, y: 0.2), "mu.asc")
        self.write(grid(at=lambda x, y: -9999), "xi.asc")
        self.write(with_bed)
        same = self.run_scene(self.scene, "same")
        self.assertEqual(self.maps(same), self.maps(plain))
        self.write(grid(at=lambda x, y: 0.2 if x < 6 else 0.8), "mu.asc")
        rough = self.run_scene(self.scene, "rough")
        two = self.run_scene(self.scene, "two", "--partitioner", "shuffle", ranks=2)
        self.assertEqual(self.maps(two), self.maps(rough))
        beyond = [sum(sum(row[7:]) for row in read_map(run, "max_speed")) for run in (rough, plain)]
        self.assertLess(beyond[0], 0.98 * beyond[1])

    def test_a_raster_that_does_not_fit_is_refused_with_file_and_reason(self):
        scene = SCENE.replace("[hazard]", 'friction = "mu.asc"\n[hazard]')
        mu = lambda at: self.write(grid(at=at), "mu.asc")
        self.assertIn("no such file", self.refused(scene))
        mu(lambda x, y: -0.1)
        self.assertIn("mu.asc: a friction of -0.1 (must be >= 0)", self.refused(scene))
        self.write(grid().replace("xllcenter 0", "xllcenter 100"), "mu.asc")
        self.assertIn("mu.asc: the raster of friction reaches from 99 to 125 along x", self.refused(scene))
        mu(lambda x, y: 0.1)
        self.assertIn("terrain.friction is not used", self.refused(scene.replace(
            'law = "voellmy", friction = 0.2, xi = 500.0', 'law = "rough"')))
        self.assertIn("terrain.xi is not used", self.refused(scene.replace('friction = "mu.asc"', 'xi = "mu.asc"').replace(
            'law = "voellmy", friction = 0.2, xi = 500.0', 'law = "coulomb", friction = 0.2')))

    def test_the_thickness_of_a_release_may_be_a_raster(self):
        self.write(grid(at=lambda x, y: 1.0), "deep.asc")
        raster = SCENE.replace("thickness = 1.0", 'thickness = "deep.asc"')
        plain = self.run_scene(self.scene, "plain", *sets(time__end=0))
        self.write(raster)
        same = self.run_scene(self.scene, "same", *sets(time__end=0))
        self.assertEqual(summary(same)["state_hash"], summary(plain)["state_hash"])
        self.write(grid(at=lambda x, y: 0.25 * y), "deep.asc")
        wedge = self.run_scene(self.scene, "wedge", *sets(time__end=0))
        ratio = summary(wedge)["mass_kg"] / summary(plain)["mass_kg"]
        self.assertGreater(ratio, 0.25 * 3)
        self.assertLess(ratio, 0.25 * 9)
        two = self.run_scene(self.scene, "two", *sets(time__end=0), ranks=2)
        self.assertEqual(summary(two)["state_hash"], summary(wedge)["state_hash"])
        self.write(grid(at=lambda x, y: 0.3), "deep.asc")
        self.assertIn("is at most 0.3 m thick (less than a cell", self.refused(raster))
        self.write(grid(at=lambda x, y: -9999 if x == 4 and y == 6 else 1), "deep.asc")
        self.assertIn("deep.asc: no thickness at (4, 6)", self.refused(raster))
        self.assertIn("release.scar.thickness is missing", self.refused(SCENE.replace("thickness = 1.0\n", "")))

    @unittest.skipUnless(GDAL, "a build without GDAL")
    def test_every_polygon_of_a_file_is_a_body_with_its_own_thickness(self):
        low, high = [[2, 3], [6, 3], [6, 5.5], [2, 5.5]], [[2, 6.5], [6, 6.5], [6, 9], [2, 9]]
        self.write(features((low, {"thickness": 1}), (high, {"thickness": 2})), "area.geojson")
        self.write(SCENE.replace("area.csv", "area.geojson").replace("thickness = 1.0\n", ""))
        ended = call("check", self.scene, "--device", "cpu")
        self.assertEqual(ended.code, 0, ended)
        self.assertRegex(ended.out, r"release    scar-1: \S+ m3, 2 cells thick")
        self.assertRegex(ended.out, r"release    scar-2: \S+ m3, 4 cells thick\n")

    def test_gauges_tell_what_their_columns_hold(self):
        self.write("name,x,y\nscar,4.5,6.5\nroad,9.5,6.5\n", "gauges.csv")
        self.write(SCENE.replace("threshold = 0.2", 'threshold = 0.2\ngauges = "gauges.csv"'))
        one = self.run_scene(self.scene, "one", *sets(output__checkpoint_interval=0.5))
        rows = moraine.table(one, "gauges.csv")
        deepest, arrival = read_map(one, "max_depth"), read_map(one, "arrival")
        for name, column in (("scar", 4), ("road", 9)):
            depths = [float(row[f"{name}_depth_m"]) for row in rows]
            self.assertAlmostEqual(max(depths), deepest[5][column], places=5)
            first = next(float(row["time_s"]) for row in rows if float(row[f"{name}_depth_m"]) >= 0.2)
            self.assertAlmostEqual(first, arrival[5][column], places=5)
        self.assertGreater(max(float(row["road_pressure_Pa"]) for row in rows), 0)
        text = (one / "gauges.csv").read_bytes()
        two = self.run_scene(self.scene, "two", "--partitioner", "shuffle", ranks=2)
        self.assertEqual((two / "gauges.csv").read_bytes(), text)
        self.run_scene(self.scene, "one", "--restart", checkpoints(one)[0])
        self.assertEqual((one / "gauges.csv").read_bytes(), text)
        self.assertIn("gauge road is at (99, 1) (outside the domain)",
                      self.refused("name,x,y\nroad,99,1\n", "gauges.csv"))
        self.assertIn("it is there twice", self.refused("name,x,y\nroad,9,1\nroad,8,1\n", "gauges.csv"))

    DOMAIN = "min = [0.0, 0.0, 0.0]\nmax = [24.0, 12.0, 16.0]\n"

    def test_a_domain_that_is_left_out_is_that_of_the_model(self):
        said = self.run_scene(self.scene, "said")
        self.write(SCENE.replace(self.DOMAIN, ""))
        ended = call("check", self.scene, "--device", "cpu")
        self.assertEqual(ended.code, 0, ended)
        self.assertRegex(ended.out, r"domain     from 0 0 -3.5 to 24 12 21.5 m")
        left_out = self.run_scene(self.scene, "left_out", *sets(output__checkpoint_interval=0.5))
        for name in ("max_depth", "deposit"):
            for one, other in zip(read_map(said, name), read_map(left_out, name)):
                for a, b in zip(one, other):
                    self.assertAlmostEqual(a, b, places=6)
        self.assertEqual(summary(left_out)["lost_particles"], 0)
        again = self.run_scene(self.scene, "again", "--restart", checkpoints(left_out)[0], ranks=2)
        self.assertEqual(summary(again)["state_hash"], summary(left_out)["state_hash"])
        self.assertIn("domain.max is missing (domain.min is there)",
                      self.changed(self.DOMAIN, "min = [0.0, 0.0, 0.0]\n"))
        plain = SCENE[:SCENE.index("[terrain]")] + SCENE[SCENE.index("[[material]]"):SCENE.index("[[release]]")]
        self.assertIn("domain.min is missing", self.refused(plain.replace(self.DOMAIN, "")))

    def test_a_crop_lays_the_domain_around_its_polygon(self):
        self.write("x,y\n1.2,2.1\n10.9,3\n8,10.7\n", "crop.csv")
        cropped = SCENE.replace(self.DOMAIN, "").replace("[hazard]", 'crop = "crop.csv"\n[hazard]')
        self.write(cropped)
        ended = call("check", self.scene, "--device", "cpu")
        self.assertEqual(ended.code, 0, ended)
        self.assertIn("domain     from 1 2 ", ended.out)
        self.assertRegex(ended.out, r" to 11 11 \S+ m\n")
        directory = self.run_scene(self.scene, "run")
        self.assertEqual((len(read_map(directory, "deposit")), len(read_map(directory, "deposit")[0])), (9, 10))
        self.assertIn("terrain.crop is not used (domain.min and domain.max say where the domain is)",
                      self.refused(SCENE.replace("[hazard]", 'crop = "crop.csv"\n[hazard]')))
        self.write(cropped)
        self.assertIn("crop.csv: the crop reaches from 1.2 to 40 along x (the model from -1 to 25)",
                      self.refused("x,y\n1.2,2\n40,3\n8,10\n", "crop.csv"))
        self.assertIn("has a corner at", self.refused("x,y\n12,2\n20,3\n18,10\n", "crop.csv"))
        self.assertIn("no such file", self.refused(cropped.replace("crop.csv", "absent.csv")))

    def test_a_ground_that_bends_sharply_is_told_and_smoothed(self):
        self.write(grid(25, 13, 1.0, lambda x, y: max(0, 8 - x) + 1), "valley.asc")
        ended = call("check", self.scene, "--device", "cpu")
        self.assertRegex(ended.out, r"least radius of curvature 0\.\d+ m\nwarning    that is less than 5 cells: .+terrain.smooth = 2.5,")
        smooth = SCENE.replace("[hazard]", "smooth = 4.0\n[hazard]")
        self.write(smooth)
        ended = call("check", self.scene, "--device", "cpu")
        self.assertEqual(ended.code, 0, ended)
        self.assertRegex(ended.out, r"valley.asc: smoothed from a least radius of curvature of 0\S+ m to 4\S* m; heights")
        self.assertNotIn("warning", ended.out)
        one = self.run_scene(self.scene, "one", *sets(time__end=0.5))
        two = self.run_scene(self.scene, "two", *sets(time__end=0.5), ranks=2)
        self.assertEqual(summary(one)["state_hash"], summary(two)["state_hash"])
        self.assertIn("terrain.smooth = 0", self.refused(smooth.replace("smooth = 4.0", "smooth = 0.0")))
        self.assertIn("cannot be brought there", self.refused(smooth.replace("smooth = 4.0", "smooth = 1e9")))

    SECTIONS = "name,x,y\nneck,7,10\nneck,7.5,5\nneck,7,2\nback,9,2\nback,9,10\n"

    def test_what_goes_over_sections_is_the_same_on_any_ranks_and_after_a_restart(self):
        self.write(self.SECTIONS, "lines.csv")
        self.write(SCENE.replace("threshold = 0.2", 'threshold = 0.2\nsections = "lines.csv"'))
        one = self.run_scene(self.scene, "one", *sets(output__checkpoint_interval=0.5))
        text = (one / "sections.csv").read_bytes()
        rows = moraine.table(one, "sections.csv")
        self.assertGreater(rows[-1]["neck_volume_m3"], 2.0)
        self.assertLess(rows[-1]["back_volume_m3"], 0)
        volume = 0
        for last, row in zip(rows, rows[1:]):
            volume += (row["time_s"] - last["time_s"]) * row["neck_discharge_m3_s"]
            self.assertAlmostEqual(volume, row["neck_volume_m3"], places=6)
        for ranks in (2, 3):
            many = self.run_scene(self.scene, f"r{ranks}", "--partitioner", "shuffle",
                                  *sets(balance__trigger="every", balance__interval=20), ranks=ranks)
            self.assertEqual((many / "sections.csv").read_bytes(), text)
        self.run_scene(self.scene, "one", "--restart", checkpoints(one)[0], ranks=2)
        self.assertEqual((one / "sections.csv").read_bytes(), text)
        wrong = lambda lines: self.refused("name,x,y\n" + lines, "lines.csv")
        self.assertIn("section neck has a point at (7, 99) (outside the domain)", wrong("neck,7,99\nneck,7,2\n"))
        self.assertIn("section neck has 1 points", wrong("neck,7,9\n"))
        self.assertIn("it is there twice", wrong("a,7,9\na,7,2\nb,8,9\nb,8,2\na,9,9\na,9,2\n"))
        self.assertIn("hazard.sections has no lines", wrong(""))

    def test_the_volume_over_a_section_is_that_of_the_particles_beyond_it(self):
        self.write(grid(at=lambda x, y: 4.0), "valley.asc")
        self.write("name,x,y\nneck,8,11\nneck,8,1\n", "lines.csv")
        self.write(SCENE.replace("threshold = 0.2", 'threshold = 0.2\nsections = "lines.csv"').replace(
            "thickness = 1.0", "thickness = 1.0\nvelocity = [5.0, 0.0, 0.0]").replace(
            'law = "voellmy", friction = 0.2, xi = 500.0', 'law = "smooth"').replace("-9.81", "0.0"))
        directory = self.run_scene(self.scene, "slides", *sets(time__end=0.7))
        deposit = read_map(directory, "deposit")
        beyond = sum(sum(row[8:]) for row in deposit)
        self.assertGreater(beyond, 1)
        self.assertLess(beyond, 0.9 * total(deposit))
        row = moraine.table(directory, "sections.csv")[-1]
        self.assertAlmostEqual(row["neck_volume_m3"] / beyond, 1, delta=1e-6)
        self.assertAlmostEqual(row["neck_mass_kg"] / (1800 * beyond), 1, delta=1e-6)

    def test_sections_may_be_lines_of_a_geojson(self):
        self.write(json.dumps({"type": "Feature", "properties": {}, "geometry": {
            "type": "LineString", "coordinates": [[7, 10], [7, 2]]}}), "lines.geojson")
        self.write(SCENE.replace("threshold = 0.2", 'threshold = 0.2\nsections = "lines.geojson"'))
        directory = self.run_scene(self.scene, "run", *sets(time__end=0.2))
        self.assertIn("section-1_discharge_m3_s", moraine.table(directory, "sections.csv")[0])

    def test_maps_are_written_with_checkpoints_and_at_the_end(self):
        begin = lambda output, **keys: moraine.Job("run", self.scene, "--output", self.folder / output, "--device", "cpu",
                                                   *sets(time__end=1e6, output__interval=0.01, **keys), ranks=1)
        job = begin("outputs")
        try:
            history = job.wait_for(self.folder, "outputs/history.csv")
            while len(history.read_text().splitlines()) < 5:
                self.assertIsNone(job.started.poll())
            self.assertFalse((self.folder / "outputs/maps").exists())
        finally:
            job.stop()
        job = begin("checkpoints", output__checkpoint_interval=0.05)
        try:
            job.wait_for(self.folder, "checkpoints/maps/outline.*")
        finally:
            job.stop()

    def test_overwrite_removes_the_maps_of_the_run_before(self):
        directory = self.run_scene(self.scene, "run", *sets(time__end=0))
        (directory / "maps" / "notes.txt").write_text("mine")
        for name in ("max_depth.asc", "arrival.tif", "outline.geojson"):
            (directory / "maps" / name).write_text("old")
        (directory / "sections.csv").write_text("old")
        self.run_scene(self.scene, "run", "--overwrite", *sets(time__end=0, hazard__maps='["deposit"]'))
        ends = ("deposit.tif", "outline.gpkg") if GDAL else ("deposit.asc", "outline.geojson")
        self.assertEqual(sorted(path.name for path in (directory / "maps").iterdir()), sorted([*ends, "notes.txt"]))
        self.assertFalse((directory / "sections.csv").exists())

    def test_debris_stays_over_the_ground_and_leaves_by_open_sides(self):
        directory = self.run_scene(self.scene, "out", *sets(time__end=4, domain__max="[12.0, 12.0, 16.0]"))
        self.assertGreater(summary(directory)["lost_particles"], 50)

    def test_check_says_what_the_terrain_is(self):
        ended = call("check", self.scene, "--device", "cpu")
        self.assertEqual(ended.code, 0, ended)
        self.assertRegex(ended.out, r"terrain    13 x 7 heights, 2 m apart, from 1\S* to 1\d\S* m")
        self.assertRegex(ended.out, r"release    scar: \S+ m3, 2 cells thick \(4 and more resolve a flow\)")

    def refused(self, text, name="scene.toml"):
        self.write(text, name)
        return self.assert_one_problem(call("check", self.scene, "--device", "cpu"))

    def changed(self, old, new):
        self.assertIn(old, SCENE)
        return self.refused(SCENE.replace(old, new))

    def test_a_wrong_model_is_refused_with_place_and_remedy(self):
        self.assertIn("no such file", self.changed("valley.asc", "absent.asc"))
        self.assertIn("no such file" if GDAL else "gdal_translate", self.changed("valley.asc", "valley.tif"))
        self.assertIn("terrain.dem is missing", self.changed('dem = "valley.asc"\n', ""))
        self.assertIn("terrain.profile is not used", self.changed('dem = "valley.asc"', 'profile = "valley.csv"'))
        self.assertIn("Did you mean terrain.contact.friction?", self.changed("friction = 0.2", "frction = 0.2"))
        self.assertIn("terrain.contact.xi is missing", self.changed(", xi = 500.0", ""))
        self.write(SCENE)
        self.assertIn("from -1 to 23 along x (the domain from 0 to 24)", self.refused(grid(12), "valley.asc"))
        holes = grid(at=lambda x, y: -9999 if x == 4 and y == 6 else heights(x, y))
        self.assertIn("no height at (4, 6)", self.refused(holes, "valley.asc"))
        self.assertIn("valley.asc:7: the height in row 1, column 2 = \"nan\"",
                      self.refused(grid(at=lambda x, y: math.nan if (x, y) == (2, 12) else 1), "valley.asc"))

    def test_a_wrong_release_is_refused_with_place_and_remedy(self):
        self.assertIn("less than a cell", self.changed("thickness = 1.0", "thickness = 0.3"))
        self.assertIn("release.scar.material", self.changed('material = "debris"', 'material = "mud"'))
        self.assertIn("release.scar without ground",
                      self.refused(SCENE.replace(SCENE[SCENE.index("[terrain]"):SCENE.index("[[material]]")], "")))
        self.write(SCENE)
        self.assertIn("has a corner at (30, 3)", self.refused(AREA.replace("6,3.5", "30,3"), "area.csv"))
        self.assertIn("crosses itself", self.refused("x,y\n2,3\n6,8\n6,3\n2,8\n", "area.csv"))

    def test_a_wrong_map_is_refused_with_place_and_remedy(self):
        self.assertIn("columns would hold single particles", self.changed("cell = 1.0", "cell = 0.2"))
        self.assertIn('hazard.maps has "max_sped"', self.changed("threshold = 0.2", 'maps = ["max_sped"]'))
        terrain = SCENE[SCENE.index("[terrain]"):SCENE.index("[hazard]")]
        self.assertIn("[hazard] without ground", self.refused(SCENE.replace(terrain, "")))


if __name__ == "__main__":
    moraine.main()
