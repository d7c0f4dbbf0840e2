"""What is wrong with the input is said once, in one line, with exit code 2, and nothing is left behind."""
import os

import moraine
from moraine import INPUTS, SMALL_SCENE, call

SECOND_BODY = """
[[body]]
name = "other"
material = "jelly"
shape = "sphere"
center = [2.0, 1.5]
radius = 0.5
"""

# What is replaced, by what, what the message must name, and the text in whose line the fault is.
FAULTS = {
    "a misspelt key": ("density = 1000.0", "densty = 1000.0", ["densty", "mean material.jelly.density?"], "densty"),
    "a wrong type": ("cell = 0.25", 'cell = "fine"', ["domain.cell is a string", "a number [m]"], "cell ="),
    "a negative density": ("density = 1000.0", "density = -1000.0", ["material.jelly.density", "-1000"], "density"),
    "a Poisson ratio of 0.6": ("poisson = 0.3", "poisson = 0.6", ["material.jelly.poisson", "0.6", "0.5"], "poisson"),
    "a step that is not stable": ("cfl = 0.5", "cfl = 0.9", ["time.cfl", "0.86", "leave it out"], "cfl"),
    "a CFL number out of range": ("cfl = 0.5", "cfl = 3.0", ["time.cfl", "1.5"], "cfl"),
    "a body outside the domain": ("max = [2.0, 1.5]", "max = [5.0, 1.5]", ["body.block", "domain"], "[[body]]"),
    "overlapping bodies": ("[[wall]]", SECOND_BODY + "[[wall]]", ["body.other overlaps body.block"], None),
    "a body without particles": (
        'shape = "box"\nmin = [1.0, 0.5]\nmax = [2.0, 1.5]', 'shape = "sphere"\ncenter = [1.0, 1.0]\nradius = 0.01',
        ["body.block", "no particles"], None),
    "an unknown material": ('material = "jelly"', 'material = "jely"', ["jely", "mean jelly"], '"jely"'),
    "a periodic length of 4.5 blocks": ("max = [4.0, 2.0]", 'max = [4.5, 2.0]\nperiodic = ["x"]', ["periodic"], None),
    "text that is not TOML": ("[domain]", "[domain", ["TOML"], "[domain"),
}
MORE_FAULTS = {
    "a misspelt table": ("[time]", "[tme]", ["tme", "mean time"], "[tme]"),
    "a number for a list": ("min = [0.0, 0.0]", "min = 0.0", ["domain.min"], "min = 0.0"),
    "a list too long": ("gravity = [0.0, -9.81]", "gravity = [0.0, 0.0, -9.81]", ["gravity"], "gravity"),
    "a whole number wanted": ("dimensions = 2", "dimensions = 2.5", ["dimensions"], "dimensions"),
    "a modulus that is not a number": ("young = 1.0e5", "young = nan", ["young"], "young"),
    "an infinite modulus": ("young = 1.0e5", "young = inf", ["young"], "young"),
    "a negative end": ("end = 0.1", "end = -0.1", ["time.end"], "end ="),
    "a body without volume": ("max = [2.0, 1.5]", "max = [1.0, 1.5]", ["body.block"], "max = [1.0"),
    "no body": ("[[body]]", "[[material]]", ["material"], None),
    "an unknown law": ('law = "neo-hookean"', 'law = "neo-hooke"', ["neo-hooke", "neo-hookean"], "law"),
    "an unknown wall": ('kind = "no-slip"', 'kind = "sticky"', ["sticky", "no-slip"], "sticky"),
    "a wall of another dimension": ('"x-min"', '"z-min"', ["z-min"], None),
    "a length of half a cell": ("max = [4.0, 2.0]", "max = [4.1, 2.0]", ["domain"], None),
    "shifting of a solid": (
        "density = 1000.0", "density = 1000.0\nparticle_shifting = 0.1", ["material.jelly.particle_shifting", "fluids"],
        "particle_shifting"),
    "a negative smoothing": (
        "density = 1000.0", "density = 1000.0\npressure_smoothing = -0.1", ["pressure_smoothing", "-0.1"],
        "pressure_smoothing"),
    "a key given twice": ("cfl = 0.5", "cfl = 0.5\ncfl = 0.4", ["cfl"], "cfl = 0.4"),
}

# Options after `run SCENE`, and what the message must name.
WRONG_WORDS = {
    "a key that is not there": (["--set", "nonsense=1"], "nonsense"),
    "a body that is not there": (["--set", "body.blok.velocity=[1,1]"], "blok"),
    "no value": (["--set", "time.end"], "time.end"),
    "a value of another type": (["--set", "time.end=soon"], "soon"),
    "an unknown option": (["--outptu", "x"], "--output"),
    "an unknown partitioner": (["--partitioner", "mortn"], "morton"),
    "an unknown device": (["--device", "gpu"], "cuda"),
    "a device that is not built in": (["--device", "cuda"], "cuda"),
    "two scenes": (["other.toml"], "other.toml"),
}


class BadInput(moraine.ProgramTest):
    def assert_refused(self, *words, says=(), on=(None, 3)):
        """Before anything was written; on one rank and on three unless said otherwise."""
        before = sorted(os.walk(self.folder))
        for ranks in on:
            line = self.assert_one_problem(call(*words, ranks=ranks, folder=self.folder))
            for word in says:
                self.assertIn(word, line)
            self.assertEqual(sorted(os.walk(self.folder)), before, line)

    def test_the_scene_without_faults_runs(self):
        self.run_scene(self.write(SMALL_SCENE), "out", ranks=3)

    def test_faults_of_a_scene_are_named_with_file_and_line(self):
        for name, (good, bad, says, at) in {**FAULTS, **MORE_FAULTS}.items():
            with self.subTest(name):
                self.assertIn(good, SMALL_SCENE)
                text = SMALL_SCENE.replace(good, bad, 1)
                path = self.write(text)
                place = f"{path}:{text[:text.index(at)].count(chr(10)) + 1}: " if at else f"{path}:"
                on = (None, 3) if name in FAULTS else (None,)
                self.assert_refused("run", path, says=[place, *says], on=on)

    def test_what_devices_do_not_have_is_refused(self):
        mud = """[[material]]
name = "mud"
law = "newtonian"
density = 1000.0
young = 1.0e5
poisson = 0.45
viscosity = 1.0
particle_shifting = 0.1
[[body]]"""
        scene = self.write(SMALL_SCENE.replace("[[body]]", mud, 1))
        for shape in ("gimp", "gimp-contiguous", "cubic"):
            self.assert_refused("run", scene, "--device", "cuda", "--set", f"numerics.shape={shape}", "--set",
                                "material.jelly.volumetric=cell", says=["material.jelly.volumetric", "devices do not"],
                                on=(None,))

    def test_devices_have_the_pressure_on_cells_for_all_materials_or_none(self):
        mud = """[[material]]
name = "mud"
law = "newtonian"
density = 1000.0
young = 1.0e5
poisson = 0.49
viscosity = 1.0
volumetric = "grid"
[[body]]"""
        scene = self.write(SMALL_SCENE.replace("[[body]]", mud, 1))
        self.assert_refused("run", scene, "--device", "cuda", says=["material.jelly", "--device cpu"], on=(None,))

    def test_what_cells_do_not_have_is_refused(self):
        scene = self.write(SMALL_SCENE)
        for key, says in (("output.every=2", ["output.every", "all of their particles"]),
                          ('output.fields=["body"]', ["output.fields", "no mean"])):
            self.assert_refused("run", scene, "--set", "output.fields_on=cells", "--set", key, says=says, on=(None,))

    def test_wrong_words_on_the_command_line_are_named(self):
        scene = self.write(SMALL_SCENE)
        for name, (words, says) in WRONG_WORDS.items():
            with self.subTest(name):
                self.assert_refused("run", scene, *words, says=[says], on=(None,))
        for words in (["rum"], ["run"], ["check"], [scene], ["run", self.folder / "no.toml"], ["run", self.folder]):
            with self.subTest(words):
                self.assert_refused(*words, says=[str(words[-1])] if len(words) > 1 else [])

    def test_what_a_terminal_obeys_is_escaped_and_what_is_long_is_cut(self):
        scene = self.write(SMALL_SCENE)
        for word in ("no\x1b[31m.h5", "no\nsuch\n.h5", "\u009b31m.h5", "\x07" * 200 + ".h5", "long" * 1500, "ä" * 3000):
            for words in (("--restart", word), ("--output", f"no-file/{word}/x"), ("--set", word), ("--partitioner", word)):
                (self.folder / "no-file").write_text("")
                with self.subTest(word[:20], option=words[0]):
                    line = self.assert_one_problem(call("run", scene, "--quiet", *words, folder=self.folder))
                    self.assertLess(len(line.encode()), 2100)
                    self.assertTrue(line.isprintable(), line)

    def test_a_scene_that_cannot_fit_or_end_is_refused_at_once(self):
        scene = INPUTS / "slurry_runout_3d.toml"
        for command in ("run", "check"):
            for keys, says in (("domain.cell=0.002", "Use"), ("domain.cell=0.001", "a rank numbers"),
                               ("material.slurry.young=1e300", "steps to time.end")):
                with self.subTest(command=command, keys=keys):
                    self.assert_refused(command, scene, "--set", keys, says=[says], on=(None,))

    def test_zero_particles_are_refused(self):
        text = SMALL_SCENE[:SMALL_SCENE.index("[[body]]")] + SMALL_SCENE[SMALL_SCENE.index("[[wall]]"):]
        self.assert_refused("run", self.write(text), says=["no body"])

    def test_a_directory_that_cannot_be_written_is_refused(self):
        scene = self.write(SMALL_SCENE)
        file = self.write("", "file")
        for output in (file, file / "below", file / "deep" / "below", "/proc/moraine", "/dev/null/x"):
            with self.subTest(output):
                self.assert_refused("run", scene, "--output", output, says=[str(output), "--output"])

    def test_a_directory_with_a_run_is_refused_unless_overwritten(self):
        scene = self.write(SMALL_SCENE)
        directory = self.run_scene(scene, "out")
        before = {path: path.read_bytes() for path in directory.iterdir()}
        self.assert_refused("run", scene, "--output", directory, says=["--overwrite", str(directory)])
        self.assertEqual({path: path.read_bytes() for path in directory.iterdir()}, before)
        (directory / "notes.txt").write_text("mine")
        (directory / "checkpoint-000000007.h5").write_text("of the run before")
        self.run_scene(scene, "out", "--overwrite", ranks=3)
        self.assertEqual(moraine.summary(directory)["ranks"], 3)
        self.assertEqual(moraine.checkpoints(directory), [])
        self.assertTrue((directory / "notes.txt").exists())


if __name__ == "__main__":
    moraine.main()
