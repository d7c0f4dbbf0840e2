"""moraine study and calibrate as a user has them: exact values, one answer whatever runs at a time, going on, maps, and refusals."""
import csv
import json
import math
import os
import signal
import subprocess
import sys
import time
import unittest

import numpy

import moraine
from moraine.fleet import is_done
from moraine.grids import Grid
from moraine.parameters import Parameter, parse_parameters
from moraine.map_values import reached
from moraine.overlap import Overlap, Seen, read_seen, system_of
from moraine.polygons import cells_inside, read_polygons
from moraine.sampling import design
from moraine.scenario_file import require_runs
from moraine.scenario_maps import map_statistics
from moraine.sensitivity import correlation, influences
from runs_for_tests import INPUTS, ROOT, PackageTest, folder, program
from test_maps import valley, write_asc
from test_way import slope

try:
    import scipy  # noqa: F401
except ImportError:
    scipy = None
try:
    import emcee
except ImportError:
    emcee = None
try:
    import SALib
except ImportError:
    SALib = None

FRICTION = "structure.incline.contact.friction"
BLOCK = {"scene": str(INPUTS / "sliding_block.toml"), "quantities": ["centre_x_m"],
         "set": {"time.end": 0.2, "domain.max": [2.1, 0.2], "output.interval": 0.2}}
OPTIONS = ["--device", "cpu"]


UTM = ('PROJCS["WGS 84 / UTM zone 32N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],'
       'PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",9],PARAMETER["scale_factor",0.9996],'
       'PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1],AUTHORITY["EPSG","32632"]]')


def way(friction, t=0.2):
    """Where the block's centre is after t [s] (inputs/sliding_block.toml)."""
    turn = math.radians(24)
    return 0.15 + 0.1 * t + 0.5 * 9.81 * (math.sin(turn) - friction * math.cos(turn)) * t * t


class Studies(PackageTest):
    def study(self, name, **more):
        return moraine.run_study({**BLOCK, **more}, folder(name), options=OPTIONS, told=lambda line: None)

    def test_a_grid_gives_the_exact_way_of_each_friction(self):
        found = self.study("grid", parameter=[{"key": FRICTION, "range": [0.1, 0.4], "steps": 3}], sampling={"method": "grid"})
        self.assertEqual([m.sets[FRICTION] for m in found.members], [0.1, 0.25, 0.4])
        for friction, value in zip((0.1, 0.25, 0.4), found.column(found.file.quantities[0])):
            self.assertAlmostEqual(value, way(friction), delta=0.01 * (way(friction) - 0.15))
        self.assertEqual([(each.measure, each.value) for each in found.influences], [("rank correlation", -1.0)])
        rows = list(csv.DictReader((found.path / "study.csv").read_text().splitlines()))
        self.assertEqual([row["run"] for row in rows], ["run-1", "run-2", "run-3"])
        self.assertFalse(list(found.path.glob("*/checkpoint*")) + list(found.path.glob("*/particles.vtkhdf")) + list(found.path.glob("*.stderr.txt")))
        again = self.study("grid", parameter=[{"key": FRICTION, "range": [0.1, 0.4], "steps": 3}], sampling={"method": "grid"})
        self.assertEqual(again.values, found.values)
        first = ["runs", "run-1"]
        self.refuses_damage(found.path / "study.json", [first[:1], first, *([*first, name] for name in ("code", "wall_s"))],
                            lambda: self.study("grid", parameter=[{"key": FRICTION, "range": [0.1, 0.4], "steps": 3}], sampling={"method": "grid"}))
        for name in ("../mine", "run-1/..", "run-"):
            self.assertRaises(ValueError, require_runs, {"runs": {name: {"code": 0, "problem": "", "wall_s": 1.0}}})
        other = {"parameter": [{"key": FRICTION, "range": [0.1, 0.5]}], "sampling": {"method": "grid"}}
        self.assertIn("has another study", self.problem(self.study, "grid", **other))

    def test_a_failed_run_is_said_and_counts_nowhere(self):
        found = self.study("study-failed", parameter=[{"key": "domain.max", "values": [[2.1, 0.2], [0.2, 0.2]]}], sampling={"method": "grid"},
                           set={"time.end": 0.2, "output.interval": 0.2})
        from moraine.scenario_text import summary
        self.assertEqual((len(found.finished), len(found.failed)), (1, 1))
        self.assertIn("1 of 2 runs failed and count nowhere: run-2: ", summary(found))

    @unittest.skipIf(scipy is None, "no scipy")
    def test_an_interrupted_study_goes_on_to_the_same_and_jobs_change_nothing(self):
        study = folder("study-torn.toml")
        study.write_text(f'scene = "{INPUTS / "sliding_block.toml"}"\nquantities = ["centre_x_m"]\n[set]\n"time.end" = 0.4\n"domain.max" = [2.1, 0.2]\n'
                         f'[[parameter]]\nkey = "{FRICTION}"\nrange = [0.1, 0.4]\n[sampling]\nmethod = "sobol"\nruns = 4\nseed = 3\n')
        command = [program.PROGRAM, "study", str(study), "--device", "cpu", "--jobs", "2"]
        environment = {**os.environ, "MORAINE_PYTHON": sys.executable, "OMP_NUM_THREADS": "1"}
        job = subprocess.Popen([*command, "--output", str(folder("study-torn"))], env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        while not is_done(folder("study-torn") / "run-1") and job.poll() is None:
            time.sleep(0.02)
        job.send_signal(signal.SIGTERM)
        _, said = job.communicate()
        self.assertEqual(job.returncode, 5, said)
        done = subprocess.run([*command, "--output", str(folder("study-torn"))], env=environment, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        whole = subprocess.run([*command, "--jobs", "1", "--output", str(folder("whole-study"))], env=environment, capture_output=True, text=True)
        self.assertEqual(whole.returncode, 0, whole.stderr)
        values = [[run["values"] for run in json.loads((folder(name) / "study.json").read_text())["runs"].values()] for name in ("study-torn", "whole-study")]
        self.assertEqual(*values)
        page = (folder("study-torn") / "study.html").read_text()
        self.assertIn("4 runs of sliding_block.toml, by sobol; 4 have ended.", page)
        self.assertEqual(page.count('class="mark"'), 4)

    @unittest.skipIf(SALib is None, "no SALib")
    def test_indices_of_a_sum_are_shares_of_its_variance(self):
        parameters = parse_parameters([{"key": "a", "range": [0, 1]}, {"key": "b", "range": [0, 1]}])
        points = design(parameters, "saltelli", 1024, 1)
        inputs = [[point[key] for point in points] for key in "ab"]
        values = numpy.array(inputs[0]) + 2 * numpy.array(inputs[1])
        found = {(each.parameter, each.measure): each.value for each in influences(parameters, inputs, "q", values, "saltelli", inputs)}
        self.assertAlmostEqual(found["a", "first-order"], 0.2, delta=0.02)
        self.assertAlmostEqual(found["b", "total"], 0.8, delta=0.02)
        points = design(parameters, "morris", 30, 1)
        inputs = [[point[key] for point in points] for key in "ab"]
        found = influences(parameters, inputs, "q", numpy.array(inputs[0]) + 2 * numpy.array(inputs[1]), "morris", list(zip(*inputs)))
        numpy.testing.assert_allclose([each.value for each in found], [1, 2], rtol=1e-6)

    def test_designs_keep_to_their_ranges_and_their_seed(self):
        parameters = [Parameter("a", "range", 2.0, 8.0, True), Parameter("b", "normal", 30.0, 2.0), Parameter("c", "values", values=("x", "y"))]
        self.assertEqual(len(design(parameters, "grid", 0, 0)), 3 * 3 * 2)
        if scipy is None:
            self.skipTest("no scipy")
        for method in ("sobol", "latin-hypercube"):
            points = design(parameters, method, 32, 7)
            self.assertEqual(points, design(parameters, method, 32, 7))
            self.assertNotEqual(points, design(parameters, method, 32, 8))
            self.assertTrue(all(2 <= p["a"] <= 8 and 24 <= p["b"] <= 36 for p in points))
            self.assertAlmostEqual(numpy.mean([p["b"] for p in points]), 30, delta=0.3)
            self.assertEqual(sum(p["c"] == "x" for p in points), 16)
        self.assertEqual(correlation(numpy.array([1.0, 2.0, 3.0]), numpy.array([5.0, 5.0, 5.0])), 0.0)

    def test_maps_over_runs_are_envelope_quantile_and_probability(self):
        runs = []
        for k, values in enumerate(([[0, 1, 2]], [[0, 3, 0]], [[0, 2, 0]], [[0, 2, 0]])):
            run = folder(f"many-{k}")
            write_asc(run / "maps/max_depth.asc", values)
            write_asc(run / "maps/arrival.asc", [[-9999, 4 + k, 9 if k == 0 else -9999]])
            (run / "history.csv").write_text("time_s,centre_z_m\n0,1\n")
            runs.append(run)
        written = map_statistics(runs, {"max_depth": [1.5]}, folder("statistics"))
        maps = {f"{m['map']}-{m['kind']}": moraine.grids.read_grid(folder("statistics") / m["file"]).values[0] for m in written}
        nan = numpy.nan
        for name, values in (("max_depth-envelope", [nan, 3, 2]), ("max_depth-mean", [nan, 2, 0.5]), ("max_depth-q50", [nan, 2, nan]),
                             ("max_depth-exceeds-1.5", [nan, 0.75, 0.25]), ("arrival-earliest", [nan, 4, 9]), ("arrival-probability", [nan, 1, 0.25])):
            numpy.testing.assert_allclose(maps[name], values, err_msg=name)

    def test_refusals_say_what_and_why_and_what_would_do(self):
        good = {**BLOCK, "parameter": [{"key": FRICTION, "range": [0.1, 0.4]}], "sampling": {"method": "grid"}}
        for changes in ({"parameter": []}, {"parameter": [{"range": [0, 1]}]}, {"parameter": [{"key": FRICTION}]}, {"parameter": [{"key": FRICTION, "range": [1, 0]}]},
                        {"parameter": [{"key": FRICTION, "range": [0, 1], "log": True}]}, {"parameter": [{"key": FRICTION, "range": [0, 1], "normal": [1, 1]}]},
                        {"parameter": [{"key": FRICTION, "range": [0.1, 0.2]}] * 2}, {"sampling": {"method": "sobl"}}, {"sampling": {"runs": 1}}, {"sampling": {"rnus": 8}},
                        {"quantities": []}, {"quantities": ["frnt"]}, {"quantities": "front"}, {"scene": "none.toml"}, {"scene": 3}, {"exceed": {"max_depth": [1]}},
                        {"exceed": {"max_depth": ["a"]}}, {"typo": 1}, {"parameter": [{"key": "terrain.contact.friction", "range": [0.1, 0.2]}]}):
            self.problem(moraine.run_study, {**good, **changes}, folder("refused"), options=OPTIONS, told=lambda line: None)
            self.assertFalse(folder("refused").exists(), changes)


class Calibrations(PackageTest):
    def file(self, value, error=0.001, **more):
        return {**{key: BLOCK[key] for key in ("scene", "set")}, "parameter": [{"key": FRICTION, "range": [0.05, 0.4]}],
                "target": [{"quantity": "centre_x_m", "value": value, "error": error}], "search": {"first": 6, "runs": 8}, **more}

    @unittest.skipIf(emcee is None or scipy is None, "no scipy and emcee")
    def test_a_friction_is_found_again_with_the_width_that_the_error_leaves(self):
        truth, error = 0.22, 0.002
        found = moraine.calibrate(self.file(way(truth), error), folder("found"), options=OPTIONS, told=lambda line: None)
        low, middle, high = found.interval(0)
        slope_of = 0.5 * 9.81 * math.cos(math.radians(24)) * 0.2**2  # way over friction
        self.assertTrue(low < truth < high, (low, truth, high))
        self.assertAlmostEqual(found.width(0) * 0.35 / math.sqrt(12), error / slope_of, delta=0.15 * error / slope_of)
        from moraine.calibration_text import summary, write_page
        self.assertNotIn("Warning", summary(found))
        self.assertIn("posterior", write_page(found).read_text())
        again = moraine.calibrate(self.file(way(truth), error), folder("found"), options=OPTIONS, told=lambda line: None)
        numpy.testing.assert_array_equal(again.posterior.samples, found.posterior.samples)
        off = moraine.calibrate(self.file(2.0, error), folder("off"), options=OPTIONS, told=lambda line: None)
        self.assertIn("Warning: the best run does not fit", summary(off))
        wide = moraine.calibrate(self.file(way(truth), 1.0), folder("wide"), options=OPTIONS, told=lambda line: None)
        self.assertIn("what was seen does not tell it", summary(wide))

    @unittest.skipIf(emcee is None or scipy is None, "no scipy and emcee")
    def test_outlines_and_maps_of_a_run_are_met_by_that_run(self):
        scene = slope("seen")
        seen = moraine.run(scene, folder("seen-run"), sets={"domain.cell": 2.0, "terrain.contact.friction": 0.25}, progress=False, options=[*OPTIONS, "--no-particles"])
        outline = next((seen.path / "maps").glob("outline.*"))
        deposit = next((seen.path / "maps").glob("deposit.*"))
        given = {"scene": str(scene), "set": {"domain.cell": 2.0}, "parameter": [{"key": "terrain.contact.friction", "range": [0.05, 0.6]}],
                 "target": [{"outline": str(outline), "error": 0.1}, {"map": "deposit", "file": str(deposit), "error": 0.1}], "search": {"first": 5, "runs": 5}}
        found = moraine.calibrate(given, folder("met"), options=OPTIONS, told=lambda line: None)
        self.assertEqual([target.read(seen, 0.8, 2.0) for target in found.targets], [0.0, 0.0])
        self.assertTrue(all(value >= 0 for values in found.values.values() for value in values))

    def test_what_was_seen_counts_beyond_the_maps_and_must_be_in_their_coordinates(self):
        run = valley("seen-beyond", ground=False)  # 3 x 2 cells of 2 m reached, between (8, 10) and (14, 14), in maps to x = 40
        box = lambda west, south, east, north: [numpy.array([(west, south), (east, south), (east, north), (west, north)], dtype=float)]  # noqa: E731
        seen = Overlap(moraine.Run(run), Seen([box(8, 10, 14, 14)], None))
        self.assertEqual((seen.computed, seen.seen, seen.common, seen.share), (24.0, 24.0, 24.0, 1.0))
        beyond = Overlap(moraine.Run(run), Seen([box(8, 10, 56, 14)], None))
        self.assertEqual((beyond.seen, beyond.common, beyond.share), (192.0, 24.0, 0.125))
        both = Overlap(moraine.Run(run), Seen([box(8, 10, 12, 14), box(10, 10, 14, 14)], None))
        self.assertEqual(both.seen, 24.0)  # areas that lie over each other are one
        self.assertIn("lies nowhere in the maps", self.problem(Overlap, moraine.Run(run), Seen([box(7.1, -46.3, 7.2, -46.2)], None)))

    def test_polygons_of_another_system_than_the_maps_are_refused_with_the_command_that_helps(self):
        scene = slope("systems", east=600000.0, north=5200000.0)
        (scene.parent / "dem.prj").write_text(UTM)
        done = moraine.run(scene, folder("systems-run"), sets={"domain.cell": 2.0, "time.end": 0.2}, progress=False, options=[*OPTIONS, "--no-particles"])
        if "tif" not in {path.suffix[1:] for path in (done.path / "maps").iterdir()}:
            self.skipTest("no GDAL")
        self.assertEqual(system_of(done), 32632)
        ring = [[600004, 5200008], [600010, 5200008], [600010, 5200016], [600004, 5200016], [600004, 5200008]]
        shape = {"type": "Polygon", "coordinates": [ring]}
        for name, crs in (("named", {"crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32632"}}}), ("other", {"crs": {"properties": {"name": "EPSG:32633"}}})):
            folder(f"{name}.geojson").write_text(json.dumps({**shape, **crs}))
        self.assertGreater(Overlap(done, read_seen(folder("named.geojson"))).share, 0.2)
        self.assertIn("ogr2ogr -t_srs EPSG:32632", self.problem(Overlap, done, read_seen(folder("other.geojson"))))
        folder("degrees.geojson").write_text(json.dumps({"type": "Polygon", "coordinates": [[[10.3, 46.9], [10.4, 46.9], [10.4, 47.0]]]}))
        self.assertIn("EPSG:4326", self.problem(Overlap, done, read_seen(folder("degrees.geojson"))))
        own = next((done.path / "maps").glob("outline.gpkg"))
        self.assertEqual((read_seen(own).system, Overlap(done, read_seen(own)).share), (32632, 1.0))

    def test_rings_of_all_kinds_of_file_hold_the_same_cells(self):
        ring = [(0, 0), (4, 0), (4, 4), (0, 4), (0, 0)]
        hole = [(1, 1), (3, 1), (3, 3), (1, 3), (1, 1)]
        (folder("a.geojson")).write_text(json.dumps({"type": "FeatureCollection", "features": [
            {"type": "Feature", "geometry": {"type": "MultiPolygon", "coordinates": [[ring, hole]]}}]}))
        grid = Grid(numpy.zeros((4, 5)), (0.5, 0.5), 1.0)
        inside = cells_inside(read_polygons(folder("a.geojson")), grid)
        self.assertEqual(inside.sum(), 12)
        self.assertFalse(inside[1:3, 1:3].any())
        (folder("b.geojson")).write_text('{"type": "Point", "coordinates": [1, 2]}')
        for name in ("b.geojson", "none.geojson"):
            self.problem(read_polygons, folder(name))

    def test_refusals_say_what_and_why_and_what_would_do(self):
        if emcee is None:
            self.assertIn("python3-emcee", self.problem(moraine.calibrate, self.file(0.2), folder("refused-2"), options=OPTIONS))
            return
        for changes in ({"target": []}, {"target": [{"value": 1}]}, {"target": [{"quantity": "centre_x_m", "value": 1}]}, {"target": [{"quantity": "centre_x_m", "error": 1}]},
                        {"target": [{"quantity": "centre_x_m", "value": 1, "error": 0}]}, {"target": [{"quantity": "centre_x_m,front", "value": 1, "error": 1}]},
                        {"target": [{"quantity": "centre", "value": 1, "error": 1}]}, {"target": [{"outline": "none.gpkg", "error": 1}]},
                        {"target": [{"map": "deposit", "error": 1}]}, {"parameter": [{"key": FRICTION, "values": [0.1, 0.2]}]}, {"search": {"first": 2}},
                        {"search": {"runs": 3}}, {"quantities": ["front"]}):
            self.problem(moraine.calibrate, self.file(0.2, **changes), folder("refused-2"), options=OPTIONS, told=lambda line: None)
            self.assertFalse((folder("refused-2") / "run-001").exists(), changes)

class Events(PackageTest):
    """python/examples/event.py over a plane of 1:2."""

    def place(self, name, outline):
        place = slope(name).parent
        for old in ("scene.toml", "area.csv"):
            (place / old).unlink()
        for file, corners, more in (("release", [(4, 8), (10, 8), (10, 16), (4, 16)], {"thickness": 2.0}), ("outline", outline, {})):
            ring = [*corners, corners[0]]
            (place / f"{file}.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [
                {"type": "Feature", "properties": more, "geometry": {"type": "Polygon", "coordinates": [ring]}}]}))
        return place

    def event(self, place, *more):
        return subprocess.run([sys.executable, str(ROOT / "python/examples/event.py"), str(place), "--cell", "0.5", "--end", "0.8", *more], capture_output=True, text=True)

    def test_a_folder_gives_the_overlap_of_an_event_with_its_error_bar(self):
        place = self.place("event", [(4, 8), (20, 8), (20, 16), (4, 16)])
        done = self.event(place)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = list(csv.DictReader((place / "event/overlap.csv").read_text().splitlines()))
        numpy.testing.assert_allclose([float(row["cell_m"]) for row in rows], [1, 2 / 3, 0.5])
        came = reached(moraine.Run(place / "event/cells/cell-0.5"))
        inside = cells_inside(read_polygons(place / "outline.geojson"), came)
        last = {name: float(value) for name, value in rows[-1].items()}
        self.assertEqual((last["seen_m2"], last["computed_m2"], last["common_m2"]), (128.0, came.values.sum(), (inside & came.values).sum()))
        self.assertEqual(last["overlap"], (inside & came.values).sum() / (inside | came.values).sum())
        self.assertTrue(0.3 < last["overlap"] < 1, last)
        self.assertRegex(done.stdout, r"overlap = 0\.\d+ \+- |no error bar \(")

    def test_what_a_folder_lacks_is_said(self):
        place = self.place("event-lacks", [(-118.3, 34.4), (-118.2, 34.4), (-118.2, 34.5)])
        done = self.event(place)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
        self.assertIn("lies nowhere in the maps", done.stderr)
        self.assertFalse((place / "event/cells").exists())
        (place / "outline.geojson").unlink()
        done = self.event(place)
        self.assertEqual((done.returncode, done.stderr.count("has no outline (it needs outline.geojson, .gpkg, .csv). Is it the right folder?\n")), (2, 1), done.stderr)


if __name__ == "__main__":
    unittest.main()
