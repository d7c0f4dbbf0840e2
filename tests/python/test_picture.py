"""Pictures: their files and sizes, what stands in them, and what cannot be drawn."""
import contextlib
import csv
import io
import os
import pathlib
import shutil
import subprocess
import sys
import time
import unittest
import unittest.mock

import numpy
import moraine
from moraine.outlines import displacement_at, outline, turn_at
from moraine.picture import draw, main
from runs_for_tests import JELLY, PackageTest, folder, jelly, program, slurry, slurry_3d

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

    def test_a_displacement_that_is_no_number_is_passed_over(self):
        table = {"time_s": numpy.array([1.0, 2.0, 3.0]), "displacement_x_m": numpy.array([1.0, numpy.nan, 3.0]),
                 "displacement_y_m": numpy.full(3, numpy.nan)}
        numpy.testing.assert_allclose(displacement_at({"rod": table}, "rod", 2.0, 2), [2.0, 0.0])

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

    def test_what_turns_is_drawn_turned_about_its_centre(self):
        quarter = {"time_s": numpy.array([1.0]), "angle_rad": numpy.array([numpy.pi / 2])}
        box = {"shape": "box", "min": [0, 0], "max": [4, 2]}
        found = outline(box, (0, 1), 2, numpy.array([1.0, 0.0]), turn_at({"box": quarter}, "box", 1.0, 2))
        numpy.testing.assert_allclose([found.min(axis=0), found.max(axis=0)], [[2, -1], [4, 3]], atol=1e-12)
        half = {"time_s": numpy.array([1.0]), **{f"quaternion_{part}": numpy.array([value]) for part, value in zip("wxyz", (0.5 ** 0.5, 0.5 ** 0.5, 0, 0))}}
        prism = {"shape": "polygon", "points": [[0, 0], [3, 0], [0, 3]], "z": [1, 3]}
        found = outline(prism, (0, 1), 3, numpy.zeros(3), turn_at({"prism": half}, "prism", 1.0, 3))
        numpy.testing.assert_allclose([found.min(axis=0), found.max(axis=0)], [[0, 0], [3, 2]], atol=1e-12)
        self.assertIsNone(turn_at({"rod": {"time_s": numpy.array([1.0])}}, "rod", 1.0, 2))

    def test_the_command_writes_pictures_and_an_animation_and_tells_of_each(self):
        output = folder("drawn")
        scene = moraine.write_scene(JELLY, folder("jelly.toml"))
        done = subprocess.run([sys.executable, "-m", "moraine.picture", str(jelly().path), "--times", "0,0.05,0.08", "--output", str(output),
                               "--scene", str(scene)], capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stdout), (0, ""), done.stderr)
        names = ["speed-0.png", "speed-1.png", "speed-2.png", "speed.gif"] + (["speed.mp4"] if shutil.which("ffmpeg") else [])
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

    def program(self, *words, code=0):
        """moraine picture, as a user calls it; its lines on stderr."""
        done = subprocess.run([program.PROGRAM, "picture", *map(str, words)], capture_output=True, text=True,
                              env={**os.environ, "MORAINE_PYTHON": sys.executable, "PYTHONPATH": ""})
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stderr)
        return done.stderr.splitlines()

    def test_the_program_draws_and_says_how_far_it_is(self):
        output = folder("by-program")
        said = self.program(jelly().path, "--time", "0.05", "--output", output)
        self.assertEqual([path.name for path in output.iterdir()], ["speed-0.png"])
        self.assertRegex(said[-1], r"speed-0.png  t = 0.06 s  \(1 of 1\)$|speed-0.png  t = 0.04 s  \(1 of 1\)$")
        said = self.program(jelly().path, "--times", "0,0.1", "--output", output, "--sheet")
        self.assertEqual(len(said), 2)
        with Image.open(output / "speed-sheet.png") as sheet:
            self.assertEqual(sheet.mode, "P")  # of few colours

    @unittest.skipUnless(shutil.which("ffmpeg"), "no ffmpeg")
    def test_with_ffmpeg_there_is_an_mp4(self):
        files = draw(jelly().path, times=[0.0, 0.04], output=folder("moving"))
        self.assertEqual([path.suffix for path in files], [".png", ".png", ".gif", ".mp4"])
        self.assertEqual(files[-1].read_bytes()[4:8], b"ftyp")

    def test_wrong_words_are_one_line_and_exit_code_2(self):
        run, nothing = jelly().path, folder("never")
        for words, why in (([run, "--field", "sped"], "'sped' cannot be drawn .* Did you mean speed?"),
                           ([run, "--quantity", "presure"], "Did you mean pressure?"),
                           ([run, "--times", "soon"], "soon"), ([run, "--tmies", "1"], "--tmies"), ([], "RUN_DIR"),
                           ([run, "--times", "nan"], "time nan s cannot be drawn"),
                           ([run, "--line", "1,1"], "no profile along 1,1"), ([run, "--line", "0,0,1,1"], "in 2-D is x0,x1"),
                           ([folder("nowhere")], "no such directory"), ([folder("")], "no history.csv")):
            with self.subTest(words):
                said = self.program(*words, *(["--output", nothing] if words else []), code=2)
                self.assertEqual(len(said), 1, said)
                self.assertRegex(said[0], f"^moraine: .*{why}.*[?]$")
        self.assertFalse(nothing.exists())

    def test_without_packages_it_says_what_to_install(self):
        python = folder("python")
        python.write_text(f'#!/bin/sh\nexec {sys.executable} -S "$@"\n')
        python.chmod(0o755)
        done = subprocess.run([program.PROGRAM, "picture", "nowhere"], capture_output=True, text=True,
                              env={**os.environ, "MORAINE_PYTHON": str(python), "PYTHONPATH": ""})
        self.assertEqual(done.returncode, 4)
        self.assertRegex(done.stderr, "^moraine: pictures need .*apt-get install python3-matplotlib python3-h5py[?]\n$")

    def test_walls_and_structures_are_those_of_the_run_itself(self):
        from moraine.surroundings import surroundings_of
        found = surroundings_of(jelly())
        self.assertEqual(found["domain"], {"min": [0, 0], "max": [4, 2], "cell": 0.25})
        self.assertEqual([wall["kind"] for wall in found["wall"]], ["none", "open", "no-slip", "none"])
        keep = ("name", "shape", "from", "to", "radius", "min", "max")
        self.assertEqual(found["structure"], [{key: item[key] for key in keep if key in item} for item in JELLY["structure"]])
        panel = self.frames(jelly(), scene=found).figure(1).axes[0]
        self.assertEqual([text.get_text() for text in panel.texts], ["rod", "shelf"])

    def test_what_set_changed_stands_where_it_was_put(self):
        from moraine.surroundings import surroundings_of
        run = moraine.run(JELLY, folder("moved"), sets={"structure.shelf.max": [0.9, 0.3], "time.end": 0.02}, progress=False)
        self.assertEqual(surroundings_of(run)["structure"][1]["max"], [0.9, 0.3])
        for torn in ("{torn", "[]", '{"wall": [{"face": 7}]}', '{"structure": [{"name": "a", "shape": "box"}]}', '{"wall": [{"face": "x-min"}]}'):
            (run.path / "scene.json").write_text(torn)
            self.assertIsNone(surroundings_of(run), torn)

    def test_particles_can_be_coloured_by_rank(self):
        figure = self.frames(slurry(), "rank").figure(1)
        colours = figure.axes[0].collections[0].get_array()
        self.assertEqual(sorted(set(colours.tolist())), [0, 1])
        self.assertEqual([tick.get_text() for tick in figure.axes[1].get_yticklabels()], ["0", "1"])

    def test_a_profile_along_a_line_is_drawn_and_written(self):
        output = folder("line")
        draw(slurry_3d().path, times=[0.0], output=output, line=[0.0, 2.0, 8.0, 2.0], animate=False)
        with open(output / "speed-profile.csv", newline="") as file:
            rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
        block = [row["depth_m"] for row in rows if row["distance_m"] < 4]
        self.assertTrue(all(abs(depth - 5) < 0.3 for depth in block), block)  # the reservoir of the scene is 5 m deep
        self.assertEqual(rows[-1]["depth_m"], 0)
        self.assertLess(rows[-1]["distance_m"], 8)

    def test_what_is_no_number_does_not_spoil_a_picture(self):
        import dataclasses
        frames = self.frames(slurry())
        read = frames.run.particles.read

        def spoilt(k, fields=None):
            particles = read(k, fields)
            position, velocity = particles.position.copy(), particles["velocity"].copy() if fields else None
            position[:10] = numpy.nan
            if fields:
                velocity[20:30] = numpy.inf
            return dataclasses.replace(particles, position=position, fields={"velocity": velocity} if fields else {})
        with unittest.mock.patch.object(frames.run.particles, "read", spoilt):
            figure = self.frames(frames.run).figure(1)
            figure.canvas.draw()
        self.assertEqual(len(figure.axes[0].collections[0].get_offsets()), len(slurry().particles[1]) - 10)
        self.assertTrue(numpy.isfinite(figure.axes[0].collections[0].get_clim()).all())

    def test_a_run_that_goes_on_or_was_killed_is_drawn_as_far_as_it_is(self):
        directory = folder("under-way")
        job = program.Job("run", program.INPUTS / "slurry_runout.toml", "--output", directory, "--quiet",
                          *program.sets(domain__cell=0.25, time__end=1e4, time__stop="end", output__interval=0.02), ranks=1)
        self.addCleanup(job.stop)
        for _ in range(20000):
            with contextlib.suppress(moraine.Error, OSError):
                if len(moraine.Run(directory).particles) > 2:
                    break
            self.assertIsNone(job.started.poll(), "the run ended")
            time.sleep(0.01)
        self.assertIn("speed-0.png", self.program(directory, "--no-animation", "--time", "0.02")[-1])
        job.stop()
        self.assertFalse((directory / "summary.json").exists())
        self.assertGreater(len(self.program(directory, "--sheet")), 1)
