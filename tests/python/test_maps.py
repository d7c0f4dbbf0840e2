"""Maps of a run as pictures, and the grids that they are read from."""
import json
import subprocess
import sys
import unittest

import numpy
import moraine
from moraine.grids import read_grid
from moraine.maps import ground_of, map_files, reached_by
from moraine.picture import draw
from runs_for_tests import PackageTest, folder

try:
    import matplotlib.image
    from PIL import Image, TiffImagePlugin
except ImportError:
    matplotlib = None

HEAD = "ncols {}\nnrows {}\nxll{} {}\nyll{} {}\ncellsize {}\nNODATA_value -9999\n"


def write_asc(path, values, west=0, south=0, cell=2, place="corner"):
    """Rows of values from the north on."""
    rows = [" ".join(f"{value:g}" for value in row) for row in values]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(HEAD.format(len(values[0]), len(values), place, west, place, south, cell) + "\n".join(rows) + "\n")


def valley(name, ground=True):
    """A run of which only the maps are left: 20 x 10 cells, of which 3 x 2 were reached, on a slope."""
    run = folder(name)
    depth, arrival = numpy.zeros((10, 20)), numpy.full((10, 20), -9999.0)
    depth[3:5, 4:7], arrival[3:5, 4:7] = 1.5, 7
    depth[0, 0] = 0.01  # a drop: no arrival
    write_asc(run / "maps/max_depth.asc", depth)
    write_asc(run / "maps/arrival.asc", arrival)
    (run / "history.csv").write_text("time_s,centre_z_m\n0,1\n")
    if ground:
        write_asc(run / "slope.asc", [[50 - x for x in range(21)] for _ in range(11)], place="center")
    scene = {"title": "a slope", "structure": [{"name": "terrain", "shape": "ground", "file": "slope.asc"}]}
    (run / "scene.json").write_text(json.dumps(scene))
    return run


class Grids(PackageTest):
    def test_rows_begin_at_the_north_and_corners_are_half_a_cell_from_centres(self):
        path = folder("small.asc")
        write_asc(path, [[1, 2, 3], [4, -9999, 6]], west=10, south=20)
        grid = read_grid(path)
        numpy.testing.assert_array_equal(grid.values, [[4, numpy.nan, 6], [1, 2, 3]])
        self.assertEqual((grid.first, grid.last, grid.extent), ((11, 21), (15, 23), (10, 16, 20, 24)))
        part = grid.within(14.5, 20, 20, 24)
        self.assertEqual((part.values[1].tolist(), part.first), ([2, 3], (13, 21)))

    @unittest.skipIf(matplotlib is None, "no Pillow")
    def test_a_tiff_reads_like_the_ascii_grid_of_its_numbers(self):
        values = numpy.array([[1, 2, 3], [4, -9999, 6]], dtype=numpy.float32)
        tags = TiffImagePlugin.ImageFileDirectory_v2()
        for tag, kind, value in ((33550, 12, (2.0, 2.0, 0.0)), (33922, 12, (0.0, 0.0, 0.0, 10.0, 24.0, 0.0)), (42113, 2, "-9999")):
            tags.tagtype[tag] = kind
            tags[tag] = value
        path, text = folder("small.tif"), folder("same.asc")
        Image.fromarray(values).save(path, tiffinfo=tags)
        write_asc(text, values.tolist(), west=10, south=20)
        one, other = read_grid(path), read_grid(text)
        numpy.testing.assert_array_equal(one.values, other.values)
        self.assertEqual((one.first, one.cell), (other.first, other.cell))

    def test_what_is_no_grid_is_said(self):
        for text in ("", "ncols 2\nnrows 2\n1 2 3 4\n", HEAD.format(2, 2, "corner", 0, "corner", 0, 1) + "1 2 3\n",
                     HEAD.format(2, 1, "corner", 0, "corner", 0, 1) + "1 deep\n", HEAD.format(1, 1, "corner", 0, "corner", 0, 0) + "1\n"):
            path = folder("damaged.asc")
            path.write_text(text)
            self.assertIn("is no grid", self.problem(read_grid, path))
        path = folder("damaged.tif")
        path.write_bytes(b"II*\0")
        if matplotlib:
            self.assertIn("is no grid", self.problem(read_grid, path))
        self.assertIn("no such file", self.problem(read_grid, folder("missing.asc")))


class Maps(PackageTest):
    def test_the_flow_reached_where_it_arrived(self):
        run = valley("arrived")
        files = map_files(run)
        self.assertEqual(list(files), ["max_depth", "arrival"])
        reached = reached_by(files, {"max_depth": read_grid(files["max_depth"])}, "max_depth")
        self.assertEqual(reached.sum(), 6)
        self.assertTrue(reached[5:7, 4:7].all())
        del files["arrival"]
        self.assertEqual(reached_by(files, {"max_depth": read_grid(files["max_depth"])}, "max_depth").sum(), 7)

    def test_a_run_has_its_maps_and_gauges(self):
        path = valley("with-maps")
        (path / "gauges.csv").write_text("step,time_s,bridge_depth_m\n0,0,0\n9,1.5,0.25\n")
        run = moraine.Run(path)
        self.assertEqual(list(run.maps), ["max_depth", "arrival"])
        self.assertEqual((run.maps["max_depth"].values.max(), run.maps["max_depth"].cell), (1.5, 2))
        self.assertEqual(run.gauges["bridge_depth_m"].tolist(), [0, 0.25])
        self.assertIn("sections.csv", self.problem(lambda: run.sections))
        bare = folder("without-maps")
        bare.mkdir()
        (bare / "history.csv").write_text("time_s\n0\n")
        self.assertEqual(moraine.Run(bare).maps, {})

    def test_the_ground_is_found_beside_the_run_and_is_not_needed(self):
        self.assertEqual(ground_of(valley("with-ground")).extent, (-1, 41, -1, 21))
        self.assertIsNone(ground_of(valley("without-ground", ground=False)))

    @unittest.skipIf(matplotlib is None, "no matplotlib")
    def test_a_figure_has_outline_heights_scale_bar_and_units(self):
        from moraine.map_figure import draw_map
        run = valley("figure")
        grid = read_grid(run / "maps/max_depth.asc")
        figure = draw_map("largest depth [m]", "Blues", grid, grid.values > 1, ground_of(run), "a slope")
        figure.canvas.draw()
        box, bar = figure.axes
        outline = next(lines for lines in box.collections if len(lines.get_paths()) == 10)  # around 3 x 2 cells
        places = numpy.concatenate([path.vertices for path in outline.get_paths()])
        self.assertEqual([*places.min(axis=0), *places.max(axis=0)], [8, 10, 14, 14])
        self.assertEqual((box.get_xlabel(), box.get_ylabel(), bar.get_ylabel()), ("x [m]", "y [m]", "largest depth [m]"))
        self.assertIn("10 m", [text.get_text() for text in box.texts])
        self.assertEqual([text.get_text() for text in figure.legends[0].get_texts()], ["reached by the flow", "height of the ground, every 2 m"])
        window = box.get_window_extent()
        self.assertAlmostEqual(window.width / 40, window.height / 20, places=6)

    @unittest.skipIf(matplotlib is None, "no matplotlib")
    def test_the_command_draws_all_maps_or_one_and_says_what_is_missing(self):
        run = valley("command")
        done = subprocess.run([sys.executable, "-m", "moraine.picture", str(run)], capture_output=True, text=True)  # it has no particles
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(sorted(path.name for path in (run / "pictures").iterdir()), ["map-arrival.png", "map-max_depth.png"])
        picture = matplotlib.image.imread(run / "pictures/map-max_depth.png")
        self.assertTrue(500 < picture.shape[1] < 1200 and 300 < picture.shape[0] < 900, picture.shape)
        self.assertEqual([path.name for path in draw(run, "arrival", output=folder("one"))], ["map-arrival.png"])
        self.assertIn("no map deposit (it has max_depth, arrival)", self.problem(draw, run, "deposit"))
        lines = []
        draw(valley("no-ground", ground=False), "max_depth", told=lines.append)
        self.assertIn("--terrain", lines[0])
        self.assertIn("no such file", self.problem(draw, run, "arrival", terrain="nowhere.asc"))
