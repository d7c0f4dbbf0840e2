"""Hazard maps, gauges and sections: they hold what flowed, on any number of ranks and after a restart."""
import json
import math
import sqlite3
import os
import subprocess
import unittest
import xml.etree.ElementTree as tree

import geotiff
import moraine
from moraine import checkpoints, sets, summary, table
from valley import GDAL, SCENE, ZONE, ValleyTest, grid, map_grid, read_map, total


class Hazard(ValleyTest):
    def test_memory_is_for_where_soil_is_and_not_for_the_domain(self):
        self.write(grid(columns=9, rows=9, side=500.0, at=lambda x, y: 4.0), "valley.asc")
        self.write("x,y\n1001,1002\n1011,1002\n1011,1012\n1001,1012\n", "area.csv")
        self.write(SCENE.replace("min = [0.0, 0.0, 0.0]", "min = [0, 0, 0]").replace(
            "max = [24.0, 12.0, 16.0]", "max = [4000, 3500, 16]"))
        directory = self.folder / "large"
        command = moraine.command(["run", self.scene, "--output", directory, "--device", "cpu", "--quiet",
                                   *sets(time__end=0, hazard__maps='["deposit"]')])
        started = subprocess.Popen(command, env=moraine.environment())
        _, status, used = os.wait4(started.pid, 0)
        started.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(started.returncode, 0)
        self.assertLess(used.ru_maxrss, 500e3)  # KiB; 14 million columns of 60 bytes would be 820 MiB alone
        volume = summary(directory)["mass_kg"] / 1800
        self.assertAlmostEqual(total(read_map(directory, "deposit")), volume, delta=1e-6 * volume)

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

    def test_thickness_is_normal_to_the_ground_and_depth_is_vertical(self):
        self.write(grid(at=lambda x, y: 25 - x), "valley.asc")
        self.write("x,y\n2,3\n10,3\n10,9\n2,9\n", "area.csv")
        names = ["max_depth", "deposit", "max_thickness", "deposit_thickness"]
        self.write(SCENE.replace("16.0]", "28.0]").replace("threshold = 0.2", f"threshold = 0.2\nmaps = {names}"))
        directory = self.run_scene(self.scene, "run", *sets(time__end=0))
        for name in names:
            for row in read_map(directory, name)[4:8]:
                for value in row[4:9]:  # a cell within the edges
                    self.assertAlmostEqual(value, 1 if "thickness" in name else math.sqrt(2), delta=1e-5)
        moving = self.run_scene(self.scene, "moving", *sets(time__end=0.5))
        for depth, thickness in ((0, 2), (1, 3)):
            a, b = (total(read_map(moving, names[k])) for k in (depth, thickness))
            self.assertAlmostEqual(b / a, math.sqrt(0.5), delta=1e-5)

    def test_maps_of_other_cells_and_crops_lie_on_one_grid(self):
        """Which begins at the model's first height, whatever the domain; what sticks out of it is no area."""
        places = {}
        for name, low, high, cell in (("whole", "0.0, 0.0", "24.0, 12.0", 0.5), ("part", "0.7, 1.6", "23.2, 11.1", 0.5), ("coarse", "1.0, 1.0", "23.0, 11.0", 1.0)):
            self.write(SCENE.replace("min = [0.0, 0.0,", f"min = [{low},").replace("max = [24.0, 12.0,", f"max = [{high},").replace("cell = 0.5", f"cell = {cell}")
                       .replace("cell = 1.0\nthreshold", "cell = 2.0\nthreshold"))
            directory = self.run_scene(self.scene, name, *sets(time__end=0))
            run = moraine.table(directory, "history.csv")[0]
            grid = map_grid(directory, "deposit")
            places[name] = grid
            self.assertEqual((grid["x"] % 2, grid["y"] % 2, grid["side"]), (0, 0, 2))
            # the outer columns go to the ends of the domain, also where what is left is less than a cell
            area = lambda k, n, start, end: (end[1] if k == n - 1 else start + 2 * (k + 1)) - (end[0] if k == 0 else start + 2 * k)  # noqa: E731
            ends = [tuple(float(text.split(", ")[a]) for text in (low, high)) for a in (0, 1)]
            rows = read_map(directory, "deposit")[::-1]
            volume = sum(depth * area(i, len(rows[0]), grid["x"], ends[0]) * area(j, len(rows), grid["y"], ends[1])
                         for j, row in enumerate(rows) for i, depth in enumerate(row))
            self.assertAlmostEqual(volume * 1800 / run["mass_kg"], 1, delta=1e-5)
        self.assertEqual((places["part"]["x"], places["part"]["y"]), (0, 2))

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
        for word in (b'name="scene"', b'name="state_hash"', b"material.debris.law = drucker-prager", b'name="threshold_m">0.2<', b"scar: 1 m, 2 cells thick"):
            self.assertIn(word, tags[42112])
        self.assertIn(summary(directory)["state_hash"].encode(), tags[42112])
        style = tree.parse(directory / "maps" / "max_depth.qml").getroot()
        self.assertTrue(1 < len(style.findall(".//item")) <= 8)
        self.assertEqual(style.findall(".//item")[-1].get("value"), "inf")
        self.assertEqual(tags[259], (8,))
        self.assertIn(-9999, rows[0])

    def test_equal_runs_leave_equal_files_and_a_model_without_system_is_on_a_plane(self):
        one, two = (self.run_scene(self.scene, name, *sets(time__end=0.3), ranks=ranks) for name, ranks in (("one", None), ("two", 2)))
        names = sorted(path.name for path in (one / "maps").iterdir())
        self.assertIn("deposit.qml", names)
        for name in names:
            self.assertEqual((one / "maps" / name).read_bytes(), (two / "maps" / name).read_bytes(), name)
        if GDAL:
            base = sqlite3.connect(one / "maps" / "outline.gpkg")
            (name, hash_text), = base.execute("select scene, state_hash from outline").fetchall()
            system, = base.execute("select srs_name from gpkg_spatial_ref_sys natural join gpkg_geometry_columns").fetchone()
            base.close()
            self.assertEqual((name, hash_text), ("scene", summary(one)["state_hash"]))
            self.assertIn("Cartesian", system)

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

    RECORDED = SCENE.replace("threshold = 0.2", 'threshold = 0.2\nsections = "lines.csv"\ngauges = "gauges.csv"')

    def write_recorded(self):
        self.write(self.SECTIONS, "lines.csv")
        self.write("name,x,y\nscar,4.5,6.5\n", "gauges.csv")
        self.write(self.RECORDED)

    def test_a_restart_from_the_checkpoint_of_the_end_adds_no_row(self):
        self.write_recorded()
        keys = sets(time__end=0.2, output__checkpoint_interval=0.1)
        one = self.run_scene(self.scene, "one", *keys)
        before = {name: (one / name).read_bytes() for name in ("gauges.csv", "sections.csv", "history.csv")}
        self.run_scene(self.scene, "one", *keys, "--restart", checkpoints(one)[-1])
        for name, text in before.items():
            self.assertEqual((one / name).read_bytes(), text, name)

    def test_a_refused_resume_has_changed_nothing(self):
        self.write_recorded()
        keys = sets(time__end=0.2, output__checkpoint_interval=0.1)
        one = self.run_scene(self.scene, "one", *keys)
        (one / "sections.csv").write_text("step,time_s\n1,2\n")
        before = {path.name: path.read_bytes() for path in one.iterdir() if path.is_file()}
        ended = moraine.call("run", self.scene, "--output", one, "--device", "cpu", "--quiet", *keys, "--restart",
                             checkpoints(one)[0])
        self.assertIn("sections.csv (its columns are others)", self.assert_one_problem(ended))
        self.assertEqual({path.name: path.read_bytes() for path in one.iterdir() if path.is_file()}, before)

    def test_what_maps_will_need_is_tried_before_the_run(self):
        (self.folder / "out").mkdir()
        (self.folder / "out" / "maps").write_text("mine")
        words = ["run", self.scene, "--output", self.folder / "out", "--device", "cpu", "--quiet", *sets(time__end=1e6)]
        self.assertIn("maps (it is not a directory)", self.assert_one_problem(moraine.call(*words)))
        self.assertEqual((self.folder / "out" / "maps").read_text(), "mine")

    @unittest.skipUnless(GDAL, "a build without GDAL")
    def test_maps_fall_back_to_text_where_gdal_cannot_write_them(self):
        directory = self.folder / "out"
        done = subprocess.run(moraine.command(["run", self.scene, "--output", directory, "--device", "cpu",
                                               *sets(time__end=0)]), env={**moraine.environment(), "GDAL_SKIP": "GTiff"},
                              capture_output=True, text=True, stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("Warning: hazard maps will be .asc and .geojson: GDAL cannot write GeoTIFF", done.stderr)
        rows = [line.split() for line in (directory / "maps" / "deposit.asc").read_text().splitlines()[6:]]
        self.assertAlmostEqual(sum(float(word) for row in rows for word in row if word != "-9999"), summary(directory)["mass_kg"] / 1800, delta=1e-3)
        self.assertTrue((directory / "maps" / "outline.geojson").exists())

    def test_a_link_in_place_of_a_partial_file_is_not_written_through(self):
        (self.folder / "out" / "maps").mkdir(parents=True)
        victim = self.write("mine", "victim")
        names = ["history.csv", "summary.json", "maps/deposit.tif", "maps/deposit.asc", "particles.vtkhdf"]
        for name in names:
            (self.folder / "out" / (name + ".partial")).symlink_to(victim)
        self.run_scene(self.scene, "out", *sets(time__end=0, hazard__maps='["deposit"]'))
        self.assertEqual(victim.read_text(), "mine")

    def test_a_run_says_where_its_maps_are(self):
        directory = self.folder / "run"
        ended = moraine.call("run", self.scene, "--output", directory, "--device", "cpu", *sets(time__end=0))
        self.assertEqual(ended.code, 0, ended)
        self.assertIn(f"Results are in {directory}, hazard maps in {directory}/maps\n", ended.err)

    def test_overwrite_removes_the_maps_of_the_run_before(self):
        directory = self.run_scene(self.scene, "run", *sets(time__end=0))
        (directory / "maps" / "notes.txt").write_text("mine")
        for name in ("max_depth.asc", "arrival.tif", "outline.geojson"):
            (directory / "maps" / name).write_text("old")
        (directory / "sections.csv").write_text("old")
        self.run_scene(self.scene, "run", "--overwrite", *sets(time__end=0, hazard__maps='["deposit"]'))
        ends = ("deposit.tif", "outline.gpkg") if GDAL else ("deposit.asc", "outline.geojson")
        self.assertEqual(sorted(path.name for path in (directory / "maps").iterdir()), sorted([*ends, "deposit.qml", "notes.txt"]))
        self.assertFalse((directory / "sections.csv").exists())

    def test_a_wrong_map_is_refused_with_place_and_remedy(self):
        self.assertIn("columns would hold single particles", self.changed("cell = 1.0", "cell = 0.2"))
        self.assertIn('hazard.maps has "max_sped"', self.changed("threshold = 0.2", 'maps = ["max_sped"]'))
        terrain = SCENE[SCENE.index("[terrain]"):SCENE.index("[hazard]")]
        self.assertIn("[hazard] without ground", self.refused(SCENE.replace(terrain, "")))


if __name__ == "__main__":
    moraine.main()
