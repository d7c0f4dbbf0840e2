"""Pictures: their files and sizes, what stands in them, and what cannot be drawn."""
import contextlib
import io
import pathlib
import shutil
import subprocess
import sys
import unittest

import numpy
import moraine
from moraine.outlines import displacement_at, outline
from moraine.picture import draw, main
from runs_for_tests import JELLY, PackageTest, folder, jelly, slurry, slurry_3d

try:
    import matplotlib.image
    from PIL import Image
except ImportError:
    matplotlib = None


@unittest.skipIf(matplotlib is None, "no matplotlib")
class Pictures(PackageTest):
    def frames(self, run, field="speed", scene=None):
        from moraine.frames import Frames
        from moraine.surroundings import Surroundings
        return Frames(run, range(len(run.particles)), field, Surroundings(run, scene), "title")

    def test_a_picture_has_the_particles_in_true_proportion_with_units_and_time(self):
        run = slurry()
        figure = self.frames(run, "pressure").figure(2)
        figure.canvas.draw()
        top, below, bar = figure.axes[0], figure.axes[-1], figure.axes[1]
        self.assertEqual(top.get_title(loc="left"), f"t = {run.particles.times[2]:.2f} s")
        self.assertEqual([top.get_ylabel(), below.get_xlabel(), below.get_ylabel(), bar.get_ylabel()],
                         ["y [m]", "x [m]", "depth [m]", "pressure [kPa]"])
        box, x, y = top.get_window_extent(), top.get_xlim(), top.get_ylim()
        self.assertAlmostEqual(box.width / (x[1] - x[0]), box.height / (y[1] - y[0]), places=6)
        self.assertEqual(top.get_xlim(), below.get_xlim())
        marks = top.collections[0]
        particles = run.particles[2]
        numpy.testing.assert_allclose(marks.get_offsets(), particles.position)
        numpy.testing.assert_allclose(marks.get_array(), particles["pressure"] / 1e3)
        for text in (top.title, *top.get_xticklabels(), *bar.get_yticklabels(), below.xaxis.label):
            self.assertGreaterEqual(text.get_fontsize() * 80 / 72, 11)  # pixels, in the animation too

    def test_a_flow_at_rest_has_a_scale_from_zero(self):
        from moraine.frames import Frames
        from moraine.surroundings import Surroundings
        figure = Frames(slurry(), [0], "speed", Surroundings(slurry(), None)).figure(0)
        self.assertEqual(figure.axes[0].collections[0].get_clim(), (0, 1))

    def test_walls_and_structures_stand_where_the_scene_and_the_run_say(self):
        run = jelly()
        rod = JELLY["structure"][0]
        for time in (0.0, 0.1):
            moved = displacement_at(run.structures, "rod", time, 2)
            numpy.testing.assert_allclose(moved, [0.5 * time, -3.0 * time], atol=1e-3)
            shape = outline(rod, (0, 1), 2, moved)
            numpy.testing.assert_allclose(shape.min(axis=0), numpy.array([0.22, 1.52]) + moved, atol=1e-9)
            numpy.testing.assert_allclose(shape.max(axis=0), numpy.array([0.78, 1.78]) + moved, atol=1e-3)
        panel = self.frames(run, scene=JELLY).figure(1).axes[0]
        self.assertEqual([text.get_text() for text in panel.texts], ["rod", "shelf"])
        self.assertEqual(len(panel.lines), 1)  # the base; x-max is open
        self.assertEqual(len(self.frames(run).figure(1).axes[0].texts), 0)

    def test_outlines_of_all_shapes_are_as_large_as_the_shapes(self):
        still = numpy.zeros(3)
        ball = outline({"shape": "sphere", "center": [1, 2, 3], "radius": 0.5}, (0, 2), 3, still)
        numpy.testing.assert_allclose([ball.min(axis=0), ball.max(axis=0)], [[0.5, 2.5], [1.5, 3.5]])
        pipe = {"shape": "cylinder", "from": [0, 0, 1], "to": [0, 2, 1], "radius": 0.25}
        for axes, low, high in (((0, 1), (-0.25, 0), (0.25, 2)), ((0, 2), (-0.25, 0.75), (0.25, 1.25))):
            found = outline(pipe, axes, 3, still)
            numpy.testing.assert_allclose([found.min(axis=0), found.max(axis=0)], [low, high], atol=1e-12)
        prism = {"shape": "polygon", "points": [[0, 0], [1, 0], [0.5, 2]], "z": [1, 3]}
        self.assertEqual(outline(prism, (0, 2), 3, still).tolist(), [[0, 1], [1, 1], [1, 3], [0, 3]])
        self.assertIsNone(outline({"shape": "plane"}, (0, 1), 3, still))

    def test_the_command_writes_pictures_and_an_animation_and_tells_of_each(self):
        output = folder("drawn")
        scene = moraine.write_scene(JELLY, folder("jelly.toml"))
        done = subprocess.run([sys.executable, "-m", "moraine.picture", str(jelly().path), "--times", "0,0.05,0.08", "--output", str(output),
                               "--scene", str(scene)], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (0, ""), done.stderr)
        names = ["speed-0.png", "speed-1.png", "speed-2.png", "speed.gif"]
        self.assertEqual(sorted(path.name for path in output.iterdir()), names)
        for name in names:
            self.assertIn(name, done.stderr)
        picture = matplotlib.image.imread(output / "speed-1.png")
        self.assertTrue(400 < picture.shape[1] < 1100 and 200 < picture.shape[0] < 1300, picture.shape)
        with Image.open(output / "speed.gif") as moving:
            self.assertEqual((moving.format, moving.n_frames), ("GIF", 5))

    def test_a_3d_run_is_seen_from_above_and_from_the_side(self):
        files = draw(slurry_3d().path, "depth", [0.3], output=folder("drawn-3d"))
        self.assertEqual([path.name for path in files], ["depth-0.png"])
        figure = self.frames(slurry_3d(), "depth").figure(0)
        self.assertEqual([box.get_ylabel() for box in figure.axes], ["y [m]", "depth of the flow [m]", "z [m]", "depth [m]"])
        height = figure.axes[0].collections[0].get_offsets()
        self.assertEqual(height.shape, (len(slurry_3d().particles[0]), 2))

    def test_what_cannot_be_drawn_is_said_before_anything_is_written(self):
        output = folder("nothing")
        self.assertIn("'colour' cannot be drawn", self.problem(draw, slurry().path, "colour", output=output))
        self.assertIn("no field 'pressure'", self.problem(draw, jelly().path, "pressure", output=output))
        self.assertIn("time 9 s cannot be drawn", self.problem(draw, jelly().path, times=[9.0], output=output))
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            self.assertEqual(main([str(folder("nowhere"))]), 2)
        self.assertRegex(said.getvalue(), "^moraine: .*no such directory")
        self.assertFalse(pathlib.Path(output).exists())

    def test_a_run_without_a_summary_can_be_drawn(self):
        copy = folder("unended")
        shutil.copytree(jelly().path, copy)
        (copy / "summary.json").unlink()
        self.assertEqual(len(draw(copy, times=[0.0], animate=False)), 1)
