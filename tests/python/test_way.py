"""Quantities of flows over terrain: along their way, wherever it lies; whole maps with error bars; and what a study may remove."""
import json
import math
import subprocess
import sys
import unittest

import numpy

import moraine
from moraine.grids import Grid, read_grid
from moraine.map_errors import map_error, overlap_of
from moraine.quantity import parse_quantities
from moraine.runout import Runout
from moraine.tiff import write_tiff
from moraine.steepest import area_of, steepest_way
from moraine.way import Way, way_of
from runs_for_tests import PackageTest, folder
from test_converge import converge
from test_maps import write_asc

WIDE, DEEP = 40, 24


def slope(name, east=0.0, north=0.0, hazard="", turned=False):
    """A plane of 1:2 that falls towards x (or y), with a release of 6 x 8 m, 2 m thick; its scene."""
    place = folder(name)
    place.mkdir(parents=True, exist_ok=True)
    size = (DEEP, WIDE) if turned else (WIDE, DEEP)
    heights = [[30 - 0.5 * (size[1] - j if turned else i) for i in range(size[0] + 1)] for j in range(size[1] + 1)]
    write_asc(place / "dem.asc", heights, east, north, cell=1, place="center")
    corners = [(4, 8), (10, 8), (10, 16), (4, 16)]
    (place / "area.csv").write_text("x,y\n" + "".join(f"{east + (y if turned else x)},{north + (x if turned else y)}\n" for x, y in corners))
    (place / "scene.toml").write_text(f"""dimensions = 3
gravity = [0.0, 0.0, -9.81]
[domain]
cell = 1.0
min = [{east}, {north}, 0.0]
max = [{east + size[0]}, {north + size[1]}, 40.0]
[time]
end = 0.8
[output]
interval = 0.4
[terrain]
dem = "dem.asc"
contact = {{ law = "coulomb", friction = 0.2 }}
[hazard]
cell = 2.0
threshold = 0.2
{hazard}
[[material]]
name = "debris"
law = "drucker-prager"
density = 1900.0
young = 2.0e6
poisson = 0.3
friction_angle = 32.0
[[release]]
name = "scar"
material = "debris"
area = "area.csv"
thickness = 2.0
""")
    return place / "scene.toml"


class Ways(PackageTest):
    def test_places_are_counted_along_the_line_and_on_behind_its_ends(self):
        way = Way(numpy.array([[0.0, 0.0], [10.0, 0.0], [10.0, 5.0]]), "path")
        numpy.testing.assert_allclose(way.along(numpy.array([[-3.0, 2.0], [4.0, -1.0], [11.0, 2.0], [9.5, 9.0]])), [-3, 4, 12, 19])
        axis = Way(numpy.zeros((0, 2)), "x")
        numpy.testing.assert_array_equal(axis.along(numpy.array([[6e5, 1.0]])), [6e5])

    def test_the_steepest_way_follows_a_channel_that_bends_and_goes_on_over_a_flat(self):
        x, y = numpy.meshgrid(numpy.arange(0, 200.0, 2), numpy.arange(0, 100.0, 2))
        middle = 50 + 12 * numpy.sin(x / 30)
        heights = numpy.where(x < 150, 60 - 0.4 * x, 0.0) + 0.02 * (y - middle)**2
        points = steepest_way(Grid(heights, (0.0, 0.0), 2.0), numpy.array([10.0, 54.0]), 16.0)
        inside = points[(points[:, 0] > 20) & (points[:, 0] < 140)]
        self.assertLess(abs(inside[:, 1] - (50 + 12 * numpy.sin(inside[:, 0] / 30))).max(), 6.0)
        self.assertGreater(points[-1][0], 190.0)
        level = Grid(numpy.full((20, 20), 3.0), (0.0, 0.0), 1.0)
        self.assertIn("level where the flow begins", self.problem(steepest_way, level, numpy.array([9.0, 9.0]), 4.0))

    def test_areas_are_those_of_polygons_whichever_way_round(self):
        for corners in ([(0, 0), (6, 0), (0, 3)], [(0, 3), (6, 0), (0, 0)]):
            area, middle = area_of(numpy.array(corners, dtype=float) + 5.2e6)
            self.assertAlmostEqual(area, 9.0)
            numpy.testing.assert_allclose(middle - 5.2e6, [2, 1], atol=1e-6)

    def test_a_slope_has_one_verdict_wherever_and_whichever_way_it_lies(self):
        words = "front,runout,drop,travel_angle,maps.max_depth"
        found, said = {}, {}
        for name, place in (("home", {}), ("utm", {"east": 600000.0, "north": 5200000.0}), ("turned", {"turned": True})):
            study, said[name] = converge(slope(f"slope-{name}", **place), f"study-{name}", words, coarsest=2.0, ratio="2:3:4")
            found[name] = {e["quantity"]: e for e in study.estimates()}
        for name in ("utm", "turned"):
            for quantity, estimate in found["home"].items():
                other = found[name][quantity]
                self.assertEqual(other["verdict"], estimate["verdict"], (name, quantity))
                self.assertAlmostEqual(other["finest"], estimate["finest"], delta=2e-3 * abs(estimate["finest"]), msg=(name, quantity))
        run = moraine.Run(folder("study-home") / "cell-1")
        level, runout = run.particles[-1], Runout(run, 1.0)
        self.assertEqual(runout.way.kind, "steepest")
        self.assertAlmostEqual(runout.front(level) - runout.front(run.particles[0]), numpy.sort(level.position[:, 0])[int(0.995 * len(level))]
                               - numpy.sort(run.particles[0].position[:, 0])[int(0.995 * len(level))], delta=0.1)
        self.assertAlmostEqual(runout.drop(level) / runout.runout(level), math.tan(math.radians(runout.travel_angle(level))))
        self.assertTrue(20 < runout.travel_angle(level) < 35)  # on a slope of 26.6 degrees
        self.assertRegex(said["utm"], r"front = \d+\.\d+ \+- .* % of the way of |front = \d+\.\d+: ")
        self.assertNotRegex(said["utm"], "60000")
        self.assertIn("maps.max_depth: to the level before", said["home"])
        self.assertEqual(len(list((folder("study-home") / "maps").glob("max_depth-*"))), 1)
        kept = json.loads((folder("study-home") / "converge.json").read_text())
        self.assertTrue(0 < kept["variants"][0]["maps"][0]["overlap"] <= 1)

    def test_the_path_of_the_scene_is_the_way(self):
        scene = slope("bent", hazard='path = "way.csv"\ngauges = "places.csv"\nsections = "lines.csv"')
        (scene.parent / "way.csv").write_text("name,x,y\nway,2,12\nway,12,12\nway,12,20\n")
        (scene.parent / "places.csv").write_text("name,x,y\nroad,13,12\n")
        (scene.parent / "lines.csv").write_text("name,x,y\nneck,12,20\nneck,12,4\n")
        run = moraine.run(scene, folder("bent-run"), sets={"time.end": 0.4, "output.fields": ["velocity", "mass"]}, progress=False,
                          options=["--device", "cpu"])
        way = way_of(run)
        self.assertEqual((way.kind, way.points.tolist()), ("path", [[2, 12], [12, 12], [12, 20]]))
        kept = json.loads((run.path / "scene.json").read_text())["hazard"]
        self.assertEqual((kept["gauges"], kept["sections"][0]["points"]), ([{"name": "road", "place": [13, 12]}], [[12, 20], [12, 4]]))
        for text, column in (("gauges.road.depth@max", run.gauges["road_depth_m"].max()), ("sections.neck.volume", run.sections["neck_volume_m3"][-1]),
                             ("maps.max_speed.max", numpy.nanmax(run.maps["max_speed"].values))):
            quantity, = parse_quantities(text)
            quantity.check(run, {"time": {"end": 0.4}})
            self.assertAlmostEqual(quantity.read(run, 0.4, 1.0), float(column), delta=1e-5 * abs(column))
        refused = lambda text: self.problem(parse_quantities(text)[0].check, run, {"time": {"end": 0.4}})  # noqa: E731
        self.assertIn("the gauges are road", refused("gauges.rod.depth"))
        self.assertIn("Did you mean depth_m?", refused("gauges.road.dept"))
        self.assertIn("it is two things", refused("max_depth"))
        self.assertIn("Did you mean maps.max_speed?", refused("maps.max_sped"))
        self.assertIn("maps are of the whole run", refused("maps.area@max"))
        one = moraine.run(scene, folder("bent-one"), sets={"time.end": 0.1}, progress=False, options=["--device", "cpu", "--no-particles"])
        self.assertEqual(len(one.summary["warnings"]), 1)
        self.assertIn("release.scar is 2 cells thick", one.summary["warnings"][0]["message"])


class MapErrors(PackageTest):
    def runs(self, name, maps):
        """Runs of which only maps are left: of each `maps` the depths, with their south-western corner."""
        made = []
        for k, (values, west) in enumerate(maps):
            run = folder(f"{name}-{k}")
            values = numpy.asarray(values, dtype=float)
            write_asc(run / "maps/max_depth.asc", values, west)
            write_asc(run / "maps/arrival.asc", numpy.where(values > 0, 1.0, -9999.0), west)
            (run / "history.csv").write_text("time_s,centre_z_m\n0,1\n")
            made.append(moraine.Run(run))
        return made

    def test_a_map_of_second_order_gets_its_error_in_every_cell(self):
        exact = numpy.array([[0.0, 2.0, 3.0], [0.0, 1.0, 4.0]])
        slip = numpy.array([[0.0, 0.0, 0.2], [0.0, 0.3, 0.1]])  # in one cell the levels cross
        error, field = map_error(self.runs("second", [(exact + h**2 * slip, 0) for h in (4, 2, 1)]), [4, 2, 1], "max_depth")
        self.assertAlmostEqual(error.order, 2.0, places=6)
        wide = numpy.sqrt((slip**2).sum() / 4)  # of the 2 x 2 cells around
        numpy.testing.assert_allclose(field.values[::-1][:, 1:], 1.6 * numpy.maximum(slip, wide)[:, 1:], rtol=1e-6)
        self.assertTrue(numpy.isnan(field.values[:, 0]).all())
        self.assertEqual(error.overlap, 1.0)
        self.assertAlmostEqual(error.largest_error, 0.48)

    def test_maps_that_begin_elsewhere_are_laid_over_each_other_and_other_cells_are_refused(self):
        one, two = self.runs("shifted", [([[1.0, 2.0]], 0), ([[0.0, 1.0, 2.0]], -2)])
        error, field = map_error([one, two], [2, 1], "max_depth")
        self.assertEqual((error.mean, error.overlap, error.order), (0.0, 1.0, None))
        off = self.runs("off", [([[1.0, 2.0]], 0), ([[1.0, 2.0]], 0.7)])
        self.assertIn("do not lie on one grid", self.problem(map_error, off, [2, 1], "max_depth"))
        self.assertEqual(overlap_of(numpy.zeros(3, bool), numpy.zeros(3, bool)), 1.0)

    def test_a_tiff_reads_as_it_was_written(self):
        try:
            import PIL  # noqa: F401
        except ImportError:
            self.skipTest("no Pillow")
        grid = Grid(numpy.array([[1.0, numpy.nan, 3.5], [4.0, 5.0, 6.0]]), (600011.0, 5200012.0), 2.0)
        path = folder("written.tif")
        write_tiff(path, grid, "max_depth-error", "m", tags={"what": "a < b"})
        again = read_grid(path)
        numpy.testing.assert_array_equal(again.values, grid.values)
        self.assertEqual((again.first, again.cell), (grid.first, grid.cell))
        first = path.read_bytes()
        write_tiff(path, grid, "max_depth-error", "m", tags={"what": "a < b"})
        self.assertEqual(path.read_bytes(), first)


if __name__ == "__main__":
    unittest.main()
