"""`moraine check`, --help and --version."""
import re
import time

import moraine
from moraine import INPUTS, call, sets, summary, table


def on_host(scene):
    """Devices have no terrain."""
    return ["--device", "cpu"] if "[terrain]" in scene.read_text() else []


class Check(moraine.ProgramTest):
    def said(self, words, *more):
        """What check says of a number."""
        return float(re.search(rf"^{words} +([-+.e\d]+)", self.report(*more), re.M)[1])

    def report(self, scene, *words):
        ended = call("check", scene, *words, *on_host(scene))
        self.assertEqual((ended.code, ended.err), (0, ""), ended)
        return ended.out

    def test_every_scene_is_checked_in_under_a_second_and_warned_of_nothing(self):
        scenes = sorted(INPUTS.glob("*.toml"))
        self.assertGreaterEqual(len(scenes), 6)
        for scene in scenes:
            with self.subTest(scene.name):
                limit, tries = 60 if moraine.SLOW else 1, 0
                seconds = float("inf")
                while seconds >= limit and tries < 3:  # the least: other programs may be busy
                    start = time.monotonic()
                    text = self.report(scene)
                    seconds, tries = min(seconds, time.monotonic() - start), tries + 1
                self.assertLess(seconds, limit)
                self.assertNotIn("\nwarning", text)
                for word in ("particles", "blocks", "dt", "steps", "memory"):
                    self.assertRegex(text, rf"(?m)^{word} +[\d.]+")

    def test_its_particles_are_those_of_the_run(self):
        for scene in sorted(INPUTS.glob("*.toml")):
            keys = sets(time__end=0)
            if "3d" in scene.name:
                keys += sets(domain__cell=0.2)
            with self.subTest(scene.name):
                directory = self.run_scene(scene, scene.stem, *keys, *on_host(scene), ranks=2)
                self.assertEqual(self.said("particles", scene, *keys), summary(directory)["particles"])

    def test_its_steps_are_those_of_the_run_within_30_percent(self):
        for name, end in (("slurry_runout", 0.02 if moraine.SLOW else 0.1), ("elastic_bar", 5), ("reference", 0.02),
                          ("first_scene", 0.2), ("granular_column", 0.01)):
            with self.subTest(name):
                keys = sets(time__end=end)
                scene = INPUTS / f"{name}.toml"
                steps = summary(self.run_scene(scene, name, *keys))["steps"]
                self.assertAlmostEqual(self.said("steps", scene, *keys), steps, delta=0.3 * steps)

    def test_its_bytes_of_outputs_are_those_of_the_file(self):
        scene = INPUTS / "slurry_runout.toml"
        for more in ({}, {"output__precision": "single", "output__labels": "[]", "output__fields": '["velocity"]'}):
            keys = sets(time__end=0.1, output__interval=0.025, **more)
            directory = self.run_scene(scene, f"out-{len(more)}", *keys)
            row, times = (int(word) for word in re.search(
                r"(?m)^output +(\d+) bytes a particle: [\d.]+ MB at each of (\d+) times, ", self.report(scene, *keys)).groups())
            self.assertEqual(times, len(table(directory, "history.csv")))
            size = (directory / "particles.vtkhdf").stat().st_size
            self.assertAlmostEqual(size, 20000 * (row * times + 8), delta=0.03 * size)  # metadata
        self.assertEqual(row, 24)

    def test_its_bytes_of_cells_are_about_those_of_the_file(self):
        scene = INPUTS / "slurry_runout.toml"
        keys = sets(time__end=0.1, output__interval=0.025, output__fields_on="cells", domain__cell=0.05)
        directory = self.run_scene(scene, "cells", *keys)
        row, at_each, times = (float(word) for word in re.search(
            r"(?m)^output +(\d+) bytes a cell: about ([\d.]+) MB at each of (\d+) times, ", self.report(scene, *keys)).groups())
        self.assertAlmostEqual(at_each, 20000 * row / 1e6, delta=0.051)
        size = (directory / "cells.vtkhdf").stat().st_size
        self.assertAlmostEqual(size, 20000 * (row * times + 8), delta=0.1 * size)  # cells at walls are halves, and it flows

    UNITS = {"s": 1, "min": 60, "h": 3600, "days": 86400}

    def seconds(self, *words):
        """What check says of the time of the run, and how it knows."""
        value, unit, how = re.search(r"(?m)^time +about ([-.e\d]+) (s|min|h|days) (.+)$", self.report(*words)).groups()
        return float(value) * self.UNITS[unit], how

    def test_its_time_is_that_of_a_table_for_one_core_or_several(self):
        scene = INPUTS / "strip_footing.toml"
        alone, how = self.seconds(scene)
        self.assertIn("on one core of an Intel Xeon", how)
        step = 0.37 * 130e-9 * self.said("particles", scene) + 0.2 * 8e-6 * self.said("blocks", scene)
        self.assertAlmostEqual(alone, 1.28 * step * self.said("steps", scene), delta=0.05 * alone)
        valley = INPUTS / "valley.toml"
        on_ground = self.seconds(valley)[0]
        step = 130e-9 * self.said("particles", valley) + 8e-6 * self.said("blocks", valley)
        self.assertAlmostEqual(on_ground, 1.4 * 1.28 * step * self.said("steps", valley), delta=0.1 * on_ground)
        quarter, how = self.seconds(scene, "--ranks", "4")
        self.assertIn("on 4 cores evenly loaded", how)
        self.assertAlmostEqual(quarter, alone / 4, delta=0.1 * quarter)
        device, how = self.seconds(INPUTS / "slurry_runout_3d.toml", "--device", "cuda")
        self.assertIn("on one NVIDIA H200", how)
        self.assertLess(device, 60)

    def test_a_second_of_steps_gives_the_time_here_on_any_ranks_and_writes_nothing(self):
        scene = INPUTS / "pipe_penetration.toml"
        for ranks in (None, 1, 3):
            with self.subTest(ranks=ranks):
                ended = call("check", scene, "--time", "--device", "cpu", ranks=ranks, folder=self.folder)
                self.assertEqual((ended.code, ended.err), (0, ""), ended)
                value, unit, steps, each, on = re.search(
                    r"(?m)^time +about (\S+) (\w+) by (\d+) steps of (\S+) ms \((\d+) ranks? of 1 thread on the host\), without outputs$",
                    ended.out).groups()
                self.assertEqual(int(on), ranks or 1)
                self.assertGreater(int(steps) * float(each), 990)
                expected = float(re.search(r"(?m)^steps +(\d+)", ended.out)[1]) * float(each) / 1e3
                self.assertAlmostEqual(float(value) * self.UNITS[unit], expected, delta=0.1 * expected + 0.5 * self.UNITS[unit])
                self.assertIn(f"of {on} rank", re.search(r"(?m)^memory .*", ended.out)[0].replace("each of", "of"))
                self.assertEqual(list(self.folder.iterdir()), [])

    def test_an_output_gives_the_share_of_time_of_all_and_is_removed_again(self):
        scene = INPUTS / "slurry_runout.toml"
        for ranks, keys in ((None, {}), (3, {"output__fields_on": "cells"}), (2, {"output__asynchronous": "on"})):
            with self.subTest(ranks=ranks, keys=keys):
                words = ("check", scene, "--time", "--device", "cpu", *sets(**keys))
                ended = call(*words, ranks=ranks, folder=self.folder)
                self.assertEqual((ended.code, ended.err), (0, ""), ended)
                steps, step_ms = re.search(r"(?m)^steps +(\d+)", ended.out)[1], re.search(r" steps of (\S+) ms ", ended.out)[1]
                share, count, each, size = map(float, re.search(
                    r"(?m)^ +outputs (\S+) % more: (\d+) of (\S+) s each \((\S+) MB at \S+ MB/s into this folder\)$", ended.out).groups())
                at_each, times = re.search(r"(?m)^output .* ([\d.]+) MB at each of (\d+) times", ended.out).groups()
                self.assertEqual(count, int(times))
                self.assertAlmostEqual(size / float(at_each), 1.1, delta=0.25)  # numbers of vertices, padding, metadata
                expected = 100 * count * each / (float(steps) * float(step_ms) / 1e3)
                self.assertAlmostEqual(share, expected, delta=0.15 * expected)
                self.assertEqual(list(self.folder.iterdir()), [])
        self.assertNotIn("outputs ", call(*words, "--no-particles", folder=self.folder).out.replace("without outputs", ""))
        ended = call(*words, folder="/proc", ranks=2)
        self.assertEqual((ended.code, ended.err), (0, ""), ended)
        self.assertRegex(ended.out, r"(?m)^ +outputs were not timed: cannot .+ \.moraine-check-\d+\.vtkhdf")

    def test_a_run_of_less_than_a_second_is_timed_as_a_whole(self):
        self.assertRegex(self.report(INPUTS / "first_scene.toml", "--time", *sets(time__end=0.01)), r"(?m)^time +\S+ s for the whole run \(1 rank of")

    def test_only_what_runs_is_timed(self):
        line = self.assert_one_problem(call("check", INPUTS / "first_scene.toml", "--time", "--ranks", "4"))
        self.assertIn("mpirun -n 4 moraine check", line)

    def test_what_is_rarely_meant_is_warned_of_by_check_and_by_a_run(self):
        scene = INPUTS / "first_scene.toml"
        for keys, words in ((sets(domain__cell=0.5), r"body\.block is 2 cells over its least side .+ domain\.cell of 0\.25 m\?"),
                            (sets(material__clay__poisson=0.499), r"material\.clay\.poisson = 0\.499 makes steps 2\.2 times as short .+Use 0\.495\?"),
                            (sets(body__block__velocity="[30, 0]"), r"body\.block may flow at Mach 0\.\d+ .+ times as large\?")):
            with self.subTest(words):
                self.assertRegex(self.report(scene, *keys), rf"(?m)^warning +{words}$")
                ended = call("run", scene, *keys, *sets(time__end=0), "--output", self.folder / "run", "--overwrite")
                self.assertRegex(ended.err, rf"(?m)^Warning: {words}$")
                ended = call("run", scene, *keys, *sets(time__end=0), "--output", self.folder / "run", "--overwrite", "--quiet")
                self.assertEqual((ended.code, ended.err), (0, ""))

    def test_a_transfer_more_viscous_than_a_layer_is_warned_of(self):
        thin = sets(domain__cell=0.5, material__slurry__viscosity=5)
        told = r"(?m)^warning +body\.reservoir is 10 cells deep, and there the transfer itself is as viscous as 1\.3 of material\.slurry .+ domain\.cell of 0\.17 m\?$"
        self.assertRegex(self.report(INPUTS / "slurry_runout.toml", *thin), told)
        for more in (sets(numerics__transfer="flip"), sets(material__slurry__viscosity=500), sets(domain__cell=0.25)):
            with self.subTest(more):
                self.assertNotIn("as viscous as", self.report(INPUTS / "slurry_runout.toml", *thin, *more))

    def test_a_smooth_bed_into_which_a_fluid_sinks_is_warned_of(self):
        plane = '[[structure]]\nname = "bed"\nshape = "plane"\npoint = [0.0, -1.0]\nnormal = [{}, 1.0]\ncontact = {{ law = "{}"{} }}\n'
        told = "warning +material.slurry sinks into bed, .+ material.slurry.volumetric = \"particle\"\\?"
        for tilt, law, more, expected in ((0.1, "smooth", "", True), (0.0, "smooth", "", False), (0.1, "coulomb", ", friction = 0.2", False)):
            with self.subTest(tilt=tilt, law=law):
                scene = self.folder / "bed.toml"
                scene.write_text((INPUTS / "slurry_runout.toml").read_text() + plane.format(tilt, law, more))
                said = self.report(scene, *sets(numerics__substeps=1))
                self.assertEqual(bool(re.search(f"(?m)^{told}$", said)), expected, said)
                particles = self.report(scene, *sets(numerics__substeps=1, material__slurry__volumetric="particle"))
                self.assertNotIn("sinks into", particles)

    def test_its_answer_is_said_once_on_three_ranks(self):
        ended = call("check", INPUTS / "first_scene.toml", ranks=3)
        self.assertEqual((ended.code, len(re.findall("(?m)^particles ", ended.out)), ended.err), (0, 1, ""), ended)

    def test_memory_is_divided_by_the_ranks_and_writes_nothing(self):
        scene = INPUTS / "slurry_runout_3d.toml"
        whole, quarter = self.said("memory", scene), self.said("memory", scene, "--ranks", "4")
        self.assertAlmostEqual(quarter, whole / 4, delta=0.02 * whole)
        self.assertEqual(call("check", scene, folder=self.folder).code, 0)
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_a_key_that_is_not_there_is_refused(self):
        line = self.assert_one_problem(call("check", INPUTS / "first_scene.toml", "--set", "domain.cel=1"))
        self.assertIn("domain.cell", line)

    def test_a_suggestion_never_names_what_was_written(self):
        """A key of another law, shape or kind is there, and the message says of which."""
        for key, words in (("material.clay.friction_angle", "it is for law drucker-prager). Remove it, or set material.clay.law?"),
                           ("material.clay.yield_stress", "it is for law herschel-bulkley, bingham). Remove it, or set material.clay.law?"),
                           ("body.block.radius", "it is for shape sphere). Remove it, or set body.block.shape?"),
                           ("wall.x-min.friction", "it is for kind friction, voellmy). Remove it, or set wall.x-min.kind?")):
            with self.subTest(key):
                line = self.assert_one_problem(call("check", INPUTS / "first_scene.toml", "--set", f"{key}=1"))
                self.assertIn(f"{key} is not used ({words}", line)

    def test_help_of_a_command_is_of_that_one_alone(self):
        for words in (["run", "--help"], ["help", "run"], ["run", "scene.toml", "--help"]):
            text = call(*words).out
            self.assertTrue(text.startswith("moraine run SCENE.toml") and "--restart" in text and "--ranks" not in text, text)
        self.assertIn("--ranks", call("help", "check").out)
        self.assertIn("--trigger", call("replay", "--help").out)
        self.assertIn("--levels", call("help", "converge").out)
        self.assertIn("JSON Schema", call("schema", "--help").out)
        self.assertIn("Did you mean run?", self.assert_one_problem(call("help", "rum")))

    def test_help_and_version_are_said_once_with_exit_code_0(self):
        for words, says in ((["--help"], "--restart"), (["run", "--help"], "--partitioner"), ([], "moraine run"),
                            (["--version"], "moraine ")):
            for ranks in (None, 2):
                with self.subTest(words=words, ranks=ranks):
                    ended = call(*words, ranks=ranks)
                    self.assertEqual((ended.code, ended.err), (0, ""), ended)
                    self.assertIn(says, ended.out)
                    self.assertEqual(ended.out.splitlines().count(ended.out.splitlines()[0]), 1)


if __name__ == "__main__":
    moraine.main()
