"""moraine stability as a user has it: the rule, the search, an exact factor with its bar, going on, one answer on any jobs, refusals."""
import importlib.util
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
from moraine.factor_search import bracket, is_uneven, next_factors
from moraine.particles import Particles
from moraine.strengths import reduced, strengths_of
from moraine.verdict import FAILS, STANDS, UNDECIDED, Ways, judge, rule_of
from runs_for_tests import INPUTS, PackageTest, program
from runs_for_tests import folder as shared

# A dry layer of sand on a plane of 20 degrees, a strip that repeats itself; with dilation = friction it fails at tan(phi)/tan(beta).
SLOPE, PHI, G = math.radians(20.0), 30.0, 9.81
EXACT = math.tan(math.radians(PHI)) / math.tan(SLOPE)
SAND = {"name": "sand", "law": "drucker-prager", "density": 2000.0, "young": 2.0e6, "poisson": 0.3, "friction_angle": PHI, "dilation_angle": PHI}
CLAY = {"name": "clay", "law": "tresca", "density": 2000.0, "young": 2.0e6, "poisson": 0.49, "su": 5.0e3}
LAYER = {"title": "infinite slope", "dimensions": 2, "gravity": [G * math.sin(SLOPE), -G * math.cos(SLOPE)],
         "domain": {"min": [0.0, 0.0], "max": [0.5, 1.25], "cell": 0.125, "periodic": ["x"]}, "time": {"end": 10.0},
         "numerics": {"transfer": "apic"}, "material": [SAND],
         "body": [{"name": "layer", "material": "sand", "shape": "box", "min": [0.0, 0.0], "max": [0.5, 1.0]}],
         "wall": [{"face": "y-min", "kind": "no-slip"}]}
OPTIONS = ["--device", "cpu"]


def folder(name):
    """Of this file's tests alone: all files share one."""
    return shared(f"slope-{name}")


def with_material(**changes):
    return {**LAYER, "material": [{**SAND, **changes}]}


def search(truth, first, step, jobs):
    """The bracket of a search whose trials know the truth, and how many there were; each time the last of those under way ends."""
    found, going, tried = {}, [], 0
    while True:
        stands, fails = bracket(found)
        going = [k for k in going if not (fails is not None and k > fails) and not (stands is not None and k < stands)]
        for k in next_factors(found, first, step, jobs):
            if len(going) < jobs and k not in going and k not in found:
                going.append(k)
                tried += 1
        if not going:
            return *bracket(found), tried
        k = going.pop()
        found[k] = truth(k)


class Rule(PackageTest):
    rule = rule_of({"gravity": [0.0, -10.0]}, 0.5, 10.0)

    def test_what_slid_and_still_moves_has_failed_whatever_comes_after(self):
        times = [0.0, 0.6, 1.2, 1.8]
        self.assertEqual(judge(self.rule, times, [0.0, 0.3, 0.6, 0.6], True), FAILS)
        self.assertEqual(judge(self.rule, times, [0.0, 0.3, 0.4, 0.49], True), STANDS)
        self.assertIsNone(judge(self.rule, times, [0.0, 0.3, 0.4, 0.49], False))

    def test_a_slow_creep_beyond_the_way_is_no_failure_and_no_stand(self):
        still = self.rule.still * 0.6 / self.rule.interval
        self.assertIsNone(judge(self.rule, [0.0, 0.6, 1.2], [0.5, 0.5 + 0.9 * still, 0.5 + 1.8 * still], False))
        self.assertEqual(judge(self.rule, [0.0, 0.6, 1.2], [0.5, 0.5 + 1.1 * still, 0.5 + 2.2 * still], False), FAILS)

    def test_rest_lasts_as_long_as_a_fall_and_follows_the_scene(self):
        self.assertGreaterEqual(self.rule.intervals * self.rule.interval, 2.5)
        given = rule_of({"gravity": [0.0, -10.0], "rest": {"interval": 0.1, "intervals": 50, "displacement": 0.01}}, 0.5, 10.0)
        self.assertEqual((given.interval, given.intervals, given.still), (0.1, 50, 0.005))
        strict = rule_of({"gravity": [0.0, -10.0]}, 0.5, 10.0, 0.01)
        self.assertEqual((strict.way, strict.still, strict.rest_sets()["rest.displacement"]), (0.1, 0.005, 0.01))

    def test_ways_are_by_id_across_periodic_ends_and_infinite_for_who_left(self):
        class Series(list):
            times = [0.0, 1.0, 2.0]

            def read(self, k, fields):
                return self[k]
        frame = lambda t, ids, xs: Particles(t, 2, numpy.array([[x, 0.0] for x in xs]), {"id": numpy.array(ids)}, {})
        outputs = Series([frame(0.0, [7, 3, 5], [0.9, 0.1, 0.5]), frame(1.0, [3, 5, 7], [0.2, 0.5, 0.1]), frame(2.0, [3, 7], [0.3, 0.3])])
        ways = Ways(outputs, 0, [1.0, 0.0], 1.0)
        ways.look(outputs)
        self.assertAlmostEqual(ways.ways[1], 0.2)
        self.assertEqual(ways.ways[2], math.inf)
        most = Ways(outputs, 0, [1.0, 0.0], 0.5)
        most.look(outputs)
        self.assertAlmostEqual(most.ways[2], 0.4)

    def test_strengths_are_divided_by_law(self):
        found = reduced(strengths_of({"material": [SAND, CLAY], "wall": [{"face": "y-min", "kind": "friction", "friction": 0.5}],
                                      "structure": [{"name": "pile", "contact": {"law": "undrained", "su": 4e3, "alpha": 0.5}}]}), 2.0)
        self.assertAlmostEqual(found["material.sand.friction_angle"], math.degrees(math.atan(math.tan(math.radians(PHI)) / 2)))
        self.assertEqual(found["material.sand.friction_angle"], found["material.sand.dilation_angle"])
        self.assertEqual({key: value for key, value in found.items() if "angle" not in key},
                         {"material.clay.su": 2500.0, "wall.y-min.friction": 0.25, "structure.pile.contact.su": 2000.0})


class Search(unittest.TestCase):
    def test_the_bracket_is_the_same_whatever_runs_at_a_time(self):
        for last in (100, 101, 119, 137, 138, 200, 555):
            truth = lambda k: STANDS if k <= last else FAILS
            found = {search(truth, 100, 20, jobs)[:2] for jobs in (1, 2, 3, 5)}
            self.assertEqual(found, {(last, last + 1)})
            self.assertLessEqual(search(truth, 100, 20, 1)[2], 14)
            for near in (last - 7, last, last + 1, last + 60):
                self.assertEqual(search(truth, max(1, near), 2, 2)[:2], (last, last + 1))

    def test_what_is_undecided_widens_the_bracket(self):
        truth = lambda k: STANDS if k <= 137 else UNDECIDED if k <= 141 else FAILS
        for jobs in (1, 2, 4):
            self.assertEqual(search(truth, 100, 20, jobs)[:2], (137, 142))

    def test_a_stand_above_a_failure_is_said_and_the_lower_bracket_taken(self):
        found = {100: STANDS, 130: FAILS, 140: STANDS, 150: FAILS}
        self.assertEqual((bracket(found), is_uneven(found)), ((100, 130), True))
        self.assertFalse(is_uneven({100: STANDS, 120: UNDECIDED, 130: FAILS}))

    def test_below_the_first_it_goes_down(self):
        self.assertEqual(search(lambda k: STANDS if k <= 40 else FAILS, 100, 20, 2)[:2], (40, 41))
        self.assertEqual(search(lambda k: FAILS, 100, 20, 2)[:2], (None, 1))


class Slope(PackageTest):
    def stability(self, name, scene=LAYER, **more):
        said = []
        given = {"tolerance": 0.05, "told": said.append, "options": OPTIONS, **more}
        return moraine.stability(scene, folder(name), **given), said

    def command(self, *words):
        done = subprocess.run([program.PROGRAM, "stability", *map(str, words)], capture_output=True, text=True, cwd=shared("."),
                              env={**os.environ, "MORAINE_PYTHON": sys.executable, "OMP_NUM_THREADS": "1"})
        return done.returncode, done.stdout, done.stderr

    def test_an_infinite_slope_has_the_exact_factor_within_its_bar_and_is_gone_on_with(self):
        found, said = self.stability("layer")
        self.assertEqual([level.cell for level in found.levels], [0.125, 0.0625])
        self.assertLessEqual(abs(found.factor - EXACT), found.error + 0.02 * EXACT, said)
        self.assertLessEqual(found.error, 0.15)
        runs = self.written(found)
        self.assertGreater(len(runs), 8)
        again, said = self.stability("layer")
        self.assertEqual((again.factor, again.error), (found.factor, found.error))
        self.assertEqual(self.written(found), runs)
        self.assertFalse([line for line in said if "F = " in line and "settled" not in line])
        self.goes_on_without_a_trial(found)
        self.same_on_one_job(found)
        self.names_what_is_there(found)

    def written(self, found, but=None):
        """When each run wrote its summary."""
        return {path: path.stat().st_mtime_ns for path in found.path.glob("cell-*/*/summary.json") if but is None or path.parts[-2:-1] != (but,)}

    def goes_on_without_a_trial(self, found):
        """A trial that was lost is made again, to the same ways; those that are known stay."""
        file = found.path / "stability.json"
        kept = json.loads(file.read_text())
        last = found.levels[-1]
        key = str(round(last.fails / 0.05))
        before = kept["levels"][last.folder]["trials"].pop(key)
        file.write_text(json.dumps(kept))
        others = self.written(found, but=f"F-{last.fails:g}")
        again, said = self.stability("layer")
        self.assertLess(len([line for line in said if "F = " in line and "settled" not in line]), 4)
        self.assertEqual({path: at for path, at in self.written(found).items() if path in others}, others)
        after = json.loads(file.read_text())["levels"][last.folder]["trials"][key]
        self.assertEqual((after["verdict"], after["times"], after["ways"]), (before["verdict"], before["times"], before["ways"]))
        self.assertEqual(again.factor, found.factor)

    def same_on_one_job(self, found):
        """One at a time, and each on two ranks."""
        alone, _ = self.stability("alone", jobs=1, ranks=2)
        self.assertEqual([(level.stands, level.fails) for level in alone.levels], [(level.stands, level.fails) for level in found.levels])

    def names_what_is_there(self, found):
        """Another scene, a damaged record, a foreign folder; --overwrite removes its own folders alone."""
        last, key = found.levels[0].folder, str(round(found.levels[0].fails / 0.05))
        places = [["levels"], ["levels", last], *(["levels", last, name] for name in ("height", "trials")), ["levels", last, "trials", key],
                  *(["levels", last, "trials", key, name] for name in ("factor", "verdict", "times", "ways", "wall_s", "part", "more"))]
        self.refuses_damage(found.path / "stability.json", places, lambda: self.stability("layer"))
        self.assertIn("another study", self.problem(self.stability, "layer", with_material(friction_angle=31.0)))
        (found.path / "notes.txt").write_text("mine")
        folder("foreign").mkdir()
        (folder("foreign") / "mine").write_text("mine")
        self.assertIn("is taken", self.problem(self.stability, "foreign", overwrite=True))
        (found.path / "stability.json").write_text("")
        self.problem(self.stability, "layer", with_material(matching=0, young=-1.0), overwrite=True)
        self.assertEqual(sorted(path.name for path in found.path.iterdir() if path.name.startswith("cell")), [])
        self.assertEqual((found.path / "notes.txt").read_text(), "mine")

    @unittest.skipIf(importlib.util.find_spec("matplotlib") is None, "no matplotlib")
    def test_the_command_says_the_factor_and_draws_where_it_slides(self):
        scene = moraine.write_scene(LAYER, folder("layer.toml"))
        code, out, said = self.command(scene, "--tolerance", "0.2", "--levels", "1", "--output", folder("drawn"), *OPTIONS)
        self.assertEqual(code, 0, said)
        self.assertRegex(out, r"FS between 1\.4 and 1\.6 on cells of 0\.125 m; no error bar")
        self.assertRegex(said, r"cell 0\.125 m, F = 1\.6: fails, way [0-9.]+ m after [0-9.]+ s")
        page = (folder("drawn") / "stability.html").read_text()
        self.assertIn("FS between 1.4 and 1.6", page)
        self.assertIn("data:image/png", page)
        self.assertEqual((folder("drawn") / "slip-cell-0.125.png").read_bytes()[:4], b"\x89PNG")
        kept = json.loads((folder("drawn") / "stability.json").read_text())
        self.assertEqual((kept["brackets"][0]["stands"], kept["brackets"][0]["fails"], kept["error"]), (1.4, 1.6, None))
        self.assertEqual(kept["brackets"][0]["picture"], "slip-cell-0.125.png")
        code, _, said = self.command(scene, "--tolerence", "0.1")
        self.assertEqual(code, 2)
        self.assertIn("stability inputs/stability.toml", said)

    def test_a_stopped_search_goes_on_to_the_same_ways(self):
        scene = moraine.write_scene(LAYER, folder("layer.toml"))
        words = [scene, "--tolerance", "0.2", "--levels", "1", "--jobs", "1", *OPTIONS, "--output"]
        self.assertEqual(self.command(*words, folder("whole"))[0], 0)
        job = subprocess.Popen([program.PROGRAM, "stability", *map(str, words), str(folder("stopped"))], cwd=shared("."), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               text=True, env={**os.environ, "MORAINE_PYTHON": sys.executable, "OMP_NUM_THREADS": "1"})
        while job.poll() is None and not list(folder("stopped").glob("cell-*/F-*/history.csv")):
            time.sleep(0.005)
        job.send_signal(signal.SIGTERM)
        _, said = job.communicate(timeout=60)
        self.assertEqual(job.returncode, 5, said)
        self.assertIn("stability was stopped", said)
        code, out, said = self.command(*words, folder("stopped"))
        self.assertEqual(code, 0, said)
        kept = [json.loads((folder(name) / "stability.json").read_text()) for name in ("whole", "stopped")]
        self.assertEqual(kept[0]["brackets"], kept[1]["brackets"])
        trials = [{k: (t["verdict"], t["ways"]) for k, t in each["levels"]["cell-0.125"]["trials"].items()} for each in kept]
        self.assertEqual(trials[0], trials[1])

    def test_a_slope_that_fails_at_one_says_so_and_settles_below(self):
        steep = with_material(friction_angle=18.0, dilation_angle=0.0)
        self.assertIn("--settle 0.5", self.problem(self.stability, "steep", steep, levels=1, code=3))
        found, _ = self.stability("steep", steep, levels=1, settle=0.5, tolerance=0.1, overwrite=True)
        exact = math.tan(math.radians(18.0)) * math.sqrt(1 - math.tan(SLOPE) ** 2) / math.tan(SLOPE)  # without dilation sin(phi_F) = tan(beta)
        self.assertLessEqual(found.levels[0].stands - 0.02, exact)
        self.assertGreaterEqual(found.levels[0].fails + 0.02, exact)

    def test_laws_without_a_strength_and_clay_that_softens_are_refused_by_name(self):
        cam = {"name": "soft", "law": "modified-cam-clay", "density": 1600.0}
        self.assertIn("material.soft: law modified-cam-clay", self.problem(self.stability, "no", {**LAYER, "material": [SAND, cam]}))
        self.assertIn("material.mud: law bingham", self.problem(self.stability, "no", {**LAYER, "material": [{"name": "mud", "law": "bingham"}]}))
        self.assertIn("--softening", self.problem(self.stability, "no", {**LAYER, "material": [{**CLAY, "sensitivity": 4.0}]}))
        self.assertIn("matching", self.problem(self.stability, "no", with_material(matching=1)))
        self.assertIn("material.sand.cohesion is a strength over depth", self.problem(self.stability, "no", with_material(cohesion={"surface": 1e3, "gradient": 1e2})))
        self.assertIn("--keep rock", self.problem(self.stability, "no", keep=["rock"]))
        self.assertIn("all are kept", self.problem(self.stability, "no", keep=["sand"]))
        self.assertIn("voellmy", self.problem(self.stability, "no", {**LAYER, "wall": [{"face": "y-min", "kind": "voellmy"}]}))
        self.assertEqual([s.key for s in strengths_of({"material": [SAND, cam]}, ["soft"])], ["material.sand.friction_angle", "material.sand.dilation_angle"])
        self.assertEqual([s.key for s in strengths_of({"material": [{**CLAY, "sensitivity": 4.0}]}, softening=True)], ["material.clay.su"])
        bed = {"face": "y-min", "kind": "undrained", "alpha": 0.5, "su": "soil"}  # it follows the clay's
        self.assertEqual([s.key for s in strengths_of({"material": [CLAY], "wall": [bed]})], ["material.clay.su"])

    def test_words_that_cannot_be_are_refused_and_leave_nothing(self):
        for more, says in (({"tolerance": 0.0}, "--tolerance"), ({"levels": 3}, "--levels"), ({"settle": -1.0}, "--settle"), ({"cell": 0.0}, "--cell"),
                           ({"height": -2.0}, "--height"), ({"way": 0.0}, "--way"), ({"scene": {**LAYER, "gravity": [0.0, 0.0]}}, "gravity"),
                           ({"scene": {**LAYER, "inflow": [{"name": "river"}]}}, "inflow"), ({"scene": {**LAYER, "domain": {}}}, "domain.cell"),
                           ({"scene": {**LAYER, "stage": [{"name": "settle"}]}}, "[[stage]]"), ({"scene": {**LAYER, "water": {"table": 1.0}}}, "buoyant")):
            self.assertIn(says, self.problem(self.stability, "no", **more))
        self.assertFalse(folder("no").exists())

    def test_the_shipped_scene_can_be_asked_for(self):
        keys = moraine.read_scene(INPUTS / "stability.toml")
        self.assertEqual([s.key for s in strengths_of(keys)], ["material.soil.cohesion", "material.soil.friction_angle"])


if __name__ == "__main__":
    unittest.main()
